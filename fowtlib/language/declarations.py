"""The typed fields of a component class: param, var, port, part, outer.

A field is a descriptor. While the model is flattened it gives the CasADi symbol of the instance; at any other time a
parameter gives its value or a reference to it, a port gives a reference for `connect`.
"""

from __future__ import annotations

import copy
import os
from collections.abc import Callable, Sequence
from itertools import count, takewhile
from typing import TYPE_CHECKING, Any, Generic, Literal, TypeVar, get_args, get_origin

from fowtlib.language.errors import ParameterError, StructureError
from fowtlib.language.expressions import Arithmetic, ParameterReference
from fowtlib.language.matrix_forms import Form

T = TypeVar("T")

if TYPE_CHECKING:
    from fowtlib.language.typed import Array, Data, Matrix, Number, Scalar, Vector
else:

    class Scalar:
        """One real number."""

    class Vector:
        """Three real numbers, a column."""

    class Matrix:
        """Nine real numbers, 3 x 3."""

    class Array:
        """Real numbers of the declared shape."""

    class Data(Generic[T]):
        """What is read from a data file: `Data[BeamProperties]`; given as the path of a file, or as an object."""

    Number = float  # one real number that is no symbol; an editor and a type checker accept a text with a unit for it


class Withheld:
    """Stands for a parameter that equations() must not see."""

    def __init__(self, reason: str):
        self.reason = reason


SHAPES: dict[type, tuple[int, ...] | None] = {Scalar: (), Vector: (3,), Matrix: (3, 3), Array: None}
STATE_PREFERENCES = ("never", "avoid", "default", "prefer", "always")
REQUIRED: Any = type("Required", (), {"__repr__": lambda self: "REQUIRED"})()


class Field:
    """What the declarations have in common: a name, an owner class, an annotation, a sentence."""

    doc: str
    name: str = "?"
    owner: type | None = None
    annotation: Any = None

    def __set_name__(self, owner: type, name: str) -> None:
        self.owner, self.name = owner, name

    def outside(self, component: Any) -> Any:
        """What the attribute gives outside of flattening."""
        return self

    def __deepcopy__(self, memo: Any) -> Field:
        return self  # a declaration belongs to its class

    def __get__(self, component: Any, owner: type | None = None) -> Any:
        if component is None:
            return self
        binding = component.__dict__.get("_binding")
        if binding is not None:
            value = binding[self.name]
            if isinstance(value, Withheld):
                raise StructureError(value.reason)
            return value
        return self.outside(component)

    def __set__(self, component: Any, value: Any) -> None:
        component.assign(self, value)


class Parameter(Field, Arithmetic):
    """Declaration of a parameter; arithmetic on it in the class body makes modifiers of parts."""

    def __init__(
        self, default: Any, unit: str, doc: str, minimum: Any, maximum: Any, shape: Any, structural: bool | str,
        choices: Any, bound: bool = False, instead_of: tuple[str, ...] = (), native: bool = False,
        form: Form | None = None,
    ):  # fmt: skip
        self.form = form
        self.instead_of = instead_of
        self.default, self.unit, self.doc = default, unit, doc
        self.min, self.max, self.shape, self.choices = minimum, maximum, shape, choices
        self.structural, self._why = bool(structural), structural if isinstance(structural, str) else ""
        self.bound, self.native = bound, native

    @property
    def why_structural(self) -> str:
        """Why a built model cannot be given another value; empty for a tunable or a bound parameter."""
        if self.tunable or self.bound:
            return ""
        kinds = {int: "it counts parts or states", bool: "it switches equations", str: "it chooses equations or data"}
        return self._why or kinds.get(self.annotation, "the model is built with it")

    @property
    def tunable(self) -> bool:
        """A symbol of the flat model, changed without flattening again."""
        return not self.structural and not self.bound and self.annotation in SHAPES

    @property
    def required(self) -> bool:
        return self.default is REQUIRED

    @property
    def is_data(self) -> bool:
        """A data file, or what is read from it."""
        return isinstance(self, DataParameter)

    def outside(self, component: Any) -> Any:
        if self.tunable or (self.bound and self.annotation in SHAPES):
            return ParameterReference(component, self.name)
        return component.parameter_value(self.name)

    def __repr__(self) -> str:
        return self.name


