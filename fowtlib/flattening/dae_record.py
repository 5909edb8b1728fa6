"""A flat model as texts and numbers, and back. What is no expression comes from the components again: see hooks."""

from __future__ import annotations

import base64
from collections.abc import Iterator, Mapping, Sequence
from itertools import chain
from typing import Any

import casadi as ca
import numpy as np

from fowtlib.flattening.flat_dae import (
    Check,
    CyclicSymmetry,
    Event,
    External,
    FlatDAE,
    Offer,
    Operator,
    Quadratic,
    Quantity,
    SampledUpdate,
)
from fowtlib.flattening.hooks import Hooks
from fowtlib.flattening.scalar_graph import ScalarGraph
from fowtlib.flattening.system import Bound, BoundParameter, Input, Parameter
from fowtlib.language.component import Component
from fowtlib.language.expressions import one_evaluation
from fowtlib.language.stages import Stage

Record = dict[str, Any]
_GROUPS = ("t", "x", "z", "u", "d", "p", "w")
_ARRAYS = {"numbers": "<f8", "groups": "<i4", "first": "<i4", "second": "<i4", "results": "<i4"}


def record_of(dae: FlatDAE, hooks: Hooks) -> Record:
    """All of a flat model that JSON can hold. Raises NotArithmetic, ValueError."""
    put = _Columns()
    symbols = [*(getattr(dae, name) for name in _GROUPS), *(offer.given for offer in dae.offers)]
    names = list(dae.observed)
    if not names == list(dae.units) == list(dae.docs):
        raise ValueError("results without a unit")
    texts = {text: k for k, text in enumerate(dict.fromkeys(chain(dae.units.values(), dae.docs.values())))}
    record = {
        "symbols": [[symbol.name() for symbol in group.elements()] for group in symbols],
        "columns": [put(column) for column in (dae.ode, dae.alg, dae.initial_equations)],
        **{kind: [[q.path, q.unit, q.doc, q.hint, put(q.start), q.start_given, q.fixed, q.nominal] for q in group]
           for kind, group in _quantities(dae).items()},
        "inputs": [[i.path, put(i.symbol), i.unit, i.doc, _numbers(i.default), i.driver] for i in dae.inputs.values()],
        "parameters": [_parameter(item, put) for item in dae.parameters.values()],
        "dependents": [_parameter(item, put) for item in dae.dependents.values()],
        "bound": [[b.path, b.owner, put(b.symbol), b.unit, b.doc] for b in dae.bound.values()],
        "bound_parameters": [[b.path, b.owner, b.name, b.unit, b.doc] for b in dae.bound_parameters.values()],
        "externals": [[e.path, e.function.name(), slope_of, put(e.inputs), e.outputs.start, e.outputs.stop]
                      for e, (_, slope_of) in zip(dae.externals, hooks.functions, strict=True)],
        "events": [[put(e.indicator), *_actions(e, put), e.path] for e in dae.events],
        "offers": [[o.path, o.owner, o.declared.name, *_actions(o, put)] for o in dae.offers],
        "samples": [[put(s.period), put(s.offset), s.targets, put(s.values), s.path, _place(s.process, hooks)]
                    for s in dae.samples],
        "checks": [[put(c.condition), c.message, c.level, {name: put(v) for name, v in c.values.items()}, c.path]
                   for c in dae.checks],
        "symmetries": [[put(ring.angle), ring.parts] for ring in dae.symmetries],
        "operators": [[o.path, put(o.inputs), put(o.correction)] for o in dae.operators],
        "quadratics": [[q.path, put(q.inputs), put(q.added), q.smoothing] for q in dae.quadratics],
        "stages": [[s.path, put(s.states), put(s.step)] for s in dae.stages],
        "paths": [dae.residual_paths, dae.initial_paths, dae.initial_sources],
        "stats": {name: count for name, count in dae.stats.items() if name != "flattening_time"},
        "observed": [[name, put(value), texts[dae.units[name]], texts[dae.docs[name]]]
                     for name, value in dae.observed.items()],
        "texts": list(texts),
    }  # fmt: skip
    graph = ScalarGraph.of(ca.vertcat(*symbols), put.column)
    record["graph"] = {name: base64.b64encode(getattr(graph, name).astype(kind).tobytes()).decode()
                       for name, kind in _ARRAYS.items()}  # fmt: skip
    return record


