"""A case: one run that a designer asks for, as data that can be written down, hashed and sent to another process."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field, fields, replace
from typing import Any

from fowtlib.language.errors import ParameterError, did_you_mean
from fowtlib.solving.conditions import Conditions
from fowtlib.solving.timeline import Event

Plain = str | int | float | bool | list[Any] | dict[str, Any]
"""What JSON can hold."""


@dataclass(frozen=True)
class Case:
    """One run of a model.

    name: of the case and its files; unique in a batch. model: a shipped name or the path of a model file.
    parameters: by path, values of tunable and bound parameters as in `fowt run --set`, SI or with unit:
    {"wind.kind": "kaimal", "wind.mean_speed": 12, "wind.seed": 3}. events: what happens during the run, each as in the
    `events` of a model file; without any, those of the model file itself. start: a word of `fowt run --start`, or the
    path of a result; "" is the model file's.
    duration, output_step, discard [s] and outputs: see Conditions; None is the model file's. solver, step [s] and
    tolerance: see Plant.simulate. group: of cases that are judged together, such as "DLC 1.2". labels: what the case
    was made from, for tables and pictures: {"wind_speed": 12, "seed": 3}. weight: its share of the lifetime, in any
    unit that all cases of the batch have in common. safety_factor: of its loads, for ultimate strength.
    """

    name: str
    model: str
    parameters: Mapping[str, Plain] = field(default_factory=dict)
    events: tuple[Mapping[str, Plain], ...] = ()
    start: str = ""
    duration: float | None = None
    output_step: float | None = None
    discard: float | None = None
    outputs: tuple[str, ...] | None = None
    solver: str | None = None
    step: float | None = None
    tolerance: float | None = None
    group: str = ""
    labels: Mapping[str, str | int | float] = field(default_factory=dict)
    weight: float = 1.0
    safety_factor: float = 1.0

    def conditions(self) -> Conditions:
        """What a run of the compiled model takes in."""
        events = tuple(Event.from_plain(item, f"case {self.name}") for item in self.events) or None
        return Conditions(parameters=dict(self.parameters), start=self.start, duration=self.duration,
                          output_step=self.output_step, discard=self.discard, outputs=self.outputs,
                          events=events)  # fmt: skip

    def plain(self) -> dict[str, Any]:
        """The case in what JSON can hold, without what is left out."""
        default = Case("", "")
        told = {key: value for key, value in asdict(self).items() if value != getattr(default, key)}
        return json.loads(json.dumps({"name": self.name, "model": self.model, **told}))

    @classmethod
    def from_plain(cls, values: Mapping[str, Any]) -> Case:
        """The inverse of `plain`; ParameterError for a key that a case does not have."""
        known = [item.name for item in fields(cls)]
        for key in values:
            if key not in known:
                raise ParameterError(f"a case has no '{key}'{did_you_mean(key, known)}")
        changed = {key: tuple(values[key]) for key in ("events", "outputs") if values.get(key) is not None}
        return cls(**{**values, **changed})

    def digest(self) -> str:
        """Of all that a run depends on; not of its name, group, labels, weight and safety factor."""
        same = replace(self, name="", group="", labels={}, weight=1.0, safety_factor=1.0)
        return hashlib.blake2b(json.dumps(same.plain(), sort_keys=True).encode(), digest_size=16).hexdigest()
