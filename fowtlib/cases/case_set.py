"""The cases of a batch, with what is known of where they come from."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path

from fowtlib.cases.case import Case
from fowtlib.modelfile.nodes import Place


@dataclass(frozen=True)
class CaseSet:
    """Cases, in the order of the file, with different names.

    path: the cases file, or None for cases made in Python. files: what the cases were made from, the cases file first:
    tables, distributions, model files by path, and data that the cases name; shipped files are not among them.
    places: by the name of a case, where its parameters stand by path, and under "" the set it is of. steep: names of
    cases whose sea may be steeper than is known of seas.
    """

    path: Path | None
    title: str
    cases: tuple[Case, ...]
    files: tuple[Path, ...] = ()
    places: Mapping[str, Mapping[str, Place]] = field(default_factory=dict, repr=False)
    steep: frozenset[str] = frozenset()

    def __iter__(self) -> Iterator[Case]:
        return iter(self.cases)

    def __len__(self) -> int:
        return len(self.cases)

    def __getitem__(self, number: int) -> Case:
        return self.cases[number]

    def place(self, name: str, path: str = "") -> Place:
        """Where a parameter of a case is written, or else its set; the name of the case where nothing is."""
        places = self.places.get(name, {})
        return places.get(path) or places.get("") or Place("cases")

    @property
    def models(self) -> tuple[str, ...]:
        """The models of the cases, each once."""
        return tuple(dict.fromkeys(case.model for case in self.cases))
