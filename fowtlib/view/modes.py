"""A natural mode as a motion: states over one period, as large as a picture can show it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from fowtlib.language.errors import ModelError
from fowtlib.solving import Result
from fowtlib.solving.modes import NaturalMode, natural_modes
from fowtlib.solving.results import RawTrajectory
from fowtlib.view.recording import Cast

CYCLE = 3.0  # s in which a period is shown
MOMENTS = 48  # of a period
SIZE = 0.08  # of the bodies: the largest displacement
TURN = 0.35  # rad, about 20 deg: the largest change of an angle
SMALL = 1e-5  # of the shape, to see where it moves things


def mode_of(plant: Any, number: int, state: Any) -> NaturalMode:
    """The natural mode of this number about a state, among those that oscillate."""
    modes = [mode for mode in natural_modes(plant, state) if mode.oscillates]
    for mode in modes:
        if mode.number == number:
            return mode
    numbers = [mode.number for mode in modes]
    there = f"there are 1 to {max(numbers)}, see `fowt eigen`" if numbers else "it has none that oscillates"
    raise ModelError(f"the model has no oscillating mode {number}; {there}.")


def played(plant: Any, states: Sequence[Any], time: np.ndarray) -> Result:
    """States as a result, at these times, that rebuilds every variable of the model."""
    groups = (plant.dae.states, plant.dae.algebraics, plant.dae.discretes)
    names = [tuple(quantity.path for quantity in group) for group in groups]
    x, z, d = (np.array([getattr(state, group) for state in states]) for group in "xzd")
    raw = RawTrajectory(np.asarray(time, dtype=float), x, z, d, *names)
    parameters = states[0].parameters
    attributes = {"parameters": plant.parameter_values(parameters)}
    return Result(time, {}, attributes=attributes, raw=raw, observe=plant.observer(raw, parameters))


def mode_states(plant: Any, cast: Cast, mode: NaturalMode, state: Any) -> list[Any]:
    """States x + a Re(shape exp(i phi)) over one turn of phi, first and last alike; the unknowns follow them."""
    shape = np.array([mode.shape[s.path] for s in plant.dae.states])
    angles = np.array([s.unit == "rad" for s in plant.dae.states])
    shape[[s.unit.endswith("/s") for s in plant.dae.states]] = 0.0  # a picture has no speeds

    def at(change: np.ndarray) -> Any:
        start = {s.path: float(x) for s, x in zip(plant.dae.states, state.x + change, strict=True)}
        return plant.initial_state(state.parameters, start, base=state)

    turn = float(np.max(np.abs(shape[angles]), initial=0.0))
    small = SMALL / max(1.0, turn)
    places = _places(plant, cast, [state, at(small * shape.real), at(small * shape.imag)])
    moved = float(np.max(np.linalg.norm(places[1:] - places[0], axis=2))) / small
    size = float(np.linalg.norm(np.ptp(places[0], axis=0))) or 1.0
    if not moved and not turn:
        raise ModelError(f"the mode {mode.number} ({mode.name}) moves nothing that is drawn.")
    scale = min(SIZE * size / moved if moved else np.inf, TURN / turn if turn else np.inf)
    phases = np.linspace(0.0, 2 * np.pi, MOMENTS + 1)
    return [at(scale * (shape * np.exp(1j * phase)).real) for phase in phases]


def _places(plant: Any, cast: Cast, states: Sequence[Any]) -> np.ndarray:
    """Where the frames that are drawn are, (n_states, n_frames, 3) [m]."""
    result = played(plant, states, np.arange(float(len(states))))
    return cast.poses(result.observe, len(states))[..., :3]
