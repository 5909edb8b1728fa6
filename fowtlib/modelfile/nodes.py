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

MOST_NODES = 100_000  # values of a file, with aliases put in
DEEPEST = 50  # lists and mappings in each other
LARGEST = 4_000_000  # bytes of a file
BEGINS = "a model file begins with 'fowtlib: 1'"
LONG = 200_000  # letters from which on the reader with the better messages takes too long
_TAGS = tuple(f"tag:yaml.org,2002:{kind}" for kind in ("str", "seq", "map"))
_NUMBER = re.compile(r"[+-]?(\d+(\.\d*)?|\.\d+)([eE][+-]?\d+)?")
_WORDS = {"": None, "~": None, "null": None, "true": True, "false": False, ".inf": float("inf"), "-.inf": float("-inf")}
_FORM = r"[A-Za-z_]\w*(?::[\w.+-]*)?"  # of a name between braces, with how a number is written: {wind_speed:02.0f}
_PLACEHOLDER = re.compile(rf"(?<=[\w.\]}}]){{{_FORM}}}|{{{_FORM}}}(?=[\w.\[{{])")
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
        with path.open("rb") as file:
            content = file.read(LARGEST + 1)
        if len(content) > LARGEST:
            raise ModelFileError(
                f"the file has more than {LARGEST / 1e6:g} MB, the limit of a model file; put long lists of numbers "
                "into data files.", where=name,
            )  # fmt: skip
        return content.decode("utf-8").replace("\r\n", "\n").replace("\r", "\n")
    except UnicodeDecodeError as error:
        line = 1 + content.count(b"\n", 0, error.start)
        where = name if content.startswith((b"\xff\xfe", b"\xfe\xff")) or b"\0" in content else f"{name}:{line}"
        raise ModelFileError("this is not text in UTF-8; save the file in this encoding.", where=where) from None
    except OSError as error:
        raise ModelFileError(f"the file cannot be read: {error.strerror or error}.", where=name) from None


def parse(text: str, name: str, begins: str = BEGINS) -> Node:
    """The node at the top of a YAML document; `name` is how errors call the file, `begins` how it should begin."""
    import yaml

    hidden = text
    for pattern in (_INDEX, _PLACEHOLDER):
        hidden = pattern.sub(lambda found: found[0].translate(_HIDE), hidden)
    try:
        fast = getattr(yaml, "CBaseLoader", None)  # ten times as fast, where PyYAML has it
        if fast is not None:
            try:
                return _Reader(name, yaml.parse(hidden, Loader=fast)).document(begins)
            except yaml.YAMLError:
                if len(text) > LONG:
                    raise
        return _Reader(name, yaml.parse(hidden, Loader=yaml.BaseLoader)).document(begins)  # its errors say more
    except yaml.MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        raise Place(name, mark.line + 1 if mark else 0).error(f"this is not YAML: {_explained(error)}.") from None
    except yaml.YAMLError as error:
        raise ModelFileError(f"this is not YAML: {str(error).splitlines()[0]}.", where=name) from None


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
    """PyYAML's events -> nodes."""

    def __init__(self, name: str, events: Iterator[Any]):
        self.name = name
        self.events = events
        self.count = 0
        self.anchors: dict[str, tuple[Node, int] | None] = {}  # a node and how many it holds; None while it is read

    def document(self, begins: str) -> Node:
        """The only document of the file."""
        next(self.events)  # the stream begins
        if next(self.events).__class__.__name__ == "StreamEndEvent":
            raise ModelFileError(f"the file is empty; {begins}.", where=self.name)
        top = self.node(next(self.events), 0)
        next(self.events)  # the document ends
        more = next(self.events)
        if more.__class__.__name__ != "StreamEndEvent":
            raise self._place(more).error("this is not YAML: there is a second document; a file is one.")
        return top

    def node(self, event: Any, depth: int, place: Place | None = None) -> Node:
        """The node that begins with an event; `depth` counts those it stands in, `place` is that of its key."""
        place = place or self._place(event)
        kind = event.__class__.__name__
        if kind == "AliasEvent":
            return self._alias(event.anchor, place)
        self._counted(1, place)
        if depth > DEEPEST:
            raise place.error(f"lists and mappings are nested too deeply; the limit is {DEEPEST}.")
        if event.tag not in (None, "!", *_TAGS):
            tag = _short(event.tag.replace("tag:yaml.org,2002:", "!!"))
            raise place.error(f"the tag {tag} has no meaning here.")
        before = self.count
        if event.anchor is not None:
            if event.anchor in self.anchors:
                raise place.error(f"this is not YAML: found duplicate anchor '{event.anchor}'.")
            self.anchors[event.anchor] = None
        if kind == "ScalarEvent":
            node = Node(self._scalar(event), place, quoted=event.style not in (None, ""))
        elif kind == "SequenceStartEvent":
            node = Node(self._sequence(depth + 1), place)
        else:
            node = Node(self._mapping(depth + 1), place)
        if event.anchor is not None:
            self.anchors[event.anchor] = node, 1 + self.count - before
        return node

    def _alias(self, anchor: str, place: Place) -> Node:
        if anchor not in self.anchors:
            raise place.error(f"this is not YAML: found undefined alias '{anchor.translate(_SHOW)}'.")
        known = self.anchors[anchor]
        if known is None:
            raise place.error("an alias (*name) stands within the value it names.")
        node, size = known
        self._counted(size, place)
        return Node(node.value, place, node.quoted)

    def _counted(self, more: int, place: Place) -> None:
        self.count += more
        if self.count > MOST_NODES:
            filled = " when its aliases (*name) are put in" if self.anchors else ""
            raise place.error(
                f"the file becomes too large{filled}: it has more than {MOST_NODES} values. Long tables belong into a "
                "CSV file, which the model names."
            )

    def _sequence(self, depth: int) -> list[Node]:
        items = []
        while (event := next(self.events)).__class__.__name__ != "SequenceEndEvent":
            items.append(self.node(event, depth))
        return items

    def _mapping(self, depth: int) -> dict[str, Node]:
        values: dict[str, Node] = {}
        while (event := next(self.events)).__class__.__name__ != "MappingEndEvent":
            place = self._place(event)
            if event.__class__.__name__ != "ScalarEvent":
                raise place.error("a key must be a name; quote text that begins with a bracket or a brace.")
            key = event.value.translate(_SHOW)
            if key in values:
                raise place.error(f"'{_short(key)}' is given twice; the first is in line {values[key].place.line}.")
            if event.anchor is not None:
                self.anchors[event.anchor] = Node(key, place, quoted=True), 1
            values[key] = self.node(next(self.events), depth, place)
        return values

    def _scalar(self, node: Any) -> Any:
        text = node.value.translate(_SHOW)
        if node.style not in (None, ""):
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


def _short(text: str) -> str:
    return text if len(text) <= 60 else f"{text[:57]}..."
