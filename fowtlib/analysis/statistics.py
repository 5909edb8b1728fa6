"""Statistics of several runs: means over seeds, one case against another.

Those of one run: ``result.statistics(discard=400)``.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from fowtlib.analysis.crossings import count_up_crossings
from fowtlib.analysis.series import as_series
from fowtlib.language.errors import ModelError
from fowtlib.solving.results import Statistics, Summary

if TYPE_CHECKING:
    from fowtlib.analysis.series import SeriesLike
    from fowtlib.solving.results import Result


def over_seeds(results: Sequence[Result], *, discard: float = 0.0) -> Statistics:
    """Statistics of several realisations of one case.

    Mean and root mean square are pooled, the standard deviation is that of all samples about each run's own mean, and
    minimum and maximum are the means of the runs' minima and maxima (the usual estimate of a characteristic extreme).
    """
    if not results:
        raise ModelError("there are no results to take statistics of.")
    tables = [result.statistics(discard) for result in results]
    common = [name for name in tables[0] if all(name in table for table in tables)]

    def pooled(name: str) -> Summary:
        rows = [table[name] for table in tables]
        mean, low, high = (float(np.mean([getattr(row, key) for row in rows])) for key in ("mean", "min", "max"))
        std, rms = (float(np.sqrt(np.mean([getattr(row, key) ** 2 for row in rows]))) for key in ("std", "rms"))
        return Summary(name, rows[0].unit, mean, std, low, high, rms)

    return Statistics([pooled(name) for name in common], tables[0].first, tables[0].last)


def normalized_maxima(case: Result, base: Result, *, discard: float = 0.0) -> dict[str, float]:
    """Largest value of every result of ``case`` over that of ``base``, such as a fault over normal operation."""
    ours, theirs = case.statistics(discard), base.statistics(discard)
    return {name: ours[name].max / theirs[name].max for name in ours if name in theirs and theirs[name].max != 0.0}


@dataclass(frozen=True)
class Crossings:
    """Upward crossings of a level: how many, how often [1/s], and the mean time between them [s]."""

    level: float
    count: int
    rate: float
    mean_period: float


def up_crossings(series: SeriesLike, *, level: float | None = None, discard: float = 0.0) -> Crossings:
    """Upward crossings of ``level`` (None: the mean of the series)."""
    record = as_series(series).after(discard)
    height = float(record.values.mean()) if level is None else float(level)
    count = int(count_up_crossings(record.values, [height])[0])
    rate = count / float(record.time[-1] - record.time[0])
    return Crossings(height, count, rate, 1.0 / rate if count else float("inf"))
