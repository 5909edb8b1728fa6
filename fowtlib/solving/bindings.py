"""The bindings of a compiled model: those of the last runs are kept, and the next one is made from its neighbour.

Runs that differ in tunable parameters alone have their parts and their data in common. What is computed when a run
starts says which parameters it was computed from, so that only what follows from a changed one is computed anew, on a
component tree on which the values stand for that time.
"""

from __future__ import annotations

import copy
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, replace
from functools import cached_property, partial
from threading import RLock
from typing import Any

import numpy as np

from fowtlib.flattening import FlatDAE
from fowtlib.flattening.instances import check_parameters
from fowtlib.language.component import Component
from fowtlib.language.declarations import join
from fowtlib.language.expressions import one_evaluation, parameters_read
from fowtlib.solving.binding import (
    Binding,
    Values,
    bind,
    bound_files,
    content_of,
    put_bound,
    read_for,
    start_numbers,
    tunable_value,
    vector_of,
)
from fowtlib.solving.paths import by_path, spread_out

Numbers = Mapping[str, np.ndarray]
"""Values of tunable parameters by path [SI]."""


class Common:
    """The component tree of runs that differ in tunable parameters alone."""

    def __init__(self, dae: FlatDAE, tree: Component, changed: frozenset[str]):
        self.dae, self.tree, self.changed, self._lock = dae, tree, changed, RLock()

    @cached_property
    def needs(self) -> dict[str, frozenset[str]]:
        """The parameters that each tunable one is computed from, by their paths; those that are just given: none."""
        return {path: read_for(self.tree, path) for path in self.dae.parameters}

    @contextmanager
    def put(self, given: Numbers) -> Iterator[Component]:
        """The tree with values on it, which are taken away at the end."""
        with self._lock:
            before = [(values := self._values(path), dict(values)) for path in given]
            try:
                for path, value in given.items():
                    self._values(path)[path.rpartition(".")[2]] = value if value.shape else float(value)
                yield self.tree
            finally:
                for values, old in reversed(before):
                    values.clear()
                    values.update(old)

    def is_plain(self, path: str) -> bool:
        """Whether a value for a parameter changes nothing but this value: it takes no other's place."""
        owner, _, name = path.rpartition(".")
        component = self.tree.find(owner)
        alone = not component.void and not any(field.instead_of for field in component.parameters.values())
        return alone or (name not in component.void and component._values.get(name) is not None)

    def _values(self, path: str) -> dict[str, Any]:
        return self.tree.find(path.rpartition(".")[0])._values


@dataclass(frozen=True)
class _Kept:
    """A binding, the tunable values that were given for it, and what else was given."""

    binding: Binding
    given: Numbers
    data: Any


class Bindings:
    """The bindings of a compiled model; the last ones are kept, and used again for equal values and unchanged files."""

    KEPT = 8
    COMMON = 4  # trees

    def __init__(self, dae: FlatDAE, root: Component | None):
        self.dae, self.root = dae, root
        self._kept: dict[Any, _Kept] = {}
        self._common: dict[Any, Common] = {}
        self._compiled = bound_files(root, bound=False)  # as they were then

    def __call__(self, parameters: Values | None = None) -> Binding:
        """The binding of these values; see `bind`."""
        given = by_path(parameters or {})
        given = given if self.root is None else spread_out(given, self.root)
        key = _key(given)
        self._kept = {known: item for known, item in self._kept.items() if item.binding.holds}
        found = self._kept.pop(key, None)
        if found is None or not self._fresh(found.binding):
            found = self._beside(given) or self._alone(given)
        self._kept[key] = found
        while len(self._kept) > self.KEPT:
            del self._kept[next(iter(self._kept))]
        return found.binding

    def _fresh(self, binding: Binding) -> bool:
        return binding.data == {**self._compiled, **bound_files(binding.like)}

    @cached_property
    def needs(self) -> dict[str, frozenset[str]]:
        """The parameters that each tunable one is computed from, by their paths; those that are just given: none."""
        return {path: read_for(self.root, path) for path in self.dae.parameters} if self.root is not None else {}

    def _alone(self, given: dict[str, Any]) -> _Kept:
        found = bind(self.dae, self.root, given, lambda: self.needs)
        found = replace(found, data={**self._compiled, **found.data})
        tunable, data = self._divided(given)
        return _Kept(found, {path: found.values[path] for path in tunable}, data)

    def _divided(self, given: dict[str, Any]) -> tuple[dict[str, Any], Any]:
        """The tunable parameters, and something that is equal where the others are."""
        tunable = {path: given[path] for path in sorted(given) if path in self.dae.parameters}
        return tunable, _key({path: value for path, value in given.items() if path not in tunable})

    def _beside(self, given: dict[str, Any]) -> _Kept | None:
        """From the last binding that differs in tunable parameters alone; None: there is none, or more would change."""
        tunable, data = self._divided(given)
        near = next((item for item in reversed(self._kept.values()) if item.data == data), None)
        if self.root is None or near is None or not self._fresh(near.binding):
            return None
        numbers = {path: tunable_value(self.dae, path, value) for path, value in tunable.items()}
        common = self._tree(data, {path: value for path, value in given.items() if path not in tunable})
        if not all(common.is_plain(path) for path in {**numbers, **near.given}):
            return None
        found = _moved(self.dae, near, numbers, common)
        return found and _Kept(found, numbers, data)

    def _tree(self, data: Any, given: dict[str, Any]) -> Common:
        if data not in self._common:
            tree = copy.deepcopy(self.root)
            changed = put_bound(self.dae, tree, given)
            while len(self._common) >= self.COMMON:
                del self._common[next(iter(self._common))]
            self._common[data] = Common(self.dae, tree, frozenset(changed))
        return self._common[data]


def _moved(dae: FlatDAE, near: _Kept, given: Numbers, common: Common) -> Binding | None:
    """The binding of these values, from one of others; None where data behind a handle follow from what changes."""
    old, touched = near.binding, {*given, *near.given}
    values = {**old.values, **given}
    with common.put(given) as tree, one_evaluation():
        for path, by in common.needs.items():  # back to the model's own, and what is computed from others
            if path not in given and (path in touched or not by.isdisjoint(touched)):
                owner, _, name = path.rpartition(".")
                now = np.asarray(tree.find(owner).parameter_value(name), dtype=float)
                values[path] = np.broadcast_to(now, values[path].shape).copy()
        moved = [path for path, value in values.items() if value is not old.values[path]]
        changed = {path for path in moved if not np.array_equal(values[path], old.values[path])}
        for path in common.changed:
            check_parameters(tree.find(path))
        numbers, reads, first = [], dict(old.reads), sum(value.size for value in values.values())
        for item in dae.bound.values():
            last = first + item.symbol.numel()
            if changed.isdisjoint(old.reads[item.path]):
                numbers.append(old.p[first:last])
            else:
                with parameters_read() as read:
                    found = start_numbers(item, tree.find(item.owner))
                if item.path in old.sources or not isinstance(found, np.ndarray):
                    return None
                paths = (join(owner, name) for owner, name in read)
                reads[item.path] = frozenset(path for path in paths if path in dae.parameters)
                numbers.append(found)
            first = last
    p = vector_of(values, numbers)
    dae.check_dependents(p)
    return replace(old, p=p, values=values, reads=reads, like=common.tree, lend=partial(common.put, given))


def _key(given: dict[str, Any]) -> Any:
    return tuple(sorted((path, content_of(value)) for path, value in given.items()))
