"""From a component tree to a FlatDAE: the steps in order."""

from __future__ import annotations

import gc
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from typing import Any

import casadi as ca
import numpy as np

from fowtlib.flattening.aliases import eliminate_aliases
from fowtlib.flattening.carried_starts import carry_starts
from fowtlib.flattening.causalization import Causal, Causalization
from fowtlib.flattening.diagnosis import check_structure
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
from fowtlib.flattening.incidence import Incidence
from fowtlib.flattening.index_reduction import IndexReduction
from fowtlib.flattening.instances import Instances, Statements
from fowtlib.flattening.orientations import resolve_orientations
from fowtlib.flattening.stages import stages
from fowtlib.flattening.system import System, element_names, residuals, scalars, with_names
from fowtlib.language.component import Component
from fowtlib.language.declarations import join
from fowtlib.language.equations import place
from fowtlib.language.errors import StructureError


def flatten(root: Component, opened: Sequence[str] = ()) -> FlatDAE:
    """Flatten the model below `root`.

    opened: paths of signal ports whose signal comes from outside of the model in place of the output that drives it;
    that output goes on being computed, and nobody hears it.
    Raises ModelError subclasses that say by path what is wrong: parameters, connections, structure.
    """
    return flatten_with(root, opened)[0]


def flatten_with(root: Component, opened: Sequence[str] = ()) -> tuple[FlatDAE, Instances]:
    """The same, and the tree as it was bound to symbols."""
    started = time.perf_counter()
    with _without_collection(), Instances(root, opened) as instances:
        instances.collect()
        resolve_orientations(instances.system, instances.statements)
        dae = _Flattening(instances.system, instances.statements).run()
    return replace(dae, stats={**dae.stats, "flattening_time": time.perf_counter() - started}), instances


@contextmanager
def _without_collection() -> Iterator[None]:
    """Without the search for cycles of garbage: a model is millions of objects that stay, looked at again and again."""
    was_on = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if was_on:
            gc.enable()


