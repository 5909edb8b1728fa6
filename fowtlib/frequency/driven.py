"""What random processes drive in a model, at many frequencies, and the drag that suits the response to it.

The covariance of the inputs of all laws of drag is Q G Q^H with the sums G of a a^H over frequencies and channels, a
the amplitudes of the modes and Q the inputs by these, and with what the processes put into the laws directly: so an
iteration costs products with few rows, and nothing of the size of laws times frequencies times channels.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from fowtlib.frequency.drag import gains_of
from fowtlib.language.eigenvectors import eigenvectors
from fowtlib.solving.excited import ExcitedModel
from fowtlib.solving.linear import LinearModel, Resolvent, times
from fowtlib.solving.real_modes import RealModes


@dataclass(frozen=True, eq=False)
class Process:
    """A random process: its spectrum [unit^2 s/rad] over omega, and what it drives.

    driven: numbers of the inputs of the model that it drives; amplitudes: of these over omega, complex (q, driven,
    channels); inputs: number of all inputs.
    """

    density: Callable[[np.ndarray], np.ndarray]
    driven: np.ndarray
    amplitudes: Callable[[np.ndarray], np.ndarray]
    inputs: int

    def drive(self, omega: np.ndarray) -> np.ndarray:
        """What it drives of all inputs, complex (q, inputs, channels)."""
        found = self.amplitudes(omega)
        whole = np.zeros((len(found), self.inputs, found.shape[2]), dtype=complex)
        whole[:, self.driven] = found
        return whole


CANCELLED = 1e-7  # sum of a root and a conjugate one over their sizes, up to which sums cancel
NOTHING = 1e-35  # of the largest power at a frequency: what no resonance makes felt beside it

Processes = Mapping[str, Process]
"""The random processes by path."""


@dataclass(frozen=True, eq=False)
class Driving:
    """What one process drives: numbers of the inputs, and their amplitudes (inputs, q, k) by its channels.

    power: spectra of the channels (q, k, k) times what each frequency stands for.
    """

    inputs: np.ndarray
    drive: np.ndarray
    power: np.ndarray

    @cached_property
    def weighted(self) -> np.ndarray:
        """The drive by channels that are independent, with a variance of one at each frequency."""
        return np.ascontiguousarray((self.drive.transpose(1, 0, 2) @ _roots(self.power)).transpose(1, 0, 2))

    @cached_property
    def covariances(self) -> np.ndarray:
        """Of the inputs, what each frequency adds: (q, inputs, inputs), Hermitian."""
        drive = self.drive.transpose(1, 0, 2)
        return drive @ self.power @ drive.conj().transpose(0, 2, 1)

    @cached_property
    def moved(self) -> slice:
        """From the first to the last of the frequencies at which it has power: a sea has none at those of the drift."""
        power = np.trace(self.power, axis1=1, axis2=2).real
        there = np.flatnonzero(power > NOTHING * power.max(initial=0.0))
        return slice(int(there[0]), int(there[-1]) + 1) if there.size else slice(0, 0)

    @property
    def channels(self) -> int:
        """Number of channels of the process."""
        return self.drive.shape[2]

    def thinned(self, step: int, share: np.ndarray) -> Driving:
        """Every so many frequencies, which count by their shares (q,)."""
        return Driving(self.inputs, self.drive[:, ::step], self.power[::step] * share[:, None, None])


class Grid:
    """What does not change with the gains of drag, at frequencies (q,) [Hz].

    spectra: of the processes (q, channels, channels) per Hz. driving: what they drive.
    """

    def __init__(self, excited: ExcitedModel, frequency: np.ndarray, spectra: Mapping[str, np.ndarray],
                 driving: Mapping[str, Driving]):  # fmt: skip
        self.excited, self.frequency, self.omega = excited, frequency, 2 * np.pi * frequency
        self.spectra, self.driving = dict(spectra), dict(driving)

    @staticmethod
    def of(excited: ExcitedModel, processes: Processes, frequency: np.ndarray) -> Grid:
        """That of some processes."""
        omega, widths = 2 * np.pi * frequency, frequency_widths(frequency)[:, None, None]
        spectra: dict[str, np.ndarray] = {}
        driving: dict[str, Driving] = {}
        for path, process in processes.items():
            density = 2 * np.pi * np.asarray(process.density(omega))
            spectra[path] = density.reshape(len(density), *(density.shape[1:] or (1, 1)))
            drive = np.ascontiguousarray(process.amplitudes(omega).transpose(1, 0, 2), dtype=complex)
            if not (moved := drive.any(axis=(1, 2))).all():
                drive = drive[moved]
            driving[path] = Driving(process.driven[moved], drive, spectra[path] * widths)
        return Grid(excited, frequency, spectra, driving)

    def with_model(self, excited: ExcitedModel) -> Grid:
        """The same with another model that has the same inputs."""
        return Grid(excited, self.frequency, self.spectra, self.driving)

    def thinned(self, step: int) -> Grid:
        """Every so many frequencies of it, each as what stands for its neighbours."""
        frequency = self.frequency[::step]
        share = frequency_widths(frequency) / frequency_widths(self.frequency)[::step]
        driving = {path: one.thinned(step, share) for path, one in self.driving.items()}
        return Grid(self.excited, frequency, {path: S[::step] for path, S in self.spectra.items()}, driving)

    @cached_property
    def errors(self) -> np.ndarray | None:
        """Those of the realizations of operators; see Operators.errors."""
        operators = self.excited.linear.operators
        return operators.errors(self.omega) if operators is not None else None

    def answers(self, linear: LinearModel, outputs: int | None = None) -> dict[str, np.ndarray]:
        """Transfer functions (q, outputs, channels) by process, of the first outputs or of all."""
        linear = linear.first(outputs)
        A, B, C, D = (linear.matrices[name] for name in "ABCD")
        basis = eigenvectors(A) if linear.operators is None and len(A) else None
        modes = None if basis is None else RealModes.made(*basis)
        if modes is not None:
            return self._answers_of_modes(modes, B, C, D)
        resolvent, operators, found = Resolvent(self.omega, A), linear.operators, {}
        for path, one in self.driving.items():
            amplitudes = resolvent.driven(B[:, one.inputs], one.drive)
            y = times(D[:, one.inputs], one.drive)
            if operators is not None:
                direct = times(operators.D_input[:, one.inputs], one.drive)
                more, signals = operators.added(resolvent, amplitudes, direct, self.errors)
                amplitudes, y = amplitudes + more, y + times(operators.D_output, signals)
            y += times(C @ resolvent.shapes, amplitudes)
            found[path] = np.ascontiguousarray(y.transpose(1, 0, 2))
        return found

    def _answers_of_modes(self, modes: RealModes, B: np.ndarray, C: np.ndarray, D: np.ndarray) -> dict[str, np.ndarray]:
        """The same by the modes of a model without operators."""
        functions, found = modes.functions(self.omega), {}
        for path, one in self.driving.items():
            of, direct, inputs = B[:, one.inputs], D[:, one.inputs], one.inputs.size
            if inputs <= one.channels:  # the answers to each input are fewer than those of all modes
                by_input = flat_times(modes.between(C, of).reshape(-1, len(B)), functions)
                by_input = by_input.reshape(len(C), inputs, -1) + direct[:, :, None]
                found[path] = np.ascontiguousarray(by_input.transpose(2, 0, 1)) @ one.drive.transpose(1, 0, 2)
                continue
            parts = times(modes.of, times(of, one.drive)) if inputs > len(B) else times(modes.of @ of, one.drive)
            y = times(direct, one.drive) + times(C @ modes.shapes, modes.answers(functions, parts))
            found[path] = np.ascontiguousarray(y.transpose(1, 0, 2))
        return found

    @cached_property
    def _direct(self) -> dict[str, tuple[np.ndarray, np.ndarray | None, slice]]:
        """Rates of the states (n, q k) and inputs of the laws by the drive alone, of processes that drive many inputs.

        None: nothing drives the laws. With the frequencies at which the process has any power.
        """
        n, m, found = self.excited.driven, self.excited.results, {}
        B, D = self.excited.linear.matrices["B"], self.excited.linear.matrices["D"][m:, :n]
        for path, one in self.driving.items():
            if not self._few(one):
                drive = one.weighted[:, one.moved].reshape(len(one.inputs), -1)
                of_laws = D[:, one.inputs]
                u = flat_times(of_laws, drive) if of_laws.any() else None
                found[path] = flat_times(B[:, one.inputs], drive), u, one.moved
        return found

    def _few(self, one: Driving) -> bool:
        """Whether its inputs are so few that their covariances are less than the amplitudes of all modes."""
        return one.inputs.size**2 <= len(self.excited.linear.matrices["A"]) * one.channels

    def gains(self, gains: Sequence[np.ndarray]) -> list[np.ndarray]:
        """Gains of the laws of drag that suit the response with these gains: from the covariance of their inputs."""
        excited, linear = self.excited, self.excited.linear
        n, m = excited.driven, excited.results
        loop = excited.loop(gains)
        A, B, C, D = (linear.matrices[name] for name in "ABCD")
        basis = eigenvectors(A + B[:, n:] @ loop @ C[m:]) if linear.operators is None and len(A) else None
        modes = None if basis is None else RealModes.made(*basis)
        if basis is not None and modes is not None:
            covariances = self._covariances(loop, basis[0], basis[2], modes, C[m:] @ basis[1])
        else:
            covariance = self._covariance_by_answers(gains)
            covariances = [covariance[place, place] for _, place in excited.laws]
        return gains_of(covariances, [excited.means[place] for _, place in excited.laws])

    def _covariances(self, loop: np.ndarray, roots: np.ndarray, left: np.ndarray, modes: RealModes,
                     shapes: np.ndarray) -> list[np.ndarray]:  # fmt: skip
        """Of the inputs of each law, by the eigenvectors with them in the loop; shapes: of these inputs."""
        excited, n, m = self.excited, self.excited.driven, self.excited.results
        B, C, D = (excited.linear.matrices[name] for name in "BCD")
        added, groups = B[:, n:] @ loop, [rows for _, rows in excited.law_rows]
        through = np.eye(len(loop)) + D[m:, n:] @ loop if excited.laws_add else None
        totals = [np.zeros((*rows.shape, rows.shape[1])) for rows in groups]
        seen = shapes.any(axis=0)  # an angle that nothing depends on has a root of zero
        real_shapes = C[m:] @ modes.shapes
        if through is not None:
            shapes, real_shapes = through @ shapes, through @ real_shapes
        for path, one in self.driving.items():
            if path not in self._direct:
                direct = D[m:, one.inputs]
                own = direct if through is None else through @ direct
                by_inputs = left[seen] @ (B[:, one.inputs] + added @ direct)
                shares = 1 / (1j * self.omega - roots[seen, None])
                found = _of_few(one.covariances, roots[seen], shares, by_inputs, shapes[:, seen], own)
                for total, rows in zip(totals, groups, strict=True):
                    total += found[rows[:, :, None], rows[:, None, :]]
                continue
            rates, u, moved = self._direct[path]
            rates = rates if u is None else rates + flat_times(added, u)
            parts = flat_times(modes.of, rates).reshape(len(rates), -1, one.channels)
            amplitudes = modes.answers(modes.functions(self.omega[moved]), parts)
            y = flat_times(real_shapes, amplitudes.reshape(len(rates), -1))
            if u is not None:
                y += u if through is None else flat_times(through, u)
            y = y.view(float)
            for total, rows in zip(totals, groups, strict=True):
                in_order = bool((np.diff(rows.ravel()) == 1).all())
                of_each = (y[rows[0, 0] : rows[-1, -1] + 1] if in_order else y[rows]).reshape(*rows.shape, -1)
                total += of_each @ of_each.transpose(0, 2, 1)
        found_of: list[np.ndarray] = [totals[0][0]] * len(excited.laws)
        for (numbers, _), total in zip(excited.law_rows, totals, strict=True):
            for number, covariance in zip(numbers, total, strict=True):
                found_of[number] = covariance
        return found_of

    def _covariance_by_answers(self, gains: Sequence[np.ndarray]) -> np.ndarray:
        """The same by the inputs themselves at all frequencies: with operators, and without eigenvectors."""
        linear, m = self.excited.with_gains(gains), self.excited.results
        A, B, C, D = (linear.matrices[name] for name in "ABCD")
        resolvent, operators = Resolvent(self.omega, A), linear.operators
        total = np.zeros((len(C) - m,) * 2)
        for one in self.driving.values():
            amplitudes = resolvent.driven(B[:, one.inputs], one.weighted)
            u = times(D[m:, one.inputs], one.weighted)
            if operators is not None:
                direct = times(operators.D_input[:, one.inputs], one.weighted)
                more, signals = operators.added(resolvent, amplitudes, direct, self.errors)
                amplitudes, u = amplitudes + more, u + times(operators.D_output[m:], signals)
            u += times(C[m:] @ resolvent.shapes, amplitudes)
            total += _products(u, u).real
        return total


def _of_few(covariances: np.ndarray, roots: np.ndarray, shares: np.ndarray, by_inputs: np.ndarray,
            shapes: np.ndarray, own: np.ndarray) -> np.ndarray:  # fmt: skip
    """Covariance of y = shapes a + own f, from the covariances (q, m, m) of few inputs f by frequency.

    Amplitudes a = shares by_inputs f of modes, shares = 1/(i omega - roots). Of two modes a product of shares is their
    sum over that of the roots, s_j s_k* = -(s_j + s_k*)/(roots_j + roots_k*): so sums over the frequencies are those of
    shares times covariances, and nothing has the size of modes by modes by frequencies.
    """
    q, m, _ = covariances.shape
    sums = (shares @ covariances.reshape(q, m * m)).reshape(-1, m, m)
    crossed = (by_inputs[:, None, :] @ sums)[:, 0]  # of each mode with the inputs
    both = roots[:, None] + roots.conj()
    if np.any(np.abs(both) <= CANCELLED * (np.abs(roots)[:, None] + np.abs(roots))):
        # a mode that neither decays nor grows: frequency by frequency
        a = shares.T[:, :, None] * by_inputs
        products = (a @ covariances @ a.conj().transpose(0, 2, 1)).sum(axis=0)
    else:
        products = crossed @ by_inputs.conj().T
        products = -(products + products.conj().T) / both
    mixed = (shapes @ crossed @ own.T).real
    return (shapes @ products @ shapes.conj().T).real + mixed + mixed.T + own @ covariances.sum(axis=0).real @ own.T


def flat_times(matrix: np.ndarray, values: np.ndarray) -> np.ndarray:
    """A real matrix (m, n) times complex values (n, l)."""
    return (matrix @ values.view(float)).view(complex)


def frequency_widths(frequency: np.ndarray) -> np.ndarray:
    """What each frequency stands for [Hz]."""
    steps = np.diff(frequency)
    return (np.append(steps, 0.0) + np.append(0.0, steps)) / 2


def _products(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Sums of a b^H over frequencies and channels, of (n, q, k) and (m, q, k)."""
    return a.reshape(len(a), -1) @ b.reshape(len(b), -1).conj().T


def _roots(S: np.ndarray) -> np.ndarray:
    """R (q, k, k) with R R^H = S, of Hermitian S without negative eigenvalues."""
    if S.shape[1] == 1:
        return np.sqrt(np.maximum(S.real, 0.0))
    values, vectors = np.linalg.eigh(S)
    return vectors * np.sqrt(np.maximum(values, 0.0))[:, None, :]
