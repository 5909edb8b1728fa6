"""What varies in a set of cases: lists, ranges `4:24:2`, lists that go together (`zip`), and their product."""

from __future__ import annotations

import itertools
import math
import re
from collections.abc import Iterator
from decimal import Decimal
from pathlib import Path

from fowtlib.cases import csv_tables
from fowtlib.cases.folder import Folder
from fowtlib.cases.values import Item, Names, evaluate
from fowtlib.language.errors import ModelError
from fowtlib.modelfile import formulas
from fowtlib.modelfile.nodes import Node, Place, from_python
from fowtlib.modelfile.specs import identifier, mapping

MOST_CASES = 100_000
ZIP = "zip"
_NUMBER = r"[+-]?(?:\d+(?:\.\d*)?|\.\d+)(?:[eE][+-]?\d+)?"
_RANGE = re.compile(rf"\s*({_NUMBER})\s*:\s*({_NUMBER})\s*:\s*({_NUMBER})\s*(\S.*)?")
FORM = "a list [4, 8], a range first:last:step such as 4:24:2, or one value"

Row = dict[str, Item]


class Product:
    """The product of axes; the first varies slowest. Nothing of it is held but the axes."""

    def __init__(self, axes: list[list[Row]]):
        self.axes = axes
        self.size = math.prod(len(axis) for axis in axes)

    @property
    def names(self) -> list[str]:
        """The variables, in order."""
        return [name for axis in self.axes for name in axis[0]]

    def __iter__(self) -> Iterator[Row]:
        for rows in itertools.product(*self.axes):
            yield {name: item for row in rows for name, item in row.items()}


def product(node: Node | None, names: Names, folder: Folder, files: list[Path]) -> Product:
    """The product that `vary` says; a file that is read is added to `files`."""
    axes: list[list[Row]] = []
    for key, item in mapping(node, f"'vary' is a mapping; a variable has {FORM}").items() if node else ():
        if key == ZIP:
            for part in item.value if isinstance(item.value, list) else [item]:
                axes.append(_together(part, names, folder, files))
        else:
            variable(key, item.place)
            axes.append([{key: value} for value in _values(key, item, names)])
    result = Product(axes)
    for name in result.names:
        if result.names.count(name) > 1:
            assert node is not None
            raise node.place.error(f"'{name}' varies twice.")
    return result


def variable(name: str, place: Place) -> str:
    """The name, which must be one that a formula can use."""
    identifier(name, "variable", place)
    if name in formulas.FUNCTIONS or name in formulas.CONSTANTS:
        raise place.error(f"'{name}' has a meaning in formulas; give the variable another name.")
    return name


def spread(text: str, place: Place) -> list[Item] | None:
    """The values of a range, both ends included; None for another text."""
    match = _RANGE.fullmatch(text)
    if match is None:
        return None
    first, last, step = (Decimal(match[k]) for k in (1, 2, 3))
    if step == 0 or (last - first) * step < 0:
        raise place.error(f"the range {text} does not lead from {first} to {last}; write first:last:step.")
    count = (last - first) / step
    if count > MOST_CASES:
        raise place.error(f"the range {text} has more than {MOST_CASES} values, the limit of cases.")
    if count != int(count):
        end = first + int(count) * step
        raise place.error(f"the range {text} does not end at {last}; write {first}:{end}:{step}, or another step.")
    numbers = [first + k * step for k in range(int(count) + 1)]
    unit = match[4] or ""
    empty = _NoNames()
    values = [f"{value:f} {unit}" if unit else _plain(value) for value in numbers]
    return [evaluate(from_python(value, place), empty) for value in values]


def _plain(value: Decimal) -> int | float:
    return int(value) if value == int(value) else float(value)


def _values(key: str, node: Node, names: Names) -> list[Item]:
    if isinstance(node.value, list):
        if not node.value:
            raise node.place.error(f"'{key}' has an empty list, so that the set has no case.")
        items: list[Item] = []
        for item in node.value:
            items += _values(key, item, names) if not isinstance(item.value, list) else _nested(key, item)
        return items
    if node.value is None or isinstance(node.value, dict):
        raise node.place.error(f"'{key}' has {FORM}, not {node.kind}.")
    if isinstance(node.value, str):
        values = spread(node.value, node.place)
        if values is not None:
            return values
    return [evaluate(node, names)]


def _nested(key: str, node: Node) -> list[Item]:
    raise node.place.error(f"'{key}': a list within a list; lists that go together stand under '{ZIP}'.")


def _together(node: Node, names: Names, folder: Folder, files: list[Path]) -> list[Row]:
    """Lists of the same length, from a mapping or from the columns of a CSV file."""
    if isinstance(node.value, str):
        columns = csv_tables.read(node, folder, files)
        columns = {variable(name, node.place): items for name, items in columns.items()}
    else:
        entries = mapping(node, f"'{ZIP}' is a mapping of lists of the same length, or the name of a CSV file")
        columns = {variable(key, item.place): _values(key, item, names) for key, item in entries.items()}
    lengths = {name: len(items) for name, items in columns.items()}
    if not columns:
        raise node.place.error(f"'{ZIP}' holds no list.")
    if len(set(lengths.values())) > 1:
        told = ", ".join(f"{name} has {length}" for name, length in lengths.items())
        raise node.place.error(f"the lists of '{ZIP}' have the same length; {told}.")
    return [dict(zip(columns, row, strict=True)) for row in zip(*columns.values(), strict=True)]


class _NoNames:
    names: tuple[str, ...] = ()

    def item(self, name: str) -> Item:
        raise ModelError(f"there is no variable '{name}'.")
