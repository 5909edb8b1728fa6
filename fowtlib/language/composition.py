"""How a component gets its parts: those that its class makes, those that take their place, and those that are added.

A class makes parts by declaration and in `build()`. A part that is given, to the constructor or by assignment, takes
the place of the one that the class makes, if it fits there; then the class composes itself anew around it, and whatever
`build()` reads of its parts or joins to them is that of the part which stands there. A component that was made anew
stands for its successor: references to it (connections, formulas) and values set in it go to what is at its place now.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from fowtlib.language.connectors import Connector, RealInput, Signal
from fowtlib.language.declarations import Part, Port, PortReference, Variable, join
from fowtlib.language.equations import source_line
from fowtlib.language.errors import ConnectionFault, NotFoundError, ParameterError, did_you_mean, one_of
from fowtlib.language.units import dimension

Component = Any  # the class is derived from the one below
OWN_NAMES = {"origins", "parts", "connections"}
AnyPort = PortReference | Connector | Signal  # what a port is outside of equations, and how it is declared
_NOTHING: Any = type("Nothing", (), {})  # a class, which is itself in a copy


class Composite:
    """The part of a Component that keeps its parts and connections."""

    # Given by Component.
    parameters: dict[str, Any]
    ports: dict[str, Port]
    variables: dict[str, Variable]
    declared_parts: dict[str, Part]
    part_arrays: dict[str, Any]
    outers: dict[str, Any]
    family: Any
    label: str
    path: str
    origins: dict[str, str]
    _values: dict[str, Any]

    def _start(self, given: dict[str, Component]) -> None:
        """Before anything is composed; `given` are parts in place of those that the class makes."""
        self._parent: Component | None = None
        self._name = ""
        self.parts: dict[str, Component] = {}
        self.connections: list[tuple[PortReference, PortReference, str]] = []
        self._given = given
        self._added: dict[str, Component] = {}  # further parts, that the class does not make
        self._composed = self._composing = False
        self._successor_at_place = False  # made anew, or replaced: what stands at this place now is another
        self._made_connections = 0
        self._later: set[str] = set()  # parameters and parts set from outside, after this component was made
        self._by_owner: dict[str, tuple[Any, Any]] = {}  # values that an owner's build() set: owner, value before
        self._predecessors: dict[str, Component] = {}

    def build(self) -> None:
        """Add parts and connections (composites only)."""

    # --- what authors and users call -----------------------------------------------------------------------------

    def add(self, name: str, component: Component) -> Component:
        """Add a part under a name, or put it in the place of the one there; returns the part that stands there.

        In `build()` that is a part which the user gave for this place, if there is one.
        """
        if not _is_component(component):
            raise ParameterError(f"{self.label}.{name}: a part is a Component, not {component!r}.")
        self._check_new(name, "part")
        if self._composing:
            return self._make(name, component)
        if name in self.parts:
            self._replace(name, component)
        else:
            self._put(name, component)
            self._added[name] = component
            if not self._in_build():
                self._later.add(name)
        return component

    def connect(self, a: AnyPort, b: AnyPort) -> None:
        """Join two ports of this component or of its parts."""
        ends: list[Any] = [a, b]
        for end in ends:
            if not isinstance(end, PortReference):
                raise ConnectionFault(f"{self.label}: connect() joins two ports, and {end!r} is not a port.")
            if end.component is not self and self not in end.component.enclosing():
                raise ConnectionFault(
                    f"{self.label}: {end.path} is not a port of this component or of a part below it; "
                    "connect it where it belongs, after the part was added."
                )
            check_there(end)
        self.connections.append((ends[0], ends[1], source_line()))

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

    @property
    def current(self) -> Component:
        """The component at this place: itself, or the one that was made or given in its stead."""
        one: Any = self
        while one is not None and not one._successor_at_place:
            one = one._parent
        if one is None or self._parent is None:
            return self  # type: ignore[return-value]
        parts = self._parent.current.parts
        if self._name not in parts:
            raise NotFoundError(f"{self.path} is there no more: {self._parent.current.label} was composed anew.")
        return parts[self._name]

    # --- composing -----------------------------------------------------------------------------------------------

    def _compose(self) -> None:
        """Make the declared parts, and those of build(), around those that are given."""
        before = {key: self.__dict__.get(key, _NOTHING) for key in _STATE}
        own = self.connections[self._made_connections :]  # from outside
        stay = (*self._given.values(), *self._added.values())
        old = {name: part for name, part in self.parts.items() if part not in stay}
        self.parts, self.connections, self._composing, self._predecessors = {}, [], True, dict(old)
        for table in ("ports", "variables", "_declared"):  # what an earlier build() has declared
            self.__dict__.pop(table, None)
        try:
            taken = self._take_back()
            for name, declared in self.declared_parts.items():
                given = self._given.get(name)
                self._make(name, declared.make(self) if given is None else given, declared.base)
            for array in self.part_arrays.values():
                for i, name in enumerate(array.names(self)):
                    given = self._given.get(name)
                    self._make(name, array.make(self, i) if given is None else given, array.component_class)
            self.build()
            for one, name in taken:
                if name not in one._by_owner:
                    one._compose()  # build() sets it no more
            self._check_all_used(old)
        except BaseException:
            for key, value in before.items():
                self.__dict__.pop(key, None)
                self.__dict__.update({key: value} if value is not _NOTHING else {})
            self._hold_parts()
            raise
        finally:
            self._composing, self._predecessors = False, {}
        self._composed, self._made_connections = True, len(self.connections)
        for part in old.values():
            _retire(part)
        for name, part in self._added.items():
            self._put(name, part)
        self.connections += own

    def _compose_again(self, name: str, structural: bool) -> None:
        """A parameter that may decide about parts has changed after they were made."""
        try:
            if type(self).build is not Composite.build or self.declared_parts or self.part_arrays:
                self._compose()
        except _HandedDown as error:
            raise ParameterError(
                f"{self.label}.{name} decides how {self.label} is built, and with its new value there is no "
                f"'{error.path.removeprefix(f'{self.path}.')}', which was given a value before; set {name} first."
            ) from None
        if structural:
            self._tell_owners()

    def _tell_owners(self) -> None:
        """The composites around read their parts in build(); they are made anew, unless one is being made right now."""
        for owner in list(self.enclosing()):
            if owner._composing:
                return
            if type(owner).build is not Composite.build:
                owner._compose()

    def _make(self, name: str, component: Component, base: type | None = None) -> Component:
        """A part that the class makes, or the one that was given for its place."""
        given = self._given.get(name)
        if given is None:
            for one in component.walk():
                one._later.clear()  # what build() set, it sets again
        else:
            if component is not given:
                component._parent, component._name, component._successor_at_place = self, name, True  # type: ignore
            check_fits(given, base or type(component), f"{self.label}.{name}")
            if given._parent is not self:
                given._later.clear()
            component = given
        self._put(name, component)
        if (old := self._predecessors.get(name, component)) is not component:
            component._inherit(old)
        return component

    def _put(self, name: str, component: Component) -> Component:
        owner = component._parent
        if owner is not None and not component._successor_at_place and (owner is not self or component._name != name):
            raise ParameterError(
                f"{component.path} is a part already; make a second {type(component).__name__} instead."
            )
        component._parent, component._name, component._successor_at_place = self, name, False  # type: ignore
        self.parts[name] = component
        return component

    def _replace(self, name: str, component: Component) -> None:
        """Put a part in the place of one that is there."""
        old = self.parts[name]
        if component is old:
            return
        for owner in (self, *self.enclosing()):
            for a, b, _ in owner.connections[owner._made_connections :]:
                for end in (a, b):
                    if end.component.current is old and end.field.name not in component.ports:
                        raise ConnectionFault(
                            f"{type(component).__name__} cannot take the place of {old.path}, a {type(old).__name__}: "
                            f"it has no port '{end.field.name}', which is connected."
                        )
        if name in self._added:
            self._put(name, component)
            self._added[name] = component
        else:
            before, later = dict(self._given), set(self._later)
            self._given[name] = component
            self._later |= set() if self._in_build() else {name}
            try:
                self._compose()
                self._tell_owners()
            except BaseException:
                self._given, self._later = before, later
                self._compose()
                component._parent = None
                raise
        _retire(old)

    def _inherit(self, old: Component) -> None:
        """Take over what the predecessor at this place got from outside: values and parts, at any depth."""
        if not any(one._later for one in old.walk()):
            return
        family = self.family
        if family is not None and family.selector in old._later:
            family.turn(self, old._values[family.selector])
        for name in sorted(old._later):
            if name in old.parts:
                kind = self._given if name in old._given else self._added
                kind[name] = old.parts[name]
                old.parts[name]._successor_at_place = True  # it moves
            elif name in self.parameters:
                self._values[name] = old._values[name]
                self.origins.update({name: old.origins[name]} if name in old.origins else {})
            else:
                raise _HandedDown(join(self.path, name))
        self._later |= old._later
        self.connections += old.connections[old._made_connections :]
        kept = dict(self.parts)
        self.parts = {name: part for name, part in old.parts.items() if part not in self._added.values()}
        try:
            self._compose()
        finally:
            for part in kept.values():
                if part is not self.parts.get(part._name):
                    _retire(part)

    def _hold_parts(self) -> None:
        """Parts that had moved to a component that is given up are at home again."""
        for owner in self.walk():  # type: ignore[attr-defined]
            for name, part in owner.parts.items():
                part._parent, part._name, part._successor_at_place = owner, name, False

    def _check_all_used(self, old: dict[str, Component]) -> None:
        """Refuse to lose a part that was given, or what a part that is made no more had got from outside."""
        for name, given in self._given.items():
            if name not in self.parts:
                raise ParameterError(
                    f"{self.label} makes no part '{name}' that a {type(given).__name__} could take the place of"
                    f"{did_you_mean(name, self.parts)}"
                )
        for name, part in old.items():
            if name not in self.parts:
                for one in part.walk():
                    for lost in sorted(one._later):
                        raise _HandedDown(join(one.path, lost))

    def _take_back(self) -> list[tuple[Component, str]]:
        """Undo what the last build() set in parts that are given and stay."""
        taken = []
        for given in self._given.values():
            for one in given.walk():
                mine = {name: value for name, (owner, value) in one._by_owner.items() if owner is self}
                for name, value in mine.items():
                    one._values.pop(name, None)
                    one._values.update({name: value} if value is not _NOTHING else {})
                    del one._by_owner[name]
                    taken.append((one, name))
        return taken

    def _note(self, name: str) -> None:
        """Before a parameter changes after composition: remember who sets it."""
        owner = next((one for one in self.enclosing() if one._composing), None)
        if owner is None:
            self._by_owner.pop(name, None)
            self._later.add(name)
        elif name not in self._by_owner:
            self._by_owner[name] = (owner, self._values.get(name, _NOTHING))

    def _in_build(self) -> bool:
        return any(one._composing for one in (self, *self.enclosing()))

    def _check_new(self, name: str, kind: str) -> None:
        if not name.isidentifier() or name.startswith("_"):
            raise ParameterError(f"{self.label}: '{name}' is not a name; use letters, digits and underscores.")
        if any(name in table for table in (self.parameters, self.ports, self.variables, self.outers)):
            raise ParameterError(f"{self.label}.{name} is declared already and cannot be a {kind}.")
        if hasattr(_component(type(self)), name) or name in OWN_NAMES:
            raise ParameterError(
                f"{self.label}: a {kind} cannot be called '{name}', which every component has already."
            )

    def enclosing(self) -> Iterator[Component]:
        """The components that this one is a part of, from the nearest to the top."""
        parent = self._parent
        while parent is not None:
            yield parent
            parent = parent._parent


_STATE = (
    "parts", "connections", "ports", "variables", "_declared", "_composed", "_made_connections",
)  # fmt: skip


class _HandedDown(ParameterError):
    """What was set in a part that is made no more."""

    def __init__(self, path: str):
        super().__init__(f"'{path}' was given a value before, and as the model is built now it is not there.")
        self.path = path


def check_fits(component: Component, base: type, place: str) -> None:
    """Refuse a part that cannot stand where a `base` is: neither one of them, nor with the ports that one must have."""
    if isinstance(component, base):
        return
    needed = {
        name: field
        for name, field in base.ports.items()
        if not field.optional and not (field.annotation is RealInput and field.default is not None)
    }
    missing = [name for name in needed if name not in component.ports]
    other = [
        name
        for name, field in needed.items()
        if name not in missing and component.ports[name].annotation is not field.annotation
    ]
    kind = type(component).__name__
    lead = f"{kind} cannot take the place of {place}, a {base.__name__}: "
    if not needed:
        raise ParameterError(f"{lead}only a {base.__name__} can, or a class derived from it.")
    if missing:
        raise ParameterError(f"{lead}it has no port {one_of(missing, 'and')}.")
    if other:
        has = component.ports[other[0]].annotation.__name__
        wanted = needed[other[0]].annotation.__name__
        raise ParameterError(f"{lead}its port '{other[0]}' is a {has}, not a {wanted}.")


def check_there(end: PortReference) -> PortReference:
    """The reference to the port that stands at this place now. Raises ConnectionFault where there is none."""
    try:
        component = end.component.current
    except NotFoundError as error:
        raise ConnectionFault(str(error)) from None
    if component is end.component:
        return end
    field = component.ports.get(end.field.name)
    if field is None:
        raise ConnectionFault(
            f"{component.path}, a {type(component).__name__}, has no port '{end.field.name}'"
            f"{did_you_mean(end.field.name, component.ports)}"
        )
    size = component.port_size(field)
    if end.index is not None and (size is None or end.index >= size):
        has = "one port, not an array of ports" if size is None else f"an array of {size} ports"
        raise ConnectionFault(f"{join(component.path, field.name)}[{end.index}]: this is {has}.")
    return PortReference(component, field, end.index)


def _retire(component: Component) -> None:
    """Another stands at the place of this one now."""
    owner = component._parent
    if owner is not None and owner.parts.get(component._name) is not component:
        component._successor_at_place = True


def _is_component(value: Any) -> bool:
    return isinstance(value, Composite)


def _component(cls: type) -> type:
    """The class that all components are derived from."""
    return next(parent for parent in reversed(cls.__mro__) if issubclass(parent, Composite) and parent is not Composite)