class _Flattening:
    def __init__(self, system: System, statements: Statements):
        self.system = system
        self.statements = statements
        self.constant_orientations: dict[str, ca.SX] = {}

    def run(self) -> FlatDAE:
        system = self.system
        self.original = len(system.equations)
        written = system.equations if self.original <= 5000 else []
        written = [(e.path, e.lhs, e.rhs) for e in written]
        names = system.written_names
        self._fold_constant_orientations()
        self.replaced = self._eliminate_aliases()
        incidence = Incidence(system)
        rows = incidence.rows(residuals(system.equations))
        live = self._live(rows)
        check_structure(system, live, rows)
        reduction = IndexReduction(system, set(live), incidence, rows)
        states = reduction.run()
        bases = set(live)
        everything = [j for j, v in enumerate(system.unknowns) if v.base in bases and j not in self.replaced]
        causal = Causalization(system, states, everything, incidence).run()
        dae = self._build(states, causal, everything)

        def write_equations() -> list[tuple[str, str, str]]:
            return [(path, with_names(left, names), with_names(right, names)) for path, left, right in written]

        counts = {
            "equations": self.original,
            "aliases": len(self.replaced),
            "differentiated": len(system.equations) - sum(e.order == 0 for e in system.equations),
            "blocks": len(causal.blocks),
            "largest_block": max(causal.blocks, default=0),
        }
        return replace(dae, write_equations=write_equations, stats=counts)

    def _eliminate_aliases(self) -> dict[int, ca.SX]:
        """Eliminate until no equation is an alias: a quantity found to be a number may uncover further ones."""
        replaced: dict[int, ca.SX] = {}
        while True:
            substitute, found = eliminate_aliases(self.system)
            if not found:
                return replaced
            self._apply(substitute)
            replaced = dict(zip(replaced, substitute(list(replaced.values())), strict=True)) | found

    def _fold_constant_orientations(self) -> None:
        """Put in the orientations that are numbers (of the world and what is welded to it), from the roots outwards."""
        system = self.system
        while True:
            constant = [item for item in system.intermediates if item.function is None and item.inputs.is_constant()]
            if not constant:
                return
            system.intermediates = [
                item for item in system.intermediates if not any(item is other for other in constant)
            ]
            symbols = ca.vertcat(*[symbol for item in constant for symbol in item.symbols])
            values = ca.vertcat(*[item.inputs for item in constant])
            for item in constant:
                self.constant_orientations.update(zip(item.names(), item.inputs.elements(), strict=True))
            self._apply(lambda expressions, s=symbols, v=values: ca.substitute(expressions, [s], [v]))

    def _apply(self, substitute: Any) -> None:
        """Put the remaining symbols into everything that was written with the eliminated ones."""
        system, statements = self.system, self.statements
        slots: list[tuple[Any, str | int]] = []
        for equation in system.equations:
            slots += [(equation, "lhs"), (equation, "rhs")]
        slots += [(item, "inputs") for item in system.intermediates]
        for _, statement in statements.initial:
            slots += [(statement, "lhs"), (statement, "rhs")]
        for _, assertion in statements.assertions:
            slots.append((assertion, "condition"))
            slots += [(assertion.values, name) for name in assertion.values]
        for _, when in statements.when:
            slots.append((when, "condition"))
            slots += [(action, name) for action in when.actions for name in ("target", "value")]
        for _, statement in statements.on:
            slots += [(action, name) for action in statement.actions for name in ("target", "value")]
        for _, sampled in statements.sampled:
            slots += [(action, name) for action in sampled.assignments for name in ("target", "value")]
        slots += [(statement, "angle") for _, statement in statements.symmetries]
        slots += [(statement, "inputs") for _, statement in statements.operators]
        slots += [(stage, "states") for stage in system.stages]
        slots += [(law, "inputs") for law in system.quadratics]
        slots += [(system.rates, key) for key in system.rates]
        slots += [(system.aliases, path) for path in system.aliases]
        values = [_get(owner, name) for owner, name in slots]
        for (owner, name), value in zip(slots, substitute(values), strict=True):
            if isinstance(owner, dict):
                owner[name] = value
            else:
                setattr(owner, name, value)

    def _live(self, rows: Sequence[np.ndarray]) -> list[int]:
        """Unknowns that remain, without the potentials of open optional ports that no equation mentions.

        An output that no equation mentions stays, for the structure check to find.

        rows: numbers of the unknowns in each equation.
        """
        system = self.system
        present = np.unique(np.concatenate(rows)) if rows else ()
        used = {int(system.unknowns[j].base) for j in present}
        self.unused = [
            j for j, unknown in enumerate(system.unknowns)
            if unknown.order == 0 and j not in self.replaced and j not in used and unknown.declared.name == "?"
            and j not in system.signals
        ]  # fmt: skip
        unused = set(self.unused)
        return [
            j for j, unknown in enumerate(system.unknowns)
            if unknown.order == 0 and j not in self.replaced and j not in unused
        ]  # fmt: skip

    # --- the flat DAE --------------------------------------------------------------------------------------------

    def _build(self, states: list[int], causal: Causal, everything: list[int]) -> FlatDAE:
        system = self.system
        unknowns = system.unknowns
        x = _column([unknowns[j].symbol for j in states])
        z = _column([unknowns[j].symbol for j in causal.torn])
        d = _column([item.symbol for item in system.discretes])
        u = _column([ca.vec(item.symbol) for item in system.inputs.values()])
        p = _column([ca.vec(item.symbol) for group in (system.parameters, system.bound) for item in group.values()])
        calls = [item for item in system.intermediates if item.function is not None]
        w = _column([symbol for item in calls for symbol in item.symbols])

        groups = {
            "ode": [unknowns[unknowns[j].rate].symbol for j in states],
            "alg": [system.equations[i].lhs - system.equations[i].rhs for i in causal.residuals],
            "inputs": [item.inputs for item in calls],
            "initial": [s.lhs - s.rhs for _, s in self.statements.initial],
            "assertions": [a.condition for _, a in self.statements.assertions],
            "values": [value for _, a in self.statements.assertions for value in a.values.values()],
            "indicators": [_indicator(path, when.condition) for path, when in self.statements.when],
            "actions": [action.value for _, when in self.statements.when for action in when.actions],
            "offers": [action.value for _, statement in self.statements.on for action in statement.actions],
            "samples": [action.value for _, sampled in self.statements.sampled for action in sampled.assignments],
            "symmetries": [statement.angle for _, statement in self.statements.symmetries],
            "operators": [statement.inputs for _, statement in self.statements.operators],
            "quadratics": [law.inputs for law in system.quadratics],
            "aliases": list(system.aliases.values()),
            "replaced": [ca.SX(value) for value in self.replaced.values()],
        }
        flat = [expression for members in groups.values() for expression in members]
        symbols = [symbol for symbol, _ in causal.sequence]
        if symbols:
            definitions, flat = ca.substitute_inplace(
                [ca.vertcat(*symbols)], [ca.vertcat(*[value for _, value in causal.sequence])], flat
            )
            assigned = ca.densify(definitions[0]).elements()
        else:
            assigned = []
        solved: dict[str, list[ca.SX]] = {}
        position = 0
        for name, members in groups.items():
            solved[name] = flat[position : position + len(members)]
            position += len(members)

        numbers = (system.number.get(symbol.element_hash()) for symbol in symbols)
        given = [(j, value) for j, value in zip(numbers, assigned, strict=True) if j is not None]
        carry_starts(system, states, causal.torn, given)
        observed, units, docs = self._observed(states, causal, symbols, assigned, solved)
        externals = _externals(calls, solved["inputs"])
        return FlatDAE(
            t=system.time, x=x, z=z, u=u, d=d, p=p, w=w,
            ode=_column(solved["ode"]), alg=_column(solved["alg"]),
            states=[self._quantity(j) for j in states], algebraics=[self._quantity(j) for j in causal.torn],
            discretes=[self._discrete(item) for item in system.discretes],
            inputs=system.inputs, parameters=system.parameters, bound=system.bound,
            bound_parameters=system.bound_parameters, externals=externals,
            dependents=system.dependents, observed=observed, units=units, docs=docs,
            residual_paths=[self._residual_path(i) for i in causal.residuals],
            initial_equations=_column([ca.vec(e) for e in solved["initial"]]),
            initial_paths=[path for (path, _), e in zip(self.statements.initial, solved["initial"], strict=True)
                           for _ in range(e.numel())],
            initial_sources=[f"{path or 'the model'} ({place(statement.source)})"
                             for path, statement in self.statements.initial],
            events=self._events(states, solved), offers=self._offers(states, solved),
            samples=self._samples(solved), checks=self._checks(solved),
            symmetries=[CyclicSymmetry(angle, [part.path for part in statement.parts])
                   for (_, statement), angle in zip(self.statements.symmetries, solved["symmetries"], strict=True)],
            operators=[Operator(path, inputs, statement.correction, statement.transfer, statement.realization)
                       for (path, statement), inputs in zip(self.statements.operators, solved["operators"],
                                                            strict=True)],
            quadratics=[Quadratic(law.path, inputs, law.added, law.smoothing)
                        for law, inputs in zip(system.quadratics, solved["quadratics"], strict=True)],
            stages=stages(system.stages, x, [*solved["ode"], *solved["alg"]], externals),
        )  # fmt: skip

    def _quantity(self, number: int) -> Quantity:
        unknown = self.system.unknowns[number]
        declared = unknown.declared
        nominal = float(declared.nominal) if declared.nominal is not None else 1.0
        unit = declared.unit
        for _ in range(unknown.order):
            unit = "1/s" if unit == "1" else f"{unit}/s"
        start = ca.SX(0) if unknown.start is None else ca.SX(unknown.start)
        return Quantity(
            unknown.path,
            unit,
            declared.doc,
            declared.hint,
            start,
            unknown.start is not None,
            bool(declared.fixed),
            nominal,
        )

    @staticmethod
    def _discrete(item: Any) -> Quantity:
        start = ca.SX(0) if item.start is None else ca.SX(item.start)
        return Quantity(item.path, item.declared.unit, item.declared.doc, item.declared.hint, start, True, True, 1.0)

    def _residual_path(self, number: int) -> str:
        equation = self.system.equations[number]
        return f"{equation.path or 'the model'} ({place(equation.source)})"

    def _observed(
        self, states, causal, symbols, assigned, solved
    ) -> tuple[dict[str, ca.SX], dict[str, str], dict[str, str]]:
        system = self.system
        number = system.number
        observed: dict[str, ca.SX] = {}
        units: dict[str, str] = {}
        docs: dict[str, str] = {}

        def take(path: str, value: ca.SX, declared: Any, order: int = 0) -> None:
            observed[path] = value
            units[path] = (
                declared.unit if not order else ("1" if declared.unit == "1" else declared.unit) + "/s" * order
            )
            docs[path] = declared.doc

        orientations = {
            symbol.element_hash(): name
            for item in system.intermediates if item.function is None
            for symbol, name in zip(item.symbols, item.names(), strict=True)
        }  # fmt: skip
        for j in [*states, *causal.torn]:
            unknown = system.unknowns[j]
            take(unknown.path, unknown.symbol, unknown.declared, unknown.order)
        for symbol, value in zip(symbols, assigned, strict=True):
            j = number.get(symbol.element_hash())
            if j is None:
                name = orientations[symbol.element_hash()]
                observed[name], units[name], docs[name] = value, "1", "orientation, world from frame"
            else:
                unknown = system.unknowns[j]
                take(unknown.path, value, unknown.declared, unknown.order)
        for (j, _), value in zip(self.replaced.items(), solved["replaced"], strict=True):
            unknown = system.unknowns[j]
            take(unknown.path, value, unknown.declared, unknown.order)
        for path, value in zip(system.aliases, solved["aliases"], strict=True):
            for name, element in zip(element_names(path, value.shape), scalars(value), strict=True):
                if name not in observed:
                    observed[name] = element
                    units[name], docs[name] = system.alias_units[path]
        for name, value in self.constant_orientations.items():
            observed[name], units[name], docs[name] = value, "1", "orientation, world from frame"
        for j in self.unused:
            unknown = system.unknowns[j]
            take(unknown.path, ca.SX.nan(1), unknown.declared)
        for item in system.inputs.values():
            for name, element in zip(element_names(item.path, item.symbol.shape), scalars(item.symbol), strict=True):
                observed[name], units[name], docs[name] = element, item.unit, item.doc
        for item in system.discretes:
            take(item.path, item.symbol, item.declared)
        return observed, units, docs

    def _targets(self, path: str, actions: Any, states: list[int]) -> tuple[list[int], list[int], list[int], list[int]]:
        """Numbers of the states and of the discretes that actions set, and which scalar action sets each."""
        system = self.system
        state_of = {system.unknowns[j].symbol.element_hash(): k for k, j in enumerate(states)}
        discrete_of = {item.symbol.element_hash(): k for k, item in enumerate(system.discretes)}
        on_states, from_states, on_discretes, from_discretes = [], [], [], []
        k = 0
        for action in actions:
            for target in scalars(action.target):
                key = target.element_hash()
                if key in state_of and action.is_reinit:
                    on_states.append(state_of[key])
                    from_states.append(k)
                elif key in discrete_of and not action.is_reinit:
                    on_discretes.append(discrete_of[key])
                    from_discretes.append(k)
                else:
                    name = system.text(target)
                    if action.is_reinit:
                        why = f"reinit() cannot set {name}, which is not a state; declare it with state='always'."
                    elif key in state_of:
                        why = f"assign() cannot set {name}, which is a state; write reinit()."
                    else:
                        why = f"assign() cannot set {name}; declare it with var(discrete=True)."
                    raise StructureError(f"{path or 'the model'}: {why}")
                k += 1
        return on_states, from_states, on_discretes, from_discretes

    def _events(self, states: list[int], solved: dict[str, list[ca.SX]]) -> list[Event]:
        events, values = [], iter(solved["actions"])
        for (path, when), indicator in zip(self.statements.when, solved["indicators"], strict=True):
            column = _column([ca.vec(next(values)) for _ in when.actions])
            on_states, from_states, on_discretes, from_discretes = self._targets(path, when.actions, states)
            events.append(Event(indicator, on_states, column[from_states], on_discretes, column[from_discretes], path))
        return events

    def _offers(self, states: list[int], solved: dict[str, list[ca.SX]]) -> list[Offer]:
        values = iter(solved["offers"])
        found: dict[str, tuple[str, Any, list[Any], list[ca.SX]]] = {}
        for path, statement in self.statements.on:
            name = join(path, statement.event.declared.name)
            _, _, actions, columns = found.setdefault(name, (path, statement.event, [], []))
            actions += statement.actions
            columns += [ca.vec(next(values)) for _ in statement.actions]
        offers = []
        for name, (path, happening, actions, columns) in found.items():
            column, given = _column(columns), _column(list(happening.symbols.values()))
            on_states, from_states, on_discretes, from_discretes = self._targets(path, actions, states)
            offers.append(Offer(name, path, happening.declared, given, on_states, column[from_states], on_discretes,
                                column[from_discretes]))  # fmt: skip
        return offers

    def _samples(self, solved: dict[str, list[ca.SX]]) -> list[SampledUpdate]:
        samples, values = [], iter(solved["samples"])
        for path, sampled in self.statements.sampled:
            targets, column = ca.SX(0, 1), ca.SX(0, 1)
            for action in sampled.assignments:  # each sees the values assigned before it
                value = (
                    ca.substitute(ca.vec(next(values)), targets, column) if targets.numel() else ca.vec(next(values))
                )
                targets, column = ca.vertcat(targets, ca.vec(action.target)), ca.vertcat(column, value)
            _, _, numbers, _ = self._targets(path, sampled.assignments, [])
            clock = ca.SX(sampled.period), ca.SX(sampled.offset)
            samples.append(SampledUpdate(*clock, numbers, ca.densify(column), path, sampled.process))
        return _in_order(samples, self.system)

    def _checks(self, solved: dict[str, list[ca.SX]]) -> list[Check]:
        values = iter(solved["values"])
        return [
            Check(
                condition, assertion.message, assertion.level, {name: next(values) for name in assertion.values}, path
            )
            for (path, assertion), condition in zip(self.statements.assertions, solved["assertions"], strict=True)
        ]


