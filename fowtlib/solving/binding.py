"""What one run takes in: the values of its parameters, and all that is computed from them when it starts.

The flat model has symbols for the tunable parameters, and for the numbers that components compute at the start. A run
gives values to the first, puts bound parameters and replaced parts on a copy of the component tree, and lets the
components at their places compute the second.
"""

from __future__ import annotations

import copy
from collections.abc import Callable, Iterator, Mapping
from contextlib import AbstractContextManager, contextmanager
from dataclasses import dataclass, field
from functools import cached_property
from threading import RLock
from types import MappingProxyType
from typing import Any

import numpy as np

from fowtlib.flattening import FlatDAE
from fowtlib.flattening.instances import check_parameters
from fowtlib.flattening.system import Bound
from fowtlib.language import bounds
from fowtlib.language.component import Component
from fowtlib.language.data_files import files_of, named
from fowtlib.language.declarations import join
from fowtlib.language.errors import ModelError, ParameterError, did_you_mean
from fowtlib.language.expressions import parameters_read
from fowtlib.language.matrix_forms import wrong_form
from fowtlib.language.units import to_si
from fowtlib.solving.paths import by_path, spread_out
from fowtlib.solving.structure import structural_values

Values = Mapping[str, Any]


@dataclass(frozen=True)
class Binding:
    """The values of one run.

    p: all entries of the vector of that name of the flat model; values: the tunable parameters by path. Read only.
    like: a component tree with the same parts and bound parameters; None where the model has none. lend: gives it with
    the values of the run on it, as long as the context lasts; None: it has them.
    breaks: instants at which a solver has to stop and start again.
    sources: data behind handles by the path of their numbers; reads: the tunable parameters that numbers were computed
    from, by the same paths. steady: the handles, by the hashes of their symbols, whose data are the same at all times.
    """

    p: np.ndarray
    values: Mapping[str, np.ndarray]
    like: Component | None
    lend: Callable[[], AbstractContextManager[Component]] | None = field(default=None, repr=False)
    breaks: tuple[float, ...] = ()
    sources: dict[str, Any] = field(default_factory=dict)
    reads: dict[str, frozenset[str]] = field(default_factory=dict)
    steady: frozenset[int] = frozenset()
    held: tuple[Any, ...] = field(default=(), repr=False)
    data: Mapping[str, str] = field(default_factory=dict)
    """Files that parameters name, with the digests of what was read, by the paths of the parameters."""

    def __post_init__(self) -> None:
        for array in (self.p, *self.values.values()):
            array.flags.writeable = False
        object.__setattr__(self, "values", MappingProxyType(dict(self.values)))

    @cached_property
    def root(self) -> Component | None:
        """The component tree of the run; None where the model has none."""
        with self.tree() as tree:
            return copy.deepcopy(tree) if self.lend is not None else tree

    @contextmanager
    def tree(self) -> Iterator[Component | None]:
        """The component tree of the run to look at, for as long as the context lasts; quicker than `root`, its copy."""
        if self.lend is None:
            yield self.like
        else:
            with self.lend() as tree:
                yield tree

    @cached_property
    def structure(self) -> dict[str, Any]:
        """Structural and bound parameters of all parts; see structural_values."""
        values = structural_values(self.like)
        return values | {path: text for path, text in self.data.items() if path in values}

    @property
    def holds(self) -> bool:
        """Whether all its data are still there: those that were made for a run alone may be gone."""
        return all(getattr(source, "there", True) for source in self.sources.values())

    def words(self, message: str) -> str:
        """A message with the values of bound parameters put in for their paths in braces, as in {wind.file}."""
        if self.like is None or "{" not in message:
            return message
        for part in self.like.walk():
            for name, declared in part.parameters.items():
                key = "{" + join(part.path, name) + "}"
                if declared.bound and key in message:
                    message = message.replace(key, str(part.parameter_value(name)))
        return message


def read_for(root: Component, path: str) -> frozenset[str]:
    """The parameters that one is computed from, by their paths; none where it is just given."""
    owner, _, name = path.rpartition(".")
    with parameters_read() as read:
        root.find(owner).parameter_value(name)
    return frozenset(join(*item) for item in read) - {path}


