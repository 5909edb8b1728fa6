"""Component: the base class of everything a model is made of."""

from __future__ import annotations

import inspect
import math
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any, Self, dataclass_transform

import numpy as np

from fowtlib.language import expressions
from fowtlib.language.composition import OWN_NAMES, Composite
from fowtlib.language.declarations import (
    SHAPES,
    DataParameter,
    Field,
    Outer,
    Parameter,
    Part,
    PartArray,
    Port,
    Variable,
    data,
    join,
    outer,
    param,
    port,
    var,
)
from fowtlib.language.equations import active
from fowtlib.language.errors import (
    ModelError,
    NotFoundError,
    ParameterError,
    StructureError,
    UnusedParameterError,
    did_you_mean,
    one_of,
)
from fowtlib.language.facts import Fact
from fowtlib.language.families import Family
from fowtlib.language.names_of_all import refuse_names_of_all
from fowtlib.language.offered import OfferedEvent, event
from fowtlib.language.placing import placed
from fowtlib.language.shapes import Drawing
from fowtlib.language.units import check_si, to_si

MOST_ELEMENTS = 10_000  # of one array of ports, variables or parts


class UnknownAttribute(NotFoundError, AttributeError):
    """A name that a component does not have."""


# no part(): a part has a default
@dataclass_transform(kw_only_default=True, field_specifiers=(param, data, port, var, outer, event))
class Component(Composite):
    """A class of model parts: parameters, ports, variables, `equations()`.

    Keyword arguments of the constructor are parameters of the component, or parts that take the place of those that the
    class makes, declared or in `build()`. A composite adds parts and connections in `build()`.
    """

    parameters: dict[str, Parameter] = {}
    ports: dict[str, Port] = {}
    variables: dict[str, Variable] = {}
    declared_parts: dict[str, Part] = {}
    part_arrays: dict[str, PartArray] = {}
    outers: dict[str, Outer] = {}
    offered_events: dict[str, OfferedEvent] = {}

    family: Family | None = None

    void: tuple[str, ...] = ()
    """Parameters of its base class which a kind takes no notice of."""

    units_within: dict[str, Any] = {}
    """Units of parameters that a declaration cannot say: by element, or of a general block by its signals, "y/u".

    A function of the component where the elements are as many as it says. A check of dimensions takes what is named
    here for anything, variables too."""

    in_own_units: dict[str, str] = {}
    """Parameters with data that no scaled model can have, and why; under "" the component itself."""

    of_the_air: bool = False
    """Its speeds are those of the wind, which a scaled model may have in a proportion of its own."""

    def __init_subclass__(
        cls, *, selector: str = "", kind: str = "", shared: Sequence[str] = (), **kwargs: Any
    ) -> None:
        super().__init_subclass__(**kwargs)
        _resolve_annotations(cls, sys._getframe(1).f_locals)
        fields = [item for base in reversed(cls.__mro__) for item in vars(base).items() if isinstance(item[1], Field)]
        refuse_names_of_all(Component, cls, [name for name, _ in fields], sys._getframe(1))
        for field_class, table in _TABLES.items():
            setattr(cls, table, {name: value for name, value in fields if isinstance(value, field_class)})
        if selector:
            cls.family = Family(cls, selector, tuple(shared))
        elif kind:
            if cls.family is None:
                raise TypeError(f"{cls.__name__}: kind={kind!r}, but no class above it has a selector")
            cls.family.add(kind, cls)

    def __new__(cls, *_: Any, **modifiers: Any) -> Self:
        """`Wind(kind="steady")` makes an object of the class of that kind."""
        family = cls.family
        chosen = family.chosen(cls, modifiers) if family is not None else cls
        return object.__new__(chosen)

    def __init__(self, **modifiers: Any):
        self._binding: dict[str, Any] | None = None
        self._values: dict[str, Any] = {}
        self.origins: dict[str, str] = {}  # file and line of each given value, and under "" of the component itself
        modifiers = self._spread(modifiers)
        given = {name: value for name, value in modifiers.items() if self._is_part(name, value)}
        self._start(given)
        if self.family is not None:
            own = self.family.kind_of(type(self))
            kind_given = modifiers.pop(self.family.selector, None) is not None
            if own is not None and (kind_given or own != self.family.field.default):
                self._values[self.family.selector] = own
        for name, value in modifiers.items():
            if name not in given:
                self._set(name, value)
        self.refuse_void()
        self._compose()

    def _spread(self, modifiers: dict[str, Any]) -> dict[str, Any]:
        """The arguments of the constructor with lists of parts taken apart."""
        spread: dict[str, Any] = {}
        for name, value in modifiers.items():
            declared = self.part_arrays.get(name)
            if declared is None:
                spread[name] = value
            elif not isinstance(value, list | tuple) or not all(isinstance(one, Component) for one in value):
                raise ParameterError(f"{type(self).__name__}.{name} is an array of parts; give a list of components.")
            else:
                spread |= {f"{declared.stem}_{i + 1}": one for i, one in enumerate(value)}
        return spread

    def _is_part(self, name: str, value: Any) -> bool:
        return name in self.declared_parts or (isinstance(value, Component) and name not in self.parameters)

    # --- what authors override -----------------------------------------------------------------------------------

    def equations(self) -> list[Any]:
        """The statements of this component; called once, while the model is flattened."""
        return []

    def drawing(self) -> Drawing:
        """What pictures show of this component: see fowtlib.language.shapes. By default, what they show of its parts.

        Called outside of flattening: numbers come from `parameter_value`.
        """
        return [shape for part in self.parts.values() for shape in part.drawing()]

    def facts(self) -> Sequence[Fact]:
        """What the sheet of a model says of this component, without its parts: see fowtlib.language.facts.

        Called outside of flattening: numbers come from `parameter_value`.
        """
        return ()

    def remarks(self) -> list[str]:
        """Sentences that `fowt check` adds to its report: what one should know of this component as it stands here.

        Called outside of flattening, like `drawing`.
        """
        return []

    # --- parameters ----------------------------------------------------------------------------------------------

    def assign(self, field: Field, value: Any) -> None:
        """Attribute assignment: a parameter gets a value, a declared part is replaced."""
        if isinstance(field, Parameter):
            self._set(field.name, value)
        elif isinstance(field, Part) and isinstance(value, Component):
            self.current.add(field.name, value)
        elif isinstance(field, PartArray):
            raise ParameterError(f"{self.label}.{field.name} is an array of parts; assign to one of them: [0].")
        elif isinstance(field, Part):
            raise ParameterError(f"{self.label}.{field.name} is a part, and {value!r} is no Component.")
        else:
            raise ParameterError(f"{self.label}.{field.name} is not a parameter and cannot be set.")

    def _set(self, name: str, value: Any) -> None:
        here = self.current
        if here is not self:
            here._set(name, value)
            return
        if self.family is not None and name == self.family.selector:
            if self._composed:
                self._note(name)
            self.family.turn(self, value)
            return
        field = self.parameters.get(name)
        if field is None:
            raise self.no_parameter(name)
        value, before = self._checked(field, value), dict(self._values)
        if self._composed:
            self._note(name)
            for other in self.rivals(name):
                self._values.pop(other, None)
        self._values[name] = value
        decides = not (field.tunable or field.bound)
        if self._composed and (decides or name not in before):
            try:
                self._compose_again(name, decides)
            except BaseException:
                self._values = before
                self._compose()
                raise

    def set_together(self, values: Mapping[str, Any]) -> None:
        """Give several parameters their values at once, where each alone would not fit the others as they are now."""
        here, before = self.current, dict(self.current._values)
        try:
            for name, value in values.items():
                if name not in here.parameters or here.family is not None and name == here.family.selector:
                    raise here.no_parameter(name)
                here._values[name] = here._checked(here.parameters[name], value)
                here._note(name)
            here._compose_again(next(iter(values)), True)
        except BaseException:
            here._values = before
            here._compose()
            raise

    def no_parameter(self, name: str) -> ParameterError:
        """The error for a parameter that there is not, with what may have been meant."""
        if name in self.parts:
            return ParameterError(
                f"{join(self.path, name)} is a part, a {type(self.parts[name]).__name__}: give values to its "
                "parameters, or another component in its place."
            )
        hint = self.family.hint(name) if self.family is not None else ""
        return ParameterError(f"{self.label} has no parameter '{name}'{hint or did_you_mean(name, self.parameters)}")

    def _checked(self, field: Parameter, value: Any) -> Any:
        where = join(self.path or type(self).__name__, field.name)
        if isinstance(field, DataParameter):
            return field.checked(value, where)
        if expressions.is_expression(value):
            return value
        if value is None and (field.default is None or inspect.isfunction(field.default)):
            return None
        if field.annotation in SHAPES:
            numbers = to_si(value, field.unit, where)
            if SHAPES[field.annotation] == () and np.size(numbers) != 1:  # what is computed from it cannot check it
                shape = " x ".join(map(str, np.shape(numbers)))
                raise ParameterError(f"{where} has shape {shape}, and one number is expected ({field.doc}).")
            return numbers
        if field.annotation in (int, float, str, bool):
            return _plain(field, value, where)
        if field.annotation is list and field.unit != "1":
            return _quantities(field, value, where)
        return value

    def values_of(self, record: type[Component]) -> dict[str, Any]:
        """What this component's parameters of a record are set to: arguments for a part that has the record too.

        A record is a partial class with parameters only, from which those are derived that have them in common:
        `Beam(**self.values_of(BeamSettings))`.
        """
        return {name: getattr(self, name) for name in record.parameters}

    def parameter_value(self, name: str) -> Any:
        """The value a parameter has now, in SI units; an error where a required one is missing."""
        field = self.parameters[name]
        if field.bound and self._binding is not None:
            raise StructureError(self._binding[name].reason)
        found = (expressions.known_now() or {}).get((id(self), name))
        if found is not None and expressions.reads_now() is None:  # the way that is gone most, made short
            return found[0]
        return expressions.remembered((id(self), name), self, lambda: self._evaluated(field))

    def _evaluated(self, field: Parameter) -> Any:
        """The number of what a parameter is set to, an expression or not, or what data stand for; noted as read."""
        name, reads = field.name, expressions.reads_now()
        if reads is not None:
            reads.add((self.path, name))
        value = self.parameter_binding(name)
        if isinstance(field, DataParameter):
            return field.read(self, value)
        if field.annotation in SHAPES:
            if value is None:
                return None
            try:
                value = np.asarray(expressions.evaluate(value, combine=_stack), dtype=float)
            except ZeroDivisionError:
                doc = self.parameters[name].doc
                raise ParameterError(f"{join(self.path, name)} is not a finite number: {value!r} ({doc}).") from None
            if SHAPES[field.annotation] != ():
                return value
            if value.size != 1:
                raise ParameterError(
                    f"{join(self.path, name)} takes one number, and a list of {value.size} is given ({field.doc})."
                )
            return value.item()
        if field.annotation is list and expressions.is_expression(value):
            return _quantities(field, value, join(self.path, name))
        if expressions.is_expression(value):
            return _plain(self.parameters[name], expressions.evaluate(value), join(self.path, name))
        return value

    def parameter_binding(self, name: str) -> Any:
        """What a parameter is set to: a value, or an expression of other parameters."""
        here = self.current
        if here is not self and name in here.parameters:
            return here.parameter_binding(name)
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

    @classmethod
    def rivals(cls, name: str) -> tuple[str, ...]:
        """Parameters that a value of this one makes void, or that make it void."""
        others = (other for other, field in cls.parameters.items() if name in field.instead_of)
        return (*cls.parameters[name].instead_of, *others)

    def refuse_void(self) -> None:
        """ParameterError for values that were given in one place and do nothing beside each other, or for this kind."""
        for name, field in self.parameters.items():
            if field.instead_of and self._values.get(name) is not None:
                self.refuse_unused(*field.instead_of, because=f"{name} is given, which takes its place")
        if self.void and self.family is not None:
            kind = self.family.kind_of(type(self))
            self.refuse_unused(*self.void, because=f"the {self.family.selector} '{kind}' takes no notice of it")

    def refuse_unused(self, *names: str, because: str) -> None:
        """An error for a parameter that was given and would do nothing, since another one takes precedence."""
        for name in names:
            if self.is_set(name):
                where = f"{self.origins[name]}: " if name in self.origins else ""
                raise UnusedParameterError(
                    f"{where}{join(self.path or type(self).__name__, name)} is given and would do nothing, because "
                    f"{because}; leave one of them out, or change it."
                )

    def resolve(self, value: Any) -> Any:
        """A declared value for this instance: functions called, class-body parameters replaced by this instance's."""
        if inspect.isfunction(value):
            try:
                value = value(self)
            except ModelError as error:
                raise placed(error, self) from None
        return expressions.rebind(value, self)

    # --- what is around -------------------------------------------------------------------------------------------

    def find_outer(self, field: Outer) -> Any:
        """The nearest part of the field's class in an enclosing component; of a collection, all those of the model.

        Raises ParameterError where there is none, or where two are equally near.
        """
        wanted = field.component_class or field.annotation
        if field.many:
            return self._find_all(wanted)
        for enclosing in self.enclosing():
            found = [part for part in enclosing.parts.values() if isinstance(part, wanted) and part is not self]
            if len(found) > 1:
                raise ParameterError(
                    f"{self.label} needs one {wanted.__name__} as its '{field.name}', and there are "
                    f"{one_of([part.path for part in found], 'and')}; leave one, or put each beside what belongs to it."
                )
            if found:
                return found[0]
        if field.optional:
            return None
        raise ParameterError(
            f"{self.path or type(self).__name__} needs a {wanted.__name__}: "
            f"declare one in the model, for example under the name '{field.name}'."
        )

    def _find_all(self, wanted: type) -> list[Component]:
        """All components of a class in the whole model, but for this one, its parts and what it is a part of."""
        around = list(self.enclosing())
        left_out = {id(one) for one in (*around, *self.walk())}
        return [one for one in (around or [self])[-1].walk() if isinstance(one, wanted) and id(one) not in left_out]

    def port_size(self, field: Port) -> int | None:
        """Number of ports of an array of ports; None for a single port."""
        if field.size is None:
            return None
        size = self.parameter_value(field.size) if isinstance(field.size, str) else np.asarray(self.resolve(field.size))
        return self._counted(int(size), field)

    def shape_of(self, field: Variable | Port | Parameter) -> tuple[int, ...]:
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
        sizes = tuple(int(self.parameter_value(item)) if isinstance(item, str) else int(item) for item in shape)
        self._counted(math.prod(sizes), field)
        return sizes

    def _counted(self, elements: int, field: Field) -> int:
        """The number of elements of an array, which has a limit."""
        if elements > MOST_ELEMENTS and not isinstance(field, Parameter):
            raise ParameterError(
                f"{join(self.path, field.name) or field.name} has {elements} elements; the limit is {MOST_ELEMENTS}."
            )
        return elements

    def __setattr__(self, name: str, value: Any) -> None:
        if (
            isinstance(value, Component)
            and not name.startswith("_")
            and not isinstance(getattr(type(self), name, None), Field)
        ):
            self.current.add(name, value)
        elif name.startswith("_") or hasattr(type(self), name) or name in OWN_NAMES:
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
        known = [*parts, *self.parameters, *self.ports, *self.variables, *self.offered_events]
        raise UnknownAttribute(
            f"{self.label} has no part, port, parameter or variable '{name}'{did_you_mean(name, known)}"
        )

    def in_the_mean(self) -> dict[str, Any]:
        """Parameters of its own by name, bound or tunable, with which what it does in time stands still at its mean.

        A run that starts from a mean state starts from that of these; see solving.starts.
        """
        return {}

    def before_the_run(self) -> dict[str, Any]:
        """By their names, what stands for its `run_time_series` before the run where they do not say it themselves.

        A Series that repeats itself, with the changes about the mean, in place of one that is none; None: nobody knows.
        A stationary start takes it; see solving.stationary.
        """
        return {}

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

    def walk(self) -> Iterator[Component]:
        """The component and all parts below it, parents first."""
        left: list[Component] = [self]
        while left:
            component = left.pop()
            yield component
            left.extend(reversed(component.parts.values()))

    def find(self, path: str) -> Component:
        """The component at a path below this one."""
        component: Component = self
        for name in path.split(".") if path else ():
            if name not in component.parts:
                raise NotFoundError(f"{component.label} has no part '{name}'{did_you_mean_part(name, component)}")
            component = component.parts[name]
        return component

    def __repr__(self) -> str:
        return f"<{type(self).__name__} {self.path}>" if self.path else f"<{type(self).__name__}>"