def _get(owner: Any, name: Any) -> ca.SX:
    return owner[name] if isinstance(owner, dict) else getattr(owner, name)


def _column(items: list[ca.SX]) -> ca.SX:
    return ca.densify(ca.vertcat(*items)) if items else ca.SX(0, 1)


def _externals(calls: list[Any], inputs: list[ca.SX]) -> list[External]:
    externals, position = [], 0
    for item, y in zip(calls, inputs, strict=True):
        externals.append(External(item.called, y, slice(position, position + len(item.symbols)), item.path))
        position += len(item.symbols)
    return externals


def _indicator(path: str, condition: ca.SX) -> ca.SX:
    """Expression that becomes negative when the condition a < b becomes true."""
    if not condition.is_scalar() or condition.is_constant() or condition.op() not in (ca.OP_LT, ca.OP_LE):
        raise StructureError(
            f"{path}: a when() takes one comparison, a < b or a > b; join several by fmax (and) or fmin (or)."
        )
    return condition.dep(0) - condition.dep(1)


def _in_order(samples: list[SampledUpdate], system: System) -> list[SampledUpdate]:
    """Sampled parts at one instant: one that reads what another assigns comes after it."""
    d = _column([item.symbol for item in system.discretes])
    reads = []
    for sample in samples:
        pattern = ca.Function("reads", [d], [sample.values], {"allow_free": True}).jac_sparsity(0, 0)
        reads.append({int(c) for c in pattern.get_triplet()[1]} - set(sample.targets))
    order: list[int] = []
    left = list(range(len(samples)))
    while left:
        ready = [k for k in left if not any(reads[k] & set(samples[j].targets) for j in left if j != k)]
        if not ready:
            names = ", ".join(samples[k].path for k in left)
            raise StructureError(
                f"the sampled parts {names} need each other's values of the same instant; delay one by a sample."
            )
        order += ready
        left = [k for k in left if k not in ready]
    return [samples[k] for k in order]