def bind(dae: FlatDAE, root: Component | None, parameters: Values | None = None,
         needs: Callable[[], Mapping[str, frozenset[str]]] | None = None) -> Binding:  # fmt: skip
    """The binding of a run.

    needs: gives what each tunable parameter is computed from, so that only what is changed is computed anew.
    parameters: by path the values of tunable and of bound parameters, SI or with unit, or a component that takes the
    place of the part at the path, of the same family (what it was not given, it takes from that part, as far as all
    kinds have it).
    Raises ParameterError where there is no such parameter, a value is out of its bounds, or a part has other equations.
    """
    given = by_path(parameters or {})
    if root is None:
        values = {path: item.value for path, item in dae.parameters.items()}
        values |= {path: tunable_value(dae, path, value) for path, value in given.items()}
        return Binding(vector_of(values, []), values, None)
    given = spread_out(given, root)
    tree, values, changed = _with_values(dae, root, given)
    if tree is not root:
        by = needs() if needs is not None and not changed else None
        for path in values:  # those that were computed from what is changed now
            if path not in given and (by is None or not by[path].isdisjoint(given)):
                owner, _, name = path.rpartition(".")
                now = np.asarray(tree.find(owner).parameter_value(name), dtype=float)
                values[path] = np.broadcast_to(now, values[path].shape).copy()
    return _computed(dae, tree, values)


def tree_with(dae: FlatDAE, root: Component, parameters: Values | None = None) -> Component:
    """The component tree of a run, with nothing computed from it: no series, no fields; see `bind`."""
    return _with_values(dae, root, spread_out(by_path(parameters or {}), root))[0]


class RunTrees:
    """Component trees of runs of one model, used again where runs differ in numbers alone; see `tree_with`.

    A tree is that of the last run that it was asked for, and no more than that: nothing may hold it.
    """

    KEPT = 4

    def __init__(self, dae: FlatDAE, root: Component):
        self.dae, self.root = dae, root
        self._kept: dict[Any, Component] = {}
        self._lock = RLock()

    @contextmanager
    def lent(self, parameters: Values | None = None) -> Iterator[Component]:
        """The tree of a run to look at, for as long as the context lasts."""
        with self._lock:
            yield self(parameters)

    def __call__(self, parameters: Values | None = None) -> Component:
        """The tree of a run with these parameters."""
        given = spread_out(by_path(parameters or {}), self.root)
        numbers = {path: value for path, value in given.items()
                   if _is_number(value) or (path in self.dae.parameters and isinstance(value, np.ndarray))}  # fmt: skip
        others = {path: value for path, value in given.items() if path not in numbers}
        key = tuple(sorted(numbers)), tuple((path, content_of(others[path])) for path in sorted(others))
        tree = self._kept.pop(key, None)  # where a value is refused, it is not kept
        if tree is None:
            tree = tree_with(self.dae, self.root, given)
        else:
            for path, value in sorted(numbers.items()):
                owner, _, name = path.rpartition(".")
                component = tree.find(owner)
                if path in self.dae.parameters:
                    array = tunable_value(self.dae, path, value)
                    component._values[name] = array if array.shape else float(array)
                else:
                    component._set(name, value)
            for owner in dict.fromkeys(path.rpartition(".")[0] for path in numbers if path not in self.dae.parameters):
                check_parameters(tree.find(owner))
        self._kept[key] = tree
        while len(self._kept) > self.KEPT:
            del self._kept[next(iter(self._kept))]
        return tree


def _is_number(value: Any) -> bool:
    return isinstance(value, (int, float, np.integer, np.floating)) and not isinstance(value, bool)


