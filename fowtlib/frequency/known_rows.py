"""Functions of frequency of a run, row by row: what another run of the same numbers has computed is not asked again.

Most frequencies of a response are those of all others, and the coarse ones those of all seas about one mean; transfer
functions of waves do not know how high the sea is. Which parameters a function reads is noted as it is computed.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np

from fowtlib.language.component import Component
from fowtlib.language.declarations import join
from fowtlib.language.expressions import evaluation_again
from fowtlib.solving.known_slopes import Contents, relevant

OfFrequency = Callable[[np.ndarray], np.ndarray]
"""`omega (q,), rising -> values (q, ...)`, each row by its own frequency alone."""

Known = Callable[[Hashable, OfFrequency], OfFrequency]
"""A function under a name -> the same, with what is known of it; see KnownRows."""

KEPT = 4  # sets of parameters
TABLES = 2  # of each: a coarse and a fine one
LARGEST = 500_000  # numbers of a table


@dataclass(eq=False)
class _Known:
    """Rows by frequency of one set of parameters: what is set of those that count, and what all of them come to.

    places: the parameters that are read; numbers: values that follow from them, of the parts of the tree root.
    """

    root: Component
    values: dict[str, Any] = field(default_factory=dict)
    places: set[tuple[str, str]] = field(default_factory=set)
    numbers: dict[Any, Any] = field(default_factory=dict)
    tables: list[tuple[np.ndarray, np.ndarray]] = field(default_factory=list)

    def suits(self, parameters: Contents) -> bool:
        """Whether all that counts has the same values in a run with these parameters."""
        return relevant(parameters, self._read) == self.values

    def computed(self, function: OfFrequency, omega: np.ndarray, root: Component, parameters: Contents,
                 numbers: dict[Any, Any] | None = None) -> np.ndarray:  # fmt: skip
        """The rows of these frequencies, anew; numbers: of this run, where there are some, in place of its own."""
        if root is not self.root:  # of another tree
            self.root, self.numbers = root, {}
        with evaluation_again(self.numbers if numbers is None else numbers, self.places):
            found = function(omega)
        if len(self._read) != len(self.places):
            self.__dict__.pop("_read")
        self.values = relevant(parameters, self._read)
        return found

    @cached_property
    def _read(self) -> frozenset[str]:
        return frozenset(join(*place) for place in self.places)


class KnownRows:
    """Rows of functions of the runs of one model."""

    def __init__(self) -> None:
        self._known: dict[Hashable, list[_Known]] = {}

    def of(self, name: Hashable, root: Component, parameters: Contents, function: OfFrequency,
           numbers: dict[Any, Any]) -> OfFrequency:  # fmt: skip
        """A function under a name, which asks for the rows that are not known yet.

        root: the tree of a run with these parameters; the function is one of its parts. numbers: values that follow
        from them, of this run alone, which functions of which nothing is known have in common.
        """

        def rows(omega: np.ndarray) -> np.ndarray:
            entries = self._known.setdefault(name, [])
            known = next((one for one in entries if one.suits(parameters)), None)
            if known is None:
                known, common = _Known(root), numbers
            else:
                entries.remove(known)
                common = None

            def compute(missing: np.ndarray) -> np.ndarray:
                return known.computed(function, missing, root, parameters, common)

            found = _with_known(known, omega, compute)
            if found.size <= LARGEST:
                known.tables[:] = [table for table in known.tables if table[1] is not found][: TABLES - 1]
                known.tables.insert(0, (omega, found))
            entries.insert(0, known)
            del entries[KEPT:]
            return found

        return rows


def _with_known(known: _Known, omega: np.ndarray, compute: OfFrequency) -> np.ndarray:
    """The rows of these frequencies, those that are not known computed."""
    missing, taken = np.ones(omega.size, dtype=bool), []
    for table, rows in known.tables:
        if table.size == omega.size and np.array_equal(table, omega):
            return rows
        place = np.minimum(np.searchsorted(table, omega), table.size - 1)
        there = missing & (table[place] == omega)
        missing &= ~there
        taken.append((there, rows, place[there]))
    if missing.all():
        return compute(omega)
    new = compute(omega[missing]) if missing.any() else None
    like = taken[0][1] if new is None else new
    found = np.empty((omega.size, *like.shape[1:]), dtype=like.dtype)
    for there, rows, place in taken:
        found[there] = rows[place]
    if new is not None:
        found[missing] = new
    return found
