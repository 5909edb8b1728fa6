"""Model: a component tree with its outputs and simulation settings, before it is compiled."""

from __future__ import annotations

import copy
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any
from weakref import WeakKeyDictionary

import numpy as np

from fowtlib.flattening import FlatDAE, dimensions_of, flat
from fowtlib.language.component import Component
from fowtlib.language.errors import ModelError, ParameterError
from fowtlib.solving.binding import bind
from fowtlib.solving.check import ModelReport, broken_at_start
from fowtlib.solving.engines.choice import check_settings
from fowtlib.solving.paths import spread_out
from fowtlib.solving.plant import Plant
from fowtlib.solving.results.html import table
from fowtlib.solving.settings import without
from fowtlib.solving.starts import mean_parameters, mean_values

# What is known of the root of a model besides its parts: title, outputs, settings, name.
_KNOWN: WeakKeyDictionary[Component, tuple[str, dict[str, Any], Mapping[str, Any], str]] = WeakKeyDictionary()


def known_of(root: Component) -> tuple[str, dict[str, Any], Mapping[str, Any], str] | None:
    """Title, outputs, settings and name of the model that this component is the root of; None for any other one."""
    return _KNOWN.get(root)


@dataclass(frozen=True)
class Output:
    """A result: the path of a variable, the unit it is given in (None: SI), a description (empty: the variable's)."""

    of: str
    unit: str | None = None
    doc: str = ""


@dataclass(repr=False)
class Model:
    """What `fw.load` gives. `compile()` makes a Plant of it.

    `rebuild` makes the same model with parameters changed before construction; the loader of model files gives it, and
    `files`, from which it has read the model: the model file, its definitions and their Python code.
    A model remembers what it knows of its root, so that `fw.load(model.root)` has the same outputs and settings.
    """

    root: Component
    title: str = ""
    outputs: Mapping[str, Output] = field(default_factory=dict)
    settings: Mapping[str, Any] = field(default_factory=dict)
    source: Path | None = None
    name: str = ""
    rebuild: Any = field(default=None, repr=False)
    files: Sequence[Path] = ()

    def __post_init__(self) -> None:
        if self.outputs or self.settings:
            _KNOWN[self.root] = (self.title, dict(self.outputs), copy.copy(self.settings), self.name)

    def compile(self, inputs: Sequence[str] | Mapping[str, str] = ()) -> Plant:
        """Flatten the model; raises ModelError subclasses that say by path what is wrong.

        inputs: paths of signals, such as "turbine.blade_pitch", that become inputs of the plant; or names of your own
        for them, {"pitch": "turbine.blade_pitch"}. What drove them, a controller, goes on by itself unheard; what it
        gives at the start is the value of the input where nobody gives another.
        A model with a statement `equilibrium` is solved first; see `solved`.
        """
        if "equilibrium" in self.settings:
            return self.solved().compile(inputs)
        names = dict(inputs) if isinstance(inputs, Mapping) else {}
        dae = flat(self.root, list(names.values()) if names else inputs)
        plant = self._plant(dae, names)
        plant.binding()  # a mistake in the data of the model is found now, and not at the first run
        plant.timeline()
        driven = {path: item for path, item in dae.inputs.items() if item.driver}
        if not driven:
            return plant
        start = plant.initial_state()
        values = {path: np.ravel(start[item.driver], order="F") for path, item in driven.items()}
        defaults = {path: replace(item, default=values.get(path, item.default)) for path, item in dae.inputs.items()}
        return self._plant(replace(dae, inputs=defaults), names)

    def solved(self) -> Model:
        """The model with its freed parameters at the values that its statement `equilibrium` asks for.

        settings["equilibrium"]: the mappings `free` from paths to first guesses or None, `targets` from results to
        values, and `set`, parameters of the state at which they hold, beside those of the mean of wind and waves. This
        compiles the model once by itself. A model without the statement is returned as it is.
        """
        statement = self.settings.get("equilibrium")
        if not statement:
            return self
        rest = without(self.settings, "equilibrium")
        plant = replace(self, settings=rest).compile()
        try:
            mean = mean_parameters(plant, statement.get("set"))
            state = plant.equilibrium(mean, free=statement["free"], targets=statement["targets"])
        except ModelError as error:
            raise error.at(f"{self.source or self.name or 'model'}, equilibrium") from None
        paths = {path if path in plant.dae.parameters else path.partition("[")[0] for path in statement["free"]}
        found = self.with_parameters({path: state.parameters[path] for path in sorted(paths)})
        return replace(found, settings=rest)

    def _plant(self, dae: FlatDAE, names: Mapping[str, str]) -> Plant:
        return Plant(
            dae, self.outputs, name=self.name, title=self.title, settings=self.settings, root=self.root,
            input_names=names,
        )  # fmt: skip

    def __repr__(self) -> str:
        parts = sum(1 for _ in self.root.walk()) - 1
        name = self.name or type(self.root).__name__
        about = f": {self.title}" if self.title and self.title != name else ""
        return f"<Model {name}{about}; {parts} parts, {len(self.outputs)} outputs>"

    def _repr_html_(self) -> str:
        rows = [(name, item.of, item.unit or "SI", item.doc) for name, item in self.outputs.items()]
        return table(("output", "variable", "unit", ""), rows, repr(self)[1:-1])

    def check(self) -> ModelReport:
        """Flatten the model, and check dimensions, the settings of a run and what can be judged of its start unsolved.

        The report says what was found.
        """
        title = self.title or self.name or "model"
        dae = flat(self.root)
        dimensions = dimensions_of(self.root, dae)
        faults, warned = broken_at_start(dae, bind(dae, self.root), self.name, self.settings.get("start", "file"))
        try:
            check_settings(self.settings)
        except ParameterError as error:
            faults.append(str(error))
        remarks = [remark for part in self.root.walk() for remark in part.remarks()]
        parts = sum(1 for _ in self.root.walk()) - 1
        return ModelReport(title, parts, dae, dimensions, (*remarks, *warned), tuple(faults))

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
        """The same model with parameters changed by path, structural ones too; stars in a path as in events."""
        values = spread_out(values, self.root)
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
                raise component.no_parameter(name)
            setattr(component, name, value)
        return replace(self, root=root)

    def in_the_mean(self) -> Model:
        """The same model in still water, and in steady wind of the mean speed of its own."""
        values = mean_values(self.root)
        return self.with_parameters(values) if values else self