def did_you_mean_part(name: str, component: Component) -> str:
    """The end of a message about a part that a component lacks: parts of this very name further down come first."""
    within = f"{component.path}." if component.path else ""
    below = [part.path.removeprefix(within) for part in component.walk() if part.path.rpartition(".")[2] == name]
    if 0 < len(below) <= 3:
        return f"; did you mean {one_of(below)}?"
    return did_you_mean(name, component.parts)


_TABLES: dict[type, str] = {
    Parameter: "parameters", Port: "ports", Variable: "variables", Part: "declared_parts", Outer: "outers",
    PartArray: "part_arrays", OfferedEvent: "offered_events",
}  # fmt: skip


def _resolve_annotations(cls: type, local_names: dict[str, Any]) -> None:
    """Give each field the class that its annotation names; under `from __future__ import annotations` that is text."""
    module = vars(sys.modules[cls.__module__]) if cls.__module__ in sys.modules else {}
    annotations = vars(cls).get("__annotations__", {})
    for name, value in vars(cls).items():
        if isinstance(value, Part):
            value.annotation = annotations.get(name)
            value.names = {**module, **local_names}
            continue
        if not isinstance(value, Field):
            continue
        annotation = annotations.get(name)
        if annotation is None:
            raise TypeError(f"{cls.__name__}.{name} has no annotation; write for example `{name}: Scalar = ...`")
        if isinstance(annotation, str):
            annotation = eval(annotation, {**module, **local_names})
        value.annotation = annotation
        check_si(value.unit if isinstance(value, (Parameter, Port, Variable)) else "1", f"{cls.__name__}.{name}")


