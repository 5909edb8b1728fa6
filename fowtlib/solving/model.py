"""Model: a component tree with its outputs and simulation settings, before it is compiled."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from fowtlib.flattening import flatten
from fowtlib.language.component import Component
from fowtlib.solving.plant import Plant


@dataclass(frozen=True)
class Output:
    """A result: the path of a variable, the unit it is given in (None: SI), a description (empty: the variable's)."""

    of: str
    unit: str | None = None
    doc: str = ""


@dataclass
class Model:
    """What `fw.load` gives. `compile()` makes a Plant of it.

    `rebuild` makes the same model with parameters changed before construction; the loader of model files gives it.
    """

    root: Component
    title: str = ""
    outputs: Mapping[str, Output] = field(default_factory=dict)
    settings: Mapping[str, Any] = field(default_factory=dict)
    source: Path | None = None
    name: str = ""
    rebuild: Any = field(default=None, repr=False)

    def compile(self) -> Plant:
        """Flatten the model; raises ModelError subclasses that say by path what is wrong."""
        return Plant(flatten(self.root), self.outputs, name=self.name, title=self.title, settings=self.settings)

    def check(self) -> Any:
        """Flatten the model and check the dimensions of its equations; returns the report."""
        from fowtlib.flattening.dimensions import check_dimensions

        return check_dimensions(self.root)

    def tree(self) -> str:
        """The component tree as text: names and classes."""
        lines = [f"{self.title or self.name or 'model'}: {type(self.root).__name__}"]

        def draw(component: Component, indent: str) -> None:
            parts = list(component.parts.items())
            for i, (name, part) in enumerate(parts):
                last = i == len(parts) - 1
                lines.append(f"{indent}{'└── ' if last else '├── '}{name}: {type(part).__name__}")
                draw(part, indent + ("    " if last else "│   "))

        draw(self.root, "")
        return "\n".join(lines)

    def with_parameters(self, values: Mapping[str, Any]) -> Model:
        """The same model with parameters changed by path, structural ones too."""
        if self.rebuild is not None:
            return self.rebuild(values)
        for path, value in values.items():
            owner, _, name = path.rpartition(".")
            setattr(self.root.find(owner), name, value)
        return self
