"""The mean at which expected rates of a model vanish, and the slopes that belong to it; see frequency.equivalent."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
from scipy.linalg import block_diag

from fowtlib.frequency.expectations import Expectations, Expected, Gaussian, LawExpectations
from fowtlib.frequency.quadratic_rows import QuadraticRows
from fowtlib.language.errors import SimulationError
from fowtlib.solving import State
from fowtlib.solving.disturbed import DisturbedRows
from fowtlib.solving.equilibrium import moving_states
from fowtlib.solving.excited import ExcitedModel, means_of_laws
from fowtlib.solving.linear import Further, slopes_of

NOWHERE = (
    "the mean of the equivalent linearisation is not found: the deviations reach to where the equations have no "
    "values, or no mean balances them. Take linearisation='tangent', or runs."
)

LOOSE = 1e-11  # singular value over the largest one, from which a direction is held by no row
STILL = 1e-3  # of the size of a state, the least deviation: one at its limit has none
LEFT = 1e-8  # of the right-hand sides, that a solution may leave

Off = tuple[np.ndarray, np.ndarray, np.ndarray]
"""By how much slopes of the first rows are others than those at a point, by states, unknowns and signals."""


class RestingRows:
    """The equations and results of a plant, as a linear model has them, with their expected values."""

    def __init__(self, plant: Any, state: State, names: Sequence[str], further: Further, quadratic: bool):
        self.plant, self.at = plant, plant.at(state.parameters)
        self.slopes = slopes_of(self.at, plant.layout, plant.outputs, [], names, further)
        self.symbols = [symbol for name, symbol in further.symbols.items() if not name.startswith("law ")]
        key = "disturbed", tuple(names), tuple(further.symbols)
        make = partial(DisturbedRows, plant.dae, self.slopes.rows, self.symbols)
        self.of = Expectations(plant, self.at, plant.functions.once(key, make), quadratic)
        self.further, self.step = further, np.inf
        self.expected: Expected | None = None
        self.slopes_so_far: list[np.ndarray] = []
        self.moving = moving_states(self.at.functions, set())
        self.to = np.zeros((0, 0))

    def wanted(self, excited: ExcitedModel) -> list[int] | None:
        """None: all states, and inputs, count alike."""
        return None

    def mixing(self, state: State, inputs: int) -> np.ndarray:
        """Signals by the inputs of the linear model."""
        count = len(self.symbols)
        if self.further.mixing is None:
            return np.eye(count)
        q = np.concatenate([state.u, state.d])
        return self.further.mixing(state.t, state.x, state.z, q)[:count, :inputs]

    def stepped(self, excited: ExcitedModel, state: State, guess: np.ndarray, share: float) -> tuple[State, Off]:
        """The mean one step of Newton nearer to where expected rates vanish, and how slopes differ from those there.

        guess: covariance of [states; inputs] of the linear model. share: of these slopes, beside those so far.
        """
        at = [[item.path for item in self.at.dae.states].index(path) for path in excited.linear.states]
        M = self.mixing(state, len(guess) - len(at))
        self.to = to = block_diag(np.eye(len(at)), M)
        law = Gaussian(at, to @ guess @ to.T, len(M))
        q, n = np.concatenate([state.u, state.d]), state.x.size
        known = None if self.expected is None else (self.expected.by_x, self.expected.by_z, self.expected.by_signals)
        try:
            found = self.of(state.t, state.x, state.z, q, means_of_laws(self.at, state), law, known)
        except (RuntimeError, np.linalg.LinAlgError):  # an equation cannot be evaluated somewhere, or holds no unknown
            raise SimulationError(NOWHERE) from None
        self.expected = found
        rows = [*self.moving, *range(n, n + state.z.size)]
        slopes = np.hstack([found.by_x[:, self.moving], found.by_z])[rows]
        if not np.all(np.isfinite(slopes)) or not np.all(np.isfinite(found.values)):
            raise SimulationError(NOWHERE)
        step = -_solved(slopes, found.values[rows])
        moved = step[: len(self.moving)] + (found.mean - state.x)[self.moving]
        self.step = _over(moved, states_of(law, n)[self.moving], state.x[self.moving])
        x = found.mean.copy()
        x[self.moving] += step[: len(self.moving)]
        paths = [item.path for item in self.at.dae.states]
        new = self.plant.initial_state(state.parameters, dict(zip(paths, x.tolist(), strict=True)))
        new = replace(new, z=found.unknowns + step[len(self.moving) :])  # expected unknowns solve expected equations
        whole = np.concatenate([q, self.at.parameters, np.zeros(law.signals), means_of_laws(self.at, new)])
        there = self.of.disturbed.slopes(new.t, new.x, new.z, whole)
        own = (found.by_x, found.by_z, found.by_signals)
        self.slopes_so_far = [old + share * (by - old) for old, by in zip(self.slopes_so_far or own, own, strict=True)]
        by_x, by_z, by_signals = (by - at for by, at in zip(self.slopes_so_far, there, strict=True))
        return new, (by_x, by_z, by_signals)

    @property
    def quadratic(self) -> QuadraticRows | None:
        """What the rows are of second order, by [states; inputs] of the linear model."""
        found = None if self.expected is None else self.expected.quadratic
        return None if found is None else replace(found, whitening=found.whitening @ self.to)

    @property
    def shown(self) -> np.ndarray | None:
        """Expected results in their units."""
        if self.expected is None:
            return None
        first = self.expected.by_x.shape[1] + self.expected.by_z.shape[1]
        return self.slopes.scale.ravel() * self.expected.values[first : first + self.slopes.scale.size]


class TurningRows:
    """The same of a model in which rotors of blade elements turn: its laws with corners alone (frequency.corners)."""

    shown: np.ndarray | None = None
    quadratic: QuadraticRows | None = None

    def __init__(self, plant: Any, state: State):
        self.plant, self.at, self.step = plant, plant.at(state.parameters), np.inf
        self.of = LawExpectations(plant, self.at)

    def wanted(self, excited: ExcitedModel) -> list[int]:
        """Numbers of the states of the linear model that laws follow from."""
        paths = {self.at.dae.states[k].path for k in self.of.laws.moving}
        return [k for k, path in enumerate(excited.linear.states) if path in paths]

    def stepped(self, excited: ExcitedModel, state: State, guess: np.ndarray, share: float) -> tuple[State, Off]:
        """See the other; the mean is that over a revolution, and the slopes are those of this guess alone."""
        average, mean = excited.rotating.average, excited.rotating.mean
        paths = [item.path for item in self.at.dae.states]
        own = [k for k, path in enumerate(excited.linear.states) if path in set(paths)]
        numbers = [paths.index(excited.linear.states[k]) for k in own]
        law = Gaussian(numbers, guess[np.ix_(own, own)], 0)
        laws = self.of(state.t, state.x, np.concatenate([state.u, state.d]), law)
        n, free = state.x.size, average.free
        rates, slopes = mean.rates.copy(), mean.slopes[:, :n].copy()
        for number, value, row in laws.rows:
            k = laws.followers.index(number) if number in laws.followers else None
            rates[number] = value if k is None else laws.pace[k] * (laws.means[k] - state.x[number])
            slopes[number] = row
        if not np.all(np.isfinite(slopes)) or not np.all(np.isfinite(rates)):
            raise SimulationError(NOWHERE)
        try:
            step = -np.linalg.solve(slopes[np.ix_(free, free)], rates[free])
        except np.linalg.LinAlgError:
            raise SimulationError(NOWHERE) from None
        known = np.isin(free, numbers)
        self.step = _over(step[known], states_of(law, n)[free][known], state.x[free][known])
        y = average.multiblade.from_states(state.x)
        y[free] += step
        x = average.multiblade.to_states(y)
        new = self.plant.initial_state(state.parameters, dict(zip(paths, x.tolist(), strict=True)))
        there = self.of.tangents(new.t, new.x, np.concatenate([new.u, new.d]))
        off = np.zeros((n, n))
        for number, _, row in laws.rows:
            off[number] = row - there[number]
        return new, (off, np.zeros((0, 0)), np.zeros((0, 0)))


def deviations_of(covariance: np.ndarray) -> np.ndarray:
    """Square roots of the diagonal."""
    return np.sqrt(np.maximum(np.diag(covariance), 0.0))


def states_of(law: Gaussian, count: int) -> np.ndarray:
    """Deviations of all states (count,)."""
    found = np.zeros(count)
    found[list(law.states)] = deviations_of(law.covariance)[: len(law.states)]
    return found


def _solved(slopes: np.ndarray, values: np.ndarray) -> np.ndarray:
    """The solution; of rows that do not hold all unknowns, as those of a rotor without wind do not, the shortest one.

    It is that of rows and columns of the size of one. SimulationError where there is none.
    """
    try:
        return np.linalg.solve(slopes, values)
    except np.linalg.LinAlgError:
        pass
    by_row = 1 / np.maximum(np.abs(slopes).max(axis=1), 1e-300)
    by_row[by_row > 1e299] = 1.0
    level = slopes * by_row[:, None]
    by_column = 1 / np.where(level.any(axis=0), np.abs(level).max(axis=0), 1.0)
    wanted = values * by_row
    found = np.linalg.lstsq(level * by_column, wanted, rcond=LOOSE)[0]
    if np.linalg.norm(level @ (by_column * found) - wanted) > LEFT * max(float(np.linalg.norm(wanted)), LEFT):
        raise SimulationError(NOWHERE)
    return by_column * found


def _over(step: np.ndarray, deviations: np.ndarray, at: np.ndarray) -> float:
    """The largest step over the deviation of its state."""
    return float(np.max(np.abs(step) / np.maximum(deviations, STILL * (1 + np.abs(at))), initial=0.0))
