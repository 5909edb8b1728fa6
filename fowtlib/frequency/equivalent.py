"""Equivalent linearisation of a whole model: mean and linear model that suit the response which they have.

A linear model about the mean in mean wind knows nothing of a corner beside it, of a table that curves, of products of
fluctuations. In its place stands the linear model nearest in the mean square, for states, unknowns and signals that are
Gaussian with the covariance of the response itself: expected values and slopes of all equations and results
(frequency.expectations), about the mean at which the expected rates vanish. Covariance, mean and linear model are found
together: on the same frequencies as soon as they hardly change, and in steps that get shorter, so that near a swing
that hardly decays, which makes a percent of a slope ten of a deviation, the points of the means are averaged out.

Of rotors of blade elements that turn, the laws of controllers and actuators alone are so; see TurningRows.

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
from fowtlib.frequency.expected_means import RestingRows, TurningRows, deviations_of
from fowtlib.frequency.settling import settled_gains
from fowtlib.language.eigenvectors import eigenvalues
from fowtlib.language.errors import SimulationError
from fowtlib.solving import State
from fowtlib.solving.excited import ExcitedModel, excited_model

ITERATIONS = 60
WHOLE = 6  # from this iteration on the way to the covariance that is found is shortened, as this over their number
SETTLED = 3e-3  # change of the deviation of a result, and distance from that over the last iterations, to end at
PATIENT, NEARLY = 15, 0.03  # after so many iterations, where a swing hardly decays and the points of the means tell
CLOSE = 0.02  # step of the mean over the deviation of a state
HELD = 0.05  # from which the frequencies stay
FEWEST = 3  # iterations; the first guess has too small a covariance
CALM = 0.3  # of the covariance by the tangent, the first guess: near a corner it is far too large
DAMPED = 1.5  # times the growth of the fastest growing mode, taken off all roots for a first guess
SLOWEST = 1e-4  # 1/s, at least

Driven = Callable[[ExcitedModel], tuple[ExcitedModel, Processes]]
"""The linear model by the channels that count, and the random processes that drive it."""


@dataclass(frozen=True, eq=False)
class Equivalent:
    """What was found: mean state, linear model with gains of its drag, and frequencies.

    shown: expected results in their units; None where they are those of the mean.
    """

    state: State
    excited: ExcitedModel
    gains: list[np.ndarray]
    grid: Grid
    iterations: int
    shown: np.ndarray | None


def equivalent(plant: Any, state: State, names: Sequence[str], driven: Driven, frequency: np.ndarray | None,
               tolerance: float) -> Equivalent:  # fmt: skip
    """The equivalent linearisation that starts from a mean state in mean wind; see the module.

    Where rotors of blade elements turn it is that of the laws with corners alone, which are no loads of these rotors.
    SimulationError where the fixed point is not found.
    """
    excited = excited_model(plant, state, names)
    turning = excited.rotating.average is not None
    rows = TurningRows(plant, state) if turning else RestingRows(plant, state, names, excited.further)
    guess, last, given = None, None, frequency
    gains: list[np.ndarray] | None = None
    smooth: np.ndarray | None = None
    for iteration in range(1, ITERATIONS + 1):
        excited, processes = driven(excited)
        settled, damping = _settled(excited, processes, given, tolerance, gains)
        excited, gains, grid = settled
        found, deviations = _covariances(excited, gains, grid, with_inputs=not turning)
        share = min(1.0, WHOLE / iteration)
        smooth = deviations if smooth is None else smooth + share * (deviations - smooth)
        change = np.inf if last is None else max(_change(deviations, last), _change(deviations, smooth))
        enough = SETTLED if iteration <= PATIENT else NEARLY
        if iteration > FEWEST and rows.step < CLOSE and change < enough and not damping:
            shown = None if rows.shown is None else rows.shown[: excited.results]
            return Equivalent(state, excited, gains, grid, iteration, shown)
        if last is not None and _change(deviations, last) < HELD:
            given = grid.frequency
        guess = CALM * found if guess is None else guess + share * (found - guess)
        last = deviations
        state, off = rows.stepped(excited, state, guess)
        excited = excited_model(plant, state, names, off)
    raise SimulationError(
        f"the equivalent linearisation does not settle within {ITERATIONS} iterations; the last change of a deviation "
        f"is {change:.2g}. Take linearisation='tangent', or runs."
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
    damping = max(DAMPED * float(eigenvalues(excited.linear.matrices["A"]).real.max(initial=0.0)), SLOWEST)
    for _ in range(6):
        calm = excited.damped(damping)
        try:
            gains, grid, _ = settled_gains(calm, processes, frequency, tolerance)
            return (calm, gains, grid), damping
        except UnstableError:
            damping *= 2
    raise first


def _covariances(excited: ExcitedModel, gains: Sequence[np.ndarray], grid: Grid,
                 with_inputs: bool) -> tuple[np.ndarray, np.ndarray]:  # fmt: skip
    """Covariance of the states, or of [states; inputs], and standard deviations of the results."""
    linear = excited.with_gains(gains)
    n, m = len(linear.states), excited.results
    H = grid.answers(with_states(linear, m, np.eye(n), linear.states))
    both: dict[str, np.ndarray] = {}
    for path, answer in H.items():
        if not with_inputs:
            both[path] = answer[:, m:]
            continue
        drive = np.zeros((len(answer), excited.driven, answer.shape[2]), dtype=complex)
        drive[:, grid.driving[path].inputs] = grid.driving[path].drive.transpose(1, 0, 2)
        both[path] = np.concatenate([answer[:, m:], drive], axis=1)
    shown: Mapping[str, np.ndarray] = {path: answer[:, :m] for path, answer in H.items()}
    of_results = covariance(shown, grid.spectra, grid.frequency)
    return covariance(both, grid.spectra, grid.frequency), deviations_of(of_results)


def _change(new: np.ndarray, old: np.ndarray) -> float:
    """The largest relative change of a deviation that is one."""
    moves = new > 1e-9 * new.max(initial=0.0)
    return float(np.max(np.abs(new - old)[moves] / new[moves], initial=0.0))
