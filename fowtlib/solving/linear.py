"""Exact linear models at a state, and their modes."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

import casadi as ca
import numpy as np

from fowtlib.flattening import FlatDAE
from fowtlib.flattening.flat_dae import Operator
from fowtlib.flattening.system import element_names
from fowtlib.language.eigenvectors import eigenvectors
from fowtlib.language.errors import ModelError, SimulationError
from fowtlib.language.operators import transfer_matrix
from fowtlib.language.whole_files import write_whole
from fowtlib.solving.binding import start_slopes
from fowtlib.solving.functions import AtParameters
from fowtlib.solving.layout import Layout
from fowtlib.solving.outputs import Outputs
from fowtlib.solving.real_modes import FewFunctions, RealModes
from fowtlib.solving.results.html import table
from fowtlib.solving.results.linear_files import OperatingPoint, write_lin
from fowtlib.solving.state import State

if TYPE_CHECKING:
    import xarray


Mixing = Callable[..., np.ndarray]
"""`(t, x, z, q) -> ` how the symbols of the flat model follow from the inputs, (symbols, inputs)."""


@dataclass(frozen=True, eq=False)
class Further:
    """What a linear model has beside parameters and results, by what it is called.

    symbols: scalars of the flat model, also outputs of externals; they are inputs, or where there is a `mixing` they
    follow from `inputs`, as it says. outputs: expressions. added: rows of [ode; alg] to which further inputs are added,
    the last ones: forces, where a row is an equation of motion. off: by how much slopes of the first rows by x, by z
    and by the first symbols are others than those at the point, as those of an equivalent linearisation are.
    """

    symbols: Mapping[str, ca.SX] = field(default_factory=dict)
    outputs: Mapping[str, ca.SX] = field(default_factory=dict)
    inputs: tuple[str, ...] | None = None
    mixing: Mixing | None = None
    added: tuple[int, ...] = ()
    off: tuple[np.ndarray, np.ndarray, np.ndarray] | None = None

    @property
    def labels(self) -> tuple[str, ...]:
        """What the inputs are called."""
        return (tuple(self.symbols) if self.inputs is None else self.inputs) + tuple(f"added {k}" for k in self.added)


NOTHING = Further()
FAST = 2.0  # times the highest frequency; functions of roots above it are put together


@dataclass(frozen=True)
class Mode:
    """An eigenmode: undamped natural frequency [Hz], damping ratio, eigenvalue [1/s], the state that takes part most.

    `shape` gives the complex amplitude of each output (of each state where the model has no outputs), scaled to 1 at
    the largest; `participation` the share of each state.
    """

    frequency_hz: float
    damping_ratio: float
    eigenvalue: complex
    label: str
    shape: dict[str, complex] = field(repr=False)
    participation: dict[str, float] = field(repr=False)

    @property
    def period(self) -> float:
        """Damped period [s]; infinite without oscillation."""
        return 2 * np.pi / abs(self.eigenvalue.imag) if self.eigenvalue.imag else float("inf")


class LinearModel:
    """dx' = A dx + B du, dy = C dx + D du about a state; inputs and states in SI, outputs in the units given.

    The matrices hold the realizations of the linear operators of the model (waves that radiate, for instance); a
    response at a frequency takes their transfer functions themselves.
    """

    def __init__(self, A: np.ndarray, B: np.ndarray, C: np.ndarray, D: np.ndarray, states: Sequence[str],
                 inputs: Sequence[str], outputs: Sequence[str], units: dict[str, str],
                 operators: Operators | None = None):  # fmt: skip
        self.matrices = {"A": A, "B": B, "C": C, "D": D}
        self.states, self.inputs, self.outputs = list(states), list(inputs), list(outputs)
        self.units, self.operators = units, operators
        self.point: Callable[[], OperatingPoint] | None = None

    @property
    def about(self) -> OperatingPoint | None:
        """Where it is of; None for a model of matrices alone."""
        return None if self.point is None else self.point()

    def _labelled(self, name: str, rows: tuple[str, list[str]], columns: tuple[str, list[str]]) -> xarray.DataArray:
        import xarray

        return xarray.DataArray(
            self.matrices[name], dims=(rows[0], columns[0]), coords=dict([rows, columns]), name=name
        )

    @property
    def A(self) -> xarray.DataArray:
        """State matrix (rate of a state by a state)."""
        return self._labelled("A", ("rate", self.states), ("state", self.states))

    @property
    def B(self) -> xarray.DataArray:
        """Input matrix."""
        return self._labelled("B", ("rate", self.states), ("input", self.inputs))

    @property
    def C(self) -> xarray.DataArray:
        """Output matrix."""
        return self._labelled("C", ("output", self.outputs), ("state", self.states))

    @property
    def D(self) -> xarray.DataArray:
        """Feed-through matrix."""
        return self._labelled("D", ("output", self.outputs), ("input", self.inputs))

    def frequency_response(self, omega: Sequence[float], *, realized: bool = False) -> np.ndarray:
        """Outputs per input at circular frequencies [rad/s]: complex (n, outputs, inputs), for exp(+i omega t).

        realized: of the matrices alone, as a run in time has it.
        """
        omega = np.atleast_1d(np.asarray(omega, dtype=float))
        A, B, C, D = (self.matrices[name] for name in "ABCD")
        plain = transfer_matrix(1j * omega, A, B, C, D)
        if realized or self.operators is None:
            return plain
        return self.operators.corrected(omega, A, B, C, plain)

    def driven(self, omega: np.ndarray, drive: np.ndarray, errors: np.ndarray | None = None) -> np.ndarray:
        """Outputs (q, outputs, k) at circular frequencies (q,) [rad/s], for amplitudes of the inputs (q, inputs, k).

        The same as `frequency_response` times the amplitudes, in a small part of the time where these are few.
        errors: `operators.errors(omega)`, where it is known.
        """
        A, B, C, D = (self.matrices[name] for name in "ABCD")
        resolvent, inputs = Resolvent(omega, A), np.asarray(drive).transpose(1, 0, 2)
        amplitudes = resolvent.amplitudes(times(B, inputs))
        y = times(D, inputs)
        if self.operators is not None:
            more, signals = self.operators.added(resolvent, amplitudes, times(self.operators.D_input, inputs), errors)
            amplitudes, y = amplitudes + more, y + times(self.operators.D_output, signals)
        y += times(C @ resolvent.shapes, amplitudes)
        return np.ascontiguousarray(y.transpose(1, 0, 2))

    def first(self, outputs: int | None) -> LinearModel:
        """The model with its first outputs alone."""
        if outputs is None:
            return self
        A, B, C, D = (self.matrices[name] for name in "ABCD")
        operators = self.operators
        if operators is not None:
            operators = replace(operators, D_output=operators.D_output[:outputs])
        return LinearModel(A, B, C[:outputs], D[:outputs], self.states, self.inputs, self.outputs[:outputs],
                           self.units, operators)  # fmt: skip

    def modes(self) -> list[Mode]:
        """Oscillating and decaying modes, lowest frequency first; a conjugate pair counts once."""
        A, C = self.matrices["A"], self.matrices["C"]
        if not len(A):
            return []
        values, right = np.linalg.eig(A)
        left = _inverse(right)  # rows are the left eigenvectors
        kept = values.imag >= 0
        values, right, left = values[kept], right[:, kept], left[kept]
        weights = np.abs(left.T * right)
        weights = weights / np.maximum(weights.sum(axis=0), 1e-300)
        shapes = C @ right if self.outputs else right
        peaks = shapes[np.argmax(np.abs(shapes), axis=0), np.arange(len(values))] if len(shapes) else np.ones(1)
        shapes = shapes / np.where(np.abs(peaks) > 1e-200, peaks, 1.0)
        modes = []
        for value, shape, weight in zip(values.tolist(), shapes.T.astype(complex), weights.T, strict=True):
            size = abs(value)
            modes.append(
                Mode(
                    size / (2 * np.pi),
                    -value.real / size if size > 0 else 0.0,
                    complex(value),
                    self.states[int(np.argmax(weight))],
                    dict(zip(self.outputs or self.states, shape.tolist(), strict=True)),
                    dict(zip(self.states, weight.tolist(), strict=True)),
                )
            )
        return sorted(modes, key=lambda mode: mode.frequency_hz)

    def save(self, path: str | Path) -> Path:
        """Write A, B, C, D and the names of states, inputs and outputs as .mat (MATLAB 5), .npz (NumPy) or .lin (text).

        With units and, where the model knows its operating point, the values there; see results.linear_files for .lin.
        """
        from scipy.io import savemat

        path, point = Path(path), self.about
        names = {"states": self.states, "inputs": self.inputs, "outputs": self.outputs}
        names["output_units"] = [self.units.get(name, "1") for name in self.outputs]
        if path.suffix == ".lin":
            if point is None:
                raise ModelError(f"{path}: a .lin file says where it is of; this linear model has no operating point.")
            return write_lin(self, point, path)
        if point is not None:
            names |= {"state_units": list(point.state_units), "input_units": list(point.input_units)}
            values = {f"{name}_at": getattr(point, name) for name in ("states", "inputs", "outputs")}
            values |= {"rotor_speed": np.array(point.rotor_speed), "azimuth": np.array(point.azimuth)}
        else:
            values = {}
        content = {**self.matrices, **values, **{key: np.array(value, dtype=object) for key, value in names.items()}}
        plain = {**self.matrices, **values, **{key: np.array(value, dtype=str) for key, value in names.items()}}
        writers = {
            ".mat": lambda temporary: savemat(temporary, content),
            ".npz": lambda temporary: np.savez(temporary, **plain),
        }
        if path.suffix not in writers:
            ending = path.suffix or "no ending"
            raise ModelError(f"{path}: a linear model is saved as .mat, .npz or .lin, not as '{ending}'.")
        return write_whole(path, writers[path.suffix])

    def _repr_html_(self) -> str:
        rows = [(mode.label, mode.frequency_hz, mode.damping_ratio) for mode in self.modes()]
        return table(("state that takes part most", "frequency [Hz]", "damping ratio"), rows, repr(self)[1:-1])

    def __repr__(self) -> str:
        return f"<LinearModel: {len(self.states)} states, {len(self.inputs)} inputs, {len(self.outputs)} outputs>"


def _inverse(vectors: np.ndarray) -> np.ndarray:
    """Of eigenvectors; the pseudo-inverse, which takes longer, where the matrix that they belong to is defective."""
    try:
        found = np.linalg.inv(vectors)
    except np.linalg.LinAlgError:
        return np.linalg.pinv(vectors)
    return found if np.abs(found).max() < 1e12 else np.linalg.pinv(vectors)


class Resolvent:
    """(i omega - A)^-1 at many circular frequencies omega (q,) [rad/s], by the eigenvectors of A where these serve.

    Arrays have the frequencies in the middle, (n, q, k), so that what is constant multiplies all in one product.
    """

    def __init__(self, omega: np.ndarray, A: np.ndarray):
        self.omega, self.A = omega, A
        self.basis = eigenvectors(A) if len(A) else None
        self.modes = RealModes.made(*self.basis) if self.basis is not None and np.isrealobj(A) else None

    @property
    def shapes(self) -> np.ndarray:
        """What x is made of, (n, n): the eigenvectors, or the states themselves where these do not serve."""
        if self.modes is not None:
            return self.modes.shapes
        return np.eye(len(self.A)) if self.basis is None else self.basis[1]

    def driven(self, B: np.ndarray, drive: np.ndarray) -> np.ndarray:
        """Amplitudes of the shapes in x = (i omega - A)^-1 B u, for B (n, m) and u (m, q, k)."""
        if self.basis is None or B.shape[1] > len(B):
            return self.amplitudes(times(B, drive))
        if self.modes is not None:
            return self.modes.answers(self.functions, times(self.modes.of @ B, drive))
        found = times(self.basis[2] @ B, drive)
        found *= self._shares[:, :, None]
        return found

    def amplitudes(self, b: np.ndarray) -> np.ndarray:
        """Those of the shapes in x = (i omega - A)^-1 b, for b (n, q, k)."""
        if self.basis is None:
            return self._solved(b)
        if self.modes is not None:
            return self.modes.answers(self.functions, times(self.modes.of, b))
        return times(self.basis[2], b) * self._shares[:, :, None]

    def __call__(self, b: np.ndarray) -> np.ndarray:
        """(i omega - A)^-1 b, for b (n, q, k)."""
        return self._solved(b) if self.basis is None else times(self.shapes, self.amplitudes(b))

    def adjoint(self, b: np.ndarray) -> np.ndarray:
        """(i omega - A)^-H b, for b (n, q, k)."""
        amplitudes, lift = self.backwards(times(self.shapes.conj().T, b))
        return times(lift, amplitudes)

    def backwards(self, b: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Amplitudes a (n, q, k), and a real matrix L with (i omega - A)^-H c = L a, for b = shapes^H c."""
        if self.basis is None:
            return self._solved(b, adjoint=True), np.eye(len(self.A))
        if self.modes is not None:
            return self.modes.answers(self.functions.conj(), b), self.modes.of.T
        return times(self.basis[2].conj().T, b * self._shares.conj()[:, :, None]), np.eye(len(self.A))

    def between(self, C: np.ndarray, B: np.ndarray, part: slice = slice(None)) -> np.ndarray:
        """C (i omega - A)^-1 B, for constant C (m, n) and B (n, k): (q, m, k); part: of the frequencies."""
        q = self.omega[part].size
        if self.basis is None:
            b = np.broadcast_to(B[:, None, :], (len(B), q, B.shape[1]))
            return times(C, self._solved(b, part=part)).transpose(1, 0, 2)
        _, right, left = self.basis
        to, of = C @ right, left @ B
        by_root = (to.T[:, :, None] * of[:, None, :]).reshape(len(of), -1)  # all elements of all roots
        return (self._shares[:, part].T @ by_root).reshape(q, len(C), B.shape[1])

    def _solved(self, b: np.ndarray, *, adjoint: bool = False, part: slice = slice(None)) -> np.ndarray:
        one, found = np.eye(len(self.A)), np.empty(b.shape, dtype=complex)
        for k, w in enumerate(self.omega[part]):
            matrix = 1j * w * one - self.A
            found[:, k] = np.linalg.solve(matrix.conj().T if adjoint else matrix, b[:, k])
        return found

    @cached_property
    def functions(self) -> np.ndarray:
        """Those of the real modes, where there are any."""
        return self.modes.functions(self.omega)

    @cached_property
    def few(self) -> FewFunctions:
        """What these are sums of."""
        return FewFunctions.made(self.functions, self.modes.faster(FAST * self.omega.max()))

    @cached_property
    def _shares(self) -> np.ndarray:
        return 1 / (1j * self.omega - self.basis[0][:, None])