def _with_values(dae: FlatDAE, root: Component,
                 given: dict[str, Any]) -> tuple[Component, dict[str, np.ndarray], set[str]]:  # fmt: skip
    """The tree of a run, the tunable values, and the parts that have other data; `given` keeps the tunable ones."""
    tree = copy.deepcopy(root) if given else root
    changed = _put_parts(tree, {path: given.pop(path) for path in list(given) if isinstance(given[path], Component)})
    changed |= put_bound(dae, tree, given)
    values = {path: item.value for path, item in dae.parameters.items()}
    for path in sorted(given):
        values[path] = tunable_value(dae, path, given[path])
        owner, _, name = path.rpartition(".")
        component = tree.find(owner)
        if name in component.void and np.array_equal(values[path], component.parameter_value(name)):
            continue  # as a result says it of a kind that takes no notice of it
        component._values[name] = values[path] if values[path].shape else float(values[path])
    for path in changed:
        check_parameters(tree.find(path))
    for path in changed | {path.rpartition(".")[0] for path in given}:
        tree.find(path).refuse_void()
    return tree, values, changed


def tunable_value(dae: FlatDAE, path: str, value: Any) -> np.ndarray:
    """The value of a tunable parameter in SI, within its bounds."""
    if path not in dae.parameters:
        known = [*dae.parameters, *dae.bound_parameters]
        raise ParameterError(
            f"there is no tunable parameter '{path}'{did_you_mean(path, known)} "
            "A structural or dependent parameter is changed in the model, before compile()."
        )
    item = dae.parameters[path]
    try:
        numbers = np.asarray(to_si(value, item.unit, path), dtype=float)
        fits = np.broadcast_to(numbers, item.value.shape).copy()
    except ValueError:
        shape = "one number" if not item.value.shape else f"numbers of shape {item.value.shape}"
        raise ParameterError(f"{path} = {value} does not fit: it takes {shape} [{item.unit}] ({item.doc}).") from None
    if not np.all(np.isfinite(numbers)):
        raise ParameterError(f"{path} = {value} is not a finite number ({item.doc}).")
    found = bounds.outside(numbers, item.min, item.max, item.unit)
    if found:
        raise ParameterError(f"{path} = {value} is {found[1]} ({item.doc}).")
    if item.form and (wrong := wrong_form(item.form, fits)):
        raise ParameterError(f"{path}: {wrong} ({item.doc}).")
    return fits


# --- what is put on the tree --------------------------------------------------------------------------------------


def put_bound(dae: FlatDAE, tree: Component, given: dict[str, Any]) -> set[str]:
    """Take the bound parameters out of `given` and set them; the paths of their components."""
    chosen: list[tuple[bool, str, Component, str]] = []
    for path in given:
        if path in dae.parameters:
            continue
        owner, _, name = path.rpartition(".")
        component = _found(tree, owner)
        if component is None:
            continue
        family = component.family
        declared = component.parameters.get(name) or (family.parameters.get(name) if family is not None else None)
        if declared is not None and declared.bound:
            chosen.append((family is None or name != family.selector, path, component, name))
    for _, path, component, name in sorted(chosen, key=lambda item: item[:2]):  # kinds first
        family, before = component.family, type(component)
        component._set(name, given.pop(path))
        if type(component) is not before:
            _same_equations(path.rpartition(".")[0], before, type(component), family)
    return {component.path for _, _, component, _ in chosen}


def _put_parts(tree: Component, parts: dict[str, Component]) -> set[str]:
    """Put parts in the places of others; the paths where that was done."""
    for path, given in sorted(parts.items()):
        old = _found(tree, path)
        if old is None or not path:
            known = [part.path for part in tree.walk() if part.path]
            raise ParameterError(f"there is no part '{path}' to be replaced{did_you_mean(path, known)}")
        family = old.family
        if family is None or not isinstance(given, family.base):
            wanted = f"a {family.base.__name__}" if family is not None else "the part it was compiled with"
            raise ParameterError(
                f"{path}: a {type(given).__name__} cannot take the place of a {type(old).__name__} in a compiled "
                f"model, where only {wanted} fits; replace it in the model, before compile()."
            )
        _same_equations(path, type(old), type(given), family)
        new = _alone(given)
        common = new.parameters if type(new) is type(old) else family.base.parameters
        for name, value in old._values.items():
            if name in common and name not in new.void and name not in new._values and name != family.selector:
                new._values[name] = value
                if name in old.origins:
                    new.origins[name] = old.origins[name]
        for name, declared in new.parameters.items():
            if declared.bound or declared.tunable:
                continue
            before, now = old.parameter_value(name), new.parameter_value(name)
            if not np.array_equal(np.asarray(before, dtype=object), np.asarray(now, dtype=object)):
                raise ParameterError(
                    f"{path}.{name} decides about the equations: the model is compiled with {before}, and the "
                    f"{type(given).__name__} has {now}. Change it in the model, before compile()."
                )
        new._parent, new._name = old._parent, old._name
        old._parent.parts[old._name] = new
    return set(parts)


