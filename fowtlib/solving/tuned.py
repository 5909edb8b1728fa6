"""Parameters with respect to which results are differentiated, and what of a run follows from them.

Most of them are symbols of the flat model. Others act through numbers that parts compute when a run starts (masses and
stiffnesses of a tube from its diameter), through other parameters that follow from them, or, as the speed of a wind,
through what an external function gives. These are smooth functions in Python; their slopes are taken in closed form
where parts say it (solving.closed_slopes), else by central differences of that part alone, on one copy of the component
tree, and only of numbers that results depend on.
"""

from __future__ import annotations

import copy
import threading
from collections.abc import Callable, Hashable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from fowtlib.flattening.system import element_names
from fowtlib.language.component import Component
from fowtlib.language.declarations import SHAPES
from fowtlib.language.errors import ParameterError, did_you_mean
from fowtlib.language.expressions import one_evaluation, parameters_read
from fowtlib.language.series import Series
from fowtlib.language.units import to_si
from fowtlib.solving.beside import Beside
from fowtlib.solving.binding import RunTrees, start_numbers, tree_with
from fowtlib.solving.bindings import Common
from fowtlib.solving.closed_slopes import Tangents
from fowtlib.solving.differences import SHORT, derivative
from fowtlib.solving.known_slopes import Contents, Known, KnownSlopes, contents_of
from fowtlib.solving.paths import by_path, spread_out
from fowtlib.solving.starts import mean_parameters
from fowtlib.solving.together import slopes_together

Plant = Any
Values = Mapping[str, Any]


@dataclass(frozen=True)
class Tuned:
    """One element of a parameter: path, number of the element in column order, its name, SI unit, and its bounds.

    tunable: a symbol of the flat model; else a number that a part reads when a run starts, as the height of waves.
    """

    path: str
    number: int
    name: str
    unit: str
    tunable: bool
    min: float | None = None
    max: float | None = None


def tuned_elements(plant: Plant, by: Sequence[str], parameters: Values | None = None) -> list[Tuned]:
    """The elements of parameters behind paths; a path without a number stands for all of its elements.

    parameters: of the run, which may have a number where the model has none, and another kind of wind or sea.
    Raises ParameterError for what is no parameter, or one whose results have no derivative by it, and says why.
    """
    if isinstance(by, str):
        raise ParameterError(f"by: parameters are given as a list of paths, as in [{by!r}].")
    root = plant.root
    if parameters and any(name.partition("[")[0] in plant.dae.bound_parameters for name in by):
        root = tree_with(plant.dae, root, dict(parameters))
    found = [item for name in by for item in _elements(plant, name, root)]
    names = [item.name for item in found]
    if twice := next((name for name in names if names.count(name) > 1), None):
        raise ParameterError(f"by: {twice} is given twice.")
    return found


def _elements(plant: Plant, name: str, root: Component | None) -> list[Tuned]:
    dae = plant.dae
    path = name if name in dae.parameters or name in dae.bound_parameters else name.partition("[")[0]
    if path in dae.parameters:
        item = dae.parameters[path]
        names, unit, bounds, tunable = element_names(path, item.symbol.shape), item.unit, (item.min, item.max), True
    elif path in dae.bound_parameters and (field := _number(root, path)) is not None:
        names, unit, bounds, tunable = [path], field.unit, (field.min, field.max), False
    else:
        raise ParameterError(_why_not(plant, path))
    if name != path and name not in names:
        there = f"they are {names[0]} to {names[-1]}" if len(names) > 1 else "it is one number"
        raise ParameterError(f"{path} has no element '{name}'; {there}.")
    return [Tuned(path, k, own, unit, tunable, *bounds) for k, own in enumerate(names) if name in (path, own)]


def _number(root: Component, path: str) -> Any:
    """The declaration of a bound parameter that is one number in a tree; else None."""
    owner, _, name = path.rpartition(".")
    part = root.find(owner)
    field = part.parameters.get(name)
    if field is None or field.annotation not in (float, *SHAPES):
        return None
    value = part.parameter_value(name)
    return field if isinstance(value, (int, float, np.number)) and not isinstance(value, bool) else None


