"""The catalogue of parts: every public component class with what it declares, from the declarations themselves."""

from __future__ import annotations

import inspect
from dataclasses import dataclass
from typing import Any, get_args

from fowtlib.language.component import Component
from fowtlib.language.connectors import RealOutput, Signal
from fowtlib.language.declarations import SHAPES, Field, Parameter, Port, Variable
from fowtlib.language.offered import OfferedEvent
from fowtlib.modelfile import catalogue as library

KINDS = ("parameters", "ports", "variables", "events")


@dataclass(frozen=True)
class Entry:
    """One declaration: its name, its type, unit, default value (parameters) or nature (ports), and its sentence."""

    name: str
    type: str
    unit: str
    default: str
    doc: str


@dataclass(frozen=True)
class Class:
    """A component class: its group (the package it lives in), its docstring, its declarations in order."""

    name: str
    group: str
    doc: str
    parameters: tuple[Entry, ...]
    ports: tuple[Entry, ...]
    variables: tuple[Entry, ...]
    events: tuple[Entry, ...]

    @property
    def summary(self) -> str:
        """The first paragraph of the docstring on one line."""
        return " ".join(self.doc.partition("\n\n")[0].split())


def classes() -> list[Class]:
    """Every public component class of the library, by group and name."""
    return sorted(map(_describe, library.classes().values()), key=lambda item: (item.group, item.name))


def _describe(item: type[Component]) -> Class:
    return Class(
        item.__name__,
        item.__module__.split(".")[2],
        inspect.getdoc(item) or "",
        tuple(_entry(field, _default(field)) for field in item.parameters.values()),
        tuple(_entry(field, _nature(field)) for field in item.ports.values()),
        tuple(_entry(field, "") for field in item.variables.values()),
        tuple(_event(field) for field in item.offered_events.values()),
    )


def _entry(field: Parameter | Port | Variable, default: str) -> Entry:
    acausal = isinstance(field, Port) and not issubclass(field.annotation, Signal)
    return Entry(field.name, _type(field), "" if acausal else field.unit, default, field.doc)


def _event(field: OfferedEvent) -> Entry:
    values = (name if item.unit == "1" else f"{name} [{item.unit}]" for name, item in field.values.items())
    return Entry(field.name, ", ".join(values), "", "", field.doc)


def _type(field: Field) -> str:
    if getattr(field, "choices", None):
        return " | ".join(map(str, _choices(field)))
    name = getattr(field.annotation, "__name__", str(field.annotation))
    if isinstance(field, Parameter) and field.is_data:
        return f"file or {', '.join(getattr(item, '__name__', str(item)) for item in get_args(field.annotation))}"
    shape = getattr(field, "shape", None)
    if shape is not None and not inspect.isfunction(shape):
        sizes = shape if isinstance(shape, (tuple, list)) else (shape,)
        name += "[" + ", ".join(map(str, sizes)) + "]"
    size = getattr(field, "size", None)
    return f"array of {name}" if size is not None else name


def _choices(field: Parameter) -> list[Any]:
    """The possible values; of the kinds of a family those of the library, not what else is loaded."""
    family = getattr(field.owner, "family", None)
    if family is None or field is not family.field:
        return list(field.choices)
    return [kind for kind, item in family.kinds.items() if item in library.classes().values()]


def _default(field: Parameter) -> str:
    if field.required:
        return "required"
    if inspect.isfunction(field.default):
        return "computed"
    if field.default is None:
        return ""
    if field.annotation in SHAPES and isinstance(field.default, (tuple, list)):
        return "(" + ", ".join(f"{value}" for value in field.default) + ")"
    return _text(field.default)


def _nature(field: Port) -> str:
    if field.annotation is RealOutput:
        return ""
    if field.optional:
        return "may stay open"
    return "required" if field.default is None else f"{_text(field.default)} when open"


def _text(value: Any) -> str:
    if isinstance(value, float):
        return f"{value:g}"
    return " ".join(str(value).split())  # a matrix would end the line of its table


def markdown(items: list[Class]) -> str:
    """The catalogue as a page of the documentation."""
    lines = [
        "# Catalogue of parts",
        "",
        "Made by `make catalogue` from the docstrings and declarations of the component classes; do not edit.",
        "On the terminal: `fowt parts`, and `fowt parts CLASS` for one class.",
    ]
    for group in sorted({item.group for item in items}):
        lines += ["", f"## {group}"]
        for item in items:
            if item.group == group:
                lines += ["", f"### {item.name}", "", *_paragraphs(item.doc), *_table(item)]
    return "\n".join(lines) + "\n"


def _paragraphs(doc: str) -> list[str]:
    """The docstring as it stands in the source: indented lines and symbols keep their look."""
    return ["```text", *doc.splitlines(), "```"]


def _table(item: Class) -> list[str]:
    rows = [(kind[:-1], f"`{e.name}`", e.type, e.unit, e.default, e.doc) for kind in KINDS for e in getattr(item, kind)]
    if not rows:
        return []
    escaped = [" | ".join(cell.replace("|", "\\|") for cell in row) for row in rows]
    head = ["| kind | name | type | unit | default | |", "| --- | --- | --- | --- | --- | --- |"]
    return ["", *head, *(f"| {row} |" for row in escaped)]
