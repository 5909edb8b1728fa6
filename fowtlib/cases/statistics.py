"""Statistics of one case, as plain data for the registry."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from fowtlib.solving.results import Result

_AT_ONCE = 2**22  # numbers that are worked on together, so that long results do not double the memory


def statistics_of(result: Result) -> dict[str, dict[str, Any]]:
    """By output (vectors by element): unit, mean, std, min, max, rms, skewness and kurtosis (3 of a normal one).

    Of all points of the result, with equal weights. Skewness and kurtosis of what does not change are nan.
    """
    columns = list(result.stored.columns())
    size = max(1, _AT_ONCE // max(1, result.time.size))
    told: dict[str, dict[str, Any]] = {}
    for first in range(0, len(columns), size):
        some = columns[first : first + size]
        values = np.array([column for _, _, column in some])  # (outputs, points)
        mean, low, high = values.mean(axis=1), values.min(axis=1), values.max(axis=1)
        values -= mean[:, None]
        squares = values * values
        variance = squares.mean(axis=1)
        third, fourth = (values * squares).mean(axis=1), (squares * squares).mean(axis=1)
        still = variance <= (1e-12 * np.maximum(np.abs(low), np.abs(high))) ** 2
        with np.errstate(invalid="ignore", divide="ignore"):
            skewness = np.where(still, np.nan, third / variance**1.5)
            kurtosis = np.where(still, np.nan, fourth / variance**2)
        numbers = {"mean": mean, "std": np.sqrt(variance), "min": low, "max": high,
                   "rms": np.sqrt(variance + mean**2), "skewness": skewness, "kurtosis": kurtosis}  # fmt: skip
        for k, (name, unit, _) in enumerate(some):
            told[name] = {"unit": unit, **{key: float(array[k]) for key, array in numbers.items()}}
    return told
