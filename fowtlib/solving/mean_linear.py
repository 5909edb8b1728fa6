"""The linear model about the mean state of a model whose rotors turn.

The matrices of a rotor of blade elements are periodic in its azimuth, and those of one azimuth are no linear model of
the machine: where the angle is a state, its stiffness there is the slope of a load that goes round and has a mean of
zero. The mean over a revolution is (solving.turning: forces are averaged, not accelerations), and the azimuth, to which
nothing is tied, is none of its states. That is the harmonic balance of order zero: right for what is slow beside a
revolution or felt by all blades alike, as motions in waves; blades that bend one after the other count as stiff in it.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from fowtlib.solving.checks import check_state
from fowtlib.solving.linear import LinearModel, slopes_of
from fowtlib.solving.turning import AZIMUTHS, Average, turns_of

if TYPE_CHECKING:
    from fowtlib.solving.state import State

Plant = Any


def mean_linear_model(plant: Plant, state: State, inputs: Sequence[str] = (),
                      outputs: Sequence[str] | None = None) -> LinearModel:  # fmt: skip
    """The linear model of the mean over a revolution at a mean state; `plant.linearize` where no rotor turns there.

    inputs: inputs or tunable parameters by path; outputs: results or variables, None for all results. Angles of rotors
    are no states of it, and states that nothing depends on neither.
    """
    at = plant.at(state.parameters)
    turns = turns_of(plant, at, state)
    if not turns:
        return plant.linearize(state, inputs, outputs)
    check_state(at, state, plant.name, warn=False)
    names = list(plant.outputs) if outputs is None else outputs
    slopes = slopes_of(at, plant.layout, plant.outputs, [plant.input_names.get(name, name) for name in inputs], names)
    nx, end = at.dae.x.numel(), at.dae.x.numel() + at.dae.z.numel()

    def jacobian(*point: Any) -> tuple[np.ndarray, ...]:
        by_x, by_z, by_u = slopes(*point)
        columns = np.hstack([by_x, by_u])
        return columns[:nx], by_z[:nx], columns[nx:end], by_z[nx:end], columns[end:], by_z[end:]

    average = Average(at, state, turns, AZIMUTHS, jacobian)
    _, of_states, of_outputs = average.with_outputs(state.x)
    free, rest = average.free, slice(nx, None)
    states = [list(plant.layout.x)[k] for k in free]
    linear = slopes.model(of_states[np.ix_(free, free)], of_states[free, rest], of_outputs[:, free],
                          of_outputs[:, rest], states)  # fmt: skip
    own = {path: name for name, path in plant.input_names.items() if name in inputs}
    linear.inputs = [own.get(path, path) for path in linear.inputs]
    return linear