def _why_not(plant: Plant, path: str) -> str:
    """Why there is no derivative by a parameter."""
    dae, owner, name = plant.dae, path.rpartition(".")[0], path.rpartition(".")[2]
    known = [*dae.parameters, *dae.bound_parameters]
    part = None if plant.root is None else next((part for part in plant.root.walk() if part.path == owner), None)
    field = part.parameters.get(name) if part is not None else None
    if path in dae.bound_parameters:
        return f"there is no derivative by {path}: it is no number in this run that could be a little more or less."
    if path in dae.dependents:
        return f"there is no derivative by {path}: it follows from other parameters; take those."
    if field is not None and field.is_data:
        return f"there is no derivative by {path}: it is a file, or what was read from it."
    if field is not None and field.why_structural:
        return f"there is no derivative by {path}: it is structural, {field.why_structural}; it is no tunable number."
    if field is not None:
        return f"there is no derivative by {path}: it is no tunable parameter of this model."
    return f"there is no tunable parameter '{path}'{did_you_mean(path, known)}"


class _Work(threading.local):
    """What the runs of one plant have in common, in one thread: component trees, and slopes of what follows from them.

    A tree has the values of the run that asked for it last, and is put anew for another one.
    """

    def __init__(self, plant: Plant):
        self.of_runs, self.of_means, self.apart = KnownSlopes(), KnownSlopes(), dict[Hashable, set[str]]()
        self._plant = plant
        self._trees = {what: RunTrees(plant.dae, plant.root) for what in ("run", "mean")}
        self._lent: dict[str, tuple[object, Common]] = {}
        self._asked: list[tuple[Any, dict[bytes, np.ndarray]]] = []

    def common(self, what: str, owner: object, parameters: Values) -> Common:
        """The tree of a run, or of its mean."""
        known = self._lent.get(what)
        if known is None or known[0] is not owner:
            tree = self._trees[what](parameters)
            if tree is self._plant.root:
                tree = copy.deepcopy(tree)
            same = known is not None and known[1].tree is tree
            known = self._lent[what] = owner, known[1] if same else Common(self._plant.dae, tree, frozenset())
        return known[1]

    def asked(self, values: Any, omega: np.ndarray) -> np.ndarray:
        """Frequencies, with those that were asked for at these values of the elements, and at the last ones."""
        if not self._asked or self._asked[-1][0] != values:
            self._asked = [*self._asked[-1:], (values, {})]
        self._asked[-1][1][omega.tobytes()] = omega
        return np.unique(np.concatenate([one for _, group in self._asked for one in group.values()]))


