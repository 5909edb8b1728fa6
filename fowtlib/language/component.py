"""Component: the base class of everything a model is made of."""

from __future__ import annotations

import inspect
import sys
from collections.abc import Callable, Iterator
from typing import Any, dataclass_transform

import numpy as np

from fowtlib.language import expressions
from fowtlib.language.declarations import (
    SHAPES,
    Field,
    Outer,
    Parameter,
    Part,
    Port,
    PortReference,
    Variable,
    join,
    outer,
    param,
    part,
    port,
    var,
)
from fowtlib.language.equations import active, source_line
from fowtlib.language.errors import ConnectionFault, NotFoundError, ParameterError, did_you_mean
from fowtlib.language.shapes import Drawn
from fowtlib.language.units import check_si, dimension, to_si


class UnknownAttribute(NotFoundError, AttributeError):
    """A name that a component does not have."""


@dataclass_transform(kw_only_default=True, field_specifiers=(param, part, port, var, outer))
class Component:
    """A class of model parts: parameters, ports, variables, `equations()`.

    Keyword arguments of the constructor are parameters of the component, or parts that take the place of
    declared ones. A composite adds parts and connections in `build()`.
    """

    parameters: dict[str, Parameter] = {}
    ports: dict[str, Port] = {}
    variables: dict[str, Variable] = {}
    declared_parts: dict[str, Part] = {}
    outers: dict[str, Outer] = {}

    def __init_subclass__(cls, **kwargs: Any) -> None:
        super().__init_subclass__(**kwargs)
        _resolve_annotations(cls, sys._getframe(1).f_locals)
        for kind, table in _TABLES.items():
            own = {name: value for name, value in vars(cls).items() if isinstance(value, kind)}
            setattr(cls, table, {**getattr(cls, table), **own})

    def __init__(self, **modifiers: Any):
        self._parent: Component | None = None
        self._name = ""
        self._binding: dict[str, Any] | None = None
        self._values: dict[str, Any] = {}
        self.origins: dict[str, str] = {}
        self.parts: dict[str, Component] = {}
        self.connections: list[tuple[PortReference, PortReference, str]] = []
        self._given = {name: value for name, value in modifiers.items() if name in self.declared_parts}
        self._composed: tuple[int, int] | None = None
        self._composing = False
        self._later: set[str] = set()  # parameters set from outside, after this component was made
        for name, value in modifiers.items():
            if name not in self._given:
                self._set(name, value)
        self._compose()

    def _compose(self) -> None:
        """Make the declared parts, and those of build()."""
        self.parts, self.connections, self._composing = {}, [], True
        for table in ("ports", "variables", "_declared"):  # what an earlier build() has declared
            self.__dict__.pop(table, None)
        try:
            for name, declared in self.declared_parts.items():
                given = self._given.get(name)
                self.add(name, declared.component_class(**_bound(declared.modifiers, self)) if given is None else given)
            self.build()
        finally:
            self._composing = False
        self._composed = (len(self.parts), len(self.connections))

    # --- what authors override -----------------------------------------------------------------------------------

    def build(self) -> None:
        """Add parts and connections (composites only)."""

    def equations(self) -> list[Any]:
        """The statements of this component; called once, while the model is flattened."""
        return []

    def drawing(self) -> list[Drawn]:
        """What pictures show of this component: see fowtlib.language.shapes. By default, what they show of its parts.

        Called outside of flattening: numbers come from `parameter_value`.
        """
        return [shape for part in self.parts.values() for shape in part.drawing()]

    # --- parameters ----------------------------------------------------------------------------------------------

    def assign(self, field: Field, value: Any) -> None:
        """Attribute assignment: a parameter gets a value, a declared part is replaced."""
        if isinstance(field, Parameter):
            self._set(field.name, value)
        elif isinstance(field, Part) and isinstance(value, Component):
            self._given[field.name] = value
            self.add(field.name, value)
        else:
            raise ParameterError(f"{self.label}.{field.name} is not a parameter and cannot be set.")

    def _set(self, name: str, value: Any) -> None:
        field = self.parameters.get(name)
        if field is None:
            raise ParameterError(f"{self.label} has no parameter '{name}'{did_you_mean(name, self.parameters)}")
        was_set = name in self._values
        self._values[name] = self._checked(field, value)
        if self._composed is not None and not any(one._composing for one in (self, *self.enclosing())):
            self._later.add(name)
        if self._composed is not None and not (was_set and field.tunable):
            self._compose_again(name)

    def _compose_again(self, name: str) -> None:
        """A parameter that may decide about parts has changed after they were made."""
        if type(self).build is Component.build and not self.declared_parts:
            return
        owned = [one for one in self.parts.values() if one not in self._given.values()]
        made = [inner for one in owned for inner in one.walk()]
        for one in (self, *made):
            if one._composed != (len(one.parts), len(one.connections)):
                raise ParameterError(
                    f"{self.label}.{name} cannot be changed any more, because parts were added to {one.label} by hand; "
                    f"give it to the constructor of {type(self).__name__}."
                )
        kept = [(one.path, one) for one in made if one._later]
        self._compose()
        for path, old in kept:  # values that parts got from outside are not lost with the old parts
            self._keep(path.removeprefix(f"{self.path}."), old, name)

    def _keep(self, path: str, old: Component, cause: str) -> None:
        """Give the part at a path the values that its predecessor got from outside."""
        new: Component | None = self
        for step in path.split("."):
            new = new.parts.get(step) if new is not None else None
        for name in sorted(old._later):
            if new is None or name not in new.parameters:
                raise ParameterError(
                    f"{self.label}.{cause} decides how {self.label} is built, and with its new value there is no "
                    f"'{path}.{name}', which was given a value before; set {cause} first."
                )
            setattr(new, name, old._values[name])
            new._later.add(name)
            new.origins.update({name: old.origins[name]} if name in old.origins else {})

    def _checked(self, field: Parameter, value: Any) -> Any:
        where = join(self.path or type(self).__name__, field.name)
        if expressions.is_expression(value):
            return value
        if field.annotation in SHAPES:
            return to_si(value, field.unit, where)
        if field.annotation in (int, float, str, bool):
            return _plain(field, value, where)
        return value

    def parameter_value(self, name: str) -> Any:
        """The value a parameter has now, in SI units; an error where a required one is missing."""
        value = self.parameter_binding(name)
        if self.parameters[name].annotation in SHAPES:
            if value is None:
                return None
            value = np.asarray(expressions.evaluate(value, combine=_stack), dtype=float)
            return value.item() if SHAPES[self.parameters[name].annotation] == () and value.size == 1 else value
        if expressions.is_expression(value):
            return _plain(self.parameters[name], expressions.evaluate(value), join(self.path, name))
        return value

    def parameter_binding(self, name: str) -> Any:
        """What a parameter is set to: a value, or an expression of other parameters."""
        if name in self._values:
            return self._values[name]
        field = self.parameters[name]
        if field.required:
            raise ParameterError(
                f"{join(self.path or type(self).__name__, name)} has no value: {field.doc or 'a required parameter'} "
                f"[{field.unit}]. Give {type(self).__name__} the parameter '{name}'."
            )
        return self._checked(field, self.resolve(field.default))

    def is_set(self, name: str) -> bool:
        """True where the parameter was given, not left at its default."""
        return name in self._values

    def resolve(self, value: Any) -> Any:
        """A declared value for this instance: functions called, class-body parameters replaced by this instance's."""
        if inspect.isfunction(value):
            value = value(self)
        return expressions.rebind(value, self)

    # --- composition ---------------------------------------------------------------------------------------------

    def add(self, name: str, component: Component) -> Component:
        """Add a part under a name; returns it."""
        if not isinstance(component, Component):
            raise ParameterError(f"{self.label}.{name}: a part is a Component, not {component!r}.")
        if component._parent is not None and component._parent is not self:
            raise ParameterError(
                f"{component.path} is a part already; make a second {type(component).__name__} instead."
            )
        self._check_new(name, "part")
        component._parent, component._name = self, name
        self.parts[name] = component
        if self._composing and component not in self._given.values():
            for one in component.walk():
                one._later.clear()  # what build() set, it sets again
        return component

    def declare(self, name: str, annotation: type, field: Port | Variable) -> None:
        """In build(): a port or variable that only this instance has, as where a file says which there are.

        `self.declare("pitch", RealOutput, port(unit="rad"))` does what `pitch: RealOutput = port(unit="rad")` does in a
        class body.
        """
        self._check_new(name, "port or variable")
        field.name, field.owner, field.annotation = name, type(self), annotation
        dimension(field.unit)
        table = "ports" if isinstance(field, Port) else "variables"
        object.__setattr__(self, table, {**getattr(self, table), name: field})
        self._declared = {**self.__dict__.get("_declared", {}), name: field}

    def _check_new(self, name: str, kind: str) -> None:
        if not name.isidentifier() or name.startswith("_"):
            raise ParameterError(f"{self.label}: '{name}' is not a name; use letters, digits and underscores.")
        if any(name in table for table in (self.parameters, self.ports, self.variables, self.outers)):
            raise ParameterError(f"{self.label}.{name} is declared already and cannot be a {kind}.")
        if hasattr(Component, name) or name in _OWN:
            raise ParameterError(
                f"{self.label}: a {kind} cannot be called '{name}', which every component has already."
            )

    def connect(self, a: PortReference, b: PortReference) -> None:
        """Join two ports of this component or of its parts."""
        for end in (a, b):
            if not isinstance(end, PortReference):
                raise ConnectionFault(f"{self.label}: connect() joins two ports, and {end!r} is not a port.")
            if end.component is not self and self not in end.component.enclosing():
                raise ConnectionFault(
                    f"{self.label}: {end.path} is not a port of this component or of a part below it; "
                    "connect it where it belongs, after the part was added."
                )
        self.connections.append((a, b, source_line()))

    def find_outer(self, field: Outer) -> Component | None:
        """The nearest part of the field's class in an enclosing component."""
        component_class = field.component_class or field.annotation
        for enclosing in self.enclosing():
            for candidate in enclosing.parts.values():
                if isinstance(candidate, component_class) and candidate is not self:
                    return candidate
        if field.optional:
            return None
        raise ParameterError(
            f"{self.path or type(self).__name__} needs a {component_class.__name__}: "
            f"declare one in the model, for example under the name '{field.name}'."
        )

    def port_size(self, field: Port) -> int | None:
        """Number of ports of an array of ports; None for a single port."""
        if field.size is None:
            return None
        return int(
            self.parameter_value(field.size) if isinstance(field.size, str) else np.asarray(self.resolve(field.size))
        )

    def shape(self, field: Variable | Port | Parameter) -> tuple[int, ...]:
        """Shape of a declared quantity, with structural parameters put in."""
        fixed = SHAPES.get(field.annotation) if not isinstance(field, Port) else ()
        shape = field.shape
        if shape is None:
            if fixed is not None:
                return fixed
            if isinstance(field, Parameter):
                return np.shape(self.parameter_value(field.name))
            raise ParameterError(f"{self.label}.{field.name}: an Array needs a shape.")
        if inspect.isfunction(shape):
            shape = shape(self)
        if isinstance(shape, (int, str, np.integer)):
            shape = (shape,)
        return tuple(int(self.parameter_value(item)) if isinstance(item, str) else int(item) for item in shape)

    def __setattr__(self, name: str, value: Any) -> None:
        if (
            isinstance(value, Component)
            and not name.startswith("_")
            and not isinstance(getattr(type(self), name, None), Field)
        ):
            self.add(name, value)
        elif name.startswith("_") or hasattr(type(self), name) or name in _OWN:
            object.__setattr__(self, name, value)
        else:
            self._set(name, value)

    def __getattr__(self, name: str) -> Any:
        parts = self.__dict__.get("parts", {})
        if name in parts:
            return parts[name]
        if name.startswith("_"):
            raise AttributeError(name)
        if name in self.__dict__.get("_declared", {}):
            return self._declared[name].__get__(self)
        known = [*parts, *self.parameters, *self.ports, *self.variables]
        raise UnknownAttribute(
            f"{self.label} has no part, port, parameter or variable '{name}'{did_you_mean(name, known)}"
        )

    # --- names ---------------------------------------------------------------------------------------------------

    @property
    def path(self) -> str:
        """Names from the top of the model down to this component; empty at the top."""
        return join(self._parent.path, self._name) if self._parent is not None else ""

    @property
    def label(self) -> str:
        """Path for messages: the class name at the top."""
        return self.path or type(self).__name__

    @property
    def time(self) -> Any:
        """Time [s], inside `equations()`."""
        return active().time

    def enclosing(self) -> Iterator[Component]:
        """The components that this one is a part of, from the nearest to the top."""
        parent = self._parent
        while parent is not None:
            yield parent
            parent = parent._parent

    def walk(self) -> Iterator[Component]:
        """The component and all parts below it, parents first."""
        yield self
        for child in self.parts.values():
            yield from child.walk()

    def find(self, path: str) -> Component:
        """The component at a path below this one."""
        component: Component = self
        for name in path.split(".") if path else ():
            if name not in component.parts:
                raise NotFoundError(f"{component.label} has no part '{name}'{did_you_mean(name, component.parts)}")
            component = component.parts[name]
        return component

    def __repr__(self) -> str:
        return f"<{type(self).__name__} {self.path}>" if self.path else f"<{type(self).__name__}>"


