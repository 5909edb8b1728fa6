"""The variables of an FMU: what an importer sees of a plant, each with its number, the value reference.

The numbers go by groups in a fixed order, which the C code knows: time, states, their derivatives, inputs, parameters,
discrete variables, outputs, event indicators, settings of the engine. Names are the paths of fowtlib, elements counted
from zero (`platform.motion.velocity[0]`), so that one name serves in Python, on the command line and in an importer.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import casadi as ca
import numpy as np

from fowtlib.flattening import FlatDAE
from fowtlib.flattening.system import element_names
from fowtlib.solving.plant import Plant
from fowtlib.solving.state import State

GROUPS = ("time", "state", "rate", "input", "parameter", "discrete", "output", "indicator", "solver")
DISPLAYED = {"rad": "deg", "rad/s": "rpm"}  # what a person reads of an SI unit; rpm of rotating parts only

_PLAIN = re.compile(r"[A-Za-z_]\w*(\[\d+(,\d+)*\])?(\.[A-Za-z_]\w*(\[\d+(,\d+)*\])?)*", re.ASCII)


@dataclass(frozen=True)
class Variable:
    """A scalar of an FMU. of: the number of the state of a derivative; path: in the model, of inputs and outputs."""

    name: str
    reference: int
    group: str
    unit: str
    doc: str
    start: float | None = None
    low: float | None = None
    high: float | None = None
    nominal: float | None = None
    display: str = ""
    of: int = -1
    is_output: bool = False
    path: str = ""

    def with_start(self, value: float) -> Variable:
        """The same with another start value."""
        return replace(self, start=value)


@dataclass(frozen=True)
class Settings:
    """Of the co-simulation engine and of the experiment; SI."""

    step: float
    rho_inf: float
    tolerance: float
    duration: float
    output_step: float


class Variables:
    """All variables of an FMU, and the expressions of its outputs in the order of their numbers."""

    def __init__(self, plant: Plant, start: State, settings: Settings):
        dae, self.plant, self.settings = plant.dae, plant, settings
        self.items: list[Variable] = []
        self.first: dict[str, int] = {}
        self.observed: list[str] = []  # paths of the results that are no states, with all their elements
        self.output_expressions: list[ca.SX] = []
        self.output_places: list[int] = []  # of each output among the elements of `observed`
        self._begin("time")
        self._add("time", "time", "s", "time")
        self._begin("state")
        for quantity, value in zip(dae.states, start.x.tolist(), strict=True):
            self._add("state", quantity.path, quantity.unit, quantity.doc, start=value, nominal=quantity.nominal)
        self._begin("rate")
        for i, quantity in enumerate(dae.states):
            name = f"der({fmi_name(quantity.path)})"
            self._add("rate", name, _rate(quantity.unit), f"rate of {quantity.path}", of=self.first["state"] + i)
        self._begin("input")
        for name, unit, doc, value in _inputs(dae):
            self._add("input", name, unit, doc, start=value, path=name)
        self._begin("parameter")
        for item in dae.parameters.values():
            names = element_names(item.path, item.symbol.shape)
            for name, value in zip(names, np.ravel(item.value, order="F").tolist(), strict=True):
                self._add("parameter", name, item.unit, item.doc, start=value, low=item.min, high=item.max)
        self._begin("discrete")
        for quantity in dae.discretes:
            self._add("discrete", quantity.path, quantity.unit, quantity.doc)
        self._begin("output")
        self._add_outputs(plant)
        self._begin("indicator")
        for i, event in enumerate(dae.events):
            doc = f"{event.path or 'model'}: its event comes where this falls below zero"
            self._add("indicator", f"event_{i}", "1", doc)
        self._begin("solver")
        for name, value, unit, doc, low, high in (
            ("step", settings.step, "s", "longest step of the fixed-step engine in co-simulation", 1e-9, None),
            ("rho_inf", settings.rho_inf, "1", "what a step leaves of an infinitely fast oscillation", 0.0, 1.0),
            ("tolerance", settings.tolerance, "1", "tolerance of the iterations within a step", 1e-15, 0.1),
        ):  # fmt: skip
            self._add("solver", f"solver.{name}", unit, doc, start=value, low=low, high=high)

    def _begin(self, group: str) -> None:
        self.first[group] = len(self.items)

    def _add(self, group: str, name: str, unit: str, doc: str, **more: object) -> None:
        name = name if group in ("rate", "solver") else fmi_name(name)
        display = str(more.pop("display", "")) or (DISPLAYED["rad"] if unit == "rad" else "")
        self.items.append(Variable(name, len(self.items), group, unit, doc, display=display, **more))  # type: ignore[arg-type]

    def _add_outputs(self, plant: Plant) -> None:
        """The results of the model; a state that is one becomes an output under its own name."""
        there, total = {item.name: i for i, item in enumerate(self.items)}, 0
        for name, (path, unit, doc) in plant.outputs.items():
            expression = ca.densify(plant.dae.observe_expression(path))
            si = plant.describe(path)[0]
            elements = zip(element_names(name, expression.shape), ca.vec(expression).elements(), strict=True)
            before = len(self.output_expressions)
            for place, (element, value) in enumerate(elements, total):
                number = there.get(fmi_name(element))
                if number is not None:
                    known = self.items[number]
                    if known.group in ("state", "discrete"):
                        self.items[number] = replace(known, is_output=True, path=path)
                    continue
                self._add("output", element, si, doc, display=unit if unit != si else "", is_output=True, path=path)
                self.output_expressions.append(value)
                self.output_places.append(place)
            if len(self.output_expressions) > before:
                self.observed.append(path)
                total += expression.numel()

    def group(self, name: str) -> list[Variable]:
        """The variables of a group, in order."""
        return [item for item in self.items if item.group == name]

    @property
    def outputs(self) -> list[Variable]:
        """Everything that is an output."""
        return [item for item in self.items if item.is_output]

    @cached_property
    def by_name(self) -> dict[str, Variable]:
        """Variables by name."""
        return {item.name: item for item in self.items}


def _inputs(dae: FlatDAE) -> Sequence[tuple[str, str, str, float]]:
    rows = []
    for item in dae.inputs.values():
        names = element_names(item.path, item.symbol.shape)
        rows += [(name, item.unit, item.doc, value) for name, value in zip(names, item.default.tolist(), strict=True)]
    return rows


def fmi_name(path: str) -> str:
    """A path as a structured name of FMI: as it is, or in quotes where it has other characters."""
    return path if _PLAIN.fullmatch(path) else quoted(path)


def quoted(path: str) -> str:
    """A name in quotes."""
    return "'" + re.sub(r"([\\'\"])", r"\\\1", path) + "'"


def _rate(unit: str) -> str:
    known = {"1": "1/s", "m": "m/s", "m/s": "m/s^2", "rad": "rad/s", "rad/s": "rad/s^2", "s": "1"}
    return known.get(unit, f"{unit}/s")