def dae_of(record: Record, root: Component, hooks: Hooks, values: Mapping[str, Any]) -> FlatDAE:
    """The flat model of a record, with parameters of `values_now`.

    Raises ValueError, KeyError, IndexError, TypeError where it is none, or not this.
    """
    groups = [[ca.SX.sym(name) for name in names] for names in record["symbols"]]
    arrays = {name: np.frombuffer(base64.b64decode(record["graph"][name]), kind) for name, kind in _ARRAYS.items()}
    columns = [_column(group) for group in groups]
    arrays["groups"] = arrays["groups"].reshape(-1, 2)
    get = _Made(ScalarGraph(sum(map(len, groups)), **arrays).expressions(ca.vertcat(*columns)))
    given = iter(columns[len(_GROUPS) :])
    functions = _functions(record, hooks)
    ode, alg, initial = map(get, record["columns"])
    texts, observed = record["texts"], record["observed"]
    return FlatDAE(
        **dict(zip(_GROUPS, columns, strict=False)), ode=ode, alg=alg, initial_equations=initial,
        **{kind: tuple(Quantity(path, unit, doc, hint, get(start), *rest)
                       for path, unit, doc, hint, start, *rest in record[kind])
           for kind in ("states", "algebraics", "discretes")},
        inputs={path: Input(path, get(symbol), unit, doc, _array(default), driver)
                for path, symbol, unit, doc, default, driver in record["inputs"]},
        parameters=_parameters(record["parameters"], get, values),
        dependents=_parameters(record["dependents"], get, values),
        bound={path: Bound(path, owner, get(symbol), unit, doc, hooks.bound[path].compute, hooks.bound[path].functions)
               for path, owner, symbol, unit, doc in record["bound"]},
        bound_parameters={item[0]: BoundParameter(*item) for item in record["bound_parameters"]},
        externals=tuple(External(function, get(inputs), slice(start, stop), path)
                   for function, (path, _, _, inputs, start, stop) in zip(functions, record["externals"], strict=True)),
        events=tuple(Event(get(indicator), *_acting(actions, get), path)
                     for indicator, *actions, path in record["events"]),
        offers=tuple(Offer(path, owner, root.find(owner).offered_events[name], next(given), *_acting(actions, get))
                     for path, owner, name, *actions in record["offers"]),
        samples=tuple(SampledUpdate(get(period), get(offset), targets, get(values), path,
                                    None if process < 0 else hooks.processes[process])
                      for period, offset, targets, values, path, process in record["samples"]),
        checks=tuple(Check(get(condition), message, level, {name: get(value) for name, value in values.items()}, path)
                     for condition, message, level, values, path in record["checks"]),
        symmetries=tuple(CyclicSymmetry(get(angle), parts) for angle, parts in record["symmetries"]),
        operators=tuple(Operator(path, get(inputs), get(correction), stated.transfer, stated.realization)
                        for (path, inputs, correction), stated in zip(record["operators"], hooks.operators,
                                                                      strict=True)),
        quadratics=tuple(Quadratic(path, get(inputs), get(added), smoothing)
                         for path, inputs, added, smoothing in record["quadratics"]),
        stages=tuple(Stage(path, get(states), get(step)) for path, states, step in record["stages"]),
        observed=_Observed(get, {name: place for name, place, _, _ in observed}),
        units={name: texts[unit] for name, _, unit, _ in observed},
        docs={name: texts[doc] for name, _, _, doc in observed},
        **dict(zip(("residual_paths", "initial_paths", "initial_sources"), map(tuple, record["paths"]), strict=True)),
        stats=record["stats"],
    )  # fmt: skip


class _Columns:
    """Puts expressions one behind the other; each gets its place: where it begins, rows, columns, perhaps a pattern."""

    def __init__(self) -> None:
        self._items: list[ca.SX] = []
        self.count = 0

    def __call__(self, value: ca.SX) -> list[Any]:
        place: list[Any] = [self.count, *value.shape]
        if not value.is_dense():
            place += [list(value.sparsity().colind()), list(value.sparsity().row())]
        self._items.append(value)
        self.count += value.nnz()
        return place

    @property
    def column(self) -> ca.SX:
        """All of them."""
        entries = [ca.SX(ca.Sparsity.dense(item.nnz(), 1), item.nz[:]) for item in self._items if item.nnz()]
        return ca.vertcat(*entries) if entries else ca.SX(0, 1)


