"""Columns of a CSV file: names, with units where needed, in the first line; `#` begins a remark."""

from __future__ import annotations

import re
from pathlib import Path

from fowtlib.cases.folder import Folder
from fowtlib.cases.values import Item, as_quantity, number
from fowtlib.language.data_files import cells_of, lines_of
from fowtlib.language.errors import ModelError, ModelFileError, UnitError
from fowtlib.language.unit_grammar import parse_unit
from fowtlib.language.units import si_unit, to_si
from fowtlib.modelfile import files as file_names
from fowtlib.modelfile.nodes import Node

_HEAD = re.compile(r"([^\W\d]\w*)\s*(?:\[([^\]]*)\])?")


def read(node: Node, folder: Folder, files: list[Path]) -> dict[str, list[Item]]:
    """Columns by name of the file that a node names; its path is added to `files`."""
    try:
        path = folder.find(str(node.value))
        columns = _columns(path)
    except ModelError as error:
        raise node.place.error(str(error)) from None
    files.append(path)
    return columns


def _columns(path: Path) -> dict[str, list[Item]]:
    shown = file_names.shown(path)
    rows = [(number, cells_of(line)) for number, line in lines_of(path, "the table", ModelFileError)]
    if len(rows) < 2:
        raise ModelFileError(f"{shown}: a table has a line with the names of its columns, and rows under it.")
    heads = [_HEAD.fullmatch(text) for text in rows[0][1]]
    for text, head in zip(rows[0][1], heads, strict=True):
        if head is None:
            where = f"{shown}:{rows[0][0]}"
            raise ModelFileError(f"{where}: '{text}' is not the name of a column; write name or name [unit].")
    names = [head[1] for head in heads if head]
    if len(set(names)) < len(names):
        raise ModelFileError(f"{shown}:{rows[0][0]}: two columns have the same name.")
    columns: dict[str, list[Item]] = {name: [] for name in names}
    for line, row in rows[1:]:
        if len(row) != len(names):
            raise ModelFileError(f"{shown}:{line}: the row has {len(row)} values, and there are {len(names)} columns.")
        for head, text in zip(heads, row, strict=True):
            assert head is not None
            columns[head[1]].append(_item(text, head[2] or "", f"{shown}:{line}: {head[1]}"))
    return columns


def _item(text: str, unit: str, where: str) -> Item:
    try:
        if unit:
            return number(float(to_si(f"{text} {unit}", si_unit(unit))), parse_unit(si_unit(unit)))
    except UnitError as error:
        raise ModelFileError(f"{where}: {error}") from None
    found = as_quantity(text)
    if found is None:
        return Item(text)
    return number(found.value, found.unit)