class DataParameter(Parameter):
    """Declaration of a data file, or of what is read from it; the attribute of a component gives what is read."""

    def __init__(self, reader: Callable[..., Any], default: Any, doc: str, using: tuple[str, ...]):
        super().__init__(default, "1", doc, None, None, None, True, None)
        self.reader, self.using = reader, using

    def read(self, component: Any, given: Any) -> Any:
        """What a given value stands for: a file is read, an object is itself."""
        if not isinstance(given, (str, os.PathLike)) or given == "":
            return None if given == "" else given
        more = []
        for name in self.using:
            declared = component.parameters[name]
            value = component.parameter_binding(name) if declared.is_data else component.parameter_value(name)
            if value is None:
                raise ParameterError(f"{join(component.label, name)} has no value: {declared.doc}.")
            more.append(value)
        return self.reader(os.fspath(given), *more)

    def checked(self, value: Any, where: str) -> Any:
        """The value, which must be the path of a file or an object of the annotated class."""
        if value is None and self.default is None:
            return value
        wanted = next((item for item in get_args(self.annotation)), object)
        wanted = get_origin(wanted) or wanted
        if isinstance(value, (str, os.PathLike)):
            return os.fspath(value)
        if isinstance(wanted, type) and not isinstance(value, wanted):
            raise ParameterError(
                f"{where} is a {type(value).__name__}; the path of a file or a {wanted.__name__} is expected "
                f"({self.doc})."
            )
        return value


class Variable(Field):
    """Declaration of a variable: an unknown of the equations."""

    def __init__(self, unit: str, doc: str, hint: str, shape: Any, start: Any, fixed: bool | None, state: str,
                 nominal: Any, minimum: Any, maximum: Any, discrete: bool):  # fmt: skip
        if state not in STATE_PREFERENCES:
            raise ValueError(f"var(state={state!r}): choose one of {', '.join(STATE_PREFERENCES)}")
        self.unit, self.doc, self.hint, self.shape, self.start = unit, doc, hint, shape, start
        self.fixed, self.state, self.nominal, self.min, self.max = fixed, state, nominal, minimum, maximum
        self.discrete = discrete

    def outside(self, component: Any) -> VariableReference:
        return VariableReference(component, self.name)


class VariableReference:
    """A variable of a component instance, by path: for outputs, start values and results."""

    def __init__(self, component: Any, name: str):
        self.component, self.name = component, name

    @property
    def path(self) -> str:
        return join(self.component.path, self.name)

    def __repr__(self) -> str:
        return self.path

    __str__ = __repr__


class Port(Field):
    """Declaration of a connector of a component."""

    def __init__(self, size: Any, optional: bool, doc: str, unit: str, shape: Any, default: Any):
        self.size, self.optional, self.doc, self.unit, self.shape, self.default = (
            size,
            optional,
            doc,
            unit,
            shape,
            default,
        )

    def outside(self, component: Any) -> PortReference:
        return PortReference(component, self)


class PortReference:
    """A port of a component instance, to be given to `connect`."""

    def __init__(self, component: Any, field: Port, index: int | None = None):
        self.component, self.field, self.index = component, field, index

    @property
    def path(self) -> str:
        return join(self.component.path, self.label)

    @property
    def label(self) -> str:
        return self.field.name if self.index is None else f"{self.field.name}[{self.index}]"

    def __len__(self) -> int:
        size = self.component.port_size(self.field)
        if size is None:
            raise TypeError(f"{self.path} is one port, not an array of ports")
        return size

    def __bool__(self) -> bool:
        return True

    def __getitem__(self, index: int) -> PortReference:
        from fowtlib.language.errors import ConnectionFault

        size = self.component.port_size(self.field)
        if size is None or self.index is not None:
            raise ConnectionFault(f"{self.path} is one port, not an array of ports; connect it without an index.")
        if not -size <= index < size:
            raise ConnectionFault(f"{self.path}[{index}]: the array has {size} ports, counted from 0.")
        return PortReference(self.component, self.field, index % size)

    def __iter__(self):
        return (self[i] for i in range(len(self)))

    def __repr__(self) -> str:
        return self.path


