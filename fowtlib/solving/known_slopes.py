"""Slopes of what is computed when a run starts, kept: another run with the same numbers does not compute them again.

States of one design in other winds and seas have its hull, its tower and its lines in common. Which parameters a
number reads is noted as it is computed; while these are what they were, so are its slopes.
"""

from __future__ import annotations

from collections.abc import Hashable, Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from fowtlib.language.component import Component
from fowtlib.language.declarations import join
from fowtlib.solving.binding import content_of

Contents = Mapping[str, Any]
"""Parameters by path, as what is equal for equal values; see `contents_of`."""


@dataclass(eq=False)
class Known:
    """What is known of one number, or of numbers that belong together.

    paths: of the parameters that it reads; values: what is set of these. slopes: by the name of an element, None of one
    that does not matter; apart: names of those that are known not to. there: the numbers themselves, where kept.
    before: which numbers an element mattered to, at the values before; None: to none of them.
    """

    values: dict[str, Any]
    paths: set[str] = field(default_factory=set)
    before: dict[str, np.ndarray | None] = field(default_factory=dict)
    slopes: dict[str, Any] = field(default_factory=dict)
    apart: set[str] | None = None
    there: Any = None

    def note(self, read: Iterable[tuple[str, str]], contents: Contents) -> None:
        """That these parameters are read: owner and name."""
        self.paths |= {join(*place) for place in read}
        self.values = relevant(contents, self.paths)

    @property
    def mattered(self) -> dict[str, np.ndarray | None]:
        """Which numbers an element matters to, or did before; of those that are kept with frequencies, all or none."""
        return {**self.before, **{name: slope if slope is None else np.array([True]) if isinstance(slope, tuple)
                                  else slope != 0 for name, slope in self.slopes.items()}}  # fmt: skip


class KnownSlopes:
    """What is known of the runs of one model, of the last values that each number was computed from."""

    def __init__(self) -> None:
        self._known: dict[Hashable, Known] = {}

    def of(self, name: Hashable, contents: Contents) -> Known:
        """What is known under a name, for a run with these parameters."""
        known = self._known.get(name)
        if known is None or relevant(contents, known.paths) != known.values:
            before = {} if known is None else known.mattered
            known = self._known[name] = Known(relevant(contents, ()), before=before)
        return known


def contents_of(parameters: Mapping[str, Any]) -> dict[str, Any]:
    """Parameters by path; what is no number, marked as such: a word may choose another kind of part."""
    return {path: (is_number(value), content_of(value)) for path, value in parameters.items()}


def relevant(contents: Contents, read: Iterable[str]) -> dict[str, Any]:
    """What the numbers that are read, and all that is no number, are set to."""
    return {path: value for path, value in contents.items() if path.partition("[")[0] in read or not value[0]}


def is_number(value: Any) -> bool:
    """Whether it is a number, or an array of numbers."""
    if isinstance(value, (Component, str, bool)):
        return False
    return isinstance(value, (int, float, np.number)) or (isinstance(value, np.ndarray) and value.dtype.kind in "iuf")