class _Made:
    """Gives expressions by their places."""

    def __init__(self, entries: ca.SX):
        self._entries = entries

    def __call__(self, place: Sequence[Any]) -> ca.SX:
        start, rows, columns, *pattern = place
        if pattern:
            sparsity = ca.Sparsity(rows, columns, *pattern)
            return ca.SX(sparsity, self._entries[start : start + sparsity.nnz()]) if sparsity.nnz() else ca.SX(sparsity)
        if rows == columns == 1:
            return self._entries[start]
        column = self._entries[start : start + rows * columns] if rows * columns else ca.SX(rows, columns)
        return column if columns == 1 else ca.reshape(column, rows, columns)


class _Observed(Mapping[str, ca.SX]):
    """Expressions of all variables, each made when it is first asked for."""

    def __init__(self, get: _Made, places: Mapping[str, Any]):
        self._get, self._places, self._made = get, places, dict[str, ca.SX]()

    def __getitem__(self, name: str) -> ca.SX:
        if name not in self._made:
            self._made[name] = self._get(self._places[name])
        return self._made[name]

    def __contains__(self, name: object) -> bool:
        return name in self._places

    def __iter__(self) -> Iterator[str]:
        return iter(self._places)

    def __len__(self) -> int:
        return len(self._places)


def _functions(record: Record, hooks: Hooks) -> list[ca.Function]:
    """The external functions; ValueError where they are not those of the record."""
    externals = record["externals"]
    functions = [function for function, _ in hooks.with_jacobians([of for _, _, of, *_ in externals]).functions]
    if [f.name() for f in functions] != [name for _, name, *_ in externals]:
        raise ValueError("other external functions")
    if list(hooks.bound) != [path for path, *_ in record["bound"]] or len(hooks.operators) != len(record["operators"]):
        raise ValueError("other numbers at the start, or other operators")
    return functions


def _column(items: Sequence[ca.SX]) -> ca.SX:
    return ca.vertcat(*items) if items else ca.SX(0, 1)


def _quantities(dae: FlatDAE) -> dict[str, tuple[Quantity, ...]]:
    return {"states": dae.states, "algebraics": dae.algebraics, "discretes": dae.discretes}


def _parameter(item: Parameter, put: _Columns) -> list[Any]:
    return [item.path, put(item.symbol), _numbers(item.value), item.unit, item.doc, item.min, item.max, item.form]


def _parameters(items: Sequence[Any], get: _Made, values: Mapping[str, Any]) -> dict[str, Parameter]:
    return {path: Parameter(path, get(symbol), _array(values[path]), *rest) for path, symbol, _, *rest in items}


def values_now(record: Record, root: Component) -> dict[str, Any]:
    """The parameters of a record, by path, with the values that they have in the tree.

    They follow from bound ones too: the speed at which a rotor starts from the file of the wind.
    """
    with one_evaluation():
        return {path: _value(root, path, shape) for kind in ("parameters", "dependents")
                for path, _, (shape, _), *_ in record[kind]}  # fmt: skip


def _value(root: Component, path: str, shape: Sequence[int]) -> list[Any]:
    owner, _, name = path.rpartition(".")
    value = np.asarray(root.find(owner).parameter_value(name), dtype=float)
    return _numbers(np.broadcast_to(value, tuple(shape)))


def _numbers(value: np.ndarray) -> list[Any]:
    return [list(np.shape(value)), np.asarray(value, dtype=float).ravel().tolist()]


def _array(record: Sequence[Any]) -> np.ndarray:
    return np.array(record[1], dtype=float).reshape(record[0])


def _actions(item: Event | Offer, put: _Columns) -> list[Any]:
    return [item.state_targets, put(item.state_values), item.discrete_targets, put(item.discrete_values)]


def _acting(actions: Sequence[Any], get: _Made) -> tuple[tuple[int, ...], ca.SX, tuple[int, ...], ca.SX]:
    states, state_values, discretes, discrete_values = actions
    return tuple(states), get(state_values), tuple(discretes), get(discrete_values)


def _place(process: Any, hooks: Hooks) -> int:
    return -1 if process is None else next(k for k, one in enumerate(hooks.processes) if one is process)
