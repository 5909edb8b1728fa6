"""The JSON schema of model files, for editors: keys, classes, parameters with types, units, bounds and descriptions."""

from __future__ import annotations

import inspect
import math
from typing import Any

from fowtlib.language.bounds import POSITIVE
from fowtlib.language.component import Component
from fowtlib.language.declarations import SHAPES, Parameter, Scalar
from fowtlib.modelfile import catalogue, reader
from fowtlib.modelfile.document import SETTINGS, VERSION

Schema = dict[str, Any]

_TEXT: Schema = {"type": "string"}
_REFERENCE = "#/$defs/"
_KEYS: dict[str, Schema] = {
    "class": {**_TEXT, "description": "class of the component, from the catalogue (`fowt parts`)"},
    "use": {**_TEXT, "description": "definition file; the keys beside it override it"},
    "parameters": {
        "description": "quantities with names, for formulas; they are parameters of the model",
        "type": "object",
        "additionalProperties": {"$ref": _REFERENCE + "declared"},
    },
    "parts": {
        "description": "components by name",
        "type": "object",
        "additionalProperties": {"$ref": _REFERENCE + "part"},
    },
    "each": {
        "description": "repeat parts and connections for every mapping in 'for'; {name} stands for its values",
        "anyOf": [{"type": "array", "items": {"$ref": _REFERENCE + "each"}}, {"$ref": _REFERENCE + "each"}],
    },
    "connect": {
        "description": "ports that are joined",
        "type": "array",
        "items": {"type": "array", "items": _TEXT, "minItems": 2},
    },
    "ports": {
        "description": "ports of parts under names of this component",
        "type": "object",
        "additionalProperties": _TEXT,
    },
}


def schema() -> Schema:
    """The schema (JSON Schema draft 7) of a model file, made from the declarations of the catalogue."""
    classes = catalogue.classes()
    part: Schema = {
        "type": "object",
        "properties": {"class": {"enum": list(classes)}},
        "allOf": [{"if": _is_class(name), "then": {"$ref": f"{_REFERENCE}class {name}"}} for name in classes],
    }
    return {
        "$schema": "http://json-schema.org/draft-07/schema#",
        "title": "fowtlib model file",
        "type": "object",
        "required": ["fowtlib"],
        "properties": _top_keys(),
        "additionalProperties": {"anyOf": [{"$ref": _REFERENCE + "part"}, {"$ref": _REFERENCE + "any value"}]},
        "$defs": {
            "part": part,
            "each": _each(),
            "declared": _declared(),
            "any value": {"type": ["number", "string", "boolean", "array", "null"]},
            **{f"class {name}": _class(item) for name, item in classes.items()},
        },
    }


_BY_PATH = {"type": "object", "additionalProperties": {"type": ["number", "string", "boolean", "null"]}}
_EQUILIBRIUM = {"free": {"anyOf": [_TEXT, {"type": "array", "items": _TEXT}, _BY_PATH]}, "targets": _BY_PATH,
                "set": _BY_PATH}  # fmt: skip


def _top_keys() -> Schema:
    output = {
        "anyOf": [
            _TEXT,
            {
                "type": "object",
                "properties": dict.fromkeys(reader.OUTPUT_KEYS, _TEXT),
                "required": ["of"],
                "additionalProperties": False,
            },
        ]
    }
    settings = {key: _TEXT if not unit else _quantity(unit) for key, unit in SETTINGS.items()}
    return {
        "fowtlib": {"const": VERSION, "description": "version of the format"},
        "title": {"type": ["string", "number"]},
        "description": {"type": ["string", "number"]},
        "python": {"anyOf": [_TEXT, {"type": "array", "items": _TEXT}], "description": "Python files with own classes"},
        **_KEYS,
        "outputs": {"type": "object", "additionalProperties": output, "description": "results by name"},
        "events": {"anyOf": [{"type": "array", "items": _event()}, _event()], "description": "what happens in a run"},
        "simulation": {"type": "object", "properties": settings, "additionalProperties": False},
        "equilibrium": {
            "type": "object",
            "properties": _EQUILIBRIUM,
            "required": ["free", "targets"],
            "additionalProperties": False,
            "description": "parameters that take the values at which conditions hold at the mean position",
        },
    }


def _event() -> Schema:
    keys = {
        "event": {**_TEXT, "description": "an event that a part offers, by its path (`fowt events`)"},
        "at": {**_quantity("s"), "description": "time of the event"},
        "when": {**_TEXT, "description": "instead of the time: result or path > value, or < value"},
    }
    more = {"type": ["number", "string"], "description": "a value that the event takes"}
    return {"type": "object", "properties": keys, "required": ["event"], "additionalProperties": more}


def _each() -> Schema:
    value = {"type": ["number", "string", "boolean"]}
    names = {"anyOf": [{"type": "object", "additionalProperties": value}]}
    keys = {key: item for key, item in _KEYS.items() if key in reader.EACH_KEYS}
    return {
        "type": "object",
        "required": ["for"],
        "properties": {
            "for": {"anyOf": [{"type": "array", "items": names}, names]},
            **keys,
            "outputs": {"type": "object"},
        },
        "additionalProperties": False,
    }


def _declared() -> Schema:
    value: Schema = {"type": ["number", "string", "array"]}
    keys = {"value": value, "unit": _TEXT, "description": _TEXT, "min": value, "max": value}
    long_form = {"type": "object", "properties": keys, "required": ["value"], "additionalProperties": False}
    return {"anyOf": [value, long_form]}


def _is_class(name: str) -> Schema:
    return {"properties": {"class": {"const": name}}, "required": ["class"]}


def _class(item: type[Component]) -> Schema:
    family = item.family
    parameters = family.parameters if family is not None and item is family.base else item.parameters
    required = [field.name for field in parameters.values() if field.required]
    return {
        "description": (inspect.getdoc(item) or "").partition("\n\n")[0],
        "properties": {**_KEYS, **{name: _parameter(field) for name, field in parameters.items()}},
        "required": required,
        "additionalProperties": False,
    }


def _parameter(field: Parameter) -> Schema:
    unit = "" if field.unit == "1" else f" [{field.unit}]"
    about: Schema = {"description": f"{field.doc}{unit}"}
    if isinstance(field.default, (bool, int, float, str)) and field.default not in (math.inf, -math.inf):
        about["default"] = field.default
    return {**_type(field), **about}


def _type(field: Parameter) -> Schema:
    if field.choices:
        return {"enum": list(field.choices)}
    if field.annotation is bool:
        return {"type": "boolean"}
    if field.annotation is str or field.is_data:
        return {"type": ["string", "number", "null"]}
    if field.annotation in (int, float, Scalar):
        return _quantity(field.unit, field)
    if field.annotation in SHAPES:
        return {"type": ["array", "number", "string"]}
    return {}


def _quantity(unit: str, field: Parameter | None = None) -> Schema:
    """A number in SI within the bounds, or text: a number with a unit, or a formula."""
    number: Schema = {"type": "number"}
    if field is not None:
        lowest = "exclusiveMinimum" if field.min == POSITIVE else "minimum"
        bounds = {lowest: 0 if field.min == POSITIVE else field.min, "maximum": field.max}
        numeric = {key: bound for key, bound in bounds.items() if isinstance(bound, (int, float))}
        number |= {key: bound for key, bound in numeric.items() if math.isfinite(bound)}
    choices = [number, {"type": "string", "description": f"number with a unit, or a formula [{unit}]"}]
    return {"anyOf": [*choices, {"type": "null"}] if field is not None and field.default is None else choices}