def times(matrix: np.ndarray, values: np.ndarray) -> np.ndarray:
    """A matrix (m, n) times complex values (n, q, k), as one product: (m, q, k)."""
    n, q, k = values.shape
    flat = np.ascontiguousarray(values, dtype=complex).reshape(n, q * k)
    if np.isrealobj(matrix):
        return (matrix @ flat.view(float)).view(complex).reshape(len(matrix), q, k)
    return (matrix @ flat).reshape(len(matrix), q, k)


@dataclass(frozen=True, eq=False)
class Operators:
    """The linear operators of a linear model, by what columns w, w', w'' added to their outputs do.

    B: rate of the states by w, w', w''. C, D_input: inputs of the operators by state and by input of the model; D: by
    w, w', w''. D_output: outputs of the model by them.
    """

    B: np.ndarray
    C: np.ndarray
    D: np.ndarray
    D_input: np.ndarray
    D_output: np.ndarray
    items: tuple[Operator, ...]

    def corrected(self, omega: np.ndarray, A: np.ndarray, B: np.ndarray, C: np.ndarray,
                  plain: np.ndarray) -> np.ndarray:  # fmt: skip
        """The response with each operator itself instead of its realization.

        w = E u with E = H - H_realized, and u = G_ui i + G_uw w; so the outputs gain G_yw (1 - E G_uw)^-1 E G_ui i.
        """
        E = self.errors(omega)
        by_input = transfer_matrix(1j * omega, A, B, self.C, self.D_input)
        by_w = _of_signal(omega, transfer_matrix(1j * omega, A, self.B, self.C, self.D))
        to_output = _of_signal(omega, transfer_matrix(1j * omega, A, self.B, C, self.D_output))
        return plain + to_output @ np.linalg.solve(np.eye(E.shape[1]) - E @ by_w, E @ by_input)

    def added(self, resolvent: Resolvent, amplitudes: np.ndarray, direct: np.ndarray,
              errors: np.ndarray | None) -> tuple[np.ndarray, np.ndarray]:  # fmt: skip
        """What the operators add to the amplitudes (n, q, k) of a resolvent, and their w, w', w'' (3 m, q, k).

        amplitudes: with the realizations alone. direct: what drives the operators (m, q, k) beside the states.
        """
        omega = resolvent.omega
        E = self.errors(omega) if errors is None else errors
        by_w = _of_signal(omega, resolvent.between(self.C, self.B) + self.D)
        u = (times(self.C @ resolvent.shapes, amplitudes) + direct).transpose(1, 0, 2)
        w = np.linalg.solve(np.eye(E.shape[1]) - E @ by_w, E @ u).transpose(1, 0, 2)
        rates = (1j * omega)[None, :, None]
        signals = np.concatenate([w, rates * w, rates**2 * w])
        return resolvent.amplitudes(times(self.B, signals)), signals

    def fed_back(self, loop: np.ndarray, inputs: int, outputs: int, matrices: Mapping[str, np.ndarray]) -> Operators:
        """The operators of the model whose inputs behind the first ones are `loop` @ its outputs behind the first ones.

        matrices: A, B, C, D of the model without that.
        """
        n, m = inputs, outputs
        B, C, D = (matrices[name] for name in "BCD")
        by_loop, of_output = self.D_input[:, n:] @ loop, self.D_output[m:]
        return Operators(
            self.B + B[:, n:] @ loop @ of_output,
            self.C + by_loop @ C[m:],
            self.D + by_loop @ of_output,
            self.D_input[:, :n] + by_loop @ D[m:, :n],
            self.D_output + D[:, n:] @ loop @ of_output,
            self.items,
        )

    def errors(self, omega: np.ndarray) -> np.ndarray:
        """Transfer functions less those of the realizations, (q, n, m) of all operators together."""
        rows, columns = (sum(shape) for shape in zip(*(item.realization.D.shape for item in self.items), strict=True))
        E, i, j = np.zeros((omega.size, rows, columns), dtype=complex), 0, 0
        for item in self.items:
            n, m = item.realization.D.shape
            H = np.asarray(item.transfer(omega))
            if H.shape != (omega.size, n, m) or not np.all(np.isfinite(H)):
                raise SimulationError(
                    f"{item.path}: the transfer function gives {H.shape} at {omega.size} frequencies, where finite "
                    f"numbers {(omega.size, n, m)} are expected."
                )
            E[:, i : i + n, j : j + m] = H - item.realization.transfer(omega)
            i, j = i + n, j + m
        return E