class TunedRun:
    """A run about its mean, and the elements of parameters by which its results are differentiated.

    parameters: of the run; `mean` are those of its mean.
    """

    def __init__(self, plant: Plant, parameters: Values | None, elements: Sequence[Tuned]):
        self.plant, self.parameters, self.elements = plant, dict(parameters or {}), list(elements)
        self.mean = mean_parameters(plant, self.parameters)
        self.binding = plant.binding(self.mean)
        self._work: _Work = plant.functions.once("tuned runs", lambda: _Work(plant))
        self._beside: dict[bool, Beside] = {}
        self._found: dict[str, Known] = {}
        self._from: dict[str, list[str]] = {}
        self._started: dict[str, np.ndarray] = {}

    @cached_property
    def values(self) -> np.ndarray:
        """Values of the elements (m,) [SI]."""
        return np.array([self._value(item) for item in self.elements])

    def _value(self, item: Tuned) -> float:
        if item.tunable:
            return float(np.ravel(self.whole(item), order="F")[item.number])
        owner, _, name = item.path.rpartition(".")
        return float(self.tree.find(owner).parameter_value(name))

    @property
    def tree(self) -> Component:
        """Component tree of the run itself, not of its mean."""
        return self._of_run.tree

    @property
    def _of_run(self) -> Common:
        return self._work.common("run", self, self.parameters)

    @property
    def _common(self) -> Common:
        return self._work.common("mean", self, self.mean)

    @cached_property
    def contents(self) -> Contents:
        """The parameters of the run, to compare."""
        return self._compared(self.parameters)

    @cached_property
    def _contents(self) -> Contents:
        """Those of its mean."""
        return self._compared(self.mean)

    def _compared(self, parameters: Values) -> Contents:
        """Parameters by path, and the files that were read."""
        values = by_path(parameters) if self.plant.root is None else spread_out(by_path(parameters), self.plant.root)
        return {**contents_of(values), "": (False, tuple(sorted(self.binding.data.items())))}

    def known(self, name: Hashable) -> Known:
        """What runs with the same numbers, as far as these count, have found of what is computed from a tree."""
        return self._work.of_runs.of(name, self.contents)

    def _known(self, path: str) -> Known:
        """The same of a parameter, or of numbers, in the mean."""
        if path not in self._found:
            self._found[path] = self._work.of_means.of(path, self._contents)
        return self._found[path]

    def asked(self, omega: np.ndarray) -> np.ndarray:
        """All frequencies that this run and others with equal elements ask for, or did at the last elements."""
        values = tuple(self.contents.get(path) for path in dict.fromkeys(item.path for item in self.elements))
        return self._work.asked(values, omega)

    @contextmanager
    def tree_at(self, item: Tuned, value: float) -> Iterator[Component]:
        """The same with another value of an element, for as long as the context lasts."""
        if not self._of_run.is_plain(item.path):
            with one_evaluation():
                yield tree_with(self.plant.dae, self.plant.root, self.changed(item, value))
            return
        with self.beside().at({item.path: np.asarray(self._with(item, value))}) as tree:
            yield tree

    def beside(self, of_mean: bool = False) -> Beside:
        """Evaluations of the tree of the run, or of its mean."""
        common = self._common if of_mean else self._of_run
        if of_mean not in self._beside or self._beside[of_mean].common is not common:
            self._beside[of_mean] = Beside(common)
        return self._beside[of_mean]

    def changed(self, item: Tuned, value: float) -> dict[str, Any]:
        """The parameters of the run, with another value of an element."""
        return {**self.parameters, item.path: self._with(item, value)}

    def whole(self, item: Tuned) -> np.ndarray:
        """The whole parameter of an element [SI]."""
        if not item.tunable:
            return np.array(self._value(item))
        unit, now = self.plant.dae.parameters[item.path].unit, self.binding.values[item.path]
        given = to_si(self.parameters.get(item.path, now), unit, item.path)
        return np.array(np.broadcast_to(np.asarray(given, dtype=float), now.shape))

    def _with(self, item: Tuned, value: float) -> Any:
        """The whole parameter, with another value of an element."""
        moved = self.whole(item)
        if not moved.shape:
            return value
        moved.T.flat[item.number] = value
        return moved

    def step(self, item: Tuned) -> float:
        """By how much an element moves for a slope; negative where its upper bound is near."""
        value = float(self.values[self.elements.index(item)])
        step = SHORT * (abs(value) or 1.0)
        return step if item.max is None or value + step <= item.max else -step

    def moves_freely(self, item: Tuned, of_mean: bool = False) -> bool:
        """Whether an element may move to both sides, as a value on a tree."""
        value, step = float(self.values[self.elements.index(item)]), self.step(item)
        if not item.tunable or step < 0 or (item.min is not None and value - step < item.min):
            return False
        return (self._common if of_mean else self._of_run).is_plain(item.path)

    def shifted(self, shifts: Mapping[str, float]) -> dict[str, np.ndarray]:
        """Whole parameters with elements shifted by so much, by their names."""
        found: dict[str, np.ndarray] = {}
        for number, item in enumerate(self.elements):
            if (shift := shifts.get(item.name)) is not None:
                whole = found.setdefault(item.path, np.array(self.whole(item)))
                whole.T.flat[item.number if whole.shape else 0] = self.values[number] + shift
        return found

    def kept_apart(self, name: Hashable, known: Known, items: Sequence[Tuned], here: np.ndarray,
                   computed: Callable[[Component], np.ndarray], of_mean: bool = False) -> set[str]:  # fmt: skip
        """Names of the elements that did not matter to numbers computed from a tree, in evaluations before this.

        A part of a hull knows all diameters and reads those near to it. That it still does is seen at once, by moving
        all the others together: where the numbers are no longer the same, to the last digit, all count again.
        """
        if known.apart is None:
            common, contents = (self._common, self._contents) if of_mean else (self._of_run, self.contents)
            before = self._work.apart.setdefault(name, set())
            apart = [item for item in items if item.name in before and item.tunable and common.is_plain(item.path)]
            if apart:
                moved = self.shifted({item.name: self.step(item) for item in apart})
                with self.beside(of_mean).at(moved) as tree, parameters_read() as read:
                    if not np.array_equal(computed(tree), here):
                        apart = []
                known.note(read, contents)
            before -= {item.name for item in items} - {item.name for item in apart}
            known.apart = {item.name for item in apart}
        return known.apart

    def set_apart(self, name: Hashable, item: Tuned) -> None:
        """That an element did not matter to numbers; see kept_apart."""
        self._work.apart.setdefault(name, set()).add(item.name)

    def slope(self, item: Tuned, function: Callable[[float], np.ndarray],
              here: np.ndarray | None = None) -> np.ndarray:  # fmt: skip
        """Derivative of `function(value of the element)`, whose value is `here`."""
        value = float(self.values[self.elements.index(item)])
        what = f"what follows from {item.name}"
        return derivative(function, value, here=here, low=item.min, high=item.max, quick=True, what=what)

    # --- what the mean takes in ----------------------------------------------------------------------------------

    @cached_property
    def _numbers(self) -> dict[str, slice]:
        """Places in p of the numbers that are computed when a run starts, by their paths."""
        dae = self.plant.dae
        first, places = sum(item.symbol.numel() for item in dae.parameters.values()), {}
        for path, item in dae.bound.items():
            places[path] = slice(first, first := first + item.symbol.numel())
        return places

    def pulled_back(self, p: np.ndarray, w: np.ndarray, t: float) -> np.ndarray:
        """Slopes of results by the elements (k, m).

        From those by all entries of p (k, p), and by the outputs of the externals (k, w), in the mean.
        """
        used, used_w = np.any(p != 0, axis=0), np.any(w != 0, axis=0)
        found = np.zeros((len(p), len(self.elements)))
        if self.plant.root is not None:
            self._learn_closed(counting := self._counting(used))
            self._learn_together(counting)
        for column, item in enumerate(self.elements):
            if item.tunable and self.plant.root is None:
                found[:, column] = p[:, self.plant.layout.p[item.path].start + item.number]
            elif item.name in self._alone:
                found[:, column] = p[:, self.plant.layout.p[item.path].start + item.number]
                found[:, column] += self._through_numbers(item, p, counting)
            else:
                found[:, column] = self._through_all(item, p, w, used_w, t)
        return found

    @cached_property
    def _alone(self) -> frozenset[str]:
        """Names of the tunable elements of which that is so."""
        return frozenset(item.name for item in self.elements if item.tunable and self._acts_alone(item))

    def _acts_alone(self, item: Tuned) -> bool:
        """Whether the parameters of the mean are those of the run in it, and no data behind a handle follow from it."""
        if not self._common.is_plain(item.path):
            return False
        if item.path in self.parameters and not np.array_equal(
            np.ravel(self.binding.values[item.path], order="F")[item.number], self._value(item)
        ):
            return False
        read = {item.path, *self._followers(item)}
        return not any(read & self.binding.reads.get(path, frozenset()) for path in self.binding.sources)

    def _followers(self, item: Tuned) -> list[str]:
        """Parameters that are computed from one."""
        return [path for path, by in self._common.needs.items() if item.path in by]

    def _asked(self, item: Tuned, counting: frozenset[str]) -> dict[str, Known]:
        """Other parameters, and numbers, that are computed from an element, of those that count."""
        return {path: self._known(path) for path in self._computed_from(item) if path in counting}

    def _computed_from(self, item: Tuned) -> list[str]:
        """Paths of all of them."""
        if item.path not in self._from:
            followers = self._followers(item)
            read = {item.path, *followers}
            numbers = [path for path in self._numbers if not read.isdisjoint(self.binding.reads.get(path, ()))]
            self._from[item.path] = [*followers, *numbers]
        return self._from[item.path]

    def _counting(self, used: np.ndarray) -> frozenset[str]:
        """Paths of parameters and numbers on which results depend, of which it is said for each entry of p."""
        places = {**self.plant.layout.p, **self._numbers}
        return frozenset(path for path, place in places.items() if used[place].any())

    def _through_numbers(self, item: Tuned, p: np.ndarray, counting: frozenset[str]) -> np.ndarray:
        """Slopes through other parameters, and through numbers, that are computed from an element."""
        known = self._asked(item, counting)
        self._learn(item, {path: one for path, one in known.items() if item.name not in one.slopes})
        found = np.zeros(len(p))
        for path, one in known.items():
            if (slope := one.slopes[item.name]) is not None:
                found += p[:, self._place(path)] @ slope
        return found

    @cached_property
    def by_arithmetic(self) -> list[Tuned]:
        """Elements by which slopes of other parameters may follow from arithmetic; see `tangents`."""
        return [item for item in self.elements if item.name in self._alone]

    def tangents(self) -> Tangents:
        """Changes of values of parameters along these elements, on a tree of this run or of its mean."""
        return Tangents([(item.path, item.number) for item in self.by_arithmetic], self._start_slopes)

    def _start_slopes(self, path: str, numbers: np.ndarray) -> np.ndarray | None:
        """Slopes (n, m) by these elements of what a part computes at the start; None where that are other numbers."""
        if path not in self._numbers or not np.array_equal(numbers, self.binding.p[self._place(path)]):
            return None
        if path not in self._started:
            self._learn_together(frozenset([path]))
            found, one = np.zeros((len(numbers), len(self.by_arithmetic))), self._known(path)
            for column, item in enumerate(self.by_arithmetic):
                if path not in self._computed_from(item):
                    continue
                if item.name not in one.slopes:
                    self._learn(item, {path: one})
                if (slope := one.slopes[item.name]) is not None:
                    found[:, column] = slope
            self._started[path] = found
        return self._started[path]

    def _learn_closed(self, counting: frozenset[str]) -> None:
        """Slopes that are arithmetic, or that parts say of their numbers; see solving.closed_slopes."""
        asked: dict[str, list[tuple[int, Tuned]]] = {}
        for column, item in enumerate(self.by_arithmetic):
            for path, one in self._asked(item, counting).items():
                if item.name not in one.slopes:
                    asked.setdefault(path, []).append((column, item))
        tangents = self.tangents()
        for path, items in asked.items():
            bound = self.plant.dae.bound.get(path)
            slopes = None if bound is None else getattr(bound.compute, "slopes", None)
            if path in self.binding.sources or (bound is not None and slopes is None):
                continue
            one = self._known(path)
            self._meet(path, one)
            with self.beside(of_mean=True).here() as (tree, _):
                owner, _, name = path.rpartition(".")
                found = tangents(tree.find(owner), name) if slopes is None else slopes(tree.find(bound.owner), tangents)
            if found.shape != (np.size(self.binding.p[self._place(path)]), len(self.by_arithmetic)):
                continue
            for column, item in items:
                if np.all(np.isfinite(slope := found[:, column])):
                    one.slopes[item.name] = slope.copy() if slope.any() else None

    def _learn_together(self, counting: frozenset[str]) -> None:
        """Slopes by those elements of which it is known what they mattered to before."""
        steps: dict[str, float] = {}
        asked: dict[str, dict[str, Known]] = {}
        for item in self.elements:
            if item.name not in self._alone or not self.moves_freely(item, of_mean=True):
                continue
            known = {path: one for path, one in self._asked(item, counting).items() if item.name not in one.slopes}
            if known and all(item.name in one.before for one in known.values()):
                steps[item.name], asked[item.name] = self.step(item), known
        if len(steps) < 2:
            return
        for path, one in {path: one for known in asked.values() for path, one in known.items()}.items():
            self._meet(path, one)
        affects = {name: {path: one.before[name] for path, one in known.items() if one.before[name] is not None}
                   for name, known in asked.items()}  # fmt: skip
        here = {path: np.atleast_1d(self.binding.p[self._place(path)]) for known in asked.values() for path in known}

        def computed(shifts: Mapping[str, float], paths: Sequence[str]) -> list[np.ndarray]:
            with self.beside(of_mean=True).at(self.shifted(shifts)) as tree:
                return [self._computed(tree, path) for path in paths]

        found = slopes_together(steps, affects, here, computed)
        for name, slopes in (found or {}).items():
            for path, one in asked[name].items():
                one.slopes[name] = slopes.get(path)

    def _meet(self, path: str, one: Known) -> None:
        """What is computed, as it is, so that it is noted what it follows from."""
        beside = self.beside(of_mean=True)
        if path not in beside.met:
            beside.met.add(path)
            with beside.here() as (tree, read):
                self._computed(tree, path)
            one.note(read, self._contents)

    def _place(self, path: str) -> Any:
        """Where a parameter, or numbers, stand in p."""
        return self._numbers[path] if path in self._numbers else self.plant.layout.p[path]

    def _learn(self, item: Tuned, unknown: Mapping[str, Known]) -> None:
        """The slopes of what is computed from an element; None of what does not depend on it."""
        apart, beside = set[str](), self.beside(of_mean=True)
        for path, one in unknown.items():
            self._meet(path, one)
            if path in self._numbers and path not in self.binding.sources:
                kept = self.kept_apart(path, one, self.elements, self.binding.p[self._place(path)],
                                       lambda tree, path=path: self._computed(tree, path), of_mean=True)  # fmt: skip
                if item.name in kept:
                    one.slopes[item.name] = None
                    apart.add(path)
        asked = {path: one for path, one in unknown.items() if path not in apart}
        if not asked:
            return
        ends = np.cumsum([0, *(np.size(self.binding.p[self._place(path)]) for path in asked)])
        given = np.array(self.binding.values[item.path])

        def computed(value: float) -> np.ndarray:
            moved = given.copy()
            moved.T.flat[item.number] = value
            with beside.at({item.path: moved}) as tree:
                return np.concatenate([self._computed(tree, path) for path in asked])

        here = np.concatenate([np.atleast_1d(self.binding.p[self._place(path)]) for path in asked])
        slope = self.slope(item, computed, here)
        for (path, one), first, last in zip(asked.items(), ends[:-1], ends[1:], strict=True):
            part = slope[first:last]
            one.slopes[item.name] = part if part.any() else None
            if path in self._numbers and not part.any():
                self.set_apart(path, item)

    def _computed(self, tree: Component, path: str) -> np.ndarray:
        """Numbers, or a parameter that follows from others, with the values that a tree has."""
        if path in self._numbers:
            item = self.plant.dae.bound[path]
            return start_numbers(item, tree.find(item.owner))
        owner, _, name = path.rpartition(".")
        now = np.asarray(tree.find(owner).parameter_value(name), dtype=float)
        return np.ravel(np.broadcast_to(now, self.binding.values[path].shape), order="F")

    def _same_mean(self, item: Tuned) -> bool:
        """Whether the mean does not see it, as the height of waves."""
        value = float(self.values[self.elements.index(item)])
        moved = mean_parameters(self.plant, self.changed(item, value + 1e-3 * (abs(value) or 1.0)))
        return moved.keys() == self.mean.keys() and all(
            moved[path] is now or np.array_equal(moved[path], now) for path, now in self.mean.items()
        )

    def _through_all(self, item: Tuned, p: np.ndarray, w: np.ndarray, used: np.ndarray, t: float) -> np.ndarray:
        """By whole bindings of the mean, and what they know behind handles."""
        plant, dae = self.plant, self.plant.dae
        if not item.tunable and self._same_mean(item):
            return np.zeros(len(p))
        handles = [self._numbers[bound.path] for _, bound in dae.with_data]
        asked = [(k, bound) for k, bound in dae.with_data if used[dae.externals[k].outputs].any()]

        def taken_in(value: float) -> np.ndarray:
            binding = plant.binding(mean_parameters(plant, self.changed(item, value)))
            numbers = np.where(np.isfinite(binding.p), binding.p, 0.0)
            for place in handles:
                numbers[place] = 0.0
            columns = [numbers]
            for k, bound in asked:
                source = binding.sources.get(bound.path)
                if source is None or source is self.binding.sources.get(bound.path):  # none, or those that do not move
                    columns.append(np.zeros(dae.externals[k].outputs.stop - dae.externals[k].outputs.start))
                elif isinstance(source, Series):
                    columns.append(np.ravel(source(t)))
                else:
                    raise ParameterError(
                        f"there is no derivative by {item.name}: {bound.path} is computed when a run starts, as data "
                        "that have no derivative by it. Take the difference of two values of it."
                    )
            return np.concatenate(columns)

        places = [w[:, dae.externals[k].outputs] for k, _ in asked]
        return np.hstack([p, *places]) @ self.slope(item, taken_in)
