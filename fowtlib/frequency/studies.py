"""What the responses of one compiled model have in common: the means, and the linear models about them.

All seas about one mean wind have one mean state and one linear model; the means of neighbouring winds are near.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from threading import RLock
from typing import Any, TypeVar

import numpy as np

from fowtlib.analysis.plants import UnstableError, refuse_unstable
from fowtlib.language.component import Component
from fowtlib.solving import State, mean_state
from fowtlib.solving.binding import RunTrees, content_of
from fowtlib.solving.excited import ExcitedModel, excited_model
from fowtlib.solving.mean_linear import RotatingLinearModel
from fowtlib.solving.rotation import Rotation, steady_rotation
from fowtlib.solving.starts import mean_parameters

MEANS, MODELS = 200, 12  # kept of a plant, the last ones

Key = tuple[tuple[str, Any], ...]
Made = TypeVar("Made")


def study_of(plant: Any) -> Study:
    """The study of a plant; the same again as long as it is in use."""
    return plant.functions.once("responses", lambda: Study(plant))


class Study:
    """Means, linear models and component trees of the runs of one plant."""

    def __init__(self, plant: Any):
        self.plant = plant
        self._trees = RunTrees(plant.dae, plant.root) if plant.root is not None else None
        self._means: dict[Key, State] = {}
        self._models: dict[Any, ExcitedModel] = {}
        self._rotations: dict[Any, Rotation] = {}
        self._gains: dict[tuple[tuple[str, int], ...], list[np.ndarray]] = {}
        self._lock = RLock()

    @contextmanager
    def tree(self, parameters: Mapping[str, Any] | None) -> Iterator[Component]:
        """The component tree of a run to look at, for as long as the context lasts."""
        with self._lock:
            yield self._trees(parameters)

    def mean(self, parameters: Mapping[str, Any] | None, root: Component) -> State:
        """The mean of a run with these parameters and this tree.

        Newton is tried first from the nearest one so far, where nothing goes round; a mean that it finds counts where
        it is stable, since another way may lead to another one.
        """
        values = mean_parameters(self.plant, parameters, root)
        return _kept(self._means, _key(values), MEANS, lambda: self._found(values))

    def excited(self, state: State, names: Sequence[str]) -> ExcitedModel:
        """The linear model about a mean."""
        key = _key(state.parameters), tuple(names), state.x.tobytes(), state.z.tobytes()
        return _kept(self._models, key, MODELS, lambda: excited_model(self.plant, state, names))

    def gains(self, excited: ExcitedModel) -> list[np.ndarray] | None:
        """Gains of drag that another state settled at; None before the first one."""
        return self._gains.get(_laws(excited))

    def keep_gains(self, excited: ExcitedModel, gains: list[np.ndarray]) -> None:
        """Let another state begin with these."""
        self._gains = {_laws(excited): gains}

    def rotation(self, state: State, names: Sequence[str], rotating: RotatingLinearModel) -> Rotation | None:
        """What goes round with the rotors in the steady wind of a mean; None where nothing turns."""
        if rotating.average is None:
            return None
        key = tuple(names), state.x.tobytes(), state.z.tobytes(), _key(state.parameters)
        return _kept(self._rotations, key, MODELS, lambda: steady_rotation(self.plant, state, names, rotating))

    def _found(self, values: Mapping[str, Any]) -> State:
        near = min(self._means.values(), key=lambda state: _distance(values, state.parameters), default=None)
        if near is None or self.plant.dae.symmetries or not np.isfinite(_distance(values, near.parameters)):
            return mean_state(self.plant, values)
        beside = self.plant.equilibrium(values, near=near)
        try:
            refuse_unstable(self.plant.linearize(beside, (), ()))
        except UnstableError:
            return mean_state(self.plant, values)
        return beside


def _laws(excited: ExcitedModel) -> tuple[tuple[str, int], ...]:
    return tuple((path, place.stop - place.start) for path, place in excited.laws)


def _key(values: Mapping[str, Any]) -> Key:
    return tuple(sorted((path, content_of(value)) for path, value in values.items()))


def _distance(one: Mapping[str, Any], other: Mapping[str, Any]) -> float:
    """How far the numbers of one mean are from those of another; infinite where something else differs."""
    if one.keys() != other.keys():
        return np.inf
    total = 0.0
    for path, value in one.items():
        if isinstance(value, (int, float)) and isinstance(other[path], (int, float)):
            total += abs(value - other[path]) / max(abs(value) + abs(other[path]), 1e-12)
        elif content_of(value) != content_of(other[path]):
            return np.inf
    return total


def _kept(store: dict[Any, Made], key: Any, most: int, make: Callable[[], Made]) -> Made:
    made = store.pop(key) if key in store else make()
    store[key] = made  # the last one used is the last to go
    while len(store) > most:
        del store[next(iter(store))]
    return made
