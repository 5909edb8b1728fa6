"""The timeline of a run: which of the events that the parts of a model offer happen in it, and when.

An event is carried out between two steps of the solver, like a sample: discrete variables take their values, and the
algebraic unknowns are solved for anew. Nothing is flattened or compiled for it.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import casadi as ca
import numpy as np

from fowtlib.flattening.flat_dae import FlatDAE, Offer
from fowtlib.language import expressions
from fowtlib.language.component import Component
from fowtlib.language.declarations import Parameter
from fowtlib.language.errors import ModelError, NotFoundError, ParameterError, SimulationError, did_you_mean
from fowtlib.language.units import from_si, quantity, to_si
from fowtlib.solving.functions import AtParameters
from fowtlib.solving.outputs import Outputs
from fowtlib.solving.paths import EVERY, by_path, meant

MOST_LISTED = 40  # events in the message about an unknown one
_CONDITION = re.compile(r"\s*(?P<name>[^<>]+?)\s*(?P<sign>[<>])\s*(?P<value>[^<>=]+?)\s*")
_TEXT = re.compile(r"\s*(?P<what>\S+)\s+(?P<word>at|when)\s+(?P<instant>[^,]+?)\s*(?P<values>(,.*)?)", re.DOTALL)
_FORM = "'turbine.grid_loss at 100 s' or 'turbine.emergency_shutdown when generator_speed > 1400 rpm', and values " \
        "behind a comma: ', rate=4 deg/s'"  # fmt: skip


@dataclass(frozen=True)
class Event:
    """Something that happens in a run, once.

    what: an event that a part offers, by its path: "turbine.safety.grid_loss". Names may be left out of the path as
    long as it says which one is meant: "turbine.grid_loss". Or the event itself: `turbine.safety.grid_loss`. With stars
    for letters of a name it happens wherever it fits: "*.grid_loss" at every turbine.
    at: the time [s], or with a unit. when: instead of it, a result or the path of a variable, and what it has to reach:
    "generator_speed > 1400 rpm". The event comes at the instant at which that becomes true; where it is true at the
    start, that is after it has been false. values: what the event takes, by name, SI or with unit.
    place: the line of the file it comes from, for messages.
    """

    what: str
    at: float | str | None = None
    when: str | None = None
    values: Mapping[str, Any] = field(default_factory=dict)
    place: str = field(default="", compare=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "what", str(self.what))
        if (self.at is None) == (self.when is None):
            raise self.error("needs its time, 'at', or its condition, 'when', and one of them only.")
        if self.at is not None:
            try:
                seconds = float(to_si(self.at, "s", "at"))
            except (ModelError, TypeError, ValueError) as error:
                raise self.error(f"{error}") from None
            if not math.isfinite(seconds):
                raise self.error(f"at = {seconds:g} s, which is not a finite number.")
            object.__setattr__(self, "at", seconds)
        elif not isinstance(self.when, str) or not _CONDITION.fullmatch(self.when):
            raise self.error(
                f"when: {self.when!r} is no condition: a result or the path of a variable, > or <, and a value, as in "
                "'generator_speed > 1400 rpm'."
            )
        object.__setattr__(self, "values", by_path(self.values, "values of an event"))

    def error(self, message: str) -> ParameterError:
        """An error about this event."""
        about = f"the event '{self.what}'"
        return ParameterError(f"{about}: {message}" if not message.startswith("needs") else f"{about} {message}",
                              where=self.place)  # fmt: skip

    def plain(self) -> dict[str, Any]:
        """The event as a model file has it: {"event": "turbine.grid_loss", "at": 100.0, "delay": "0.5 s"}."""
        instant = {"at": self.at} if self.at is not None else {"when": self.when}
        return {"event": self.what, **instant, **self.values}

    @classmethod
    def from_plain(cls, entries: Any, place: str = "") -> Event:
        """The inverse of `plain`."""
        if not isinstance(entries, Mapping) or not isinstance(entries.get("event"), str):
            raise ParameterError(
                "an event is a mapping with its name, its time or condition, and values, as in {event: "
                f"turbine.grid_loss, at: 100 s}}, and this is {entries!r}.", where=place,
            )  # fmt: skip
        values = {key: value for key, value in entries.items() if key not in ("event", "at", "when")}
        return cls(entries["event"], entries.get("at"), entries.get("when"), values, place)

    @classmethod
    def parse(cls, text: str) -> Event:
        """An event from one line: NAME at TIME, or NAME when VARIABLE > VALUE, then perhaps `, name=value`."""
        found = _TEXT.fullmatch(text)
        if not found:
            raise ParameterError(f"'{text}' is no event; write {_FORM}.")
        pairs = [pair.partition("=") for pair in found["values"].split(",")[1:]]
        for name, sign, value in pairs:
            if not sign or not name.strip() or not value.strip():
                raise ParameterError(f"'{text}': '{name.strip()}' has no value; write {_FORM}.")
        values = {name.strip(): value.strip() for name, _, value in pairs}
        return cls(found["what"], **{found["word"]: found["instant"]}, values=values)


def events_of(given: Any) -> tuple[Event, ...]:
    """Events from objects, plain mappings or lines of text; ParameterError for anything else."""
    if isinstance(given, (Event, str, Mapping)) or not isinstance(given, Iterable):
        given = [given]
    read = {Event: lambda item: item, str: Event.parse}
    return tuple(read.get(type(item), Event.from_plain)(item) for item in given)


# --- what a model offers ------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Offered:
    """An event that a model offers, for tables: its path, the values it takes with unit and default, a sentence."""

    path: str
    values: tuple[tuple[str, float, str, str], ...]
    doc: str


def offered(dae: FlatDAE, root: Component | None) -> list[Offered]:
    """What can happen in a run of a compiled model; values: name, default in SI, unit, sentence."""
    return [
        Offered(
            offer.path,
            tuple((name, _default(offer, item, root), item.unit, item.doc) for name, item in _values(offer)),
            offer.declared.doc,
        )
        for offer in dae.offers
    ]  # fmt: skip


def _values(offer: Offer) -> list[tuple[str, Parameter]]:
    return list(offer.declared.values.items())


def _default(offer: Offer, item: Parameter, root: Component | None) -> float:
    value = item.default
    if root is not None:
        value = root.find(offer.owner).resolve(value)
    if expressions.is_expression(value):
        value = expressions.evaluate(value)
    return float(to_si(value, item.unit, f"{offer.path}, {item.name}"))


def _chosen(event: Event, dae: FlatDAE) -> list[int]:
    """Numbers of the offers that an event means: one, or with stars in its name all that fit."""
    known = [offer.path for offer in dae.offers]
    paths = meant(event.what, known)
    if len(paths) == 1 or (paths and EVERY in event.what):
        return [known.index(path) for path in paths]
    if paths:
        raise event.error(
            f"it can happen at {len(paths)} places; say at which: {_listed(paths)}, or with a star in its name at all "
            f"of them: {EVERY}.{event.what.rpartition('.')[2]}."
        )
    if not known:
        raise NotFoundError(f"there is no event '{event.what}': no part of this model offers any.", where=event.place)
    hint = did_you_mean(event.what, known, list_up_to=0)
    text = f"there is no event '{event.what}'{hint} The model offers {_listed(known)}."
    raise NotFoundError(text, where=event.place)


def _listed(paths: Sequence[str]) -> str:
    more = f" and {len(paths) - MOST_LISTED} more (`fowt events`)" if len(paths) > MOST_LISTED else ""
    return ", ".join(paths[:MOST_LISTED]) + more


# --- one run ------------------------------------------------------------------------------------------------------


@dataclass
class Planned:
    """An event of a run. given: its values, SI. at: its time [s]; else `path`, sign (1: above) and limit, SI."""

    offer: Offer
    given: np.ndarray
    label: str
    at: float | None = None
    path: str = ""
    sign: int = 1
    limit: float = 0.0
    done: bool = False


class Timeline:
    """The events of one run; all of them are checked when it is made, before the run begins."""

    def __init__(self, events: Sequence[Event], dae: FlatDAE, outputs: Outputs, root: Component | None):
        self.dae, self.outputs, self.root, self.asked = dae, outputs, root, tuple(events)
        self.planned = [self._planned(event, number) for event in events for number in _chosen(event, self.dae)]
        self.happened: list[str] = []  # a line for each that has happened, as a result tells it
        self.heard: Callable[..., None] | None = None  # is told of each, as `carry_out` is

    def _planned(self, event: Event, number: int) -> Planned:
        offer = self.dae.offers[number]
        given = self._given(event, offer)
        if event.at is not None:
            return Planned(offer, given, offer.path, float(event.at))
        found = _CONDITION.fullmatch(event.when or "")
        assert found is not None  # checked when the event was made
        name = found["name"]
        entry = self.outputs.entry(name)
        try:
            expression = self.dae.observe_expression(entry.path)
        except NotFoundError:
            names = [*self.outputs, *self.dae.names]
            raise NotFoundError(
                f"the event '{event.what}': there is no result or variable '{name}'{did_you_mean(name, names)}",
                where=event.place,
            ) from None
        if expression.numel() != 1:
            raise event.error(f"when: '{name}' has {expression.numel()} values; take one of them, as in '{name}[0]'.")
        si = self.outputs.describe(entry.path)[0]
        number = quantity(found["value"])
        if number is not None and not number[1] and entry.unit != si:
            raise event.error(f"when: '{name}' is given in {entry.unit}; say the unit: {number[0]:g} {entry.unit}.")
        try:
            limit = float(to_si(found["value"], si, f"when: {name}"))
        except ModelError as error:
            raise event.error(str(error)) from None
        shown = from_si(limit, si, entry.unit)
        unit = "" if entry.unit == "1" else f" {entry.unit}"
        label = f"{offer.path} ({name} {found['sign']} {shown:g}{unit})"
        return Planned(offer, given, label, None, entry.path, 1 if found["sign"] == ">" else -1, limit)

    def _given(self, event: Event, offer: Offer) -> np.ndarray:
        """The values of an event in SI: as given, else the defaults."""
        declared = offer.declared.values
        for name in event.values:
            if name not in declared:
                none = "" if declared else "; it takes no values."
                raise event.error(f"it has no value '{name}'{none or did_you_mean(name, declared)}")
        numbers = []
        for name, item in declared.items():
            value = event.values.get(name)
            try:
                number = _default(offer, item, self.root) if value is None else float(to_si(value, item.unit, name))
            except (ModelError, TypeError, ValueError) as error:
                raise event.error(f"{error}") from None
            low, high = (-math.inf if item.min is None else item.min), (math.inf if item.max is None else item.max)
            if not (math.isfinite(number) and low <= number <= high):
                bounds = "a finite number" if not math.isfinite(number) else f"{low:g} to {high:g} {item.unit}"
                raise event.error(f"{name} = {value if value is not None else number}, and it must be {bounds} "
                                  f"({item.doc}).")  # fmt: skip
            numbers.append(number)
        return np.array(numbers)

    # --- times ---------------------------------------------------------------------------------------------------

    def begin(self, t: float, resumed: bool, happened: Sequence[str] = ()) -> None:
        """Before a run from t [s]; of one that goes on from a result, with the lines that it has about its events."""
        told = [line.partition(": ")[2] for line in happened]
        self.happened = list(happened)
        for item in self.planned:
            if resumed:
                item.done = item.label in told or (item.at is not None and item.at <= t)
            elif item.at is not None and item.at < t:
                raise ParameterError(
                    f"the event {item.label} at {item.at:g} s lies before the start of the run, {t:g} s."
                )

    def next_time(self, t: float) -> float:
        """The next instant behind t [s] at which an event is to happen."""
        return min((item.at for item in self.planned if not item.done and item.at is not None and item.at > t),
                   default=math.inf)  # fmt: skip

    def due(self, t: float) -> list[int]:
        """Numbers of the events that are to happen until t [s]."""
        return [k for k, item in enumerate(self.planned) if not item.done and item.at is not None and item.at <= t]

    # --- conditions ----------------------------------------------------------------------------------------------

    @property
    def waiting(self) -> list[int]:
        """Numbers of the events that wait for a condition."""
        return [k for k, item in enumerate(self.planned) if item.at is None]

    def indicators(self, at: AtParameters, times: np.ndarray, x: np.ndarray, z: np.ndarray, q: np.ndarray) \
            -> np.ndarray:  # fmt: skip
        """Rows of what falls below zero as each condition becomes true; 1 for events that have happened."""
        items = [self.planned[k] for k in self.waiting]
        if not items:
            return np.zeros((len(times), 0))
        values = at.along(at.functions.observed([item.path for item in items]), times, x, z, q)
        columns = [np.ones(len(times)) if item.done else item.sign * (item.limit - values[:, i])
                   for i, item in enumerate(items)]  # fmt: skip
        return np.column_stack(columns)

    # --- what happens --------------------------------------------------------------------------------------------

    def carry_out(self, k: int, at: AtParameters, t: float, x: np.ndarray, z: np.ndarray, q: np.ndarray) \
            -> tuple[np.ndarray, np.ndarray]:  # fmt: skip
        """Values of the states and of the discrete variables that event k sets."""
        item, offer = self.planned[k], self.planned[k].offer
        if self.heard is not None:
            self.heard(k, t, x, z, q)

        def put(expression: ca.SX) -> ca.SX:
            return ca.substitute([expression], [offer.given], [ca.SX(ca.DM(item.given))])[0] if len(item.given) \
                else expression  # fmt: skip

        function = at.functions.function("offered", [put(offer.state_values), put(offer.discrete_values)])
        states, discretes = (np.array(values).ravel() for values in at.call(function, t, x, z, q))
        if not (np.all(np.isfinite(states)) and np.all(np.isfinite(discretes))):
            raise SimulationError(f"the event {item.label} sets a value that is not a finite number (t = {t:g} s).")
        item.done = True
        self.happened.append(f"t = {t:.9g} s: {item.label}")
        return states, discretes

    def settings(self) -> list[list[Any]]:
        """What must be the same for a run to go on exactly."""
        return [[item.label, item.at, *item.given.tolist()] for item in self.planned]

    def missing(self) -> list[str]:
        """Sentences about what has not happened."""
        return [
            f"the event {item.label} did not happen: " + (
                "its condition did not become true." if item.at is None else f"the run ends before {item.at:g} s.")
            for item in self.planned if not item.done
        ]  # fmt: skip
