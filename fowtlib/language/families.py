"""Families of component classes: kinds of one thing that share its equations, and differ in data only.

`class Wind(Component, selector="kind")` declares the family and the parameter that names the kind;
`class SteadyWind(Wind, kind="steady")` adds a kind. `Wind(kind="steady")` makes a SteadyWind, and so does a model file;
a part of a family may be replaced by another kind when a run starts.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from fowtlib.language.declarations import Parameter
from fowtlib.language.errors import ParameterError, did_you_mean


class Family:
    """The kinds of a base class.

    selector: its parameter that names the kind; shared: methods whose result other parts write into their equations, so
    that a kind with its own cannot take the place of another in a compiled model.
    """

    def __init__(self, base: type, selector: str, shared: tuple[str, ...]):
        field = base.parameters.get(selector)
        if field is None or field.annotation is not str or not field.bound:
            raise TypeError(f"{base.__name__}: declare its selector as `{selector}: str = param(bound=True, ...)`")
        self.base, self.field, self.shared = base, field, ("equations", "build", *shared)
        self.kinds: dict[str, type] = {}

    @property
    def selector(self) -> str:
        """Name of the parameter that names the kind."""
        return self.field.name

    def add(self, kind: str, cls: type) -> None:
        """Take in a kind; one of the same name is replaced, as where a module is loaded again."""
        self.kinds[kind] = cls
        self.field.choices = tuple(self.kinds)

    def kind_of(self, cls: type) -> str | None:
        """The kind that a class is, or is derived from; None for the base class."""
        return next((kind for parent in cls.__mro__ for kind, known in self.kinds.items() if known is parent), None)

    def class_of(self, kind: Any, where: str) -> type:
        """The class of a kind; ParameterError for a kind that there is not."""
        if not isinstance(kind, str) or kind not in self.kinds:
            allowed = ", ".join(self.kinds)
            hint = did_you_mean(str(kind), self.kinds)
            raise ParameterError(f"{where} = {kind!r} is not one of {allowed} ({self.field.doc}){hint}")
        return self.kinds[kind]

    def chosen(self, cls: type, modifiers: Mapping[str, Any]) -> type:
        """The class of an object that is made by `cls(**modifiers)`."""
        where = f"{cls.__name__}.{self.selector}"
        if cls is self.base:
            kind = modifiers.get(self.selector, self.field.default)
            return self.class_of(kind, where) if self.kinds else cls
        own = self.kind_of(cls)
        if self.selector in modifiers and modifiers[self.selector] != own:
            raise ParameterError(f"{where} = {modifiers[self.selector]!r}: {cls.__name__} is of the kind '{own}'.")
        return cls

    def turn(self, component: Any, kind: Any) -> None:
        """Make a component one of another kind; it keeps the values of the parameters that all kinds have."""
        cls = self.class_of(kind, f"{component.label}.{self.selector}")
        if self.kind_of(type(component)) != kind:  # a kind may be derived from another one
            object.__setattr__(component, "__class__", cls)
            for name in [name for name in component._values if name not in self.base.parameters or name in cls.void]:
                del component._values[name]
                component._later.discard(name)
        component._values[self.selector] = kind

    def hint(self, name: str) -> str:
        """Which kinds have a parameter."""
        having = [kind for kind, cls in self.kinds.items() if name in cls.parameters]
        return f"; it belongs to the {self.selector} {', '.join(having)}." if having else ""

    @property
    def parameters(self) -> dict[str, Parameter]:
        """The parameters of all kinds, those of the base class first."""
        return self.base.parameters | {
            name: field for cls in self.kinds.values() for name, field in cls.parameters.items()
            if name not in self.base.parameters
        }  # fmt: skip

    def own_equations(self, cls: type) -> str:
        """What makes the equations of a class others than those of its family; empty where they are the same."""
        for name in self.shared:
            if getattr(cls, name, None) is not getattr(self.base, name, None):
                return f"{name}()"
        for table in ("ports", "variables", "declared_parts", "outers"):
            own = [name for name in getattr(cls, table) if name not in getattr(self.base, table)]
            if own:
                return f"'{own[0]}'"
        for name, field in cls.parameters.items():
            known = self.base.parameters.get(name)
            if not field.bound and (known is None or _nature(known) != _nature(field)):
                return f"the parameter '{name}', which is not bound"
        return ""


def _nature(field: Parameter) -> tuple[Any, ...]:
    """What the equations have of a parameter."""
    return field.annotation, field.tunable, field.shape
