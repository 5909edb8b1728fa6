"""What formulas can name: the parameters that a file declares, and parameters of parts by path."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from fowtlib.language import expressions
from fowtlib.language.component import Component
from fowtlib.language.declarations import Parameter
from fowtlib.language.errors import ModelFileError
from fowtlib.language.expressions import ParameterReference
from fowtlib.language.unit_grammar import parse_unit
from fowtlib.modelfile.catalogue import Classes
from fowtlib.modelfile.formulas import Quantity
from fowtlib.modelfile.permit import Permit

LONGEST_CHAIN = 100


@dataclass
class Scope:
    """The names one component of a file gives to the formulas in it; then those around it in the same file.

    While the class of the component is being made, its own parameters are declarations; once it exists, references.
    """

    folder: Path
    classes: Classes
    parent: Scope | None = None
    component: Component | None = None
    waiting: dict[str, Callable[[], Parameter]] = field(default_factory=dict)
    parameters: dict[str, Parameter] = field(default_factory=dict)
    in_progress: list[str] = field(default_factory=list)
    permit: Permit | None = None

    @property
    def names(self) -> list[str]:
        """The parameters that can be named here."""
        return [*self.waiting, *self.parameters, *(self.parent.names if self.parent else ())]

    def find(self, name: str) -> Quantity | None:
        """A parameter by name, or by path through the parts that exist."""
        if name in self.waiting:
            self.declare(name)
        if name in self.parameters:
            declared = self.parameters[name]
            value = declared if self.component is None else ParameterReference(self.component, name)
            return _quantity(value, declared)
        if self.component is not None and "." in name:
            path, _, last = name.rpartition(".")
            part = _part(self.component, path)
            if part is not None and last in part.parameters and part.parameters[last].tunable:
                return _quantity(ParameterReference(part, last), part.parameters[last])
        return self.parent.find(name) if self.parent else None

    def declare(self, name: str) -> Parameter:
        """Make the declaration of an own parameter, which may need others."""
        if name in self.in_progress:
            ring = " -> ".join([*self.in_progress[self.in_progress.index(name) :], name])
            raise ModelFileError(f"the parameters are defined by each other: {ring}.")
        self.in_progress.append(name)
        try:
            made = self.waiting[name]()
            made.depth = 1 + max((_depth(leaf) for leaf in leaves(made.default)), default=0)
            if made.depth > LONGEST_CHAIN:
                raise ModelFileError(
                    f"the parameter '{name}' is the end of a chain of more than {LONGEST_CHAIN} parameters, each "
                    "defined by the one before; that is the limit."
                )
            self.parameters[name] = made
        finally:
            self.in_progress.pop()
        del self.waiting[name]
        return self.parameters[name]


def _depth(leaf: Any) -> int:
    """How many parameters of files, each defined by the next, begin with this one."""
    declared = leaf.component.parameters[leaf.name] if isinstance(leaf, ParameterReference) else leaf
    return getattr(declared, "depth", 0)


def _part(component: Component, path: str) -> Component | None:
    found: Component | None = component
    for name in path.split("."):
        found = found.parts.get(name) if found is not None else None
    return found


def _quantity(value: Any, declared: Parameter) -> Quantity:
    unit = parse_unit(declared.unit)
    return Quantity(value, None if declared.unit == "1" else unit)


def freeze(value: Any, seen: set[tuple[int, str]] | None = None) -> None:
    """Make structural the parameters of files that a structural value depends on.

    The value is put in when the model is built, so a later change of such a parameter could not reach it.
    """
    seen = set() if seen is None else seen
    for leaf in leaves(value):
        key = (id(leaf.component), leaf.name) if isinstance(leaf, ParameterReference) else (0, str(id(leaf)))
        if key in seen:
            continue
        seen.add(key)
        if isinstance(leaf, ParameterReference):
            declared = leaf.component.parameters[leaf.name]
            binding = leaf.component.parameter_binding(leaf.name)
        else:
            assert isinstance(leaf, Parameter)
            declared, binding = leaf, leaf.default
        if not getattr(declared, "from_file", False):
            raise ModelFileError(f"{leaf!r} may change in a built model, and this value must be known before.")
        declared.structural = True
        freeze(binding, seen)


def leaves(value: Any) -> list[expressions.Arithmetic]:
    """The parameters that a value depends on directly."""
    if isinstance(value, expressions.Expression):
        return [leaf for argument in value.arguments for leaf in leaves(argument)]
    if isinstance(value, expressions.Arithmetic):
        return [value]
    if isinstance(value, (list, tuple)):
        return [leaf for item in value for leaf in leaves(item)]
    return []