def _of_signal(omega: np.ndarray, G: np.ndarray) -> np.ndarray:
    """The response (q, n, m) to a signal, from that to it and its two derivatives (q, n, 3 m)."""
    q, n, _ = G.shape
    powers = (1j * omega)[:, None] ** np.arange(3)
    return np.einsum("qndm,qd->qnm", G.reshape(q, n, 3, -1), powers)


@dataclass(frozen=True, eq=False)
class Slopes:
    """How the rates, the algebraic equations and the outputs of a model change with its states, unknowns and inputs.

    function: `(t, x, z, q)` -> the derivatives of all rows by x, by z and by the columns, which are the `inputs`
    labelled, w, w', w'' of the operators, and what is computed from the inputs. The rows are ode, alg, and outputs: the
    ones `shown`, then the inputs of the operators. scale: of the rows of outputs, to the units given. rows, columns:
    the expressions, and the symbols of the inputs and of the operators.
    """

    at: AtParameters
    function: ca.Function
    inputs: tuple[str, ...]
    operator_columns: int
    through: tuple[tuple[slice, str, np.ndarray], ...]
    shown: tuple[str, ...]
    units: dict[str, str]
    scale: np.ndarray
    rows: ca.SX
    columns: tuple[ca.SX, ...]
    further: Further = NOTHING

    def __call__(self, t: float, x: np.ndarray, z: np.ndarray, q: np.ndarray) -> tuple[np.ndarray, ...]:
        """All rows by x, by z, and by the inputs and the columns of the operators."""
        dae = self.at.dae
        by_x, by_z, by_all = self.at.arrays_again(self.function, t, x, z, q)
        symbols = len(self.inputs) - len(self.further.labels) + len(self.further.symbols)
        if self.further.off is not None:
            by_x, by_z, by_all = by_x.copy(), by_z.copy(), by_all.copy()
            place = symbols - len(self.further.symbols)
            for whole, off in zip((by_x, by_z, by_all[:, place:]), self.further.off, strict=True):
                whole[: len(off), : off.shape[1]] += off
        first = symbols + self.operator_columns
        by_u = by_all[:, :first].copy()
        for name in dict.fromkeys(name for _, name, _ in self.through):
            last = first + dae.bound[name].symbol.numel()
            for place, _, slope in (item for item in self.through if item[1] == name):
                by_u[:, place] += by_all[:, first:last] @ slope
            first = last
        if self.further.mixing is not None:
            own, mixed, rest = np.split(by_u, [symbols - len(self.further.symbols), symbols], axis=1)
            by_u = np.hstack([own, mixed @ self.further.mixing(t, x, z, q), rest])
        if self.further.added:
            columns = np.zeros((len(by_u), len(self.further.added)))
            columns[list(self.further.added), np.arange(columns.shape[1])] = 1.0
            place = by_u.shape[1] - self.operator_columns
            by_u = np.hstack([by_u[:, :place], columns, by_u[:, place:]])
        return by_x, by_z, by_u

    def model(self, A: np.ndarray, B: np.ndarray, C: np.ndarray, D: np.ndarray, states: Sequence[str]) -> LinearModel:
        """The linear model of matrices with all columns and all rows of outputs."""
        items, number, count = self.at.dae.operators, len(self.inputs), len(self.shown)
        C, D = C * self.scale, D * self.scale
        operators = None
        if items:
            operators = Operators(B[:, number:], C[count:], D[count:, number:], D[count:, :number], D[:count, number:],
                                  items)  # fmt: skip
        return LinearModel(A, B[:, :number], C[:count], D[:count, :number], list(states), list(self.inputs),
                           list(self.shown), self.units, operators)  # fmt: skip


