"""All statistics of one run as plain data, for a registry of many runs; and what many runs have in common.

    {"first": 400.0, "last": 4000.0, "points": 36001,
     "channels": {"surge": {"unit": "m", "mean": ..., "std": ..., ...}, ...},
     "at_extremes": {"names": ["surge", ...], "max": [[...], ...], "min": [[...], ...]},
     "refused": {"power_coefficient": "the value at 400 s is not a finite number."}}

Of a channel: mean, std, rms, min, max, min_time, max_time [s], skewness, kurtosis (3 for a Gaussian process),
percentiles {"50": ...}, mean_crossing_rate (upward, 1/s), and crossings: how often the series leaves the band within
mean +- k/10 std upward ("above") and downward ("below"), k = 0, 1, ... until never. A constant has neither skewness nor
kurtosis (None) and no crossings. Row i of at_extremes["max"] holds the values of all channels at the time at which
names[i] is largest.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from fowtlib.analysis.crossings import count_up_crossings
from fowtlib.analysis.series import scalar_series
from fowtlib.language.errors import ModelError
from fowtlib.solving.results.statistics import time_weights

if TYPE_CHECKING:
    from fowtlib.solving.results import Result

PERCENTILES = (1.0, 5.0, 25.0, 50.0, 75.0, 95.0, 99.0)
CROSSING_STEP = 0.1  # of the standard deviation, between the levels at which crossings are counted
_CONSTANT = 1e-12  # a standard deviation below this part of the largest value is rounding


def case_statistics(
    result: Result,
    discard: float = 0.0,
    *,
    percentiles: Sequence[float] = PERCENTILES,
    names: Sequence[str] | None = None,
) -> dict[str, Any]:
    """Statistics of all scalar series of a result, without its first `discard` seconds, as what JSON can hold.

    names: of the channels, also elements such as "force[2]" and variables of the model; None takes all. Vectors and
    matrices count element by element. A channel with a value that is not finite is listed under "refused" with a
    sentence. Raises ModelError when `discard` leaves fewer than 3 points, or a percentile is not between 0 and 100.
    """
    wanted = sorted(map(float, percentiles))
    if wanted and not (wanted[0] >= 0.0 and wanted[-1] <= 100.0):
        raise ModelError(f"percentiles lie between 0 and 100, not {wanted[0]:g} to {wanted[-1]:g}.")
    time = result.time
    keep = time >= time[0] + discard - 1e-9 if time.size else np.zeros(0, dtype=bool)
    if keep.sum() < 3:
        raise ModelError(
            f"statistics: discarding {discard:g} s leaves {keep.sum()} points of a result of {result.duration:g} s, "
            "and 3 are needed. Discard less, or simulate longer."
        )
    start = int(np.argmax(keep))
    time = time[start:]
    columns = [(series.name, series.unit, series.values[start:]) for series in scalar_series(result, names)]
    refused = {name: _not_finite(time, values) for name, _, values in columns if not np.isfinite(values).all()}
    columns = [column for column in columns if column[0] not in refused]
    channels, at = _channels(time, columns, wanted)
    return {"first": float(time[0]), "last": float(time[-1]), "points": int(time.size), "channels": channels,
            "at_extremes": {"names": [name for name, _, _ in columns], **at}, "refused": refused}  # fmt: skip


def _not_finite(time: np.ndarray, values: np.ndarray) -> str:
    return f"the value at {time[~np.isfinite(values)][0]:g} s is not a finite number."


def _channels(
    time: np.ndarray, columns: list[tuple[str, str, np.ndarray]], percentiles: list[float]
) -> tuple[dict[str, Any], dict[str, list[list[float]]]]:
    """What is told of each channel, and the values of all channels at the extremes of each."""
    if not columns:
        return {}, {"max": [], "min": []}
    table = np.array([values for _, _, values in columns])  # a row per channel
    weights = time_weights(time)
    mean = table @ weights
    away = table - mean[:, None]
    squares = away * away
    variance = squares @ weights
    std = np.sqrt(variance)
    third, fourth = (squares * away) @ weights, (squares * squares) @ weights
    highest, lowest = table.argmax(axis=1), table.argmin(axis=1)
    fractiles = _percentiles(table, weights, percentiles)
    span = float(time[-1] - time[0])
    told = {}
    for i, (name, unit, values) in enumerate(columns):
        low, high = float(table[i, lowest[i]]), float(table[i, highest[i]])
        constant = std[i] <= _CONSTANT * max(abs(low), abs(high))
        above, below = ([], []) if constant else (_passed(away[i], std[i]), _passed(-away[i], std[i]))
        told[name] = {
            "unit": unit,
            "mean": float(mean[i]),
            "std": float(std[i]),
            "rms": float(np.sqrt(weights @ (values * values))),
            "min": low,
            "max": high,
            "min_time": float(time[lowest[i]]),
            "max_time": float(time[highest[i]]),
            "skewness": None if constant else float(third[i] / std[i] ** 3),
            "kurtosis": None if constant else float(fourth[i] / variance[i] ** 2),
            "percentiles": {f"{p:g}": float(value) for p, value in zip(percentiles, fractiles[:, i], strict=True)},
            "mean_crossing_rate": above[0] / span if above else 0.0,
            "crossings": {"step": CROSSING_STEP, "above": above, "below": below},
        }
    return told, {"max": table[:, highest].T.tolist(), "min": table[:, lowest].T.tolist()}


def _passed(away: np.ndarray, std: float) -> list[int]:
    """Upward crossings of 0, 1, 2, ... steps of the standard deviation, up to the last level that is passed."""
    levels = np.arange(int(max(away.max(), 0.0) / (CROSSING_STEP * std)) + 1) * (CROSSING_STEP * std)
    counts = count_up_crossings(away, levels)
    last = int(np.flatnonzero(counts)[-1]) + 1 if counts.any() else 0
    return counts[:last].tolist()


def _percentiles(table: np.ndarray, weights: np.ndarray, percentiles: list[float]) -> np.ndarray:
    """Per percentile and channel; with the weights of time where the steps are not equal."""
    if not percentiles:
        return np.zeros((0, len(table)))
    if np.ptp(weights) == 0.0:
        return np.quantile(table, np.divide(percentiles, 100.0), axis=1)
    order = np.argsort(table, axis=1)
    part = weights[order]
    below = np.cumsum(part, axis=1) - 0.5 * part
    pairs = zip(below, np.take_along_axis(table, order, axis=1), strict=True)
    return np.array([np.interp(np.divide(percentiles, 100.0), x, y) for x, y in pairs]).T


def over_cases(
    cases: Mapping[str, Mapping[str, Any]], weights: Mapping[str, float] | None = None
) -> dict[str, dict[str, Any]]:
    """Statistics over many cases, by channel: of the output of `case_statistics` by name of the case.

    weights: of the cases in mean and deviation, such as hours in the lifetime; equal by default. Of a channel that all
    cases have: unit, cases (how many), mean, std (within the cases, about each one's own mean), total_std (about the
    mean of all), max and max_case, mean_max and std_max (over the cases, n - 1), and min, min_case, mean_min, std_min.
    Raises ModelError for no cases, weights that are missing, negative or all zero, and units that differ.
    """
    if not cases:
        raise ModelError("there are no cases to take statistics of.")
    shares = np.array([1.0 if weights is None else float(weights.get(name, np.nan)) for name in cases])
    if not (np.isfinite(shares).all() and shares.min() >= 0.0 and shares.sum() > 0.0):
        raise ModelError("the weights of cases are numbers from 0 upward, one for each case, and not all zero.")
    shares = shares / shares.sum()
    labels = list(cases)
    first = cases[labels[0]]["channels"]
    told = {}
    for name in first:
        rows = [case["channels"].get(name) for case in cases.values()]
        if any(row is None for row in rows):
            continue
        units = {row["unit"] for row in rows}
        if len(units) > 1:
            raise ModelError(f"{name}: the cases have it in different units: {', '.join(sorted(units))}.")
        mean, std, low, high = (np.array([row[key] for row in rows]) for key in ("mean", "std", "min", "max"))
        overall, within = float(shares @ mean), float(shares @ std**2)
        spread = len(rows) > 1
        told[name] = {
            "unit": rows[0]["unit"],
            "cases": len(rows),
            "mean": overall,
            "std": within**0.5,
            "total_std": (within + float(shares @ (mean - overall) ** 2)) ** 0.5,
            "max": float(high.max()),
            "max_case": labels[int(high.argmax())],
            "mean_max": float(high.mean()),
            "std_max": float(high.std(ddof=1)) if spread else None,
            "min": float(low.min()),
            "min_case": labels[int(low.argmin())],
            "mean_min": float(low.mean()),
            "std_min": float(low.std(ddof=1)) if spread else None,
        }
    return told
