"""The dimension check: both sides of each equation, and the terms of each sum, must have the same dimension.

It walks the expression graph of every equation as its component wrote it, from the declared units. A number has no
dimension in a product and any dimension in a sum; zero, the outputs of external functions and numbers that come from
structural data have any dimension everywhere, and so have the entries of a 6 x 6 matrix with the unit "1", which goes
over forces and moments. A block whose signals all have the unit "1" is general: what it declares
with the unit "1" may stand for any quantity.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field
from fractions import Fraction
from typing import Any

import casadi as ca
import numpy as np

from fowtlib.flattening.instances import Instances
from fowtlib.flattening.orientations import resolve_orientations
from fowtlib.language import expressions
from fowtlib.language.component import Component
from fowtlib.language.connectors import Signal
from fowtlib.language.equations import place
from fowtlib.language.errors import StructureError
from fowtlib.language.unit_grammar import NONE, Dimension, Unit
from fowtlib.language.units import dimension, kind_of, unit_text

_SECOND = dimension("s")
_SAME_OUT = {
    ca.OP_ADD: "added", ca.OP_SUB: "subtracted", ca.OP_FMIN: "compared by fmin", ca.OP_FMAX: "compared by fmax",
    ca.OP_HYPOT: "added as squares", ca.OP_FMOD: "divided with remainder", ca.OP_REMAINDER: "divided with remainder",
}  # fmt: skip
_SAME_IN = {ca.OP_LT: "compared", ca.OP_LE: "compared", ca.OP_EQ: "compared", ca.OP_NE: "compared",
            ca.OP_ATAN2: "given to atan2"}  # fmt: skip
_KEPT = (ca.OP_ASSIGN, ca.OP_NEG, ca.OP_FABS, ca.OP_TWICE, ca.OP_FLOOR, ca.OP_CEIL, ca.OP_LIFT, ca.OP_COPYSIGN)
_PLAIN = (ca.OP_SIGN, ca.OP_AND, ca.OP_OR, ca.OP_NOT)
_NUMBERS_ONLY = {
    ca.OP_SIN: "sin", ca.OP_COS: "cos", ca.OP_TAN: "tan", ca.OP_ASIN: "asin", ca.OP_ACOS: "acos", ca.OP_ATAN: "atan",
    ca.OP_SINH: "sinh", ca.OP_COSH: "cosh", ca.OP_TANH: "tanh", ca.OP_ASINH: "asinh", ca.OP_ACOSH: "acosh",
    ca.OP_ATANH: "atanh", ca.OP_EXP: "exp", ca.OP_LOG: "log", ca.OP_LOG1P: "log1p", ca.OP_EXPM1: "expm1",
    ca.OP_ERF: "erf",
}  # fmt: skip
_POWERS = {ca.OP_SQ: Fraction(2), ca.OP_SQRT: Fraction(1, 2), ca.OP_INV: Fraction(-1)}
_DIVISORS = (1, 2, 3, 4, 6, 8, 12)
_COUNTED = {k * factor / divisor for k in (1, 2, 3, 4) for factor in (1.0, np.pi) for divisor in _DIVISORS}
Numbers = set[float] | None  # None: equations made of data, where every number may have any dimension


@dataclass(frozen=True)
class Finding:
    """An equation that does not agree: the component, the line that wrote it, and what differs, in words."""

    path: str
    source: str
    text: str

    def __str__(self) -> str:
        source = f" ({place(self.source)})" if self.source else ""
        return f"{self.path or 'the model'}{source}: {self.text}"


@dataclass
class DimensionReport:
    """What the dimension check found; `equations` is the number of scalar equations looked at."""

    equations: int = 0
    findings: list[Finding] = field(default_factory=list)

    @property
    def ok(self) -> bool:
        """True where every equation agrees."""
        return not self.findings

    def __str__(self) -> str:
        if self.ok:
            return f"dimensions: {self.equations} scalar equations agree."
        n = len(self.findings)
        head = f"dimensions: {n} equation{' does' if n == 1 else 's do'} not agree:"
        return "\n".join([head, *(f"  {finding}" for finding in self.findings)])


def check_dimensions(root: Component) -> DimensionReport:
    """Check every equation of the model below `root`, as the components wrote it (before aliases are eliminated)."""
    with Instances(root) as instances:
        instances.collect()
        resolve_orientations(instances.system, instances.statements)
        return _Check(instances).run()


@dataclass(frozen=True)
class _Value:
    """Dimension of a value (None: any), whether it is a bare number, and which disagreements lie inside of it."""

    dimension: Dimension | None = None
    number: float | None = None
    faults: tuple[int, ...] = ()


_ANY = _Value()
_NUMBER = _Value(NONE)


@dataclass
class _Pair:
    """Two expressions that must have the same dimension; a known dimension of the right one comes in its place."""

    source: str
    left: ca.SX
    right: ca.SX | None
    words: tuple[str, str] = ("the left side", "the right side")
    wanted: Dimension | None = None


class _Check:
    def __init__(self, instances: Instances):
        self.instances = instances
        self.system = instances.system
        self.declared = self._declared()
        self.report = DimensionReport()

    def run(self) -> DimensionReport:
        pairs: dict[str, list[_Pair]] = defaultdict(list)
        for equation in self.system.equations:
            pairs[equation.path].append(_Pair(equation.source, equation.lhs, equation.rhs))
        self.report.equations = len(self.system.equations)
        for path, pair in self._other_statements():
            pairs[path].append(pair)
        for component in self.instances.components:
            mine = [*self._modifiers(component), *pairs.get(component.path, [])]
            if mine:
                self._component(component, mine)
        return self.report

    # --- what is declared ----------------------------------------------------------------------------------------

    def _declared(self) -> dict[int, Dimension | None]:
        """Dimension of every symbol of the model."""
        system, table = self.system, {}
        several = {(component.path, name) for component in self.instances.components for name in component.units_within}

        def mixed(path: str) -> bool:
            """Whether its elements have units of their own."""
            return tuple(path.partition("[")[0].rpartition(".")[::2]) in several

        for item in system.unknowns:
            known = None if mixed((item if item.base < 0 else system.unknowns[item.base]).path) else item.declared.unit
            table[item.symbol.element_hash()] = None if known is None else _per_time(dimension(known), item.order)
        for item in system.discretes:
            table[item.symbol.element_hash()] = dimension(item.declared.unit)
        for _, item in self.instances.statements.on:
            for name, symbol in item.event.symbols.items():
                table[symbol.element_hash()] = dimension(item.event.declared.values[name].unit)
        for group in (system.parameters, system.bound, system.inputs):
            for path, item in group.items():
                several_units = not item.unit or (item.unit == "1" and item.symbol.shape == (6, 6)) or mixed(path)
                _enter(table, item.symbol, None if several_units else dimension(item.unit))
        for item in system.intermediates:
            for symbol in item.symbols:
                table[symbol.element_hash()] = NONE if item.function is None else None
        table[system.time.element_hash()] = _SECOND
        return table

    def _own(self, component: Component) -> dict[int, Dimension | None]:
        """What this component sees otherwise: its signals in its own units, and what a general block leaves open."""
        binding, table = component._binding or {}, {}
        signals = [f for f in component.ports.values() if issubclass(f.annotation, Signal)]
        general = bool(signals) and len(signals) == len(component.ports) and all(f.unit == "1" for f in signals)
        for declared in signals:
            bound = binding[declared.name]
            for symbol in bound if isinstance(bound, list) else [bound]:
                _enter(table, symbol, None if general else dimension(declared.unit))
        if general:
            for declared in (*component.variables.values(), *component.parameters.values()):
                bound = binding[declared.name]
                if declared.unit == "1" and isinstance(bound, ca.SX):
                    _enter(table, bound, None)
                    self._rates(table, bound)
        return table

    def _rates(self, table: dict[int, Dimension | None], symbol: ca.SX) -> None:
        unknowns = self.system.unknowns
        for element in symbol.elements():
            number = self.system.number.get(element.element_hash(), -1)
            while number >= 0:
                table[unknowns[number].symbol.element_hash()] = None
                number = unknowns[number].rate

    # --- what is compared ----------------------------------------------------------------------------------------

    def _other_statements(self) -> Iterator[tuple[str, _Pair]]:
        written = self.instances.statements
        for path, item in written.initial:
            yield from ((path, pair) for pair in _pairs(item.source, item.lhs, item.rhs))
        for path, item in written.when:
            yield path, _Pair(item.source, item.condition, None)
            for action in item.actions:
                yield from ((path, pair) for pair in _pairs(item.source, action.target, action.value, _ASSIGNED))
        for path, item in written.on:
            for action in item.actions:
                yield from ((path, pair) for pair in _pairs(item.source, action.target, action.value, _ASSIGNED))
        for path, item in written.sampled:
            for action in item.assignments if item.process is None else ():
                yield from ((path, pair) for pair in _pairs(item.source, action.target, action.value, _ASSIGNED))
        for path, item in written.assertions:
            yield path, _Pair(item.source, item.condition, None)

    def _modifiers(self, component: Component) -> Iterator[_Pair]:
        """Parameters that depend on others: the expression and the declared unit."""
        binding = component._binding or {}
        for name, declared in component.parameters.items():
            bound = binding[name]
            if not (declared.tunable and isinstance(bound, ca.SX)):
                continue
            try:
                modifier = component.parameter_binding(name)
            except StructureError:  # numbers that are computed when a run starts, from what is bound then
                continue
            if expressions.is_expression(modifier):
                words = (f"the value of '{name}'", "its declaration")
                for element in bound.elements():
                    yield _Pair("", element, None, words, dimension(declared.unit))

    # --- one component -------------------------------------------------------------------------------------------

    def _text(self, expression: ca.SX) -> str:
        return _short(self.system.text(expression))

    def _component(self, component: Component, pairs: list[_Pair]) -> None:
        sides = [ca.SX(0) if side is None else side for pair in pairs for side in (pair.left, pair.right)]
        column = ca.densify(ca.vertcat(*[side[0] for side in sides]))
        symbols = ca.symvar(column)
        own = self._own(component)
        known = {**self.declared, **own} if own else self.declared
        inputs = [known.get(symbol.element_hash()) for symbol in symbols]
        function = ca.Function("walk", [ca.vertcat(*symbols)], [column])
        walk = _Walk(function, symbols, inputs, _data_numbers(component), self._text)
        seen: set[tuple[str, str]] = set()
        for k, pair in enumerate(pairs):
            left, right = walk.outputs[2 * k], walk.outputs[2 * k + 1]
            if pair.wanted is not None:
                right = _Value(pair.wanted)
            text = next((walk.faults[number] for number in (*left.faults, *right.faults)), None)
            if text is None and walk.differ(left, right):
                text = f"{pair.words[0]} is {_words(left)}, {pair.words[1]} {_words(right)}"
                text += f": {self._text(pair.left)} = {self._text(pair.right)}." if pair.right is not None else "."
            if text and (pair.source, text.partition(":")[0]) not in seen:  # once for all elements of a vector
                seen.add((pair.source, text.partition(":")[0]))
                self.report.findings.append(Finding(component.path, pair.source, text))


class _Walk:
    """The dimensions of the outputs of a function, instruction by instruction."""

    def __init__(
        self,
        function: ca.Function,
        symbols: list[ca.SX],
        inputs: list[Dimension | None],
        data: Numbers,
        text: Callable[[ca.SX], str],
    ):
        self.function, self.symbols, self.data, self.text = function, symbols, data, text
        self.faults: list[str] = []
        self.outputs: list[_Value] = [_ANY] * function.numel_out(0)
        registers: dict[int, _Value] = {}
        for k, kind, taken, given in _instructions(function):
            if kind == ca.OP_INPUT:
                registers[given[0]] = _Value(inputs[taken[1]])
            elif kind == ca.OP_CONST:
                registers[given[0]] = self._constant(function.instruction_constant(k))
            elif kind == ca.OP_OUTPUT:
                self.outputs[given[1]] = registers[taken[0]]
            else:
                registers[given[0]] = self._operation(k, kind, [registers[i] for i in taken])

    def differ(self, a: _Value, b: _Value) -> bool:
        """True where two dimensions are known and not the same; a number 1 from data leaves no trace in a product."""
        if a.number is not None or b.number is not None or None in (a.dimension, b.dimension):
            return False
        return a.dimension != b.dimension and not (self.data is None and NONE in (a.dimension, b.dimension))

    def _constant(self, value: float) -> _Value:
        if value == 0.0 or not np.isfinite(value) or not self._is_plain(abs(value)):
            return _Value(None, value)
        return _Value(NONE, value)

    def _is_plain(self, value: float) -> bool:
        """False for a number that comes, or may come, from structural data and so may have any dimension."""
        if not self.data:
            return self.data is not None or value == 1.0
        return value in _COUNTED and value not in self.data

    def _operation(self, k: int, kind: int, values: list[_Value]) -> _Value:
        a, b = values[0], values[-1]
        faults = tuple(dict.fromkeys(number for value in values for number in value.faults))
        if kind in _SAME_OUT or kind in _SAME_IN:
            verb = _SAME_OUT.get(kind) or _SAME_IN[kind]
            if self.differ(a, b):
                return self._fault(k, f"{_words(a)} and {_words(b)} are {verb}", faults)
            common = b.dimension if a.number is not None or a.dimension is None else a.dimension
            return _Value(common if kind in _SAME_OUT else NONE, None, faults)
        if kind in (ca.OP_MUL, ca.OP_DIV):
            return _Value(_product(a, b, 1 if kind == ca.OP_MUL else -1), None, faults)
        if kind in _POWERS:
            return _Value(_power(a.dimension, _POWERS[kind]), None, faults)
        if kind in (ca.OP_POW, ca.OP_CONSTPOW):
            if b.number is not None:
                return _Value(_power(a.dimension, Fraction(b.number).limit_denominator(60)), None, faults)
            if a.number is None and a.dimension not in (None, NONE):
                return self._fault(k, f"{_words(a)} has an exponent that is not a number", faults)
            if b.dimension not in (None, NONE):
                return self._fault(k, f"an exponent is {_words(b)}", faults)
            return _Value(NONE, None, faults)
        if kind in _NUMBERS_ONLY:
            if a.dimension not in (None, NONE):
                return self._fault(k, f"the argument of {_NUMBERS_ONLY[kind]}() is {_words(a)}", faults)
            return _Value(NONE, None, faults)
        if kind == ca.OP_IF_ELSE_ZERO:
            return _Value(b.dimension, b.number, faults)
        if kind == ca.OP_TWICE and self.data is None and a.dimension == NONE:
            return _Value(None, None, faults)
        if kind in _KEPT:
            return _Value(a.dimension, a.number, faults)
        return _Value(NONE if kind in _PLAIN else None, None, faults)

    def _fault(self, k: int, text: str, inner: tuple[int, ...]) -> _Value:
        self.faults.append(f"{text}: {self.text(self._expression(k))}.")
        return _Value(None, None, (*inner, len(self.faults) - 1))

    def _expression(self, last: int) -> ca.SX:
        """The expression that instruction `last` computes."""
        registers: dict[int, ca.SX] = {}
        for k, kind, taken, given in _instructions(self.function):
            if kind == ca.OP_INPUT:
                registers[given[0]] = self.symbols[taken[1]]
            elif kind == ca.OP_CONST:
                registers[given[0]] = ca.SX(self.function.instruction_constant(k))
            elif kind != ca.OP_OUTPUT:
                build = ca.SX.binary if len(taken) == 2 else ca.SX.unary
                registers[given[0]] = build(kind, *[registers[i] for i in taken])
            if k == last:
                break
        return registers[given[0]]


def _instructions(function: ca.Function) -> Iterator[tuple[int, int, list[int], list[int]]]:
    for k in range(function.n_instructions()):
        yield k, function.instruction_id(k), function.instruction_input(k), function.instruction_output(k)


_ASSIGNED = ("the variable", "its new value")


def _pairs(source: str, left: ca.SX, right: ca.SX, words: tuple[str, str] | None = None) -> Iterator[_Pair]:
    rest = {} if words is None else {"words": words}
    for a, b in zip(ca.densify(left).elements(), ca.densify(right).elements(), strict=True):
        yield _Pair(source, a, b, **rest)


def _enter(table: dict[int, Dimension | None], symbol: Any, value: Dimension | None) -> None:
    for element in ca.SX(symbol).elements():
        if element.is_symbolic():
            table[element.element_hash()] = value


def _data_numbers(component: Component) -> Numbers:
    """Numbers that the equations may have from structural parameters of the component and of the parts it refers to."""
    found = set(_written_numbers(component))
    for owner in (component, *_outer_parts(component)):
        for name, declared in owner.parameters.items():
            if declared.tunable or declared.bound or declared.annotation in (int, bool):
                continue
            if declared.annotation is not float:
                return None
            value = owner.parameter_value(name)
            if declared.unit != "1" and value is not None:
                found.add(abs(value))
    return found


def _written_numbers(component: Component) -> Iterator[float]:
    """Numbers among the elements of parameters that depend on others, such as (0, half_span, 3)."""
    for name, declared in component.parameters.items():
        bound = (component._binding or {}).get(name)
        if declared.tunable and declared.unit != "1" and isinstance(bound, ca.SX):
            yield from (abs(float(element)) for element in bound.elements() if element.is_constant())


def _outer_parts(component: Component) -> Iterable[Component]:
    found = ((component._binding or {}).get(name) for name in component.outers)
    return [part for some in found if some is not None for part in (some if isinstance(some, list) else [some])]


def _per_time(value: Dimension, times: int) -> Dimension:
    return tuple(e - times * s for e, s in zip(value, _SECOND, strict=True))


def _product(a: _Value, b: _Value, sign: int) -> Dimension | None:
    if a.dimension is None or b.dimension is None:
        return None
    return tuple(x + sign * y for x, y in zip(a.dimension, b.dimension, strict=True))


def _power(value: Dimension | None, exponent: Fraction) -> Dimension | None:
    return None if value is None else tuple(e * exponent for e in value)


def _words(value: _Value) -> str:
    if value.dimension is None:
        return "a quantity of any dimension"
    unit = Unit(1.0, value.dimension)
    kind, text = kind_of(unit), unit_text(unit)
    return kind if text == "1" or kind.endswith(text) else f"{kind} [{text}]"


def _short(text: str) -> str:
    return text if len(text) <= 80 else text[:77] + "..."
