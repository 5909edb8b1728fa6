"""A model file as data: what it says about each component, before any component exists."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from fowtlib.language.errors import closest, did_you_mean
from fowtlib.modelfile.nodes import Node, Place

Variables = Mapping[str, Node]
MOST_REPEATED = 20_000
_NAME = re.compile(r"[^\W\d]\w*")
_PLACEHOLDER = re.compile(r"\{(\w+)\}")


@dataclass(frozen=True)
class Value:
    """A value as it is written, with the variables of the `each` blocks around it."""

    node: Node
    variables: Variables = field(default_factory=dict)

    @property
    def place(self) -> Place:
        return self.node.place


@dataclass(frozen=True)
class Declared:
    """A parameter that a file declares: its value, and what is said about it."""

    value: Value
    unit: str = ""
    description: str = ""
    min: Value | None = None
    max: Value | None = None


@dataclass(frozen=True)
class Connection:
    """Ports that are joined."""

    ends: tuple[str, ...]
    place: Place


@dataclass
class Spec:
    """One component as it is written: its class or definition, values of parameters, what is in it."""

    place: Place
    class_name: Value | None = None
    use: Value | None = None
    values: dict[str, Value] = field(default_factory=dict)
    parameters: dict[str, Declared] = field(default_factory=dict)
    parts: dict[str, Spec] = field(default_factory=dict)
    connections: list[Connection] = field(default_factory=list)
    ports: dict[str, tuple[str, Place]] = field(default_factory=dict)
    document: Document | None = None


@dataclass
class OutputSpec:
    """A named result."""

    of: str
    place: Place
    unit: str = ""
    description: str = ""


@dataclass
class Document:
    """A model file or a definition file."""

    path: Path
    spec: Spec
    title: str = ""
    description: str = ""
    python: list[Value] = field(default_factory=list)
    outputs: dict[str, OutputSpec] = field(default_factory=dict)
    settings: dict[str, Any] = field(default_factory=dict)
    repeated: int = 0

    def repeat(self, place: Place) -> None:
        """Count a part, a connection, an output or a round of `each`."""
        self.repeated += 1
        if self.repeated > MOST_REPEATED:
            raise place.error(f"the file has more than {MOST_REPEATED} parts and connections; that is the limit.")


def mapping(node: Node, message: str) -> dict[str, Node]:
    """The entries of a mapping, or an error that says what is expected."""
    if not isinstance(node.value, dict):
        raise node.place.error(f"{message}, not {node.kind}.")
    return node.value


def check_keys(items: Mapping[str, Node], allowed: Collection[str], what: str) -> None:
    """Refuse keys that are not allowed."""
    for key, node in items.items():
        if key not in allowed:
            raise node.place.error(f"'{key}' is not a key of {what}{did_you_mean(key, allowed)}")


def text(items: Mapping[str, Node], key: str) -> str:
    """The text under a key; empty where there is none."""
    node = items.get(key)
    if node is None:
        return ""
    if isinstance(node.value, (list, dict, bool)) or node.value is None:
        raise node.place.error(f"'{key}' is text, not {node.kind}.")
    return str(node.value)


def substituted(template: str, variables: Variables, place: Place, formula: bool = False) -> str:
    """`rotor_{name}` with the variables put in; in a formula, a negative number gets parentheses.

    Outside of `each` blocks, where there are no variables, braces are ordinary text.
    """

    def put(found: re.Match[str]) -> str:
        name = found[1]
        if name not in variables:
            raise place.error(f"'{template}': there is no variable '{name}' here{did_you_mean(name, variables)}")
        value = variables[name].value
        if formula and isinstance(value, (int, float)) and value < 0 and found[0] != template.strip():
            return f"({value})"
        return str(value)

    return _PLACEHOLDER.sub(put, template) if variables else template


def words(node: Node) -> Iterator[str]:
    """All words in the text of a node, and the placeholders in its keys: what could name a parameter or a variable."""
    for inner in node.walk():
        if isinstance(inner.value, str):
            yield from _NAME.findall(inner.value)
        elif isinstance(inner.value, dict):
            for key in inner.value:
                yield from _PLACEHOLDER.findall(key)


def text_node(node: Node, what: str) -> Node:
    """The node, which must be text."""
    if not isinstance(node.value, str):
        raise node.place.error(f"{what} is expected, not {node.kind}.")
    return node


def identifier(name: str, what: str, place: Place) -> str:
    """The name, which must be one."""
    if not _NAME.fullmatch(name):
        raise place.error(f"'{name}' is not a name for a {what}; use letters, digits and underscores.")
    return name


def as_list(node: Node) -> list[Node]:
    """The items of a list; a single item may stand without brackets."""
    return node.value if isinstance(node.value, list) else [node]


def check_version(items: Mapping[str, Node], place: Place, key: str, version: int, first_line: str) -> None:
    """ModelFileError where a file is of another kind than its key says, or of another version.

    first_line: what the error says of how such a file begins.
    """
    if "fowtlib" in items:
        raise place.error(f"this is a model file; {first_line}.")
    if key not in items:
        instead = closest(key, items)
        hint = f" ('{instead[0]}' is not that key)" if instead else ""
        raise place.error(f"the key '{key}' is missing{hint}; {first_line}.")
    node = items[key]
    if isinstance(node.value, bool) or node.value != version:
        raise node.place.error(f"got '{key}: {node.plain()}'; this version of the program reads '{key}: {version}'.")
