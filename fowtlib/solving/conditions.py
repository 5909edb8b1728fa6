"""Conditions: what differs between two runs of one compiled model, as one value."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from typing import TYPE_CHECKING, Any

from fowtlib.language.component import Component
from fowtlib.language.errors import ParameterError, did_you_mean
from fowtlib.language.units import to_si
from fowtlib.solving.paths import by_path
from fowtlib.solving.timeline import Event, events_of

if TYPE_CHECKING:
    from fowtlib.solving.results import Result
    from fowtlib.solving.state import State

Values = Mapping[str, Any]


@dataclass(frozen=True)
class Conditions:
    """The wind and the sea of a run, its parameters, where it starts, how long it is, and what it gives.

    parts: by path, components that take the place of others of their family: {"wind": SteadyWind(mean_speed=8)}.
    parameters: by path, values of tunable and of bound parameters, SI or with unit.
    inputs: by path, values of the inputs of the model.
    start: a State, an earlier Result to go on from, start values by path, or a word: "turning", "equilibrium", "rest",
    "file", the path of a result or of a state (see solving.starts); "" is simulation.start of the model file, and None
    the start values that it gives.
    duration: the end of the run [s]; output_step: between two output points [s]; discard: time [s] at the beginning
    that the result does not hold. outputs: names of results or paths of variables. events: what happens in the run, of
    what the parts offer: Event, or a line of text, "turbine.grid_loss at 100 s"; () for none.
    What is left out, None, comes from the model file. Nothing of this is flattened or compiled.
    """

    parts: Mapping[str, Component] = field(default_factory=dict)
    parameters: Values = field(default_factory=dict)
    inputs: Values | None = None
    start: State | Result | Values | str | None = None
    duration: float | str | None = None
    output_step: float | str | None = None
    discard: float | str | None = None
    outputs: Sequence[str] | None = None
    events: Sequence[Event] | None = None

    def __post_init__(self) -> None:
        for name in ("parts", "parameters", "inputs"):
            if getattr(self, name) is not None:
                by_path(getattr(self, name), name)
        for name, kind in (("duration", "above zero"), ("output_step", "above zero"), ("discard", "zero or more")):
            value = getattr(self, name)
            seconds = None if value is None else float(to_si(value, "s", name))
            if seconds is not None and not math.isfinite(seconds):
                raise ParameterError(f"{name} is {seconds:g} s, which is not a finite number.")
            if seconds is not None and not (seconds > 0 or (seconds == 0 and name == "discard")):
                raise ParameterError(f"{name} is {seconds:g} s; it must be {kind}.")
            object.__setattr__(self, name, seconds)
        if self.events is not None:
            object.__setattr__(self, "events", events_of(self.events))
        for path, part in self.parts.items():
            if not isinstance(part, Component):
                raise ParameterError(f"parts: '{path}' is given {part!r}, and a part is a component.")

    @property
    def values(self) -> dict[str, Any]:
        """Parts and parameters by path, as all methods of a Plant take them for `parameters`."""
        return {**self.parts, **self.parameters}

    def over(self, others: Conditions | None) -> Conditions:
        """These conditions where they say something, and the others elsewhere."""
        if others is None:
            return self
        merged: dict[str, Any] = {"parts": {**others.parts, **self.parts}}
        merged["parameters"] = {**others.parameters, **self.parameters}
        for name in ("inputs", "start", "duration", "output_step", "discard", "outputs", "events"):
            mine = getattr(self, name)
            merged[name] = getattr(others, name) if mine is None else mine
        return Conditions(**merged)

    def but(self, **changes: Any) -> Conditions:
        """The same with other values of some of its fields."""
        known = [item.name for item in fields(self)]
        for name in changes:
            if name not in known:
                raise ParameterError(f"Conditions have no '{name}'{did_you_mean(name, known)}")
        return replace(self, **changes)
