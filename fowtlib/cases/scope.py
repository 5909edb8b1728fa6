"""The variables of one case, each found when it is first asked for, and which of them somebody asked for."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property

from fowtlib.cases.conditional import Source
from fowtlib.cases.values import Item, evaluate, number
from fowtlib.language.errors import ModelError
from fowtlib.modelfile.nodes import Node, Place

SEED_NAMES = ("seed_number", "seed", "wave_seed")


@dataclass
class Scope:
    """`fixed` are known; `formulas` and `sources` give the others. `used` collects what was asked for."""

    place: Place
    fixed: Mapping[str, Item]
    formulas: Mapping[str, Node] = field(default_factory=dict)
    sources: Sequence[Source] = ()
    used: set[str] = field(default_factory=set)
    found: dict[str, Item] = field(default_factory=dict)
    _asked: list[str] = field(default_factory=list)

    @cached_property
    def names(self) -> Collection[str]:
        """All names."""
        return {*self.fixed, *self.formulas, *(name for source in self.sources for name in source.columns)}

    def item(self, name: str) -> Item:
        """The value of a variable; ModelFileError where it needs itself, or lies outside of a table."""
        self.used.add(name)
        if name in self.fixed:
            return self.fixed[name]
        if name not in self.found:
            if name in self._asked:
                raise self.place.error(f"'{name}' needs itself: {' -> '.join([*self._asked, name])}.")
            self._asked.append(name)
            try:
                self.found |= self._given(name)
            finally:
                self._asked.pop()
        return self.found[name]

    def _given(self, name: str) -> dict[str, Item]:
        if name in self.formulas:
            return {name: evaluate(self.formulas[name], self)}
        source = next(source for source in self.sources if name in source.columns)
        if source.argument not in self.names:
            raise self.place.error(f"'{name}' is looked up by '{source.argument}', and there is no such variable here.")
        at = self.item(source.argument).quantity
        if at is None:
            raise self.place.error(f"'{name}' is looked up by '{source.argument}', which is no number.")
        try:
            return source.at(at)
        except ModelError as error:
            raise self.place.error(str(error)) from None


def seeds_of(values: Mapping[str, Item], count: int) -> list[dict[str, Item]]:
    """The variables of each of `count` realisations of a state that varies by `values`.

    seed_number counts from 1. seed and wave_seed are numbers below 2^31 made by BLAKE2 from the names and values of
    what varies, and from seed_number: a case keeps them when others are added, no two states share them, and wind and
    waves of one case do not draw the same random numbers.
    """
    state = json.dumps({name: values[name].written for name in sorted(values)}, sort_keys=True)
    rows = []
    for k in range(1, count + 1):
        wind, waves = (_number(f"{what} {k} {state}") for what in ("wind", "waves"))
        rows.append(dict(zip(SEED_NAMES, map(number, (k, wind, waves)), strict=True)))
    return rows


def _number(text: str) -> int:
    digest = hashlib.blake2b(text.encode(), digest_size=8).digest()
    return 1 + int.from_bytes(digest, "big") % (2**31 - 2)
