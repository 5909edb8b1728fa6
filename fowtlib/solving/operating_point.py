"""Where a linear model is of: the values at its state, in the order of its rows and columns."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from fowtlib.solving.rates import rate_states
from fowtlib.solving.results.linear_files import OperatingPoint
from fowtlib.solving.state import State
from fowtlib.solving.turning import Average, turns_of

WIND = "wind.mean_speed"


def operating_point(plant: Any, state: State, inputs: Sequence[str], outputs: Sequence[str],
                    average: Average | None = None) -> OperatingPoint:  # fmt: skip
    """Of `plant.linearize(state, inputs, outputs)`, or of the mean over a revolution that was made by `average`."""
    dae, at = plant.dae, plant.at(state.parameters)
    pairs = rate_states(dae)
    of_motion = {k for pair in pairs.items() for k in pair}
    turns = turns_of(plant, at, state)
    inside = tuple(f"{part}." for ring in dae.symmetries for part in ring.parts)
    if average is None:
        x, kept = state.x, list(range(state.x.size))
        rates = np.array(at.residual(state.t, state.x, state.z, np.concatenate([state.u, state.d]))[0]).ravel()
    else:
        x, kept = average.multiblade.from_states(state.x), average.free.tolist()
        rates = np.zeros(x.size)  # the mean stays
    fixed = {k for ring in (average.multiblade.rings if average else ()) for k in ring.states.ravel().tolist()}
    parameters = plant.parameter_values(state.parameters)
    speeds = np.array(at.residual(state.t, state.x, state.z, np.concatenate([state.u, state.d]))[0]).ravel()
    values, units = [], []
    for name in inputs:
        path = plant.input_names.get(name, name)
        if path in plant.layout.p:
            value, unit = parameters[path], dae.parameters[path].unit
        else:
            value, unit = state[path], dae.units.get(path, "1")
        value = np.ravel(np.asarray(value, dtype=float), order="F")
        values.append(value)
        units += [unit] * value.size
    shown = [np.ravel(np.asarray(value, dtype=float), order="F") for value in state.values(list(outputs))]
    return OperatingPoint(
        state.t, x[kept], rates[kept], np.concatenate([*values, []]), np.concatenate([*shown, []]),
        tuple(dae.states[k].unit for k in kept), tuple(units), tuple(2 if k in of_motion else 1 for k in kept),
        tuple(dae.states[k].path.startswith(inside) and k not in fixed for k in kept),
        float(speeds[turns[0].azimuth]) if turns else 0.0, float(state.x[turns[0].azimuth]) if turns else 0.0,
        float(np.ravel(parameters[WIND])[0]) if WIND in parameters else 0.0, plant.title or plant.name,
    )  # fmt: skip