class Part(Field):
    """Declaration of a part that every instance of the class has.

    Another may take its place: of the class that the annotation names, or with the same ports.
    """

    names: dict[str, Any] = {}  # what the annotation may name

    def __init__(self, component_class: type, modifiers: dict[str, Any], doc: str):
        self.component_class, self.modifiers, self.doc = component_class, modifiers, doc

    def make(self, owner: Any) -> Any:
        """The part as the class declares it, for one instance of the class."""
        return self.component_class(**{name: owner.resolve(value) for name, value in self.modifiers.items()})

    @property
    def base(self) -> type:
        """The class within which the part may be replaced: that of the annotation, else the declared one."""
        if isinstance(self.annotation, str):
            try:
                self.annotation = eval(self.annotation, self.names)
            except NameError:  # imported for type checkers only
                self.annotation = None
        found = self.annotation
        return found if isinstance(found, type) and issubclass(self.component_class, found) else self.component_class

    def __get__(self, component: Any, owner: type | None = None) -> Any:
        return self if component is None else component.parts[self.name]


class PartArray(Field):
    """Declaration of equal parts, as many as a parameter says: `<stem>_1`, `<stem>_2`, ..."""

    def __init__(self, component_class: type, size: Any, stem: str, each: Any, modifiers: dict[str, Any], doc: str):
        self.component_class, self.size, self.stem, self.doc = component_class, size, stem, doc
        self.each, self.modifiers = each, modifiers

    def count(self, owner: Any) -> int:
        """Number of parts in one instance of the class."""
        size = owner.parameter_value(self.size) if isinstance(self.size, str) else owner.resolve(self.size)
        return int(size)

    def names(self, owner: Any) -> list[str]:
        """Their names."""
        return [f"{self.stem}_{i + 1}" for i in range(self.count(owner))]

    def make(self, owner: Any, i: int) -> Any:
        """Part number i, counted from 0, as the class declares it."""
        own = self.each(owner, i) if self.each is not None else {}
        return self.component_class(**{name: owner.resolve(value) for name, value in self.modifiers.items()}, **own)

    def __get__(self, component: Any, owner: type | None = None) -> Any:
        return self if component is None else Parts(component, self)


class Parts(Sequence[Any]):
    """The parts of an array as they are now; one of them is replaced by assignment to its number."""

    def __init__(self, owner: Any, declared: PartArray):
        self.owner, self.declared = owner, declared

    @property
    def names(self) -> list[str]:
        """The names under which the owner has them."""
        known, stem = self.owner.current.parts, self.declared.stem
        return list(takewhile(known.__contains__, (f"{stem}_{i}" for i in count(1))))

    def __len__(self) -> int:
        return len(self.names)

    def __getitem__(self, index: Any) -> Any:
        parts = [self.owner.current.parts[name] for name in self.names]
        return parts[index]

    def __setitem__(self, index: int, component: Any) -> None:
        self.owner.current.add(self.names[index], component)

    def __repr__(self) -> str:
        return repr(list(self))


class Outer(Field):
    """Declaration of a component that is found in an enclosing component (Modelica's inner and outer), or of all."""

    def __init__(self, component_class: type | None, optional: bool, many: bool, doc: str):
        self.component_class, self.optional, self.many, self.doc = component_class, optional, many, doc

    def outside(self, component: Any) -> Any:
        return component.find_outer(self)


# `init` tells type checkers that the constructor does not take the field; it has no other meaning (PEP 681).


def param(default: Any = REQUIRED, *, unit: str = "1", doc: str = "", min: Any = None, max: Any = None,
          shape: Any = None, structural: bool | str = False, choices: Any = None,
          bound: bool = False, instead_of: tuple[str, ...] = (), native: bool = False,
          form: Form | None = None) -> Any:  # fmt: skip
    """Declare a parameter, in SI `unit`; annotated Scalar, Vector, Matrix or Array it is tunable unless `structural`.

    `structural` may be a text that says why it is, in the words that complete "structural: ...". A `bound` one is read
    when a run starts: a text, a file, a seed, a choice, a number that data are computed from. It changes no equation,
    and equations() cannot see it; the functions given to `at_start` and `run_time_series` can. A `native` one is the
    path of a file whose code is run: a model file that names it needs the leave of the user; see `leave`.

    instead_of: parameters that it makes void where it is given. Both in one place are an error; of two places, as of a
    model file and of what a run changes in it, the later one counts.
    form: what a matrix must be; see matrix_forms.

    `default`, like any modifier, may be a number, a sequence, a string with a unit, another parameter of the class
    body, arithmetic on those, or a function of the component. Without a default the parameter is required.
    """
    if structural and bound:
        raise ValueError("a parameter is structural (it decides about parts and equations) or bound, not both")
    return Parameter(default, unit, doc, min, max, shape, structural, choices, bound, instead_of, native, form)


