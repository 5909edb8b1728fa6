"""Functions of frequency of a run, row by row: what another run of the same numbers has computed is not asked again.

Most frequencies of a response are those of all others, and the coarse ones those of all seas about one mean; transfer
functions of waves do not know how high the sea is. Which parameters a function reads is noted as it is computed.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from fowtlib.language.component import Component
from fowtlib.language.declarations import join
from fowtlib.language.expressions import parameters_read
from fowtlib.solving.binding import content_of

OfFrequency = Callable[[np.ndarray], np.ndarray]
"""`omega (q,), rising -> values (q, ...)`, each row by its own frequency alone."""

KEPT = 4  # sets of parameters
TABLES = 2  # of each: a coarse and a fine one
LARGEST = 500_000  # numbers of a table


@dataclass(frozen=True, eq=False)
class _Known:
    """Rows by frequency of one set of parameters; read: the paths of those that count."""

    read: frozenset[str]
    values: dict[str, Any]
    tables: list[tuple[np.ndarray, np.ndarray]] = field(default_factory=list)


class KnownRows:
    """Rows of functions of the runs of one model."""

    def __init__(self) -> None:
        self._known: dict[Hashable, list[_Known]] = {}

    def of(self, name: Hashable, parameters: Mapping[str, Any], function: OfFrequency) -> OfFrequency:
        """A function under a name, in a run with these parameters, by path, which asks for what is not known yet."""

        def rows(omega: np.ndarray) -> np.ndarray:
            entries = self._known.setdefault(name, [])
            number = next((k for k, one in enumerate(entries) if _relevant(parameters, one.read) == one.values), None)
            if number is None:
                with parameters_read() as places:
                    found = function(omega)
                read = frozenset(join(*place) for place in places)
                known = _Known(read, _relevant(parameters, read))
            else:
                known = entries.pop(number)
                found = _with_known(known, omega, function)
            if found.size <= LARGEST:
                known.tables[:] = [table for table in known.tables if table[1] is not found][: TABLES - 1]
                known.tables.insert(0, (omega, found))
            entries.insert(0, known)
            del entries[KEPT:]
            return found

        return rows


def _with_known(known: _Known, omega: np.ndarray, function: OfFrequency) -> np.ndarray:
    missing, taken = np.ones(omega.size, dtype=bool), []
    for table, rows in known.tables:
        if table.size == omega.size and np.array_equal(table, omega):
            return rows
        place = np.minimum(np.searchsorted(table, omega), table.size - 1)
        there = missing & (table[place] == omega)
        missing &= ~there
        taken.append((there, rows, place[there]))
    new = function(omega[missing]) if missing.any() else None
    like = new if new is not None else known.tables[0][1]
    found = np.empty((omega.size, *like.shape[1:]), dtype=like.dtype)
    for there, rows, place in taken:
        found[there] = rows[place]
    if new is not None:
        found[missing] = new
    return found


def _relevant(parameters: Mapping[str, Any], read: frozenset[str]) -> dict[str, Any]:
    """What the numbers that are read, and all that is no number, are set to; a word may choose another kind of part."""
    return {path: content_of(value) for path, value in parameters.items()
            if path.partition("[")[0] in read or not _is_number(value)}  # fmt: skip


def _is_number(value: Any) -> bool:
    if isinstance(value, (Component, str, bool)):
        return False
    return isinstance(value, (int, float, np.number)) or (isinstance(value, np.ndarray) and value.dtype.kind in "iuf")
