"""What the responses of one compiled model have in common: the means, and the linear models about them.

All seas about one mean wind have one mean state and one linear model; the means of neighbouring winds are near.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from threading import RLock
from typing import Any, TypeVar

import numpy as np

from fowtlib.frequency.known_rows import Known, KnownRows
from fowtlib.language.component import Component
from fowtlib.language.eigenvectors import eigenvalues, eigenvectors
from fowtlib.solving import State, mean_state
from fowtlib.solving.binding import RunTrees, content_of
from fowtlib.solving.excited import ExcitedModel, excited_model
from fowtlib.solving.known_slopes import contents_of
from fowtlib.solving.mean_linear import RotatingLinearModel
from fowtlib.solving.paths import by_path, spread_out
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
        self._shown: dict[Any, np.ndarray] = {}
        self._rotations: dict[Any, Rotation] = {}
        self._gains: dict[tuple[tuple[str, int], ...], list[np.ndarray]] = {}
        self._rows = KnownRows()
        self._lock = RLock()

    @contextmanager
    def tree(self, parameters: Mapping[str, Any] | None) -> Iterator[Component]:
        """The component tree of a run to look at, for as long as the context lasts."""
        with self._lock:
            yield self._trees(parameters)

    def mean(self, parameters: Mapping[str, Any] | None, root: Component, names: Sequence[str] = ()) -> State:
        """The mean of a run with these parameters and this tree; names: results of which one asks there.

        Newton is tried first from the nearest one so far, where nothing goes round; a mean that it finds counts where
        it is statically stable, since another way may lead to another one.
        """
        values = mean_parameters(self.plant, parameters, root)
        return _kept(self._means, _key(values), MEANS, lambda: self._found(values, names))

    def excited(self, state: State, names: Sequence[str]) -> ExcitedModel:
        """The linear model about a mean."""
        key = _key(state.parameters), tuple(names), state.x.tobytes(), state.z.tobytes()
        return _kept(self._models, key, MODELS, lambda: excited_model(self.plant, state, names))

    def shown(self, state: State, names: Sequence[str]) -> np.ndarray:
        """Values of results at a mean, in their units, one element after the other."""
        key = _key(state.parameters), tuple(names), state.x.tobytes(), state.z.tobytes()
        return _kept(self._shown, key, MODELS,
                     lambda: np.concatenate([np.ravel(value) for value in state.values(names)]))  # fmt: skip

    def rows(self, parameters: Mapping[str, Any] | None, root: Component) -> Known:
        """Functions of frequency of a run with these parameters and this tree, with what is known of them."""
        given = by_path(parameters or {})
        given = spread_out(given, self.plant.root) if self.plant.root is not None else given
        contents, numbers = contents_of(given), dict[Any, Any]()
        return lambda name, function: self._rows.of(name, root, contents, function, numbers)

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

    def _found(self, values: Mapping[str, Any], names: Sequence[str]) -> State:
        near = min(self._means.values(), key=lambda state: _distance(values, state.parameters), default=None)
        if near is None or self.plant.dae.symmetries or not np.isfinite(_distance(values, near.parameters)):
            return mean_state(self.plant, values)
        beside = self.plant.equilibrium(values, near=near)
        return beside if self._on_the_branch(beside, names) else mean_state(self.plant, values)

    def _on_the_branch(self, state: State, names: Sequence[str]) -> bool:
        """Whether no motion grows without oscillating.

        Where a branch of equilibria turns back, a real root goes through zero. One that grows as it oscillates says
        nothing of the branch: the drag, which has hardly a slope at a mean of zero, may yet damp it.
        """
        A = self.excited(state, names).linear.matrices["A"]
        if not A.size:
            return True
        eigenvectors(A)  # of which the next one will ask
        roots = eigenvalues(A)
        return not np.any((roots.imag == 0) & (roots.real > 1e-6))


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
        a, b = _numbers(value), _numbers(other[path])
        if a is not None and b is not None and a.shape == b.shape:
            total += float(np.linalg.norm(a - b)) / max(float(np.linalg.norm(a) + np.linalg.norm(b)), 1e-12)
        elif content_of(value) != content_of(other[path]):
            return np.inf
    return total


def _numbers(value: Any) -> np.ndarray | None:
    """A number, or numbers, as an array; None for anything else, as a text with a unit."""
    if isinstance(value, bool) or not isinstance(value, (int, float, np.number, np.ndarray, list, tuple)):
        return None
    try:
        array = np.asarray(value)
    except ValueError:  # rows of different lengths
        return None
    return array if array.dtype.kind in "iuf" else None


def _kept(store: dict[Any, Made], key: Any, most: int, make: Callable[[], Made]) -> Made:
    made = store.pop(key) if key in store else make()
    store[key] = made  # the last one used is the last to go
    while len(store) > most:
        del store[next(iter(store))]
    return made
