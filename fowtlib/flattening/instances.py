"""Step 1: walk the component tree and give every parameter, variable and connector member its flat symbol."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any

import casadi as ca
import numpy as np

from fowtlib.flattening.connections import Connections
from fowtlib.flattening.system import Bound, BoundParameter, Parameter, System, element_names, scalars
from fowtlib.language import bounds, declarations, expressions
from fowtlib.language import equations as statements
from fowtlib.language.component import Component, UnknownAttribute
from fowtlib.language.connectors import BoundPort, Signal
from fowtlib.language.declarations import SHAPES, Variable, Withheld, join
from fowtlib.language.errors import ModelError, ParameterError, StructureError
from fowtlib.language.faults import author_line, reason
from fowtlib.language.matrix_forms import wrong_form
from fowtlib.language.offered import Happening
from fowtlib.language.operators import LinearOperator
from fowtlib.language.placing import placed
from fowtlib.language.units import to_si


@dataclass
class Statements:
    """What the `equations()` of all components returned, each with the path of its component."""

    initial: list[tuple[str, statements.Initial]] = field(default_factory=list)
    when: list[tuple[str, statements.When]] = field(default_factory=list)
    on: list[tuple[str, statements.On]] = field(default_factory=list)
    sampled: list[tuple[str, statements.Sampled]] = field(default_factory=list)
    assertions: list[tuple[str, statements.Assertion]] = field(default_factory=list)
    rotations: list[tuple[str, statements.Rotation]] = field(default_factory=list)
    fixed_orientations: list[tuple[str, statements.FixedOrientation]] = field(default_factory=list)
    symmetries: list[tuple[str, statements.CyclicSymmetry]] = field(default_factory=list)
    operators: list[tuple[str, LinearOperator]] = field(default_factory=list)


class Instances:
    """The bound component tree. Use as a context: the components give symbols inside, and values again afterwards."""

    def __init__(self, root: Component, opened: Sequence[str] = ()):
        self.root = root
        self.opened = opened
        self.system = System()
        self.components = list(root.walk())
        self.system.computed_now = self._computed_now
        self.system.places = {item.path: item.origins[""] for item in self.components if "" in item.origins}
        self.statements = Statements()
        self._parameters: dict[tuple[int, str], Any] = {}
        self.given_with: tuple[list[str], list[str]] = ([], [])
        """Paths of the components whose values, and whose equations, gave something that is no expression."""

    def __enter__(self) -> Instances:
        self.connections = Connections(self.components)
        for component in self.components:
            check_parameters(component)
        bindings = []
        for component in self.components:
            with self._noting(component, 0):
                bindings.append(self._bind(component))
        self._bind_ports(bindings)
        for component, binding in zip(self.components, bindings, strict=True):
            component._binding = binding
        return self

    @contextmanager
    def _noting(self, component: Component, kind: int) -> Iterator[None]:
        before = self.system.asked
        yield
        if self.system.asked > before:
            self.given_with[kind].append(component.path)

    def __exit__(self, *_: object) -> None:
        for component in self.components:
            component._binding = None

    # --- parameters ----------------------------------------------------------------------------------------------

    def _parameter(self, component: Component, name: str) -> Any:
        """The symbol of a tunable parameter, the expression of a dependent one, the value of a structural one."""
        key = (id(component), name)
        if key in self._parameters:
            return self._parameters[key]
        declared = component.parameters[name]
        value = component.parameter_binding(name)
        if declared.bound:
            bound = self._withheld(component, declared)
        elif not declared.tunable or value is None:
            bound = component.parameter_value(name) if value is not None else None
        else:
            bound = self._evaluate(value) if expressions.is_expression(value) else None
            shape = component.shape_of(declared)
            if isinstance(bound, ca.SX):
                bound = ca.densify(ca.repmat(bound, *two_dimensions(shape)) if bound.is_scalar() else bound)
                self._dependent(component, declared, bound)
            else:  # a number, or an expression of structural parameters only
                bound = self._tunable(component, declared, shape)
        self._parameters[key] = bound
        return bound

    def _withheld(self, component: Component, declared: Any) -> Withheld:
        """A bound parameter, for which equations() must not ask."""
        path = join(component.path, declared.name)
        self.system.bound_parameters[path] = BoundParameter(
            path, component.path, declared.name, declared.unit, declared.doc
        )
        return Withheld(
            f"{path} is bound when a run starts, and no equation can depend on its value now; take numbers that follow "
            "from it by at_start(...) or run_time_series(...)."
        )

    def _tunable(self, component: Component, declared: Any, shape: tuple[int, ...]) -> ca.SX:
        """The symbol of an independent parameter."""
        if not np.prod(shape):  # an empty list of something optional
            return ca.SX(*two_dimensions(shape))
        path = join(component.path, declared.name)
        symbol = ca.SX.sym(path, *two_dimensions(shape))
        value = np.broadcast_to(np.asarray(component.parameter_value(declared.name), dtype=float), shape)
        self.system.parameters[path] = Parameter(
            path, symbol, value, declared.unit, declared.doc, declared.min, declared.max, declared.form
        )
        return symbol

    def _dependent(self, component: Component, declared: Any, expression: ca.SX) -> None:
        """A parameter that follows from others: its bounds hold for every value of theirs."""
        path = join(component.path, declared.name)
        value = np.asarray(component.parameter_value(declared.name), dtype=float)
        self.system.dependents[path] = Parameter(
            path, expression, value, declared.unit, declared.doc, declared.min, declared.max, declared.form
        )

    def _evaluate(self, value: Any) -> Any:
        def combine(items: list[Any]) -> Any:
            if any(isinstance(item, (ca.SX, ca.DM)) for item in items):
                return ca.vertcat(*[ca.transpose(ca.SX(item)) for item in items])
            return np.asarray(items)

        def leaf(reference: Any) -> Any:
            if isinstance(reference, expressions.StartNumbers):
                return self.system.at_start(
                    statements.AtStart(
                        reference.name, reference.size, "", "computed when a run starts", reference.compute,
                        reference.component.current,
                    )
                )  # fmt: skip
            found = self._parameter(reference.component.current, reference.name)
            if isinstance(found, Withheld):
                raise ParameterError(found.reason)
            return found

        return expressions.evaluate(value, leaf, combine)

    def _computed_now(self, item: Bound) -> np.ndarray | None:
        """Numbers that a component computes when a run starts, with the values of now; None for other data."""
        component = next(one for one in self.components if one.path == item.owner)
        try:
            found = item.compute(component)
        except ModelError:  # bound parameters have no value yet
            return None
        return None if found is None or hasattr(found, "numbers") else np.ravel(np.asarray(found, dtype=float))

    # --- variables -----------------------------------------------------------------------------------------------

    def _bind(self, component: Component) -> dict[str, Any]:
        binding: dict[str, Any] = {name: self._parameter(component, name) for name in component.parameters}
        for name, declared in component.outers.items():
            binding[name] = component.find_outer(declared)
        for name, declared in component.variables.items():
            binding[name] = self._variable(component, declared)
        binding |= {name: Happening(declared) for name, declared in component.offered_events.items()}
        return binding

    def _variable(self, component: Component, declared: Variable) -> ca.SX:
        path, shape = join(component.path, declared.name), component.shape_of(declared)
        symbol = ca.SX.sym(path, *two_dimensions(shape))
        starts = self._start(component, declared, shape)
        given = any(component.is_set(parameter.name) for parameter in _parameters_in(declared.start))
        for element, name, start in zip(scalars(symbol), element_names(path, shape), starts, strict=True):
            if declared.discrete:
                self.system.add_discrete(element, name, declared, start)
            else:
                self.system.add_unknown(element, name, declared, start, given)
        return symbol

    def _start(self, component: Component, declared: Variable, shape: tuple[int, ...]) -> list[Any]:
        n = int(np.prod(shape))
        if declared.start is None:
            return [None] * n
        value = component.resolve(declared.start)
        if expressions.is_expression(value):
            value = self._evaluate(value)
        else:
            value = to_si(value, declared.unit, join(component.path, declared.name))
        elements = scalars(ca.SX(value) if isinstance(value, ca.SX) else ca.SX(ca.DM(value)))
        return elements * n if len(elements) == 1 else elements

    # --- ports ---------------------------------------------------------------------------------------------------

    def _bind_ports(self, bindings: list[dict[str, Any]]) -> None:
        symbols = self.connections.symbols(self.system, self.root, self.opened)
        for node in self.connections.nodes:
            members = symbols[node.number]
            if issubclass(node.field.annotation, Signal):
                bound = members["signal"]
            else:
                bound = BoundPort(node.path, node.field.annotation, node.connected, members)
            binding = bindings[node.instance]
            if node.index is None:
                binding[node.field.name] = bound
            else:
                binding.setdefault(node.field.name, []).append(bound)
        for component, binding in zip(self.components, bindings, strict=True):
            for name in component.ports:
                binding.setdefault(name, [])

    # --- equations -----------------------------------------------------------------------------------------------

    def collect(self) -> None:
        """Call `equations()` of every component and sort what it returns."""
        with statements.flattening(self.system):
            for component in self.components:
                self.system.current_path = component.path
                try:
                    with self._noting(component, 1):
                        self.take(component, component.equations())
                    self._check_offers(component)
                except ModelError as error:
                    raise _located(error, component) from None
                except Exception as error:
                    raise StructureError(
                        f"{component.label} ({author_line(error)}): the equations of {type(component).__name__} fail: "
                        f"{reason(error)}"
                    ) from error
        self.statements.assertions += self.system.range_checks

    def take(self, component: Component, returned: Any) -> None:
        """Sort what `equations()` of a component returned."""
        if returned is None:
            what = "equations() returned nothing; end it with return [...]."
            raise StructureError(f"{component.label}: {what}")
        for statement in _flattened(returned):
            self._take(component, statement)

    def _take(self, component: Component, statement: Any) -> None:
        path = component.path
        if isinstance(statement, statements.Equation):
            self.system.add_equation(statement.lhs, statement.rhs, path, statement.source)
            return
        lists: dict[type, list[Any]] = {
            statements.Initial: self.statements.initial,
            statements.When: self.statements.when,
            statements.On: self.statements.on,
            statements.Sampled: self.statements.sampled,
            statements.Assertion: self.statements.assertions,
            statements.Rotation: self.statements.rotations,
            statements.FixedOrientation: self.statements.fixed_orientations,
            statements.CyclicSymmetry: self.statements.symmetries,
            LinearOperator: self.statements.operators,
        }
        if isinstance(statement, statements.Assign):
            word, home = ("reinit()", "when()") if statement.is_reinit else ("assign()", "when() or sampled()")
            what = f"{word} stands alone in equations(), which does not say when to carry it out"
            raise StructureError(f"{component.label}: {what}; put it into a {home}.")
        if isinstance(statement, statements.Sampled):
            self._check_targets(path, statement)
            self.system.asked += statement.process is not None
        if type(statement) not in lists:
            what = "an expression" if isinstance(statement, ca.SX) else repr(statement)
            raise StructureError(
                f"{component.label}: equations() returned {what if len(what) < 60 else what[:57] + '...'}, "
                "which is not an equation; write eq(left, right), not left == right."
            )
        lists[type(statement)].append((path, statement))

    def _check_offers(self, component: Component) -> None:
        """Everything that is offered does something."""
        answered = {id(item.event) for path, item in self.statements.on if path == component.path}
        for name in component.offered_events:
            if id((component._binding or {})[name]) not in answered:
                raise StructureError(
                    f"{join(component.path, name)} is offered, and its equations do not say what it does; "
                    f"write on(self.{name}, assign(...))."
                )

    def _check_targets(self, path: str, sampled: statements.Sampled) -> None:
        """A sampled part sets discrete variables only."""
        for action in sampled.assignments:
            for target in scalars(action.target):
                number = self.system.number.get(target.element_hash())
                if number is not None:
                    name = self.system.unknowns[number].path
                    raise StructureError(
                        f"{path or 'the model'}: assign() cannot set {name}; declare it with var(discrete=True)."
                    )


def check_parameters(component: Component) -> None:
    """ParameterError where a value is missing, or is not what the parameter was declared to be."""
    for name, declared in component.parameters.items():
        value = component.parameter_value(name)
        if value is None:
            continue
        where = _where(component, name)
        if not (declared.bound or declared.tunable):
            for leaf in expressions.leaves(component.parameter_binding(name)):
                if leaf.component.parameters[leaf.name].bound:
                    raise ParameterError(
                        f"{where} decides how the model is built, and cannot depend on {leaf!r}, which is bound when a "
                        "run starts."
                    )
        if declared.choices is not None and value not in declared.choices:
            allowed = ", ".join(map(str, declared.choices))
            raise ParameterError(f"{where} = {value!r} is not one of {allowed} ({declared.doc}).")
        if declared.annotation in SHAPES:
            shape = component.shape_of(declared)
            if np.shape(value) != shape and not (np.size(value) == int(np.prod(shape)) and len(shape) < 2):
                raise ParameterError(
                    f"{where} has shape {_shape(np.shape(value))}, and "
                    f"{_shape(shape) if shape else 'one number'} is expected ({declared.doc})."
                )
        if isinstance(value, (int, float, np.ndarray)) and not isinstance(value, bool):
            _check_bounds(where, declared, value)


def _check_bounds(where: str, declared: Any, value: Any) -> None:
    numbers = np.asarray(value)
    if numbers.dtype.kind not in "fiu":
        return
    if not np.all(np.isfinite(numbers)):
        raise ParameterError(f"{where} is not a finite number: {value} ({declared.doc}).")
    found = bounds.outside(numbers, declared.min, declared.max, declared.unit)
    if found:
        worst, said = found
        raise ParameterError(f"{where} = {bounds.shown(worst, declared.unit)} is {said} ({declared.doc}).")
    if declared.form and (wrong := wrong_form(declared.form, numbers)):
        raise ParameterError(f"{where}: {wrong} ({declared.doc}).")


def _parameters_in(value: Any) -> Iterable[declarations.Parameter]:
    """Parameters of the class body that a declared value depends on."""
    if isinstance(value, declarations.Parameter):
        yield value
    elif isinstance(value, expressions.Expression):
        yield from (parameter for argument in value.arguments for parameter in _parameters_in(argument))
    elif isinstance(value, (list, tuple)):
        yield from (parameter for item in value for parameter in _parameters_in(item))


def _flattened(items: Any) -> Iterable[Any]:
    if isinstance(items, (list, tuple)):
        for item in items:
            yield from _flattened(item)
    elif items is not None:
        yield items


def _where(component: Component, name: str) -> str:
    path = join(component.path, name)
    origin = component.origins.get(name)
    return f"{origin}: {path}" if origin else path


def two_dimensions(shape: tuple[int, ...]) -> tuple[int, int]:
    """Rows and columns of a quantity; ParameterError where it has more than two dimensions."""
    if len(shape) > 2:
        raise ParameterError(f"quantities have two dimensions at most, not {len(shape)}.")
    return (1, 1) if not shape else (shape[0], shape[1] if len(shape) == 2 else 1)


def _shape(shape: tuple[int, ...]) -> str:
    return " x ".join(map(str, shape)) if shape else "of a scalar"


def _located(error: ModelError, component: Component) -> ModelError:
    """The error with the component in front, and the line where an author of equations has to look."""
    where = component.label
    if isinstance(error, (StructureError, UnknownAttribute)):
        where = f"{component.label} ({author_line(error)})"
        if error.message.startswith(f"{component.label} ") and not error.where:
            return type(error)(f"{where}{error.message.removeprefix(component.label)}")
    if re.search(rf"(?<![\w.]){re.escape(component.label)}(?!\w)", str(error)):
        return placed(error, component)
    return error.at(where)