def like(declared: Any, *, default: Any = None, doc: str = "") -> Any:
    """Declare a parameter as another one is, perhaps with another default or sentence.

    `hinges: int = like(BeamSettings.hinges, default=6)` where a class derived from a record starts at another number;
    `blade_hinges: int = like(FlexibleBlade.hinges)` where a composite has it for its parts. A default that is a formula
    or a function reads the parameters of the new class.
    """
    if not isinstance(declared, Parameter):
        raise TypeError(f"like() takes a parameter of a class, as in like(BeamSettings.hinges), not {declared!r}")
    field = copy.copy(declared)
    field.default = declared.default if default is None else default
    field.doc = doc or declared.doc
    return field


def data(reader: Callable[..., Any], *, default: Any = REQUIRED, doc: str = "", using: tuple[str, ...] = ()) -> Any:
    """Declare a parameter that is a data file.

    `properties: Data[BeamProperties] = data(read_beam)` takes the path of a file, which `reader(path, ...)` reads, or
    an object of the class in brackets; the attribute gives the object either way. using: names of parameters that the
    reader takes behind the path, in this order; of those that are data themselves, what was given. Results and FMUs
    name the file with the digest of its content. A reader that is `remembered` (data_files) gives the same object until
    the content changes.
    """
    return DataParameter(reader, default, doc, using)


def var(*, unit: str = "1", doc: str = "", hint: str = "", shape: Any = None, start: Any = None,
        fixed: bool | None = None, state: str = "default", nominal: Any = None, min: Any = None, max: Any = None,
        discrete: bool = False, init: Literal[False] = False) -> Any:  # fmt: skip
    """Declare an unknown. `state` is the wish to be a state: never, avoid, default, prefer, always.

    `hint` is what to look at when the variable comes out undetermined; `discrete` variables change only at events and
    samples.
    """
    return Variable(unit, doc, hint, shape, start, fixed, state, nominal, min, max, discrete)


def port(*, size: Any = None, optional: bool = False, doc: str = "", unit: str = "1", shape: Any = None,
         default: Any = None, init: Literal[False] = False) -> Any:  # fmt: skip
    """Declare a connector; its class is the annotation. `size` makes an array of ports.

    For signals: `unit`, `shape`, and `default`, the value of an input that nothing drives (None: it must be connected).
    """
    return Port(size, optional, doc, unit, shape, default)


def part(component_class: type, *, doc: str = "", **modifiers: Any) -> Any:
    """Declare a part; `modifiers` are its parameters, and may be arithmetic on the parameters above."""
    return Part(component_class, modifiers, doc)


def parts(component_class: type, *, size: Any, name: str, each: Callable[[Any, int], dict[str, Any]] | None = None,
          doc: str = "", **modifiers: Any) -> Any:  # fmt: skip
    """Declare an array of equal parts.

    `lines: list[Line] = parts(Line, size="n_lines", name="line", length=length)`: they are `line_1`, `line_2`, ... in
    paths, and `self.lines[0]`, `self.lines[1]`, ... in Python. size: a parameter, a number or a function of the
    component. `modifiers` are the same for all; each(component, number) gives those that differ, counted from 0:
    `each=lambda self, k: {"azimuth": 2 * pi * k / self.blades}`. One of the parts is replaced as any part; the
    constructor also takes a whole list of them.
    """
    return PartArray(component_class, size, name, each, modifiers, doc)


def outer(component_class: type | None = None, *, optional: bool = False, many: bool = False, doc: str = "",
          init: Literal[False] = False) -> Any:  # fmt: skip
    """Declare a use of the nearest part of this class in an enclosing component; two equally near are an error.

    many: all components of the class in the whole model, in the order of the tree, perhaps none:
    `towers: list[TowerFlow] = outer(TowerFlow, many=True)`. A collection finds its members; no user keeps a list.
    """
    if many and component_class is None:
        raise ValueError("outer(many=True) needs the class of its members: outer(TowerFlow, many=True)")
    return Outer(component_class, optional, many, doc)


def join(path: str, name: str) -> str:
    """`path.name`, or `name` at the top."""
    return f"{path}.{name}" if path else name
