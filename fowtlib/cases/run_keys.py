"""The keys of a set that say what is run: model, wind, sea, parameters, events, start, times, outputs, solver."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from fowtlib.cases.folder import Folder
from fowtlib.cases.scope import Scope
from fowtlib.cases.values import plain, scalar, tidy, word
from fowtlib.language.errors import ModelError, one_of
from fowtlib.modelfile import files
from fowtlib.modelfile.document import STARTS
from fowtlib.modelfile.nodes import Node, Place
from fowtlib.modelfile.short_forms import WAVES, WIND, Condition
from fowtlib.modelfile.specs import as_list, mapping
from fowtlib.solving.timeline import Event

SECONDS = ("duration", "output_step", "discard", "step")
RUN_KEYS = ("model", "wind", "sea", "turbines", "set", "events", "start", *SECONDS, "outputs", "solver", "tolerance")
TURBINES = {
    "operation": {"*.safety.idling": 0, "*.safety.braked": 0},
    "idling": {"*.safety.idling": 1, "*.safety.braked": 0},
    "parked": {"*.safety.idling": 1, "*.safety.braked": 1},
}
"""What the turbines of a model do from the start on: in words, and by parameters of their safety systems."""
CONDITIONS: dict[str, Condition] = {"wind": replace(WIND, option="wind"), "sea": replace(WAVES, option="sea")}

Layers = tuple[Mapping[str, Node], ...]
"""The keys of the defaults, and those of a set."""


class RunKeys:
    """Reads them for one case after the other; `files` collects the files that cases name."""

    def __init__(self, folder: Folder):
        self.folder = folder
        self.files: dict[Path, None] = {}
        self._models: dict[str, str] = {}

    def read(self, layers: Layers, scope: Scope) -> tuple[dict[str, Any], dict[str, Place]]:
        """Fields of a Case, and where they are written; parameters go by their path."""
        given = {key: node for layer in layers for key, node in layer.items()}
        places: dict[str, Place] = {"": scope.place}
        fields: dict[str, Any] = {"parameters": self.parameters(layers, scope, places)}
        for key in SECONDS:
            if key in given:
                fields[key] = _time(given[key], key, scope)
        if "tolerance" in given:
            value = scalar(given["tolerance"], "tolerance", scope, "1")
            fields["tolerance"] = _positive(given["tolerance"], "tolerance", value)
        if "model" in given:
            fields["model"] = self.model(given["model"], scope)
        for key in ("solver", "start"):
            if key in given:
                fields[key] = word(given[key], key, scope)
        if "start" in given:
            fields["start"] = self.start(fields["start"], given["start"].place)
        if "outputs" in given:
            fields["outputs"] = tuple(word(item, "outputs", scope) for item in as_list(given["outputs"]))
        if "events" in given:
            fields["events"] = _events(given["events"], scope)
        places |= {key: node.place for key, node in given.items() if key in RUN_KEYS}
        if fields.get("discard", 0.0) >= fields.get("duration", math.inf):
            raise places["discard"].error(
                f"discard: {fields['discard']:g} s of a run of {fields['duration']:g} s leave nothing."
            )
        return fields, places

    def parameters(self, layers: Layers, scope: Scope, places: dict[str, Place]) -> dict[str, Any]:
        """Values by path: wind, sea and `set`, those of the set of cases over those of the defaults."""
        values: dict[str, Any] = {}
        for layer in layers:
            for part, condition in CONDITIONS.items():
                if part in layer:
                    more = self.condition(condition, layer[part], scope, places)
                    if f"{part}.{condition.selector}" in more:  # another wind altogether
                        values = {path: value for path, value in values.items() if not path.startswith(f"{part}.")}
                    values |= more
        for layer in layers:
            if "turbines" in layer:
                values |= self.turbines(layer["turbines"], scope, places)
        for layer in layers:
            for path, node in self._entries(layer.get("set")).items():
                values[path] = self.value(path, node, scope)
                places[path] = node.place
        return values

    def condition(self, condition: Condition, node: Node, scope: Scope, places: dict[str, Place]) -> dict[str, Any]:
        """Wind or sea, in the words of the model file or in the short form of the command line."""
        if isinstance(node.value, str):
            text = word(node, condition.part, scope, units=True)
            try:
                values = condition.parse(text, self.folder.path)
                values = {path: tidy(value) if isinstance(value, float) else value for path, value in values.items()}
            except ModelError as error:
                raise node.place.error(f"{error}{_braces(node.value, scope)}") from None
            places |= dict.fromkeys(values, node.place)
            return {path: self._file(path, value, node.place) for path, value in values.items()}
        form = condition.form(list(condition.kinds)[1])
        what = f"'{condition.part}' is a mapping, as in a model file, or a short form such as '{form}'"
        values = {}
        for key, item in mapping(node, what).items():
            path = f"{condition.part}.{key}"
            values[path] = self.value(path, item, scope)
            places[path] = item.place
        return values

    @staticmethod
    def turbines(node: Node, scope: Scope, places: dict[str, Place]) -> dict[str, Any]:
        """Parameters of a word of TURBINES."""
        what = word(node, "turbines", scope)
        if what not in TURBINES:
            raise node.place.error(f"turbines: '{what}' is not {one_of(TURBINES)}.")
        places |= dict.fromkeys(TURBINES[what], node.place)
        return dict(TURBINES[what])

    def value(self, path: str, node: Node, scope: Scope) -> Any:
        """The value of a parameter; relative names of files begin at the folder of the cases file."""
        if node.value is None:
            raise node.place.error(f"{path} has no value.")
        return self._file(path, plain(node, scope), node.place)

    def model(self, node: Node, scope: Scope) -> str:
        """A shipped name, or the whole path of a model file; relative ones begin at the folder of the cases file."""
        name = word(node, "model", scope)
        if name not in self._models:
            try:
                if "." not in name and "/" not in name and not files.is_file(self.folder.path / name):
                    files.find_model(name)  # one that is shipped, or an error
                    self._models[name] = name
                else:
                    path = files.find_model(self.folder.allowed(name))
                    self.files[path] = None
                    self._models[name] = str(path)
            except ModelError as error:
                raise node.place.error(f"model: {error}") from None
        return self._models[name]

    def start(self, text: str, place: Place) -> str:
        """A word, or the whole path of a result or a state."""
        if text in STARTS:
            return text
        if Path(text).suffix not in (".nc", ".json"):
            files_too = "a file of a result (.nc) or a state (.json)"
            raise place.error(f"start: '{text}' is not {one_of(STARTS)}, nor {files_too}.")
        try:
            path = self.folder.find(text)
        except ModelError as error:
            raise place.error(f"start: {error}") from None
        self.files[path] = None
        return str(path)

    @staticmethod
    def _entries(node: Node | None) -> dict[str, Node]:
        return mapping(node, "'set' is a mapping of parameters by path, such as sea.heading: 30 deg") if node else {}

    def _file(self, path: str, value: Any, place: Place) -> Any:
        """A value that names a file with its whole path, of one that may be read; others as they are."""
        if not isinstance(value, str) or not files.names_file(path.rpartition(".")[2], value):
            return value
        try:
            found = self.folder.allowed(value)
        except ModelError as error:
            raise place.error(f"{path}: {error}") from None
        if files.is_file(found) and not value.startswith(files.DATA_PREFIX):
            self.files[found] = None
        return str(found)


def _time(node: Node, key: str, scope: Scope) -> float:
    seconds = scalar(node, key, scope, "s")
    return seconds if key == "discard" and seconds == 0 else _positive(node, key, seconds, " s")


def _positive(node: Node, key: str, value: float, unit: str = "") -> float:
    if not (value > 0 and math.isfinite(value)):
        raise node.place.error(f"{key} is {value:g}{unit}; it must be above zero, and finite.")
    return value


def _events(node: Node, scope: Scope) -> tuple[dict[str, Any], ...]:
    return tuple(_event(event, scope) for event in ([] if node.value is None else as_list(node)))


def _event(node: Node, scope: Scope) -> dict[str, Any]:
    """{event: turbine.grid_loss, at: 100 s, ...}, or the same as a line: turbine.grid_loss at 100 s."""
    try:
        if isinstance(node.value, str):
            return Event.parse(word(node, "events", scope, units=True)).plain()
        event = "an event is a mapping, such as {event: turbine.grid_loss, at: 100 s}, or a line of text"
        return Event.from_plain(plain(Node(mapping(node, event), node.place), scope)).plain()
    except ModelError as error:
        raise error if error.where else node.place.error(f"events: {error}") from None


def _braces(text: str, scope: Scope) -> str:
    """A hint where a variable stands in a short form as in a formula."""
    bare = [name for name in scope.names if name in text and f"{{{name}" not in text]
    return f" A variable stands in braces here: {{{bare[0]}}}." if bare else ""
