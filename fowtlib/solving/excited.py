"""The linear model about a mean, from the signals that drive it at random, with quadratic laws as linear ones.

Signals are what the parts take from waves and wind (`run_time_series`); they are inputs here, and each part says how
its own follow from the process. A quadratic law |u| u (drag) has hardly a slope at a mean of zero. Its best linear law
for a random u is G u, with a matrix G of the covariance of u (language.quadratic_laws); `with_gains` puts such matrices
in.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import casadi as ca
import numpy as np

from fowtlib.flattening import FlatDAE
from fowtlib.language.component import Component
from fowtlib.language.eigenvectors import eigenvectors
from fowtlib.language.quadratic_laws import slope_at
from fowtlib.language.run_time import RandomSignals
from fowtlib.solving.functions import AtParameters
from fowtlib.solving.linear import Further, LinearModel
from fowtlib.solving.mean_linear import RotatingLinearModel, rotating_linear_model
from fowtlib.solving.modes import rate_states
from fowtlib.solving.random_fields import FieldPlaces, field_places
from fowtlib.solving.state import State
from fowtlib.solving.turning import turns_of

MOST_SLOW = 0.7  # of the states, up to which a model of the slow ones is worth its making


@dataclass(frozen=True, eq=False)
class Signal:
    """Signals that follow a random process: their path, their columns of the inputs, who knows the process.

    outputs: their places among the outputs of all externals.
    """

    path: str
    owner: str
    columns: slice
    outputs: slice
    compute: RandomSignals

    def elements(self, dae: FlatDAE) -> list[ca.SX]:
        """Their symbols."""
        return dae.w[self.outputs].elements()

    def process(self, root: Component) -> Any:
        """The component of a run that they follow."""
        return self.compute.process(self._component(root))

    def response(self, root: Component, omega: np.ndarray) -> np.ndarray:
        """Signals per channel of the process, complex (q, signals, channels)."""
        return np.asarray(self.compute.response(self._component(root), omega))

    def numbers(self, root: Component) -> np.ndarray | None:
        """Numbers (n,) from which alone the signals follow, and from what is said `besides`; None: there are none."""
        known = getattr(self.compute, "numbers", None)
        return None if known is None else known(self._component(root))

    def number_slopes(self, root: Component, tangent: Any) -> np.ndarray | None:
        """Changes (n, m) of these numbers, where parameters change by tangents; None: only differences know them."""
        known = getattr(self.compute, "number_slopes", None)
        return None if known is None else known(self._component(root), tangent)

    def besides(self, root: Component) -> Any:
        """What else signals with such numbers follow from."""
        return self.compute.besides(self._component(root))

    def slopes(self, root: Component, omega: np.ndarray, moved: np.ndarray) -> np.ndarray:
        """Slopes (m, q, signals, channels) of such signals along changes (m, n) of their numbers."""
        return np.asarray(self.compute.slopes(self._component(root), omega, moved))

    def _component(self, root: Component) -> Any:
        return root.find(self.owner)


@dataclass(frozen=True, eq=False)
class Forces:
    """What generalised forces on the motions do, one of them each: rates of states B, outputs D, inputs of operators.

    speeds: numbers of the states whose rates they change, as many as there are forces.
    """

    speeds: tuple[int, ...]
    B: np.ndarray
    D: np.ndarray
    D_operators: np.ndarray | None


@dataclass(frozen=True, eq=False)
class ExcitedModel:
    """Linear model whose inputs are signals, channels of fields, and then what is added to quadratic laws; see above.

    linear: its outputs are the results, what these have of the turning of rotors (solving.mean_linear.Turning), and
    then the inputs of the laws. fields: columns of the inputs, and the places of one component of one field; bases: by
    their number what these columns are sums of, where they are, see RandomField.density. laws: paths of the laws, and
    their columns among what is added. results: number of the first and second of these outputs. means: of the
    inputs of the laws. forces: see Forces. further: what of the flat model these inputs and outputs are. beside: what
    is added to other rows of [ode; alg; outputs], which were asked for. smoothing: of each law.
    """

    linear: LinearModel
    signals: tuple[Signal, ...]
    fields: tuple[tuple[slice, tuple[FieldPlaces, ...]], ...]
    laws: tuple[tuple[str, slice], ...]
    results: int
    means: np.ndarray
    forces: Forces
    rotating: RotatingLinearModel
    further: Further
    bases: Mapping[int, np.ndarray] = field(default_factory=dict)
    beside: Forces | None = None
    smoothing: tuple[float, ...] = ()

    @cached_property
    def compact(self) -> dict[Any, ExcitedModel]:
        """The same with sums of channels of fields, as they are found; see frequency.few_channels."""
        return {}

    @cached_property
    def driven(self) -> int:
        """Number of the signals and channels, one by one."""
        return len(self.linear.inputs) - sum(place.stop - place.start for _, place in self.laws)

    @cached_property
    def slopes(self) -> list[np.ndarray]:
        """What the linear model has of each law by itself."""
        return [slope_at(self.means[place], s) for s, (_, place) in zip(self.smoothing, self.laws, strict=True)]

    @cached_property
    def law_rows(self) -> list[tuple[list[int], np.ndarray]]:
        """The laws of each number of inputs: which they are, and the rows of these inputs (laws, inputs)."""
        found: dict[int, tuple[list[int], list[np.ndarray]]] = {}
        for number, (_, place) in enumerate(self.laws):
            numbers, rows = found.setdefault(place.stop - place.start, ([], []))
            numbers.append(number)
            rows.append(np.arange(place.start, place.stop))
        return [(numbers, np.array(rows)) for numbers, rows in found.values()]

    @cached_property
    def laws_add(self) -> bool:
        """Whether what the laws add is felt by their inputs at once."""
        return bool(self.linear.matrices["D"][self.results :, self.driven :].any())

    def slow(self, fastest: float) -> ExcitedModel:
        """Its modes with roots below `fastest` [rad/s], with the inputs of the laws as the only outputs.

        The model itself where it has operators, or no eigenvectors, or hardly anything that is faster.
        """
        if fastest not in self._slow:
            self._slow.clear()
            self._slow[fastest] = self._reduced(fastest)
        return self._slow[fastest]

    @cached_property
    def _slow(self) -> dict[float, ExcitedModel]:
        return {}

    def _reduced(self, fastest: float) -> ExcitedModel:
        A, B, C, D = (self.linear.matrices[name] for name in "ABCD")
        basis = eigenvectors(A) if self.linear.operators is None and len(A) else None
        if basis is None:
            return self
        roots, right, left = basis
        slow = np.flatnonzero((np.abs(roots) < fastest) & (roots.imag >= 0))
        pairs = slow[roots[slow].imag > 0]
        if slow.size + pairs.size > MOST_SLOW * len(A):
            return self
        to = np.hstack([right[:, slow].real, right[:, pairs].imag])  # x = to q, with real amplitudes q
        weight = np.where(roots[slow].imag > 0, 2.0, 1.0)[:, None]
        of = np.vstack([weight * left[slow].real, -2 * left[pairs].imag])
        states = [f"mode {k + 1}" for k in range(len(of))]
        laws = self.linear.outputs[self.results :]
        linear = LinearModel(of @ A @ to, of @ B, C[self.results :] @ to, D[self.results :], states,
                             self.linear.inputs, laws, self.linear.units)  # fmt: skip
        return replace(self, linear=linear, results=0)

    def damped(self, rate: float) -> ExcitedModel:
        """The model all of whose roots have `rate` [1/s] taken off."""
        linear = self.linear
        A, B, C, D = (linear.matrices[name] for name in "ABCD")
        return replace(self, linear=LinearModel(A - rate * np.eye(len(A)), B, C, D, linear.states, linear.inputs,
                                                linear.outputs, linear.units, linear.operators))  # fmt: skip

    def loop(self, gains: Sequence[np.ndarray]) -> np.ndarray:
        """What the laws add, from their inputs without them."""
        n, m = self.driven, self.results
        D = self.linear.matrices["D"][m:, n:]
        G = np.zeros((D.shape[1], D.shape[1]))
        for (_, place), gain, slope in zip(self.laws, gains, self.slopes, strict=True):
            np.subtract(gain, slope, out=G[place, place])
        return np.linalg.solve(np.eye(len(G)) - G @ D, G) if self.laws_add else G

    def states_with(self, gains: Sequence[np.ndarray]) -> np.ndarray:
        """State matrix of the model with linear laws; see with_gains."""
        A, B, C = (self.linear.matrices[name] for name in "ABC")
        return A + B[:, self.driven :] @ self.loop(gains) @ C[self.results :]

    def with_gains(self, gains: Sequence[np.ndarray]) -> LinearModel:
        """The linear model from what drives it to the results and the inputs u of the laws, which give gain @ u.

        u about its mean; gains: whole slopes, of which those at the mean are in the linear model already.
        """
        n, m = self.driven, self.results
        linear, loop = self.linear, self.loop(gains)
        A, B, C, D = (linear.matrices[name] for name in "ABCD")
        A, B = A + B[:, n:] @ loop @ C[m:], B[:, :n] + B[:, n:] @ loop @ D[m:, :n]
        C, D = C + D[:, n:] @ loop @ C[m:], D[:, :n] + D[:, n:] @ loop @ D[m:, :n]
        operators = linear.operators
        if operators is not None:
            operators = operators.fed_back(loop, n, m, linear.matrices)
        return LinearModel(A, B, C, D, linear.states, linear.inputs[:n], linear.outputs, linear.units, operators)


def excited_model(plant: Any, state: State, names: Sequence[str], off: Any = None,
                  beside: tuple[int, ...] = ()) -> ExcitedModel:  # fmt: skip
    """The linear model of a plant at a mean state, from all that follows from random processes in a run of this mean.

    names: results and variables. off: see Further. beside: rows, see ExcitedModel.
    All runs of one mean have it in common: what there is of waves and
    of turbulence in each of them is no part of it.
    """
    dae, at = plant.dae, plant.at(state.parameters)
    places = field_places(plant, at, state, turns_of(plant, at, state))
    asked = tuple((item.owner, item.path, item.part, item.external, item.places.channels) for item in places)
    driven = at.general.once(("driven", asked), lambda: _driven(dae, places))
    fields, raw, start = [], driven.signal_count, driven.signal_count
    for owner, part in dict.fromkeys((item.owner, item.part) for item in places):
        members = tuple(item for item in places if (item.owner, item.part) == (owner, part))
        fields.append((slice(start, start := start + sum(item.places.channels for item in members)), members))

    def mixing(*point: Any) -> np.ndarray:
        rows, laws = driven.rows, driven.law_count
        whole = np.zeros((len(rows) + laws, start + laws))
        whole[:raw, :raw], whole[len(rows) :, start:] = np.eye(raw), np.eye(laws)
        for columns, members in fields:
            column = columns.start
            for item in members:
                block = item.mixing(at, *point)
                whole[[rows[name] for name in item.velocities], column : column + block.shape[1]] = block
                column += block.shape[1]
        return whole

    speeds, rows = at.functions.once("motions", lambda: _motions(at))
    further = Further(driven.symbols, driven.outputs, driven.labels, mixing if fields else None, (*rows, *beside), off)
    rotating = rotating_linear_model(plant, state, (), names, further, turning=True)
    linear, more = _without_forces(rotating.linear, (), len(beside))
    linear, forces = _without_forces(linear, speeds, len(rows))
    means = means_of_laws(at, state)
    return ExcitedModel(linear, driven.signals, tuple(fields), driven.laws, rotating.shown, means, forces, rotating,
                        replace(further, added=()), beside=more if beside else None,
                        smoothing=tuple(law.smoothing for law in dae.quadratics))  # fmt: skip


@dataclass(frozen=True, eq=False)
class _Driven:
    """What random processes drive in the flat model, and its laws, by structure alone; see ExcitedModel and Further.

    rows: of what signals and fields drive, by name, in the mixing of Further.
    """

    signals: tuple[Signal, ...]
    laws: tuple[tuple[str, slice], ...]
    symbols: dict[str, ca.SX]
    labels: tuple[str, ...]
    outputs: dict[str, ca.SX]
    rows: dict[str, int]
    signal_count: int
    law_count: int


def _driven(dae: FlatDAE, places: Sequence[FieldPlaces]) -> _Driven:
    signals = _signals(dae)
    symbols = {f"{item.path} [{k}]": element for item in signals for k, element in enumerate(item.elements(dae))}
    labels, raw = list(symbols), len(symbols)
    for owner, part in dict.fromkeys((item.owner, item.part) for item in places):
        for item in (item for item in places if (item.owner, item.part) == (owner, part)):
            velocities = dae.w[dae.externals[item.external].outputs].elements()
            symbols |= dict(zip(item.velocities, velocities, strict=True))
            labels += item.labels
    rows = {name: k for k, name in enumerate(symbols)}  # of the mixing; laws come behind
    laws, outputs, first = [], {}, 0
    for number, law in enumerate(dae.quadratics):
        n = law.added.numel()
        symbols |= (added := {f"law {number} added [{k}]": symbol for k, symbol in enumerate(law.added.elements())})
        labels += added
        outputs |= {f"law {number} of [{k}]": element for k, element in enumerate(law.inputs.elements())}
        laws.append((law.path, slice(first, first + n)))
        first += n
    return _Driven(tuple(signals), tuple(laws), symbols, tuple(labels), outputs, rows, raw, first)


def _motions(at: AtParameters) -> tuple[list[str], tuple[int, ...]]:
    """Speeds by path, and the rows of [ode; alg] at which forces on the motions stand.

    These are the equations of motion, where accelerations are unknowns, else the rates of the speeds themselves.
    """
    dae, jacobian = at.dae, at.functions.jacobian
    speeds = sorted(set(rate_states(dae).values()))
    pairs = [(row, column) for row, column in zip(*jacobian.sparsity_out(1).get_triplet(), strict=True)
             if row in set(speeds)]  # fmt: skip
    accelerations = {column for _, column in pairs}
    inside = zip(*jacobian.sparsity_out(3).get_triplet(), strict=True)
    motion = sorted({row for row, column in inside if column in accelerations})
    explicit = [row for row in speeds if row not in {row for row, _ in pairs}]
    if len(motion) != len(speeds) - len(explicit):  # they cannot be told from other equations
        return [], ()
    nx = dae.x.numel()
    return [dae.states[k].path for k in speeds], (*explicit, *(nx + row for row in motion))


def _without_forces(linear: LinearModel, speeds: Sequence[str], count: int) -> tuple[LinearModel, Forces]:
    """The model without its last inputs, and these."""
    A, B, C, D = (linear.matrices[name] for name in "ABCD")
    n, operators, own = B.shape[1] - count, linear.operators, None
    if operators is not None:
        own = operators.D_input[:, n:]
        operators = replace(operators, D_input=operators.D_input[:, :n])
    places = tuple(linear.states.index(path) for path in speeds if path in linear.states)
    rest = LinearModel(A, B[:, :n], C, D[:, :n], linear.states, linear.inputs[:n], linear.outputs, linear.units,
                       operators)  # fmt: skip
    return rest, Forces(places, B[:, n:], D[:, n:], own)


def means_of_laws(at: AtParameters, state: State) -> np.ndarray:
    """The inputs of all quadratic laws at the mean."""
    laws = [law.inputs for law in at.dae.quadratics]
    if not laws:
        return np.zeros(0)
    inputs = at.general.once("inputs of laws", lambda: at.general.function("inputs_of_laws", [ca.vertcat(*laws)]))
    return at.arrays(inputs, state.t, state.x, state.z, np.concatenate([state.u, state.d]))[0].ravel()


def _signals(dae: FlatDAE) -> list[Signal]:
    """All signals of a model that say how they follow from a random process."""
    found, first = [], 0
    for number, item in dae.with_data:
        if hasattr(item.compute, "response"):
            outputs = dae.externals[number].outputs
            last = first + outputs.stop - outputs.start
            found.append(Signal(item.path, item.owner, slice(first, last), outputs, item.compute))
            first = last
    return found
