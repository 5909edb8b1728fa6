"""Text of a model file -> a tree of nodes, each with its line, so that every error can name the place.

YAML is read with PyYAML's composer only: no tag is obeyed and no object is made. Plain scalars mean what they look
like (YAML 1.2: `1e6` is a number, `on` and `12:30` are text). Names such as `rotor_{name}` and `sum.u[0]` may stand
anywhere without quotes, also within a list, where YAML alone would see a mapping in the one and a list in the other.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from fowtlib.language.errors import ModelFileError

MOST_NODES = 100_000
_NUMBER = re.compile(r"[+-]?(\d+(\.\d*)?|\.\d+)([eE][+-]?\d+)?")
_WORDS = {"": None, "~": None, "null": None, "true": True, "false": False, ".inf": float("inf"), "-.inf": float("-inf")}
_PLACEHOLDER = re.compile(r"(?<=[\w.\]}])\{([A-Za-z_]\w*)\}|\{([A-Za-z_]\w*)\}(?=[\w.\[{])")
_INDEX = re.compile(r"(?<=[\w}])\[\s*(?:\d+|\{\w+\})\s*(?:,\s*(?:\d+|\{\w+\})\s*)?\]")
_SIGNS = "{}[],"
_HIDDEN = "\ue000\ue001\ue002\ue003\ue004"  # the signs in names, while YAML reads the text
_HIDE, _SHOW = str.maketrans(_SIGNS, _HIDDEN), str.maketrans(_HIDDEN, _SIGNS)


@dataclass(frozen=True)
class Place:
    """A line of a file; or, with line 0, the name of another origin, such as an option of the command line."""

    file: str
    line: int = 0

    def __str__(self) -> str:
        return f"{self.file}:{self.line}" if self.line else self.file

    def error(self, message: str) -> ModelFileError:
        """The error with this place in front."""
        return ModelFileError(message, where=str(self))


@dataclass(frozen=True)
class Node:
    """A value: None, bool, int, float, str, a list of nodes, or nodes by key. `place` of a mapping's value: its key."""

    value: Any
    place: Place
    quoted: bool = False

    @property
    def kind(self) -> str:
        """What a person calls the value."""
        names = {list: "a list", dict: "a mapping", str: "text", bool: "true or false", type(None): "nothing"}
        return names.get(type(self.value), "a number")

    def walk(self) -> Iterator[Node]:
        """The node itself and all nodes in it."""
        yield self
        children = self.value.values() if isinstance(self.value, dict) else self.value
        for child in children if isinstance(self.value, (dict, list)) else ():
            yield from child.walk()

    def plain(self) -> Any:
        """The value as numbers, text, lists and dictionaries."""
        if isinstance(self.value, dict):
            return {key: node.plain() for key, node in self.value.items()}
        if isinstance(self.value, list):
            return [node.plain() for node in self.value]
        return self.value


def from_python(value: Any, place: Place) -> Node:
    """A node for a value that comes from Python or the command line."""
    if hasattr(value, "tolist"):
        value = value.tolist()
    if isinstance(value, dict):
        value = {str(key): from_python(item, place) for key, item in value.items()}
    elif isinstance(value, (list, tuple)):
        value = [from_python(item, place) for item in value]
    elif isinstance(value, Path):
        value = str(value)
    elif value is not None and not isinstance(value, (bool, int, float, str)):
        raise place.error(f"got {value!r}; a number, text or a list is expected.")
    return Node(value, place)


def read_text(path: Path, name: str) -> str:
    """Text of a file; `name` is how errors call it."""
    try:
        return path.read_text(encoding="utf-8")
    except UnicodeDecodeError:
        raise ModelFileError("the file is not text in UTF-8.", where=name) from None
    except OSError as error:
        raise ModelFileError(f"the file cannot be read: {error.strerror}.", where=name) from None


def parse(text: str, name: str) -> Node:
    """The node at the top of a YAML document; `name` is how errors call the file."""
    import yaml

    hidden = text
    for pattern in (_INDEX, _PLACEHOLDER):
        hidden = pattern.sub(lambda found: found[0].translate(_HIDE), hidden)
    try:
        top = yaml.compose(hidden, Loader=yaml.BaseLoader)
        if top is None:
            raise ModelFileError("the file is empty; a model file begins with 'fowtlib: 1'.", where=name)
        return _Reader(name).node(top, ())
    except yaml.MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        raise Place(name, mark.line + 1 if mark else 0).error(f"this is not YAML: {_explained(error)}.") from None
    except yaml.YAMLError as error:
        raise ModelFileError(f"this is not YAML: {str(error).splitlines()[0]}.", where=name) from None
    except RecursionError:
        raise ModelFileError("lists and mappings are nested too deeply.", where=name) from None


def _explained(error: Any) -> str:
    problem, context = error.problem or "", error.context or ""
    if "'\\t'" in problem:
        return "there is a tab; indent with spaces"
    if problem == "mapping values are not allowed here":
        return "there is a colon too many, or the line is indented wrongly; quote text that holds ': '"
    visible = problem.replace("<block end>", "another indentation")
    for sign, code in zip(_SIGNS, ("\\ue000", "\\ue001", "\\ue002", "\\ue003", "\\ue004"), strict=True):
        visible = visible.replace(code, sign)
    return f"{visible} {context}".strip() if context else visible


class _Reader:
    """PyYAML's nodes -> ours."""

    def __init__(self, name: str):
        self.name = name
        self.count = 0

    def node(self, node: Any, enclosing: tuple[int, ...], place: Place | None = None) -> Node:
        """Convert a node; `enclosing` are the ids of those it stands in, `place` that of its key."""
        place = place or self._place(node)
        self.count += 1
        if self.count > MOST_NODES:
            raise place.error("the file becomes too large when its aliases (*name) are put in.")
        if id(node) in enclosing:
            raise place.error("an alias (*name) stands within the value it names.")
        if not node.tag.startswith("tag:yaml.org,2002:") or node.tag.rpartition(":")[2] not in ("str", "seq", "map"):
            raise place.error(f"the tag {node.tag.replace('tag:yaml.org,2002:', '!!')} has no meaning in a model file.")
        if node.id == "scalar":
            return Node(self._scalar(node), place, quoted=node.style is not None)
        enclosing = (*enclosing, id(node))
        if node.id == "sequence":
            return Node([self.node(item, enclosing) for item in node.value], place)
        return Node(self._mapping(node, enclosing), place)

    def _mapping(self, node: Any, enclosing: tuple[int, ...]) -> dict[str, Node]:
        values: dict[str, Node] = {}
        for key_node, value_node in node.value:
            place = self._place(key_node)
            if key_node.id != "scalar":
                raise place.error("a key must be a name; quote text that begins with a bracket or a brace.")
            key = key_node.value.translate(_SHOW)
            if key in values:
                raise place.error(f"'{key}' is given twice; the first is in line {values[key].place.line}.")
            values[key] = self.node(value_node, enclosing, place)
        return values

    def _scalar(self, node: Any) -> Any:
        text = node.value.translate(_SHOW)
        if node.style is not None:
            return text
        if text.lower() in _WORDS:
            return _WORDS[text.lower()]
        if _NUMBER.fullmatch(text):
            return int(text) if re.fullmatch(r"[+-]?\d{1,18}", text) else float(text)
        return text

    def _place(self, node: Any) -> Place:
        return Place(self.name, node.start_mark.line + 1)


def looks_like_text(text: str) -> bool:
    """True where the text, written without quotes, is read as text."""
    return text.lower() not in _WORDS and not _NUMBER.fullmatch(text)