def slopes_of(at: AtParameters, layout: Layout, outputs: Outputs, inputs: Sequence[str], names: Sequence[str],
              further: Further = NOTHING) -> Slopes:  # fmt: skip
    """Slopes by inputs or tunable parameters by path, of results or variables by name.

    further: what else there is, behind these.

    further_inputs: symbols of the flat model behind them, also outputs of externals; further_outputs: expressions.
    What is computed from a parameter when a run starts counts with it, by central differences (start_slopes).
    """
    dae = at.dae
    key = (tuple(inputs), tuple(names), tuple(further.symbols), further.labels, tuple(further.outputs))
    known = at.general.once(("rows and columns", key),
                            lambda: _rows_and_columns(dae, layout, outputs, inputs, names, further))  # fmt: skip
    through: list[tuple[slice, str, np.ndarray]] = []  # columns of a parameter, numbers computed from it, their slopes
    for path, place in known.places:
        if path in layout.p:
            through += [(place, name, slope) for name, slope in start_slopes(dae, at.binding, path).items()]
    computed = list(dict.fromkeys(name for _, name, _ in through))

    def make() -> ca.Function:
        columns = [*known.columns, *(dae.bound[name].symbol for name in computed)]
        u = ca.vertcat(*columns) if columns else ca.SX(0, 1)
        return at.general.torn_jacobian("linear", known.rows, [dae.x, dae.z, u])

    function = at.general.once(("linear", key, tuple(computed)), make)
    return Slopes(at, function, known.inputs, known.operator_columns, tuple(through), known.shown, dict(known.units),
                  known.scale, known.rows, known.columns, further)  # fmt: skip