def _same_equations(path: str, old: type, new: type, family: Any) -> None:
    for cls in (old, new):
        reason = family.own_equations(cls)
        if reason and cls is not (new if cls is old else old):
            raise ParameterError(
                f"{path}: a {new.__name__} cannot take the place of a {old.__name__} when a run starts, because "
                f"{cls.__name__} has {reason} of its own, other equations; choose it in the model, before compile()."
            )


def _alone(component: Component) -> Component:
    """A copy of a component without the model that it may be part of."""
    return copy.deepcopy(component, {id(component._parent): None} if component._parent is not None else None)


def _found(tree: Component, path: str) -> Component | None:
    component: Component | None = tree
    for name in path.split(".") if path else ():
        component = component.parts.get(name) if component is not None else None
    return component


# --- what is computed ---------------------------------------------------------------------------------------------


def _computed(dae: FlatDAE, tree: Component, values: dict[str, np.ndarray]) -> Binding:
    numbers, held, breaks, data = [], [], [], bound_files(tree)
    sources: dict[str, Any] = {}
    reads: dict[str, frozenset[str]] = {}
    steady: set[int] = set()
    for item in dae.bound.values():
        with parameters_read() as read:
            found = start_numbers(item, tree.find(item.owner))
        paths = (join(owner, name) for owner, name in read)
        reads[item.path] = frozenset(path for path in paths if path in dae.parameters)
        if item.functions and (isinstance(found, np.ndarray) or getattr(found, "steady", False)):
            steady.add(item.symbol[0].element_hash())
        if isinstance(found, np.ndarray):
            numbers.append(found)
            continue
        sources[item.path] = found
        held += [found, *(found.open_in(function) for function in item.functions)]
        breaks += getattr(found, "breaks", ())
        numbers.append(np.asarray(found.numbers, dtype=float))
    instants = tuple(sorted(set(breaks)))
    p, known = vector_of(values, numbers), tuple(held)
    dae.check_dependents(p)
    return Binding(p, values, tree, None, instants, sources, reads, frozenset(steady), known, data)


def data_from(dae: FlatDAE, binding: Binding, path: str) -> list[str]:
    """The paths of data behind a handle that are made from a parameter when a run starts."""
    return [item.path for item in dae.bound.values()
            if item.path in binding.sources and path in binding.reads.get(item.path, ())]  # fmt: skip


def start_slopes(dae: FlatDAE, binding: Binding, path: str) -> dict[str, np.ndarray]:
    """Derivatives of numbers that are computed at the start by a tunable parameter, by central differences.

    By the paths of the numbers: (their count, elements of the parameter). The step is 1e-5 of the value, so that the
    error is about 1e-9 of the derivative of something smooth. Raises ParameterError for data behind a handle.
    """
    given = np.asarray(binding.values[path], dtype=float)
    owner, _, name = path.rpartition(".")
    following = [item for item in dae.bound.values() if path in binding.reads.get(item.path, ())]
    for place in data_from(dae, binding, path):
        raise ParameterError(
            f"{place} is computed from {path} when a run starts, as data that have no derivative by it; "
            "run with two values of it, and take the difference."
        )
    if not following:
        return {}
    columns = []  # of each element of the parameter, by the numbers that follow from it
    for k in range(given.size):
        step = 1e-5 * (abs(given.flat[k]) or 1.0)
        both = []
        for sign in (1, -1):
            tree, moved = copy.deepcopy(binding.root), given.copy()
            moved.flat[k] += sign * step
            tree.find(owner)._values[name] = moved if moved.shape else float(moved)
            both.append([np.ravel(start_numbers(item, tree.find(item.owner))) for item in following])
        columns.append([(above - below) / (2 * step) for above, below in zip(*both, strict=True)])
    return {item.path: np.column_stack([column[i] for column in columns]) for i, item in enumerate(following)}


