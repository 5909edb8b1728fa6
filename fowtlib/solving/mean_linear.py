"""The linear model about the mean state of a model whose rotors turn.

The matrices of a rotor of blade elements are periodic in its azimuth, and those of one azimuth are no linear model of
the machine: where the angle is a state, its stiffness there is the slope of a load that goes round and has a mean of
zero. The mean over a revolution in multi-blade coordinates is (solving.turning, solving.multiblade): of blades that are
alike it is exact but for what is periodic to someone who does not turn, as gravity on blades that are bent, and it has
no azimuth, to which nothing is tied. So its states are those of the tower and the platform, and the collective, cosine
and sine parts of the blades, whose names say so: `rotor.blade_cosine.beam...`. A rotor of two blades has no such
coordinates; its blades keep their own, and what they do one against the other counts by its mean alone.

The mean itself has the motion of the blades once in a revolution. To the modes it matters by second order (the matrices
change by the square of the sag); to the loads of a blade it is all there is in steady wind.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from fowtlib.solving.checks import check_state
from fowtlib.solving.linear import NOTHING, Further, LinearModel, Slopes, linearize, slopes_of
from fowtlib.solving.operating_point import operating_point
from fowtlib.solving.turning import AZIMUTHS, Average, MeanSlopes, Turn, turns_of

if TYPE_CHECKING:
    from fowtlib.solving.state import State

Plant = Any
FELT = 1e-2  # of the largest slope of a result: what goes round with a rotor, so that it counts


def mean_linear_model(plant: Plant, state: State, inputs: Sequence[str] = (),
                      outputs: Sequence[str] | None = None, further: Further = NOTHING) -> LinearModel:  # fmt: skip
    """The linear model of the mean over a revolution at a mean state; `plant.linearize` where no rotor turns there.

    inputs: inputs or tunable parameters by path; outputs: results or variables, None for all results. Angles of rotors
    are no states of it, and states that nothing depends on neither. further: see slopes_of. Outputs of one blade are
    in the mean over a turn here; what they have of the turning is in `rotating_linear_model`.
    """
    return rotating_linear_model(plant, state, inputs, outputs, further).linear


@dataclass(frozen=True)
class Turning:
    """Outputs that turn with a rotor: y(t) + y_cosine(t) cos(psi) + y_sine(t) sin(psi), psi the azimuth.

    path: of the azimuth; speed [rad/s], its mean; azimuth [rad], that of the state. of: numbers of the outputs; cosine,
    sine: those of the outputs that these are.
    """

    path: str
    speed: float
    azimuth: float
    of: tuple[int, ...]
    cosine: slice
    sine: slice


@dataclass(frozen=True, eq=False)
class RotatingLinearModel:
    """A linear model in multi-blade coordinates, behind whose results stand what these have of the turning.

    results: number of outputs that are results; shown: of these and of what they have of the turning. average: what it
    was made by, mean: the slopes that it gave, scale: of the rows of outputs to their units; None where nothing turns.
    speeds: of the rotors [rad/s].
    """

    linear: LinearModel
    results: int
    shown: int
    turning: tuple[Turning, ...] = ()
    average: Average | None = None
    speeds: tuple[float, ...] = ()
    mean: MeanSlopes | None = None
    scale: np.ndarray | None = None


def rotating_linear_model(plant: Plant, state: State, inputs: Sequence[str] = (),
                          outputs: Sequence[str] | None = None, further: Further = NOTHING, *,
                          turning: bool = False) -> RotatingLinearModel:  # fmt: skip
    """The same, and with `turning` what its outputs have of the turning, as further outputs behind the results.

    A load of one blade in a wind that stands still is such an output; see Turning.
    """
    at = plant.at(state.parameters)
    turns = turns_of(plant, at, state)
    if not turns and further is NOTHING:
        return _resting(plant.linearize(state, inputs, outputs), NOTHING)
    check_state(at, state, plant.name, warn=False)
    names = list(plant.outputs) if outputs is None else outputs
    paths = [plant.input_names.get(name, name) for name in inputs]
    if not turns:
        return _resting(linearize(at, plant.layout, plant.outputs, state, paths, names, further), further)
    slopes = slopes_of(at, plant.layout, plant.outputs, paths, names, further)
    nx, end = at.dae.x.numel(), at.dae.x.numel() + at.dae.z.numel()

    def jacobian(*point: Any) -> tuple[np.ndarray, ...]:
        by_x, by_z, by_u = slopes(*point)
        columns = np.hstack([by_x, by_u])
        return columns[:nx], by_z[:nx], columns[nx:end], by_z[nx:end], columns[end:], by_z[end:]

    average = Average(at, state, turns, AZIMUTHS, jacobian)
    y = average.multiblade.from_states(state.x)
    found, speeds = average.at_mean(y), average.rotor_speeds(y).tolist()
    free, rest = average.free, slice(nx, None)
    results = len(slopes.shown) - len(further.outputs)
    C, D, more, turned, scale = found.outputs[:, free], found.outputs[:, rest], [], (), slopes.scale[:results]
    if turning:
        for turn, speed, rows in zip(turns, speeds, found.turning, strict=True):
            more.append((turn, speed, rows[:results][:, [*free, *range(nx, rows.shape[1])]]))
        slopes, C, D, turned = _with_turning(slopes, results, C, D, plant, state, more)
    paths_of = average.multiblade.paths()
    A, B = found.slopes[np.ix_(free, free)], found.slopes[free, rest]
    linear = slopes.model(A, B, C, D, [paths_of[k] for k in free])
    own = {path: name for name, path in plant.input_names.items() if name in inputs}
    linear.inputs = [own.get(path, path) for path in linear.inputs]
    if not turning and not further.outputs:
        linear.point = partial(operating_point, plant, state, inputs, names, average)
    return RotatingLinearModel(linear, results, len(slopes.shown) - len(further.outputs), turned, average,
                               tuple(speeds), found, scale)  # fmt: skip


def _resting(linear: LinearModel, further: Further) -> RotatingLinearModel:
    results = len(linear.outputs) - len(further.outputs)
    return RotatingLinearModel(linear, results, results)


def _with_turning(slopes: Slopes, results: int, C: np.ndarray, D: np.ndarray, plant: Plant, state: State,
                  more: Sequence[tuple[Turn, float, np.ndarray]],
                  ) -> tuple[Slopes, np.ndarray, np.ndarray, tuple[Turning, ...]]:  # fmt: skip
    """Slopes, C and D with rows for what the results have of the turning of each rotor, by [x u] complex."""
    whole = np.hstack([C, D])
    rows, names, units, scale, found = [whole[:results]], list(slopes.shown[:results]), {}, [slopes.scale[:results]], []
    for turn, speed, turning in more:
        size = np.maximum(np.abs(whole[:results]), 2 * np.abs(turning)).max(axis=1)
        of = np.flatnonzero(2 * np.abs(turning).max(axis=1) > FELT * size)
        first, path = len(names), plant.dae.states[turn.azimuth].path
        for word, part in (("cosine", 2 * turning[of].real), ("sine", -2 * turning[of].imag)):
            rows.append(part)
            fresh = [f"{slopes.shown[k]} {word} of {path}" for k in of]
            units |= {name: slopes.units[slopes.shown[k]] for name, k in zip(fresh, of, strict=True)}
            names += fresh
            scale.append(slopes.scale[of])
        cosine, sine = slice(first, first + len(of)), slice(first + len(of), first + 2 * len(of))
        found.append(Turning(path, speed, float(state.x[turn.azimuth]), tuple(of.tolist()), cosine, sine))
    whole = np.vstack([*rows, whole[results:]])
    shown = (*names, *slopes.shown[results:])
    slopes = replace(slopes, shown=shown, units=slopes.units | units, scale=np.vstack([*scale, slopes.scale[results:]]))
    return slopes, whole[:, : C.shape[1]], whole[:, C.shape[1] :], tuple(found)
