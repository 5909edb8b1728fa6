"""CSV files with a header: columns by name, units in brackets behind the names, errors with file and line."""

from __future__ import annotations

import math
import os
from collections.abc import Collection
from dataclasses import dataclass

import numpy as np

from fowtlib.language.data_files import cells_of, lines_of
from fowtlib.language.errors import ParameterError, did_you_mean
from fowtlib.metocean.states import COLUMNS, States


@dataclass(frozen=True)
class Columns:
    """The columns of a file: numbers, with nan for an empty cell of those that may be empty, or words."""

    path: str
    numbers: dict[str, np.ndarray]
    words: dict[str, list[str]]
    units: dict[str, str]
    lines: np.ndarray

    def states(self, rows: np.ndarray, probability: np.ndarray | None = None) -> States:
        """The states of some rows."""
        return States(*(self.numbers[name][rows] for name in COLUMNS), probability)

    def refuse(self, bad: np.ndarray, why: str) -> None:
        """Refuse the file for the first row that is bad."""
        if np.any(bad):
            raise ParameterError(why, where=f"{self.path}:{self.lines[int(np.argmax(bad))]}")


def read_columns(
    path: str | os.PathLike[str],
    what: str,
    known: Collection[str] | None,
    *,
    words: Collection[str] = (),
    may_be_empty: Collection[str] = (),
) -> Columns:
    """Wind speed, Hs and Tp, all positive, and further columns; `known` None takes any.

    ParameterError with file and line for what cannot be read.
    """
    where = os.fspath(path)
    lines = lines_of(path, what)
    if len(lines) < 2:
        raise ParameterError(f"{what} has a header and one line or more.", where=where)
    cells = [cell.partition("[") for cell in cells_of(lines[0][1])]
    names = [name.strip() for name, _, _ in cells]
    for name in names:
        allowed = (*COLUMNS, *(known or ()), *words)
        if not name or names.count(name) > 1:
            raise ParameterError(
                f"each column needs a name of its own; '{name}' is not.", where=f"{where}:{lines[0][0]}"
            )
        if known is not None and name not in allowed:
            raise ParameterError(
                f"{what} has no column '{name}'{did_you_mean(name, allowed)}", where=f"{where}:{lines[0][0]}"
            )
    missing = [name for name in COLUMNS if name not in names]
    if missing:
        raise ParameterError(f"{what} needs the columns {', '.join(missing)} too.", where=where)
    rows = [(number, cells_of(line)) for number, line in lines[1:]]
    for number, row in rows:
        if len(row) != len(names):
            raise ParameterError(
                f"the row has {len(row)} cells, and there are {len(names)} columns.", where=f"{where}:{number}"
            )
    columns = dict(zip(names, zip(*(row for _, row in rows), strict=True), strict=True))
    numbers = np.array([number for number, _ in rows])
    found = Columns(
        where,
        {
            name: np.array(
                [_number(c, name in may_be_empty, f"{where}:{n}: {name}") for c, n in zip(column, numbers, strict=True)]
            )
            for name, column in columns.items()
            if name not in words
        },
        {name: list(columns[name]) for name in words if name in columns},
        {name: unit.rstrip("] ").strip() for name, (_, _, unit) in zip(names, cells, strict=True)},
        numbers,
    )
    for name, unit in COLUMNS.items():
        found.refuse(~(found.numbers[name] > 0), f"{name} must be positive.")
        if found.units[name] not in ("", unit):
            raise ParameterError(f"{name} is to be given in {unit}, not in {found.units[name]}.", where=where)
    return found


def _number(text: str, may_be_empty: bool, where: str) -> float:
    if not text and may_be_empty:
        return math.nan
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise ParameterError(f"'{text}' is not a finite number.", where=where)
    return value