def start_numbers(item: Bound, component: Component) -> Any:
    """What a component computes for a place in p: numbers, or a source of them."""
    size = item.symbol.numel()
    try:
        found = item.compute(component)
        if found is None:
            return _nothing(item)
        if hasattr(found, "numbers"):
            _fit(item, found, size)
            return found
        array = np.ravel(np.asarray(found, dtype=float))
    except MemoryError:
        raise ParameterError(
            f"{item.path}: what is computed when a run starts ({item.doc}) needs more memory than there is."
        ) from None
    except ModelError as error:
        raise error.at(item.owner or type(component).__name__) if item.owner not in str(error) else error from None
    if array.size != size:
        raise ParameterError(f"{item.path}: {array.size} numbers were computed at the start, and {size} are expected.")
    if np.any(np.isnan(array)):
        raise ParameterError(f"{item.path}: what was computed at the start is not a number.")
    return array


def _nothing(item: Bound) -> np.ndarray:
    """Numbers where there are no data: a handle of 0, and no ends."""
    numbers = np.zeros(item.symbol.numel())
    if item.functions and numbers.size == 3:
        numbers[1:] = -np.inf, np.inf
    return numbers


def _fit(item: Bound, source: Any, size: int) -> None:
    if len(source.numbers) != size:
        raise ParameterError(f"{item.path}: {len(source.numbers)} numbers instead of {size}.")
    for function in item.functions:
        outputs = sum(function.outputs.values())
        if hasattr(source, "size") and source.size != outputs:
            raise ParameterError(f"{item.path}: a series of {source.size} signals, where {outputs} are expected.")


def vector_of(values: Mapping[str, np.ndarray], numbers: list[np.ndarray]) -> np.ndarray:
    """The vector p of the tunable parameters and the numbers of the bound ones."""
    parts = [*(np.ravel(value, order="F") for value in values.values()), *numbers]
    return np.concatenate(parts) if parts else np.zeros(0)


def bound_values(root: Component | None, structure: Values) -> dict[str, Any]:
    """Of the structure that a result holds, the bound parameters that the model has otherwise: the data of that run.

    A file is held by its name alone; where that is another one than the model's, it has to be where the name says.
    """
    now, found = structural_values(root), {}
    for path, value in structure.items():
        owner, _, name = path.rpartition(".")
        component = _found(root, owner) if root is not None else None
        if component is None:
            continue
        declared = (component.family.parameters if component.family is not None else component.parameters).get(name)
        if declared is not None and declared.bound and (path not in now or now[path] != value):
            found[path] = value
    return found


# --- what is the same as before -----------------------------------------------------------------------------------


def content_of(value: Any) -> Any:
    """Something that is equal for equal values."""
    if isinstance(value, Component):
        own = {name: item for name, item in vars(value).items() if name not in _PLAIN_STATE}
        if own or value.parts:
            return object()  # it has a state of its own, which may change
        return type(value), tuple(sorted((name, content_of(item)) for name, item in value._values.items()))
    if isinstance(value, np.ndarray):
        return "array", value.shape, value.dtype.str, value.tobytes()
    if isinstance(value, (list, tuple)):
        return tuple(content_of(item) for item in value)
    return type(value).__name__, repr(value)


_PLAIN_STATE = frozenset(vars(Component()))


def bound_files(root: Component | None, *, bound: bool = True) -> dict[str, str]:
    """The files that bound parameters name, or all others, with the digests of their content."""
    found = {}
    for path, file in files_of(root).items():
        owner, _, name = path.rpartition(".")
        if root is not None and root.find(owner).parameters[name].bound is bound:
            found[path] = named(file)
    return found
