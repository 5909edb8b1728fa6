"""What a model file says, key by key: nodes -> specifications of components, with `each` repeated.

A file is one component: its parts, parameters and connections, and for a model its outputs and simulation settings
beside them. A definition, which `use:` includes, is a file without those last two.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

from fowtlib.language.errors import ModelFileError, ParameterError, UnitError, closest, one_of
from fowtlib.language.units import to_si
from fowtlib.modelfile import files
from fowtlib.modelfile.nodes import Node, Place, parse, read_text
from fowtlib.modelfile.reader import ComponentReader
from fowtlib.modelfile.specs import Document, Spec, Value, as_list, check_keys, mapping, text, text_node
from fowtlib.solving.settings import Settings
from fowtlib.solving.starts import KINDS as STARTS
from fowtlib.solving.timeline import Event

SETTINGS = {
    "solver": "", "duration": "s", "output_step": "s", "tolerance": "1", "step": "s", "rho_inf": "1", "start": "",
}  # fmt: skip
EQUILIBRIUM = ("free", "targets", "set")
VERSION = 1
META_KEYS = ("fowtlib", "title", "description", "python", "outputs", "simulation", "events", "equilibrium")


def read(path: Path, definition: bool = False) -> Document:
    """Read a model file, or a definition file."""
    name = files.shown(path)
    return document(parse(read_text(path, name), name), path, definition)


def document(top: Node, path: Path, definition: bool = False) -> Document:
    """The document with this node at its top."""
    items = mapping(top, "a model file is a mapping; its first line is 'fowtlib: 1'")
    _check_version(items, top.place)
    for key in ("outputs", "simulation", "events", "equilibrium") if definition else ():
        if key in items:
            raise items[key].place.error(f"'{key}' belongs into the model file, not into a definition.")
    spec = Spec(top.place)
    result = Document(path, spec, text(items, "title") or path.stem, text(items, "description"))
    spec.document = result
    reader = ComponentReader(result)
    if "outputs" in items:
        reader.outputs(items["outputs"], {})
    reader.component(spec, {key: node for key, node in items.items() if key not in META_KEYS}, {}, top_level=True)
    if "python" in items:
        result.python = [Value(node) for node in as_list(items["python"])]
    if "simulation" in items:
        result.settings = _settings(items["simulation"])
    if "events" in items:
        result.settings["events"] = tuple(_event(item) for item in as_list(items["events"]))
    if "equilibrium" in items:
        result.settings["equilibrium"] = _equilibrium(items["equilibrium"])
    return result


def _equilibrium(node: Node) -> dict[str, dict[str, Any]]:
    """Freed parameters, conditions, and parameters of the state at which these hold, each by path."""
    items = mapping(node, f"'equilibrium' is a mapping: {', '.join(EQUILIBRIUM)}")
    check_keys(items, EQUILIBRIUM, "'equilibrium'")
    found: dict[str, dict[str, Any]] = {}
    for key, item in items.items():
        if key == "free" and isinstance(item.value, (list, str)):
            found[key] = {text_node(path, "the path of a parameter").value: None for path in as_list(item)}
            continue
        found[key] = {}
        for path, value in mapping(item, f"equilibrium.{key} is a mapping from paths to values").items():
            if isinstance(value.value, (list, dict)):
                raise value.place.error(f"equilibrium.{key}: {path} is one value, not {value.kind}.")
            found[key][path] = value.value
    for key in ("free", "targets"):
        if not found.get(key):
            raise node.place.error(f"'equilibrium' has no {key}: give as many targets as freed parameters.")
    return found


def _check_version(items: dict[str, Node], place: Place) -> None:
    if "fowtlib" not in items:
        instead = closest("fowtlib", items)
        hint = f" ('{instead[0]}' is not that key)" if instead else ""
        raise place.error(f"the key 'fowtlib' is missing{hint}; a model file begins with 'fowtlib: {VERSION}'.")
    node = items["fowtlib"]
    if node.quoted and node.value.strip() == str(VERSION):
        raise node.place.error(f"write 'fowtlib: {VERSION}', without quotes: the version is a number.")
    if isinstance(node.value, bool) or node.value != VERSION:
        shown = isinstance(node.value, (int, float, str)) and not isinstance(node.value, bool)
        given = f"'fowtlib: {node.value}'" if shown else f"{node.kind} behind 'fowtlib:'"
        raise node.place.error(f"got {given}; this version of the program reads 'fowtlib: {VERSION}'.")


def _event(node: Node) -> Event:
    items = mapping(node, "an event is a mapping, such as {event: turbine.grid_loss, at: 100 s}")
    for key, item in items.items():
        if isinstance(item.value, (list, dict, bool)) or item.value is None:
            raise item.place.error(f"'{key}' of an event is a number or text, not {item.kind}.")
    try:
        return Event.from_plain({key: item.value for key, item in items.items()}, str(node.place))
    except ParameterError as error:
        raise ModelFileError(error.message, where=error.where) from None


def _settings(node: Node) -> Settings:
    items = mapping(node, f"'simulation' is a mapping: {', '.join(SETTINGS)}")
    check_keys(items, SETTINGS, "'simulation'")
    settings = Settings(places={key: f"{item.place}: simulation.{key}" for key, item in items.items()})
    for key, item in items.items():
        if isinstance(item.value, (list, dict)):
            raise item.place.error(f"simulation.{key} is one value, not {item.kind}.")
        try:
            settings[key] = float(to_si(item.value, SETTINGS[key])) if SETTINGS[key] else text(items, key)
            if SETTINGS[key] and not math.isfinite(settings[key]):
                raise item.place.error(f"simulation.{key} is {settings[key]:g}; a finite number is expected.")
            if SETTINGS[key] and key != "rho_inf" and settings[key] <= 0:
                raise item.place.error(f"simulation.{key} is {settings[key]:g}; a number above zero is expected.")
        except UnitError as error:
            raise item.place.error(f"simulation.{key}: {error}") from None
    if settings.get("start", "file") not in STARTS:
        raise items["start"].place.error(f"simulation.start: '{settings['start']}' is not {one_of(STARTS)}.")
    return settings