_TABLES: dict[type, str] = {
    Parameter: "parameters", Port: "ports", Variable: "variables", Part: "declared_parts", Outer: "outers",
}  # fmt: skip
_OWN = {"origins", "parts", "connections"}


def _resolve_annotations(cls: type, local_names: dict[str, Any]) -> None:
    """Give each field the class that its annotation names; under `from __future__ import annotations` that is text."""
    module = vars(sys.modules[cls.__module__]) if cls.__module__ in sys.modules else {}
    annotations = vars(cls).get("__annotations__", {})
    for name, value in vars(cls).items():
        if not isinstance(value, Field) or isinstance(value, Part):
            continue
        annotation = annotations.get(name)
        if annotation is None:
            raise TypeError(f"{cls.__name__}.{name} has no annotation; write for example `{name}: Scalar = ...`")
        if isinstance(annotation, str):
            annotation = eval(annotation, {**module, **local_names})
        value.annotation = annotation
        check_si(value.unit if isinstance(value, (Parameter, Port, Variable)) else "1", f"{cls.__name__}.{name}")


def _bound(modifiers: dict[str, Any], component: Component) -> dict[str, Any]:
    return {name: component.resolve(value) for name, value in modifiers.items()}


def _stack(items: list[Any]) -> np.ndarray:
    return np.asarray([np.asarray(item, dtype=float) for item in items])


def _plain(field: Parameter, value: Any, where: str) -> Any:
    """A structural value of the annotated plain type."""
    wanted: Callable[[Any], Any] = field.annotation
    if wanted is float and isinstance(value, str):
        return float(to_si(value, field.unit, where))
    if isinstance(value, np.generic):
        value = value.item()
    if wanted is float and isinstance(value, int) and not isinstance(value, bool):
        value = float(value)
    if wanted is int and isinstance(value, float) and value.is_integer():
        value = int(value)
    if value is None and field.default is None:
        return None
    if not isinstance(value, wanted) or (wanted is int and isinstance(value, bool)):
        kinds = {int: "a whole number", float: "a number", str: "a text", bool: "true or false"}
        raise ParameterError(f"{where}: got {value!r}, and {kinds[wanted]} is expected ({field.doc}).")
    if wanted is int and field.min is not None and value < field.min:  # now: build() counts with it
        raise ParameterError(f"{where} = {value} is below its minimum {field.min:g} ({field.doc}).")
    return value


class Assembly(Component):
    """An empty component to compose a model in."""

    def __init__(self, title: str = "model", **modifiers: Any):
        object.__setattr__(self, "title", title)
        super().__init__(**modifiers)
