"""What an optimisation gives: the design, what limits it, what it costs, and how it was found."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from fowtlib.language.errors import ModelError, did_you_mean
from fowtlib.language.whole_files import write_text

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Row = tuple[Any, ...]


@dataclass(frozen=True)
class Size:
    """A number of a design, at the start and at the optimum, and its bounds. active: "lower", "upper" or "".

    price: see Limited.
    """

    name: str
    unit: str
    start: float
    value: float
    lower: float
    upper: float
    active: str = ""
    price: float = 0.0


@dataclass(frozen=True)
class Limited:
    """A number that is limited, at the start and at the optimum.

    active: "lower", "upper" or ""; violated: by more than the tolerance. price: what the objective gains per unit by
    which the active limit is relaxed; of those that are aggregated, of all together.
    """

    name: str
    unit: str
    start: float
    value: float
    lower: float
    upper: float
    use: float
    active: str = ""
    violated: bool = False
    price: float = 0.0


@dataclass(frozen=True, eq=False)
class Search:
    """One start: where it began and ended, and how."""

    number: int
    start: np.ndarray
    x: np.ndarray
    objective: float
    violation: float
    converged: bool
    reason: str
    evaluations: int
    gradients: int

    @property
    def feasible(self) -> bool:
        from fowtlib.design.problem import FEASIBLE

        return self.violation <= FEASIBLE


@dataclass(frozen=True, eq=False)
class Member:
    """An array of the model that the design drives, at the start and at the optimum, at its stations along `along`."""

    path: str
    unit: str
    start: np.ndarray
    value: np.ndarray
    stations: np.ndarray
    along: str = "element"


@dataclass(frozen=True, eq=False)
class Optimum:
    """The best design of all starts.

    parameters: of a run of the model with this design, what is freed (ballast) at its value; results: by case and name.
    conflict: where no design keeps all constraints, those that are against each other. rest: of the slope of the
    objective that no active limit takes, over its size: nearly zero at an optimum. unit: of the objective; "1" where
    its terms have several.
    """

    title: str
    objective: str
    start_objective: float
    value: float
    feasible: bool
    converged: bool
    reason: str
    variables: tuple[Size, ...]
    constraints: tuple[Limited, ...]
    parameters: Mapping[str, Any]
    results: Mapping[str, Mapping[str, Any]]
    searches: tuple[Search, ...]
    members: tuple[Member, ...] = ()
    history: tuple[tuple[float, float], ...] = ()
    conflict: tuple[str, ...] = ()
    rest: float = np.nan
    seconds: float = 0.0
    settings: Mapping[str, Any] = field(default_factory=dict)
    unit: str = "1"

    def __getitem__(self, name: str) -> Any:
        """The value of a variable (an array where it has more numbers), in SI."""
        found = {size.name: size.value for size in self.variables}
        if name in found:
            return found[name]
        many = [size.value for size in self.variables if size.name.startswith(f"{name}[")]
        if not many:
            raise ModelError(f"there is no variable '{name}'{did_you_mean(name, found)}")
        return np.array(many)

    @property
    def active(self) -> list[str]:
        """Names of the constraints and of the bounds that are active."""
        limits = [f"{item.name} {'<' if item.active == 'upper' else '>'}" for item in self.constraints if item.active]
        return limits + [f"{item.name} ({item.active} bound)" for item in self.variables if item.active]

    @property
    def sentence(self) -> str:
        """How it ended."""
        if self.feasible:
            return f"{self.reason}; all constraints are kept."
        broken = [item for item in self.constraints if item.violated]
        text = ", ".join(f"{item.name} is {item.value:.5g} {_limits(item)}" for item in broken[:4])
        against = f" Against each other: {', '.join(self.conflict)}." if len(self.conflict) > 1 else ""
        return f"no design that keeps all constraints was found ({self.reason}). The nearest: {text}.{against}"

    def variable_rows(self) -> tuple[tuple[str, ...], list[Row]]:
        """Heads and rows of the variables."""
        heads = ("variable", "start", "optimum", "lower", "upper", "active", "price")
        return heads, [
            (f"{v.name} [{v.unit}]", v.start, v.value, v.lower, v.upper, v.active, v.price if v.active else None)
            for v in self.variables
        ]

    def constraint_rows(self) -> tuple[tuple[str, ...], list[Row]]:
        """Heads and rows of the constraints."""
        heads = ("constraint", "start", "optimum", "lower", "upper", "active", "price")
        return heads, [
            (f"{c.name} [{c.unit}]", c.start, c.value, _bound(c.lower), _bound(c.upper),
             "broken" if c.violated else c.active, c.price if c.active else None)
            for c in self.constraints
        ]  # fmt: skip

    def search_rows(self) -> tuple[tuple[str, ...], list[Row]]:
        """Heads and rows of the starts."""
        heads = ("start", "objective", "violation", "feasible", "evaluations", "gradients", "end")
        return heads, [(s.number, s.objective, max(s.violation, 0.0), s.feasible, s.evaluations, s.gradients, s.reason)
                       for s in self.searches]  # fmt: skip

    def plain(self) -> dict[str, Any]:
        """All of it as JSON can hold it."""
        tables = {"variables": self.variable_rows(), "constraints": self.constraint_rows()}
        tables["starts"] = self.search_rows()
        told: dict[str, Any] = {
            "title": self.title, "objective": self.objective, "start": self.start_objective, "optimum": self.value,
            "feasible": self.feasible, "converged": self.converged, "reason": self.reason, "rest": self.rest,
            "conflict": list(self.conflict), "seconds": self.seconds, **self.settings,
        }  # fmt: skip
        told |= {name: [dict(zip(heads, row, strict=True)) for row in rows] for name, (heads, rows) in tables.items()}
        told |= {"parameters": self.parameters, "results": self.results}
        return _clean(told)

    def save(self, path: str | Path) -> Path:
        """Write all of it as .json."""
        path = Path(path)
        if path.suffix != ".json":
            raise ModelError(f"{path}: a design is saved as .json, not as '{path.suffix or 'no ending'}'.")
        return write_text(path, json.dumps(self.plain(), indent=1))

    def plot(self, path: str | Path | None = None) -> Figure:
        """Sizes before and after, constraints and how far they are used, and the way."""
        from fowtlib.design.pictures import plot_optimum

        return plot_optimum(self, path)

    def __repr__(self) -> str:
        lines = [f"<Optimum of {self.title}: {self.sentence}>", f"{self.objective}: {self.start_objective:.6g} -> "
                 f"{self.value:.6g}"]  # fmt: skip
        for v in self.variables:
            lines.append(f"{f'{v.name} [{v.unit}]':30}{v.start:>12.5g}{v.value:>12.5g}  {v.active}".rstrip())
        for c in self.constraints:
            lines.append(f"{f'{c.name} [{c.unit}]':30}{c.start:>12.5g}{c.value:>12.5g}  "
                         f"{'broken' if c.violated else c.active}".rstrip())  # fmt: skip
        return "\n".join(lines)


def _limits(item: Limited) -> str:
    over = item.value > item.upper
    unit = "" if item.unit == "1" else f" {item.unit}"
    return f"where {'at most' if over else 'at least'} {item.upper if over else item.lower:g}{unit} is allowed"


def _bound(value: float) -> float | None:
    return value if np.isfinite(value) else None


def _clean(value: Any) -> Any:
    """What JSON can hold; numbers that it lacks become None."""
    if isinstance(value, Mapping):
        return {str(key): _clean(item) for key, item in value.items()}
    if hasattr(value, "tolist"):
        return _clean(value.tolist())
    if isinstance(value, (list, tuple)):
        return [_clean(item) for item in value]
    if isinstance(value, float):
        return value if np.isfinite(value) else None
    return value if value is None or isinstance(value, (bool, int, str)) else str(value)
