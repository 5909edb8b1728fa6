"""The fixed point of the drag: gains of its linear laws that suit the response with these gains.

What is fast in a model hardly moves the water that its parts feel. So the iteration goes on a model of the slow modes
alone, which has a part of the states; what is left out is measured on the whole model with the gains that come out, and
where it is not small beside the tolerance the whole model goes on.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from fowtlib.analysis.plants import refuse_unstable
from fowtlib.frequency.drag import gains_of
from fowtlib.frequency.driven import Grid, Processes
from fowtlib.frequency.grid import HIGHEST, frequencies_about
from fowtlib.frequency.mixing import Mixing
from fowtlib.language.eigenvectors import eigenvalues
from fowtlib.language.errors import SimulationError
from fowtlib.solving.excited import ExcitedModel

ITERATIONS = 60
GUESS = 1.0  # m/s; deviation of the velocities of drag before the first iteration
ROUNDING = 1e-8  # change of the gains from which it need not get smaller
SMALL = 0.1  # of the largest gain of drag
REGRIDDED = 1e-4  # change of the gains below which the frequencies are chosen for good; they do not tell the start
FAST = 5.0  # times the highest frequency: what is faster has no part in the iteration
LEFT_OUT = 0.25  # of the tolerance: what that may change a gain
THINNED = 8  # of so many frequencies one, to measure it


def settled_gains(excited: ExcitedModel, processes: Processes, frequency: np.ndarray | None, tolerance: float,
                  start: Sequence[np.ndarray] | None = None,
                  rough: bool = False) -> tuple[list[np.ndarray], Grid, int]:  # fmt: skip
    """The gains of drag that suit the response with them, the frequencies, and the count of iterations.

    start: gains that are near, as those of another sea. A coarse grid serves until the gains change little, then the
    final one of the modes that the model has with them. rough: the coarse one is the final one.
    SimulationError where they do not settle.
    """
    means = [excited.means[place] for _, place in excited.laws]
    guess = gains_of([GUESS**2 * np.eye(len(mean)) for mean in means], means)
    gains = guess if start is None else list(start)
    if start is None:
        refuse_unstable(excited.with_gains(gains))
    if not excited.laws:
        chosen = _chosen(excited, gains, coarse=rough) if frequency is None else frequency
        return gains, Grid.of(excited, processes, chosen), 1
    highest = HIGHEST if frequency is None else frequency[-1]
    model = excited.slow(2 * np.pi * FAST * highest)
    final = rough or frequency is not None
    grid = Grid.of(model, processes, _chosen(model, guess, coarse=True) if frequency is None else frequency)
    mixing, last = Mixing(), np.inf
    for iteration in range(1, ITERATIONS + 1):
        found = grid.gains(gains)
        change = _change(gains, found)
        if final and (change < tolerance or last <= change < ROUNDING):
            if model is excited or _left_out(grid, excited, found) < LEFT_OUT * tolerance:
                return found, grid.with_model(excited), iteration
            model, mixing, last = excited, Mixing(), np.inf
            gains, grid = found, grid.with_model(excited)
            continue
        if not final and change < REGRIDDED:
            final = True
            grid = Grid.of(model, processes, _chosen(model, found))
            after = grid.gains(gains)
            mixing.moved(found, after)  # what was learnt of the steps holds on the other frequencies too
            found, change = after, _change(gains, after)
        gains, last = mixing(gains, found), change
    raise SimulationError(
        f"the linearised drag does not settle within {ITERATIONS} iterations; the last change is {last:.2g}."
    )


def _chosen(model: ExcitedModel, gains: Sequence[np.ndarray], coarse: bool = False) -> np.ndarray:
    return frequencies_about(eigenvalues(model.states_with(gains)), coarse=coarse)


def _left_out(grid: Grid, excited: ExcitedModel, gains: Sequence[np.ndarray]) -> float:
    """Change of the gains by the modes that the model of a grid has not, on a few of its frequencies."""
    few = grid.thinned(THINNED)
    return _change(few.gains(gains), few.with_model(excited).gains(gains))


def _change(gains: Sequence[np.ndarray], found: Sequence[np.ndarray]) -> float:
    """The largest relative change of a gain; one below a tenth of the largest counts as that much."""
    first = np.cumsum([0, *(matrix.size for matrix in found[:-1])])
    new, old = (np.concatenate([matrix.ravel() for matrix in of]) for of in (found, gains))
    sizes, steps = (np.sqrt(np.add.reduceat(values**2, first)) for values in (new, new - old))
    return float(np.max(steps / np.maximum(sizes, max(SMALL * sizes.max(), 1e-12))))