@dataclass(frozen=True, eq=False)
class _RowsAndColumns:
    """What slopes are of, and by what; see Slopes. places: of the columns of each input."""

    inputs: tuple[str, ...]
    operator_columns: int
    shown: tuple[str, ...]
    units: dict[str, str]
    scale: np.ndarray
    rows: ca.SX
    columns: tuple[ca.SX, ...]
    places: tuple[tuple[str, slice], ...]


def _rows_and_columns(dae: FlatDAE, layout: Layout, outputs: Outputs, inputs: Sequence[str], names: Sequence[str],
                      further: Further) -> _RowsAndColumns:  # fmt: skip
    columns: list[ca.SX] = []
    labels: list[str] = []
    places: list[tuple[str, slice]] = []
    for path in inputs:
        symbols, fresh = layout.symbols(path)
        places.append((path, slice(len(columns), len(columns) + len(symbols))))
        columns += symbols
        labels += fresh
    columns += further.symbols.values()
    labels += further.labels
    rows, factors, shown, units = [], [], [], {}
    for name in names:
        expression = ca.vec(dae.observe_expression(outputs.entry(name).path))
        fresh = element_names(name, expression.shape)
        rows.append(expression)
        factors += [outputs.factor(name)] * len(fresh)
        shown += fresh
        units |= dict.fromkeys(fresh, outputs.entry(name).unit)
    rows += further.outputs.values()
    shown += further.outputs
    factors += [1.0] * len(further.outputs)

    number = len(columns)
    for order in range(3):
        columns += [element for item in dae.operators for element in item.correction[:, order].elements()]
    for item in dae.operators:
        rows.append(item.inputs)
        factors += [1.0] * item.inputs.numel()
    expressions = ca.vertcat(dae.ode, dae.alg, *rows)
    return _RowsAndColumns(tuple(labels), len(columns) - number, tuple(shown), units,
                           np.array(factors).reshape(-1, 1), expressions, tuple(columns), tuple(places))  # fmt: skip


def linearize(at: AtParameters, layout: Layout, outputs: Outputs, state: State, inputs: Sequence[str],
              names: Sequence[str], further: Further = NOTHING) -> LinearModel:  # fmt: skip
    """The linear model at a state, from inputs or tunable parameters by path to results or variables.

    All states are kept; the algebraic unknowns are eliminated by the implicit function theorem.
    """
    slopes = slopes_of(at, layout, outputs, inputs, names, further)
    by_x, by_z, by_u = slopes(state.t, state.x, state.z, np.concatenate([state.u, state.d]))
    nx, nz = at.dae.x.shape[0], at.dae.z.shape[0]
    ode, alg, out = slice(0, nx), slice(nx, nx + nz), slice(nx + nz, None)
    by_xu = np.hstack([by_x[alg], by_u[alg]])
    dz = -np.linalg.solve(by_z[alg], by_xu) if nz else by_xu
    A, B = by_x[ode] + by_z[ode] @ dz[:, :nx], by_u[ode] + by_z[ode] @ dz[:, nx:]
    C, D = by_x[out] + by_z[out] @ dz[:, :nx], by_u[out] + by_z[out] @ dz[:, nx:]
    return slopes.model(A, B, C, D, list(layout.x))
