"""Tables over a schedule, as data: what is at each of its points, in a file or made by fowtlib.control."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Any, ClassVar, TypeVar

import numpy as np

from fowtlib.language.data_files import text_of
from fowtlib.language.errors import ParameterError, did_you_mean
from fowtlib.language.whole_files import write_text


@dataclass(frozen=True, eq=False)
class ScheduledTable:
    """Partial: arrays with one row for each of k points, which increase. A subclass has names and arrays.

    over: what the schedule runs over. kind: the word that its files begin with; called: what messages call it; lists:
    its fields that are lists of names. Raises ParameterError where the shapes do not fit.
    """

    kind: ClassVar[str]
    called: ClassVar[str]
    lists: ClassVar[tuple[str, ...]]

    over: str
    points: np.ndarray

    def shapes(self) -> dict[str, tuple[int, ...]]:
        """The shape of each array but the points, by the lengths of the lists of names."""
        raise NotImplementedError

    def __post_init__(self) -> None:
        k = np.size(self.points)
        counts = ", ".join(f"{len(getattr(self, name))} {name}" for name in self.lists)
        for name, shape in {"points": (k,), **self.shapes()}.items():
            try:
                values = np.asarray(getattr(self, name), dtype=float)
            except (TypeError, ValueError):
                raise ParameterError(f"{self.called}: {name} is no array of numbers.") from None
            if values.shape != shape:
                raise ParameterError(
                    f"{self.called}: {name} has the shape {values.shape}; with {k} points, {counts} it is {shape}."
                )
            if not np.all(np.isfinite(values)):
                raise ParameterError(f"{self.called}: {name} has numbers that are not finite.")
            object.__setattr__(self, name, values)
        for name in self.lists:
            object.__setattr__(self, name, tuple(getattr(self, name)))
        if k < 1 or np.any(np.diff(self.points) <= 0):
            raise ParameterError(f"{self.called}: its points must increase, and there must be one at least.")

    def at(self: Table, value: float) -> Table:
        """The table of one point, on the straight lines between its points, and held beyond its ends."""
        weights = np.clip((value - self.points[:-1]) / np.diff(self.points), 0, 1)

        def between(values: np.ndarray) -> np.ndarray:
            return values[:1] + np.tensordot(weights, np.diff(values, axis=0), axes=(0, 0))[None]

        return replace(self, points=np.array([value]), **{name: between(getattr(self, name)) for name in self.shapes()})

    def save(self, path: str | Path) -> Path:
        """Write the table as .json, which its reader reads."""
        path = Path(path)
        if path.suffix != ".json":
            raise ParameterError(f"{path}: {self.called} is saved as .json, not as '{path.suffix or 'no ending'}'.")
        content: dict[str, Any] = {"fowtlib": self.kind}
        for field in fields(self):
            value = getattr(self, field.name)
            content[field.name] = value.tolist() if isinstance(value, np.ndarray) else value
        return write_text(path, json.dumps(content, indent=1))


Table = TypeVar("Table", bound=ScheduledTable)


def read_table(kind: type[Table], path: str) -> Table:
    """The table of a file that its `save` wrote. Raises ParameterError with the path."""
    the = kind.called.removeprefix("an ").removeprefix("a ")
    try:
        content = json.loads(text_of(path, f"the {the}"))
    except ValueError:
        content = None
    if not isinstance(content, dict) or content.get("fowtlib") != kind.kind:
        raise ParameterError(f"{path}: this is not {kind.called}, as {kind.__name__}.save writes one.")
    names = [field.name for field in fields(kind)]
    given = {name: value for name, value in content.items() if name != "fowtlib"}
    for name in given:
        if name not in names:
            raise ParameterError(f"{path}: {kind.called} has no '{name}'{did_you_mean(name, names)}")
    missing = [name for name in names if name not in given]
    if missing:
        raise ParameterError(f"{path}: the {the} has no '{missing[0]}'.")
    for name in kind.lists:
        if not _are_names(given[name]):
            raise ParameterError(f"{path}: '{name}' must be a list of names.")
    try:
        return kind(**given)
    except ParameterError as error:
        raise ParameterError(f"{path}: {error}") from None


def _are_names(given: Any) -> bool:
    return isinstance(given, Sequence) and not isinstance(given, str) and all(isinstance(name, str) for name in given)
