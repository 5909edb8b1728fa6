"""The flat system while it is being built: unknowns, equations, intermediates, and the rule of differentiation."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import casadi as ca
import numpy as np

from fowtlib.language.declarations import Variable, join
from fowtlib.language.equations import Assertion, AtStart
from fowtlib.language.errors import StructureError
from fowtlib.language.matrix_forms import Form
from fowtlib.language.quadratic_laws import QuadraticLaw
from fowtlib.language.stages import Stage
from fowtlib.language.to_come import ToCome

_TOKEN = re.compile(r"[A-Za-z_][\w.\[\]]*")


def scalars(value: ca.SX) -> list[ca.SX]:
    """Elements of an expression, column by column, structural zeros included."""
    return value.elements() if value.is_dense() else ca.densify(value).elements()


def stacked(items: Iterable[ca.SX]) -> ca.SX:
    """One dense column of scalar expressions."""
    column = ca.vertcat(*items)
    return ca.densify(column) if column.shape[0] else ca.SX(0, 1)


def element_names(path: str, shape: tuple[int, ...]) -> list[str]:
    """Names of the scalars of a quantity, column by column: `v`, `v[0]`, `R[0,1]`."""
    if not shape or shape == (1, 1):
        return [path]
    if len(shape) == 1 or shape[1] == 1:
        return [f"{path}[{i}]" for i in range(shape[0])]
    return [f"{path}[{i},{j}]" for j in range(shape[1]) for i in range(shape[0])]


def with_names(expression: ca.SX, names: Mapping[str, str]) -> str:
    """The text of an expression, its symbols called by these names."""
    return _TOKEN.sub(lambda token: names.get(token[0], token[0]), str(expression))


@dataclass(slots=True)
class Unknown:
    """A scalar unknown of the flat system; `rate` is the number of its time derivative, where one appears.

    `start_set`: its start value was given for this model, and is not a default.
    """

    symbol: ca.SX
    path: str
    declared: Variable | Any
    start: ca.SX | None = None
    rate: int = -1
    order: int = 0
    base: int = -1
    start_set: bool = False

    @property
    def start_rank(self) -> int:
        """How much its start value counts against that of an equal unknown: 0 none, 1 a default, 2 a given one."""
        return (self.start is not None) + (self.start is not None and self.start_set)


BALANCE = "sum of the flows of a connection"
"""Source of the equations that the connections give."""


@dataclass(slots=True)
class FlatEquation:
    """A scalar equation lhs = rhs; `rate` is the number of its time derivative, where that was needed.

    `written` has the sides as the component wrote them, before unknowns were eliminated.
    """

    lhs: ca.SX
    rhs: ca.SX
    path: str
    source: str
    rate: int = -1
    order: int = 0
    base: int = -1
    written: tuple[ca.SX, ca.SX] | None = None


def residuals(equations: Sequence[FlatEquation]) -> ca.SX:
    """Left side minus right side of each equation."""
    return stacked(equation.lhs for equation in equations) - stacked(equation.rhs for equation in equations)


@dataclass(frozen=True, slots=True)
class Parameter:
    """A tunable parameter: value in SI units, `symbol` of the same shape."""

    path: str
    symbol: ca.SX
    value: np.ndarray
    unit: str
    doc: str
    min: float | None
    max: float | None
    form: Form | None = None


@dataclass(frozen=True)
class Bound:
    """Numbers computed when a run starts, by `compute` of the component at `owner`; in p behind the tunable ones.

    functions: external functions to which the data behind a handle, its first number, are to be made known.
    """

    path: str
    owner: str
    symbol: ca.SX
    unit: str
    doc: str
    compute: Callable[[Any], Any]
    functions: tuple[Any, ...] = ()


@dataclass(frozen=True)
class BoundParameter:
    """A parameter that is read when a run starts: declared so by the component at `owner`."""

    path: str
    owner: str
    name: str
    unit: str
    doc: str


@dataclass(slots=True)
class Discrete:
    """A scalar that changes only at events and samples."""

    symbol: ca.SX
    path: str
    declared: Variable
    start: ca.SX | None


@dataclass(slots=True)
class Intermediate:
    """Symbols with an explicit definition: the outputs of an external at `inputs`, or `expression` (orientations)."""

    symbols: list[ca.SX]
    inputs: ca.SX
    function: ca.Function | ToCome | None
    path: str
    matrix: str = ""
    slope_of: int = -1
    """Of the Jacobian of another one: its number."""

    @property
    def called(self) -> ca.Function:
        """The function of an external, compiled by now."""
        return self.function.made() if isinstance(self.function, ToCome) else self.function

    def names(self) -> list[str]:
        """Result names of the elements of an orientation."""
        return element_names(self.matrix, (3, 3))


@dataclass(frozen=True, slots=True)
class Input:
    """An input of the whole model: a signal that nothing drives."""

    path: str
    symbol: ca.SX
    unit: str
    doc: str
    default: np.ndarray
    driver: str = ""
    """The output that drove the signal before it was opened by name; see `flatten`."""


@dataclass(slots=True)
class Loop:
    """A ring of parts with orientations: paths of the parts, the one that closes it first; how many turn or move."""

    parts: list[str]
    turning: int
    moving: int


class System:
    """Equations over symbols, and d/dt of any expression of them."""

    def __init__(self) -> None:
        self.time = ca.SX.sym("time")
        self.unknowns: list[Unknown] = []
        self.equations: list[FlatEquation] = []
        self.intermediates: list[Intermediate] = []
        self.discretes: list[Discrete] = []
        self.parameters: dict[str, Parameter] = {}
        self.bound: dict[str, Bound] = {}
        self.computed_now: Callable[[Bound], np.ndarray | None] = lambda item: None  # numbers of these, where there are
        self.bound_parameters: dict[str, BoundParameter] = {}
        self.dependents: dict[str, Parameter] = {}
        self.inputs: dict[str, Input] = {}
        self.number: dict[int, int] = {}
        self.rates: dict[int, ca.SX] = {}
        self.aliases: dict[str, ca.SX] = {}
        self.alias_units: dict[str, tuple[str, str]] = {}
        self.orientations: list[tuple[str, ca.SX]] = []  # of connected frames, by the path of one of them
        self.signals: set[int] = set()  # numbers of the unknowns that are outputs of components
        self.orientation_at: dict[str, int] = {}  # hash of the rotation matrix of each balance of flows, by its path
        self.joints_below: dict[int, int] = {}  # joints between a rotation matrix, by its hash, and the world
        self.loops: list[Loop] = []
        self.places: dict[str, str] = {}  # file and line of components that stand in a model file
        self.eliminated: list[FlatEquation] = []
        self.range_checks: list[tuple[str, Assertion]] = []
        self.stages: list[Stage] = []
        self.quadratics: list[QuadraticLaw] = []
        self.current_path = ""
        self.asked = 0  # how often a part has given something that is no expression: a function, a computation
        self._external_of: dict[int, int] = {}

    def placed(self, path: str) -> str:
        """`file.yaml:12: ` of the nearest component at or above a path that stands in a model file, or nothing."""
        while path and path not in self.places:
            path = path.rpartition(".")[0]
        return f"{self.places[path]}: " if path in self.places else ""

    # --- building ------------------------------------------------------------------------------------------------

    def add_unknown(
        self, symbol: ca.SX, path: str, declared: Any, start: ca.SX | None = None, start_set: bool = False
    ) -> int:
        """Register a scalar symbol as unknown; returns its number."""
        number = len(self.unknowns)
        self.unknowns.append(Unknown(symbol, path, declared, start, base=number, start_set=start_set))
        self.number[symbol.element_hash()] = number
        return number

    def add_discrete(self, symbol: ca.SX, path: str, declared: Variable, start: ca.SX | None = None) -> None:
        """Register a scalar symbol that is constant between events."""
        self.discretes.append(Discrete(symbol, path, declared, start))

    def add_alias(self, path: str, value: ca.SX, unit: str, doc: str) -> None:
        """A second name for an expression, for results."""
        self.aliases[path] = value
        self.alias_units[path] = (unit, doc)

    def add_equation(self, lhs: ca.SX, rhs: ca.SX, path: str, source: str) -> None:
        """Add lhs = rhs, element by element."""
        for left, right in zip(scalars(lhs), scalars(rhs), strict=True):
            number = len(self.equations)
            self.equations.append(FlatEquation(left, right, path, source, base=number, written=(left, right)))

    def text(self, expression: ca.SX) -> str:
        """An expression with the elements of arrays called by their paths: `body.r[0]`."""
        return with_names(expression, self.written_names)

    @cached_property
    def written_names(self) -> dict[str, str]:
        """Path of each element of an array by the name that CasADi gave its symbol, which is `r_0` for `r[0]`."""
        named = [(item.symbol, item.path) for item in (*self.unknowns, *self.discretes)]
        for group in (self.parameters, self.bound, self.inputs):
            for item in group.values():
                named += zip(scalars(item.symbol), element_names(item.path, item.symbol.shape), strict=True)
        for intermediate in self.intermediates:
            if intermediate.function is None:
                named += zip(intermediate.symbols, intermediate.names(), strict=True)
        return {symbol.name(): path for symbol, path in named}

    # --- what equations() uses -----------------------------------------------------------------------------------

    def external(self, function: ca.Function | ToCome, inputs: ca.SX) -> ca.SX:
        """Tear the system at a call of `function`: its outputs become symbols."""
        self.asked += 1
        inputs = ca.densify(ca.vec(inputs))
        if function.n_in() != 1 or function.n_out() != 1:
            raise StructureError(f"external function {function.name()} must have one input and one output column.")
        if function.size1_in(0) != inputs.shape[0]:
            raise StructureError(
                f"external function {function.name()} takes {function.size1_in(0)} inputs, "
                f"and {inputs.shape[0]} are given."
            )
        outputs = ca.SX.sym(f"{self.current_path}.{function.name()}".lstrip("."), function.numel_out(0))
        symbols = scalars(outputs)
        for symbol in symbols:
            self._external_of[symbol.element_hash()] = len(self.intermediates)
        self.intermediates.append(Intermediate(symbols, inputs, function, self.current_path))
        return ca.reshape(outputs, function.size1_out(0), function.size2_out(0))

    def open_input(self, name: str, size: int, unit: str, doc: str, default: Any) -> ca.SX:
        """An input of the whole model, asked for by the part whose equations are being written."""
        path = first = join(self.current_path, name)
        number = 2
        while path in self.inputs:
            path, number = f"{first}_{number}", number + 1
        symbol = ca.SX.sym(path, size)
        value = np.broadcast_to(np.asarray(default, dtype=float), (size,))
        self.inputs[path] = Input(path, symbol, unit, doc, value)
        return symbol

    def at_start(self, wanted: AtStart) -> ca.SX:
        """Symbols of numbers that are computed when a run starts."""
        self.asked += 1
        owner = self.current_path if wanted.of is None else wanted.of.path
        path = first = join(owner, wanted.name)
        if wanted.of is not None and path in self.bound:
            there = self.bound[path]
            new = tuple(function for function in wanted.functions if function not in there.functions)
            self.bound[path] = replace(there, functions=there.functions + new)
            return there.symbol
        number = 2
        while path in self.bound:
            path, number = f"{first}_{number}", number + 1
        symbol = ca.SX.sym(path, wanted.size)
        self.bound[path] = Bound(path, owner, symbol, wanted.unit, wanted.doc, wanted.compute, wanted.functions)
        return symbol

    def set_input_rate(self, signal: ca.SX, rate: ca.SX) -> None:
        """What the derivative of a signal from outside of the model is, in place of zero."""
        for element, value in zip(scalars(signal), scalars(ca.densify(rate)), strict=True):
            self.rates[element.element_hash()] = value

    def stage(self, states: ca.SX, step: ca.SX) -> None:
        """States whose implicit steps an external function solves, and its input for that."""
        self.stages.append(Stage(self.current_path, states, step))

    def quadratic(self, inputs: ca.SX, added: ca.SX, smoothing: float) -> None:
        """A quadratic law of the part whose equations are being written."""
        self.quadratics.append(QuadraticLaw(inputs, added, smoothing, self.current_path))

    def check_range(self, value: ca.SX, low: Any, high: Any, name: str, argument: str, message: str = "") -> None:
        """Stop the simulation where a table is left: one check for all elements of a column.

        low, high: numbers, or symbols of `at_start`, infinite where there is no end.
        In a message, {value} is the element that is the farthest outside, {number} its number, counted from 1; {low}
        and {high} are the ends.
        """
        column = ca.vec(ca.densify(ca.SX(value)))
        least, most, margin = ca.mmin(column), ca.mmax(column), 1e-9 * (high - low)
        inside = ca.logic_and(least >= low - margin, most <= high + margin)
        worst = ca.if_else(low - least > most - high, least, most)
        values = {"value": worst, "low": ca.SX(low), "high": ca.SX(high)}
        if "{number}" in message:
            matches = [ca.if_else(column[i] == worst, i + 1, 0) for i in range(column.shape[0])]
            values["number"] = ca.mmax(ca.vertcat(*matches))
        text = f"table left at its edge: {name} at {argument} = {{value}}, and the table covers {{low}} to {{high}}."
        for end in ("low", "high"):
            if values[end].is_constant():
                text, message = (words.replace(f"{{{end}}}", f"{float(values[end]):g}") for words in (text, message))
                del values[end]
        self.range_checks.append((self.current_path, Assertion(inside, message or text, "error", "", values)))

    # --- differentiation -----------------------------------------------------------------------------------------

    def derivative(self, expression: ca.SX) -> ca.SX:
        """Total time derivative; unknowns without a derivative get one."""
        elements = scalars(expression)
        if len(elements) == 1 and elements[0].is_symbolic():
            return self._rate(elements[0])
        if all(element.is_symbolic() or element.is_constant() for element in elements):
            rates = [self._rate(element) for element in elements]
            return ca.densify(ca.reshape(ca.vertcat(*rates), *expression.shape))
        expression = ca.densify(expression)
        symbols = ca.symvar(expression)
        seeds = [self._rate(symbol) for symbol in symbols]
        rate = ca.jtimes(ca.vec(expression), ca.vertcat(*symbols), ca.vertcat(*seeds))
        return ca.densify(ca.reshape(rate, *expression.shape))

    def _rate(self, symbol: ca.SX) -> ca.SX:
        if symbol.is_constant():
            return ca.SX(0)
        key = symbol.element_hash()
        if key in self.number:
            return self.unknowns[self.rate_of(self.number[key])].symbol
        if key in self.rates:
            return self.rates[key]
        if key in self._external_of:
            self._differentiate_external(self.intermediates[self._external_of[key]])
            return self.rates[key]
        return ca.SX(1 if key == self.time.element_hash() else 0)

    def rate_of(self, number: int) -> int:
        """Number of the derivative of an unknown, made when it is first needed."""
        unknown = self.unknowns[number]
        if unknown.rate < 0:
            name = f"der({unknown.path})"
            rate = self.add_unknown(ca.SX.sym(name), name, unknown.declared)
            self.unknowns[rate].order = unknown.order + 1
            self.unknowns[rate].base = unknown.base
            unknown.rate = rate
        return unknown.rate

    def _differentiate_external(self, call: Intermediate) -> None:
        """d/dt w = J(y) dy/dt, with the Jacobian of the function as an external of its own."""
        jacobian = jacobian_of(call.called)
        path, self.current_path = self.current_path, call.path
        entries = ca.reshape(self.external(jacobian, call.inputs), len(call.symbols), call.inputs.shape[0])
        self.intermediates[-1].slope_of = next(k for k, item in enumerate(self.intermediates) if item is call)
        self.current_path = path
        rates = scalars(entries @ self.derivative(call.inputs))
        for symbol, rate in zip(call.symbols, rates, strict=True):
            self.rates[symbol.element_hash()] = rate

    def orient(self, R: ca.SX, w: ca.SX) -> None:
        """d/dt R = skew(w) R for the symbols of an orientation."""
        for symbol, rate in zip(scalars(R), scalars(ca.skew(w) @ R), strict=True):
            if symbol.is_symbolic():
                self.rates[symbol.element_hash()] = rate


def jacobian_of(function: ca.Function) -> ca.Function:
    """Jacobian entries, column by column; second derivatives by finite differences where there are none."""
    y = ca.MX.sym("y", function.size1_in(0))
    name, entries = f"{function.name()}_jacobian", ca.densify(ca.vec(ca.jacobian(function(y), y)))
    jacobian = ca.Function(name, [y], [entries])
    try:
        jacobian.jacobian()
    except RuntimeError:
        off = {"enable_forward": False, "enable_reverse": False, "enable_jacobian": False, "enable_fd": True}
        return ca.Function(name, [y], [entries], {**off, "never_inline": True})
    return jacobian