def _stack(items: list[Any]) -> np.ndarray:
    return np.asarray([np.asarray(item, dtype=float) for item in items])


def _quantities(field: Parameter, value: Any, where: str) -> list[Any]:
    """The numbers of a list that may hold quantities and expressions, or lists of them."""
    found = _listed(field, value, where)
    if not isinstance(found, list):
        raise ParameterError(f"{where}: a list is expected ({field.doc}), not {found!r}.")
    return found


def _listed(field: Parameter, value: Any, where: str) -> Any:
    if isinstance(value, (list, tuple)):
        return [_listed(field, item, where) for item in value]
    if isinstance(value, str) and field.unit != "1":
        return float(to_si(value, field.unit, where))
    value = expressions.evaluate(value)
    return value.tolist() if isinstance(value, (np.ndarray, np.generic)) else value


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
    if wanted is int and not field.bound and field.max is None and abs(value) > MOST_ELEMENTS:
        raise ParameterError(
            f"{where} = {value} is above {MOST_ELEMENTS}, the limit of numbers that decide how a model is built "
            f"({field.doc})."
        )
    return value


class Assembly(Component):
    """An empty component to compose a model in."""

    def __init__(self, title: str = "model", **modifiers: Any):
        object.__setattr__(self, "title", title)
        super().__init__(**modifiers)
