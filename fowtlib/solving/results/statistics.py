"""Statistics of time series: mean, standard deviation, extremes and root mean square."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from fowtlib.language.errors import ModelError, NotFoundError, did_you_mean
from fowtlib.solving.results.html import table
from fowtlib.solving.results.tables import write_table

if TYPE_CHECKING:
    import pandas

_SHOWN_ROWS = 40


@dataclass(frozen=True)
class Summary:
    """Mean, standard deviation, minimum, maximum and root mean square of one series, in its own unit."""

    name: str
    unit: str
    mean: float
    std: float
    min: float
    max: float
    rms: float


class Statistics(Mapping[str, Summary]):
    """Summaries by name; prints as a table, and ``to_pandas()`` gives it as one."""

    def __init__(self, rows: Sequence[Summary], first: float, last: float) -> None:
        self._rows = {row.name: row for row in rows}
        self.first, self.last = first, last

    def __getitem__(self, name: str) -> Summary:
        if name not in self._rows:
            raise NotFoundError(f"there is no result '{name}'{did_you_mean(name, self._rows, list_up_to=30)}")
        return self._rows[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._rows)

    def __len__(self) -> int:
        return len(self._rows)

    def to_pandas(self) -> pandas.DataFrame:
        import pandas

        return pandas.DataFrame([vars(row) for row in self._rows.values()]).set_index("name")

    def save(self, path: str | Path) -> Path:
        """Write a table as CSV, one row per series."""
        rows = [(row.name, row.unit, row.mean, row.std, row.min, row.max, row.rms) for row in self._rows.values()]
        return write_table(path, ("name", "unit", "mean", "std", "min", "max", "rms"), rows, "statistics")

    def _repr_html_(self) -> str:
        rows = [(row.name, row.unit, row.mean, row.std, row.min, row.max) for row in self._rows.values()]
        title = f"{self.first:g} s to {self.last:g} s"
        return table(("result", "unit", "mean", "std", "min", "max"), rows, title)

    def __repr__(self) -> str:
        shown = list(self._rows.values())[:_SHOWN_ROWS]
        width = max([len(row.name) for row in shown] + [4])
        unit_width = max([len(row.unit) for row in shown] + [4])
        heads = "".join(f"{head:>12}" for head in ("mean", "std", "min", "max"))
        lines = [f"{'name':<{width}} {'unit':<{unit_width}}{heads}"]
        for row in shown:
            numbers = "".join(f"{value:>12.5g}" for value in (row.mean, row.std, row.min, row.max))
            lines.append(f"{row.name:<{width}} {_shown_unit(row.unit):<{unit_width}}{numbers}")
        if len(self) > len(shown):
            lines.append(f"... and {len(self) - len(shown)} more")
        return "\n".join(lines)


def _shown_unit(unit: str) -> str:
    return "-" if unit in ("", "1") else unit


def time_weights(time: np.ndarray) -> np.ndarray:
    """Weights of the samples in a mean over time: equal on a uniform grid, trapezoidal on any other."""
    steps = np.diff(time)
    if time.size < 3 or np.ptp(steps) <= 1e-6 * abs(steps[0]):
        return np.full(time.size, 1.0 / time.size)
    weights = np.zeros(time.size)
    weights[:-1] += 0.5 * steps
    weights[1:] += 0.5 * steps
    return weights / weights.sum()


def summarise(time: np.ndarray, series: Iterable[tuple[str, str, np.ndarray]], discard: float) -> Statistics:
    """Summary of series (name, unit, values) without the first `discard` seconds."""
    keep = time >= time[0] + discard if time.size else np.zeros(0, dtype=bool)
    if not keep.any():
        duration = float(time[-1] - time[0]) if time.size else 0.0
        raise ModelError(
            f"statistics: discarding {discard:g} s leaves nothing of a result of {duration:g} s. "
            "Discard less, or simulate longer."
        )
    weights = time_weights(time[keep])
    rows = []
    for name, unit, values in series:
        part = values[keep]
        mean = float(weights @ part)
        std = float(np.sqrt(weights @ (part - mean) ** 2))
        rms = float(np.sqrt(weights @ part**2))
        rows.append(Summary(name, unit, mean, std, float(part.min()), float(part.max()), rms))
    return Statistics(rows, float(time[keep][0]), float(time[keep][-1]))
