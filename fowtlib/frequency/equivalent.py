"""Equivalent linearisation of a whole model: mean and linear model that suit the response which they have.

A linear model about the mean in mean wind knows nothing of a corner beside it, of a table that curves, of products of
fluctuations. In its place stands the linear model nearest in the mean square, for states, unknowns and signals that are
Gaussian with the covariance of the response itself: expected values and slopes of all equations and results
(frequency.expectations), about the mean at which the expected rates vanish. Covariance, mean and linear model are found
together, each iteration going half of the way, as soon as it lasts on the same frequencies.

Products of fluctuations are in it by what they do to the mean and to the slopes; what they add as a load of their own,
at sums and differences of frequencies, is not.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from fowtlib.analysis.plants import UnstableError, refuse_unstable
from fowtlib.frequency.corners import covariance, with_states
from fowtlib.frequency.driven import Grid, Processes
from fowtlib.frequency.expectations import Expectations, Expected, Gaussian
from fowtlib.frequency.settling import settled_gains
from fowtlib.language.eigenvectors import eigenvalues
from fowtlib.language.errors import ModelError, SimulationError
from fowtlib.solving import State
from fowtlib.solving.equilibrium import moving_states
from fowtlib.solving.excited import ExcitedModel, excited_model, means_of_laws
from fowtlib.solving.linear import Further, slopes_of

ITERATIONS = 60
SHORTEST = 0.25  # of the way to the covariance that is found: each time the changes grow it is half of what it was
SETTLED = 0.01  # change of a deviation of a result, and distance of the covariance from the one found, at which it ends
CLOSE = 0.02  # step of the mean over the deviation of a state, too
HELD = 0.05  # from which the frequencies stay
CALM = 0.3  # of the covariance by the tangent, the first guess: near a corner it is far too large
DAMPED = 1.5  # times the growth of the fastest growing mode, taken off all roots for a first guess

NOWHERE = (
    "the mean of the equivalent linearisation is not found: the deviations reach to where the equations have no values, "
    "or no mean balances them. Take linearisation='tangent', or runs."
)

Driven = Callable[[ExcitedModel], Processes]
"""The random processes that drive a linear model."""


@dataclass(frozen=True, eq=False)
class Equivalent:
    """What was found: mean state, linear model with gains of its drag, frequencies; means of results in SI."""

    state: State
    excited: ExcitedModel
    gains: list[np.ndarray]
    grid: Grid
    iterations: int
    shown: np.ndarray


class _Rows:
    """The equations and results of a plant, as a linear model has them, with their expected values."""

    def __init__(self, plant: Any, state: State, names: Sequence[str], further: Further):
        self.plant, self.at = plant, plant.at(state.parameters)
        self.slopes = slopes_of(self.at, plant.layout, plant.outputs, [], names, further)
        self.symbols = [symbol for name, symbol in further.symbols.items() if not name.startswith("law ")]
        key = "expectations", tuple(names), tuple(further.symbols)
        self.of = plant.functions.once(key, lambda: Expectations(plant, self.at, self.slopes.rows, self.symbols))
        self.further, self.expected, self.step = further, None, np.inf
        self.moving = moving_states(self.at.functions, set())

    def mixing(self, state: State, inputs: int) -> np.ndarray:
        """Signals by the inputs of the linear model."""
        count = len(self.symbols)
        if self.further.mixing is None:
            return np.eye(count)
        q = np.concatenate([state.u, state.d])
        return self.further.mixing(state.t, state.x, state.z, q)[:count, :inputs]

    def stepped(self, state: State, law: Gaussian) -> tuple[State, Expected, tuple[np.ndarray, ...]]:
        """The mean one step of Newton nearer to where the expected rates vanish, and how slopes differ from those there."""
        q, n = np.concatenate([state.u, state.d]), state.x.size
        known = None if self.expected is None else (self.expected.by_x, self.expected.by_z, self.expected.by_signals)
        self.of.at = self.at
        found = self.of(state.t, state.x, state.z, q, means_of_laws(self.at, state), law, known)
        self.expected = found
        rows = [*self.moving, *range(n, n + state.z.size)]
        slopes = np.hstack([found.by_x[:, self.moving], found.by_z])[rows]
        if not np.all(np.isfinite(slopes)) or not np.all(np.isfinite(found.values)):
            raise SimulationError(NOWHERE)
        try:
            step = -np.linalg.solve(slopes, found.values[rows])
        except np.linalg.LinAlgError:
            raise SimulationError(NOWHERE) from None
        moved = step[: len(self.moving)] + (found.mean - state.x)[self.moving]
        self.step = float(np.max(np.abs(moved) / np.maximum(_of_states(law, n)[self.moving], 1e-9 * (1 + np.abs(state.x[self.moving]))), initial=0.0))
        x = found.mean.copy()
        x[self.moving] += step[: len(self.moving)]
        paths = [item.path for item in self.at.dae.states]
        new = self.plant.initial_state(state.parameters, dict(zip(paths, x.tolist(), strict=True)))
        whole = np.concatenate([q, self.at.parameters, np.zeros(law.signals), means_of_laws(self.at, new)])
        there = self.of.disturbed.slopes(new.t, new.x, new.z, whole)
        off = tuple(a - b for a, b in zip((found.by_x, found.by_z, found.by_signals), there, strict=True))
        return new, found, off


def equivalent(plant: Any, state: State, names: Sequence[str], driven: Driven, frequency: np.ndarray | None,
               tolerance: float) -> Equivalent:  # fmt: skip
    """The equivalent linearisation that starts from a mean state in mean wind; see the module.

    SimulationError where the fixed point is not found. ModelError where rotors turn in their own coordinates.
    """
    excited = excited_model(plant, state, names)
    if excited.rotating.average is not None:
        raise ModelError(
            "the equivalent linearisation is there for models without rotors of blade elements that turn. Take a rotor of "
            "coefficients, or linearisation='tangent'."
        )
    rows, guess, last, given = _Rows(plant, state, names, excited.further), None, None, frequency
    gains: list[np.ndarray] | None = None
    for iteration in range(1, ITERATIONS + 1):
        processes = driven(excited)
        settled, damping = _settled(excited, processes, given, tolerance, gains)
        excited, gains, grid = settled
        found, deviations = _covariances(excited, gains, grid)
        change = np.inf if last is None else max(_change(deviations, last), _change(_deviations(found), _deviations(guess)))
        if rows.step < CLOSE and change < SETTLED and not damping:
            shown = (rows.slopes.scale.ravel() * rows.expected.values[state.x.size + state.z.size :])[: excited.results]
            return Equivalent(state, excited, gains, grid, iteration, shown)
        if last is not None and _change(deviations, last) < HELD:
            given = grid.frequency
        guess = CALM * found if guess is None else guess + min(1.0, WHOLE / iteration) * (found - guess)
        last = deviations
        at = [[item.path for item in plant.dae.states].index(path) for path in excited.linear.states]
        M = rows.mixing(state, excited.driven)
        to = np.vstack([np.hstack([np.eye(len(at)), np.zeros((len(at), M.shape[1]))]),
                        np.hstack([np.zeros((len(M), len(at))), M])])  # fmt: skip
        state, _, off = rows.stepped(state, Gaussian(at, to @ guess @ to.T, len(M)))
        excited = excited_model(plant, state, names, off)
    raise SimulationError(
        f"the equivalent linearisation does not settle within {ITERATIONS} iterations; the last change of a deviation is "
        f"{change:.2g}. Take linearisation='tangent', or runs."
    )


def _settled(excited: ExcitedModel, processes: Processes, frequency: np.ndarray | None,
             tolerance: float, start: Sequence[np.ndarray] | None,
             ) -> tuple[tuple[ExcitedModel, list[np.ndarray], Grid], float]:  # fmt: skip
    """The model with gains of its drag and frequencies, and what was taken off its roots so that it is stable."""
    try:
        if start is not None:
            refuse_unstable(excited.with_gains(start))
        gains, grid, _ = settled_gains(excited, processes, frequency, tolerance, start)
        return (excited, gains, grid), 0.0
    except UnstableError as error:
        first = error
    damping = DAMPED * float(eigenvalues(excited.linear.matrices["A"]).real.max(initial=0.0))
    for _ in range(6):
        calm = excited.damped(max(damping, 1e-4))
        try:
            gains, grid, _ = settled_gains(calm, processes, frequency, tolerance)
            return (calm, gains, grid), damping
        except UnstableError:
            damping *= 2
    raise first


def _covariances(excited: ExcitedModel, gains: Sequence[np.ndarray], grid: Grid) -> tuple[np.ndarray, np.ndarray]:
    """Covariance of [states; inputs], and standard deviations of the results."""
    linear = excited.with_gains(gains)
    n, m = len(linear.states), excited.results
    H = grid.answers(with_states(linear, m, np.eye(n), linear.states))
    both: dict[str, np.ndarray] = {}
    for path, answer in H.items():
        drive = np.zeros((len(answer), excited.driven, answer.shape[2]), dtype=complex)
        drive[:, grid.driving[path].inputs] = grid.driving[path].drive.transpose(1, 0, 2)
        both[path] = np.concatenate([answer[:, m:], drive], axis=1)
    shown: Mapping[str, np.ndarray] = {path: answer[:, :m] for path, answer in H.items()}
    of_results = covariance(shown, grid.spectra, grid.frequency)
    return covariance(both, grid.spectra, grid.frequency), _deviations(of_results)


def _deviations(covariance: np.ndarray) -> np.ndarray:
    return np.sqrt(np.maximum(np.diag(covariance), 0.0))


def _of_states(law: Gaussian, count: int) -> np.ndarray:
    """Deviations of all states (count,)."""
    found = np.zeros(count)
    found[list(law.states)] = _deviations(law.covariance)[: len(law.states)]
    return found


def _change(new: np.ndarray, old: np.ndarray) -> float:
    """The largest relative change of a deviation that is one."""
    moves = new > 1e-9 * new.max(initial=0.0)
    return float(np.max(np.abs(new - old)[moves] / new[moves], initial=0.0))
