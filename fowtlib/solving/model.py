"""Model: a component tree with its outputs and simulation settings, before it is compiled."""

from __future__ import annotations

import copy
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from fowtlib.flattening import flatten
from fowtlib.flattening.dimensions import check_dimensions
from fowtlib.language.component import Component
from fowtlib.language.errors import ParameterError, did_you_mean
from fowtlib.language.upstairs import handed_in
from fowtlib.solving.binding import bind
from fowtlib.solving.check import ModelReport
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

    def compile(self, inputs: Sequence[str] = ()) -> Plant:
        """Flatten the model; raises ModelError subclasses that say by path what is wrong.

        inputs: paths of signals, such as "turbine.blade_pitch", that become inputs of the plant. What drove them, a
        controller, goes on by itself unheard; what it gives at the start is the value of the input where nobody gives
        another.
        """
        dae = flatten(self.root, inputs)
        plant = Plant(dae, self.outputs, name=self.name, title=self.title, settings=self.settings, root=self.root)
        plant.binding()  # a mistake in the data of the model is found now, and not at the first run
        plant.start_opened_inputs()
        return plant

    def check(self) -> ModelReport:
        """Flatten the model and check the dimensions of its equations; the report says what was found."""
        dimensions = check_dimensions(self.root)
        title = self.title or self.name or "model"
        dae = flatten(self.root)
        bind(dae, self.root)
        return ModelReport(title, sum(1 for _ in self.root.walk()) - 1, dae, dimensions)

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

    def view(self, path: str | Path | None = None, **options: Any) -> Any:
        """Write a picture in 3-D as one HTML file for the browser; see fowtlib.view.view."""
        return handed_in("view")(self, path, **options)

    def with_parameters(self, values: Mapping[str, Any]) -> Model:
        """The same model with parameters changed by path, structural ones too."""
        if self.rebuild is not None:
            return self.rebuild(values)
        root = copy.deepcopy(self.root)

        def order(path: str) -> tuple[int, bool]:
            """A part before what is in it, and its kind before what only this kind has."""
            family = root.find(path.rpartition(".")[0]).family
            return path.count("."), family is None or path.rpartition(".")[2] != family.selector

        for path, value in sorted(values.items(), key=lambda item: order(item[0])):
            owner, _, name = path.rpartition(".")
            component = root.find(owner)
            if name not in component.parameters:
                hint = component.family.hint(name) if component.family is not None else ""
                hint = hint or did_you_mean(name, component.parameters)
                raise ParameterError(f"{component.label} has no parameter '{name}'{hint}")
            setattr(component, name, value)
        return replace(self, root=root)
