"""A component tree with some of its parameters elsewhere, which still knows what does not follow from them.

Slopes move one element after the other. Most of what a part computes, as the heights of a hull whose diameter moves, is
as before; which parameters a value was computed from is noted as it is computed, and only those that read one that
moves are computed again.
"""

from __future__ import annotations

from collections.abc import Hashable, Iterator
from contextlib import contextmanager
from typing import Any

from fowtlib.language.component import Component
from fowtlib.language.expressions import evaluation_again
from fowtlib.solving.bindings import Common, Numbers


class Beside:
    """Evaluations of the tree of a run, as it is and with values elsewhere; met: what was computed as it is."""

    def __init__(self, common: Common):
        self.common, self.met = common, set[Hashable]()
        self._known: dict[Any, Any] = {}
        self._others: dict[frozenset[tuple[str, str]], tuple[int, dict[Any, Any]]] = {}

    @contextmanager
    def here(self) -> Iterator[tuple[Component, set[tuple[str, str]]]]:
        """The tree as it is, and where it is noted what is read."""
        read: set[tuple[str, str]] = set()
        with evaluation_again(self._known, read):
            yield self.common.tree, read

    @contextmanager
    def at(self, given: Numbers) -> Iterator[Component]:
        """The tree with these values of parameters, for as long as the context lasts."""
        moved = frozenset((owner, name) for owner, _, name in (path.rpartition(".") for path in given))
        count, known = self._others.get(moved, (-1, {}))
        if count != len(self._known):
            known = {key: value for key, value in self._known.items() if moved.isdisjoint(value[1])}
            self._others[moved] = len(self._known), known
        with self.common.put(given) as tree, evaluation_again(dict(known)):
            yield tree
