"""The results of a model: what each is called, which variable it is, in which unit and with which words it is given."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

import numpy as np

from fowtlib.flattening import FlatDAE
from fowtlib.language.errors import NotFoundError
from fowtlib.language.units import from_si


class Entry(NamedTuple):
    """A result: path of the variable, unit in which it is given, description."""

    path: str
    unit: str
    doc: str


class Outputs(Mapping[str, Entry]):
    """The results by name; without any that are declared, all states by their paths, in SI.

    declared: name -> path, or an object with the path `of`, `unit` (None: SI) and `doc` (empty: the variable's).
    """

    def __init__(self, dae: FlatDAE, declared: Mapping[str, Any] | None = None):
        self._dae = dae
        self._declared = {name: self._entry(name, item) for name, item in (declared or {}).items()}
        self._entries = self._declared or {q.path: Entry(q.path, q.unit, q.doc) for q in dae.states}

    def __getitem__(self, name: str) -> Entry:
        return self._entries[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._entries)

    def __len__(self) -> int:
        return len(self._entries)

    @property
    def paths(self) -> list[str]:
        """The variables behind the results, in order."""
        return [entry.path for entry in self._entries.values()]

    def describe(self, path: str) -> tuple[str, str]:
        """SI unit and description of any variable."""
        units, docs = self._dae.units, self._dae.docs
        key = next((key for key in (path, f"{path}[0]", f"{path}[0,0]") if key in units), path)
        return units.get(key, "1"), docs.get(key, "") or path

    def entry(self, name: str) -> Entry:
        """A result by name, or any variable by path in SI."""
        return self._entries.get(name) or Entry(name, *self.describe(name))

    def factor(self, name: str) -> float:
        """What a change of the variable in SI is multiplied by to have that of the result in its unit."""
        entry = self.entry(name)
        si = self.describe(entry.path)[0]
        return float(from_si(1.0, si, entry.unit)) - float(from_si(0.0, si, entry.unit))

    def shown(self, name: str, values: np.ndarray) -> np.ndarray:
        """Values of a variable in SI in the unit of the result."""
        entry = self.entry(name)
        return from_si(values, self.describe(entry.path)[0], entry.unit)

    def _entry(self, name: str, item: Any) -> Entry:
        path, unit, doc = (item, None, "") if isinstance(item, str) else (item.of, item.unit, item.doc)
        where = f"output '{name}'"
        try:
            self._dae.observe_expression(path)
        except NotFoundError as error:
            raise error.at(where) from None
        si, long_name = self.describe(path)
        from_si(1.0, si, unit or si, where)  # an error where the dimensions differ
        return Entry(path, unit or si, doc or long_name)
