"""Gains of a state feedback over a schedule, as data: a file, or made by fowtlib.control."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

import numpy as np

from fowtlib.language.data_files import remembered, text_of
from fowtlib.language.errors import ParameterError, did_you_mean
from fowtlib.language.whole_files import write_text

KIND = "gains"


@dataclass(frozen=True, eq=False)
class GainTable:
    """u = trim - gains (y - set_points) - integral of integral_gains (y - set_points), over a schedule of k points.

    over: what the schedule runs over; points (k,) increase. measured, demands: names of the n signals y and of the m
    demands u. gains and integral_gains (k, m, n): of the integrals, zero for a signal that is not integrated.
    set_points (k, n): y at rest. trim (k, m): u at rest. SI. Raises ParameterError where the shapes do not fit.
    """

    over: str
    points: np.ndarray
    measured: tuple[str, ...]
    demands: tuple[str, ...]
    gains: np.ndarray
    integral_gains: np.ndarray
    set_points: np.ndarray
    trim: np.ndarray

    def __post_init__(self) -> None:
        k, n, m = np.size(self.points), len(self.measured), len(self.demands)
        shapes = {"points": (k,), "gains": (k, m, n), "integral_gains": (k, m, n), "set_points": (k, n), "trim": (k, m)}
        for name, shape in shapes.items():
            try:
                values = np.asarray(getattr(self, name), dtype=float)
            except (TypeError, ValueError):
                raise ParameterError(f"a table of gains: {name} is no array of numbers.") from None
            if values.shape != shape:
                raise ParameterError(
                    f"a table of gains: {name} has the shape {values.shape}; with {k} points, {m} demands and {n} "
                    f"measured signals it is {shape}."
                )
            if not np.all(np.isfinite(values)):
                raise ParameterError(f"a table of gains: {name} has numbers that are not finite.")
            object.__setattr__(self, name, values)
        object.__setattr__(self, "measured", tuple(self.measured))
        object.__setattr__(self, "demands", tuple(self.demands))
        if k < 1 or np.any(np.diff(self.points) <= 0):
            raise ParameterError("a table of gains: its points must increase, and there must be one at least.")

    def at(self, value: float) -> GainTable:
        """The table of one point, on the straight lines between its points, and held beyond its ends."""
        weights = np.clip((value - self.points[:-1]) / np.diff(self.points), 0, 1)

        def between(values: np.ndarray) -> np.ndarray:
            return values[:1] + np.tensordot(weights, np.diff(values, axis=0), axes=(0, 0))[None]

        parts = {name: between(getattr(self, name)) for name in ("gains", "integral_gains", "set_points", "trim")}
        return GainTable(self.over, np.array([value]), self.measured, self.demands, **parts)

    def save(self, path: str | Path) -> Path:
        """Write the table as .json; `read_gains` reads it."""
        path = Path(path)
        if path.suffix != ".json":
            raise ParameterError(f"{path}: a table of gains is saved as .json, not as '{path.suffix or 'no ending'}'.")
        content: dict[str, Any] = {"fowtlib": KIND}
        for field in fields(self):
            value = getattr(self, field.name)
            content[field.name] = value.tolist() if isinstance(value, np.ndarray) else value
        return write_text(path, json.dumps(content, indent=1))


@remembered()
def read_gains(path: str) -> GainTable:
    """The table of a file that `GainTable.save` wrote. Raises ParameterError with the path."""
    try:
        content = json.loads(text_of(path, "the table of gains"))
    except ValueError:
        content = None
    if not isinstance(content, dict) or content.get("fowtlib") != KIND:
        raise ParameterError(f"{path}: this is not a table of gains, as GainTable.save writes one.")
    names = [field.name for field in fields(GainTable)]
    given = {name: value for name, value in content.items() if name != "fowtlib"}
    for name in given:
        if name not in names:
            raise ParameterError(f"{path}: a table of gains has no '{name}'{did_you_mean(name, names)}")
    missing = [name for name in names if name not in given]
    if missing:
        raise ParameterError(f"{path}: the table of gains has no '{missing[0]}'.")
    for name in ("measured", "demands"):
        if not _are_names(given[name]):
            raise ParameterError(f"{path}: '{name}' must be a list of names.")
    try:
        return GainTable(**given)
    except ParameterError as error:
        raise ParameterError(f"{path}: {error}") from None


def _are_names(given: Any) -> bool:
    return isinstance(given, Sequence) and not isinstance(given, str) and all(isinstance(name, str) for name in given)
