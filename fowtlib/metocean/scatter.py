"""Scatter tables: how often each class of wind speed, wave height and peak period was observed."""

from __future__ import annotations

import os
from dataclasses import dataclass, replace

import numpy as np

from fowtlib.language.data_files import cells_of, lines_of
from fowtlib.language.errors import ParameterError, did_you_mean
from fowtlib.metocean.joint import VARIABLES
from fowtlib.metocean.states import States

COUNTS = ("probability", "count")


@dataclass(frozen=True)
class ScatterTable:
    """Classes by their centres, with probabilities of sum 1."""

    states: States
    name: str = ""

    def conditional(self, wind_speed: float, value: str = "median") -> tuple[float, float]:
        """Significant wave height and peak period that go with a wind speed, linear between the classes of wind.

        value: "median" or "mean" of the classes of the wind speed. Refuses a wind speed outside of the table.
        """
        if value not in ("median", "mean"):
            raise ParameterError(f"conditional values are 'median' or 'mean', not '{value}'.")
        winds = np.unique(self.states.wind_speed)
        if not winds[0] <= wind_speed <= winds[-1]:
            raise ParameterError(
                f"{wind_speed:g} m/s is outside of the scatter table, whose classes have centres from "
                f"{winds[0]:g} to {winds[-1]:g} m/s.",
                where=self.name,
            )
        rows = []
        for wind in winds:
            some = self.states[self.states.wind_speed == wind]
            rows.append([_of(values, some.weights, value) for values in (some.wave_height, some.peak_period)])
        return tuple(float(np.interp(wind_speed, winds, column)) for column in np.transpose(rows))  # type: ignore

    def sample(self, count: int, seed: int) -> States:
        """So many classes, drawn by their probabilities, each of probability 1 / count."""
        if count < 1:
            raise ParameterError(f"a sample has one state or more, not {count}.")
        drawn = np.random.default_rng(seed).choice(len(self.states), size=count, p=self.states.weights)
        return replace(replace(self.states, probability=None)[drawn], probability=np.full(count, 1 / count))


def _of(values: np.ndarray, weights: np.ndarray, value: str) -> float:
    if value == "mean":
        return float(np.average(values, weights=weights))
    order = np.argsort(values)
    sums = np.cumsum(weights[order]) / weights.sum()
    return float(values[order][np.searchsorted(sums, 0.5 - 1e-12)])


def read_scatter(path: str | os.PathLike[str]) -> ScatterTable:
    """A CSV with a header and the columns wind_speed [m/s], wave_height [m], peak_period [s], probability or count.

    Units may stand behind the names. ParameterError with file and line for what cannot be.
    """
    where = os.fspath(path)
    lines = lines_of(path, "the scatter table")
    if len(lines) < 2:
        raise ParameterError("a scatter table has a header and one line or more.", where=where)
    head = [cell.partition("[")[0].strip() for cell in cells_of(lines[0][1])]
    for name in head:
        if name not in (*VARIABLES, *COUNTS):
            raise ParameterError(
                f"a scatter table has no column '{name}'{did_you_mean(name, (*VARIABLES, *COUNTS))}",
                where=f"{where}:{lines[0][0]}",
            )
    counted = [name for name in COUNTS if name in head]
    missing = [name for name in VARIABLES if name not in head] + ([] if len(counted) == 1 else ["probability or count"])
    if missing or len(set(head)) != len(head):
        raise ParameterError(f"the scatter table needs one column each: {', '.join(missing or head)}.", where=where)
    rows = np.array([_row(line, len(head), f"{where}:{number}") for number, line in lines[1:]])
    columns = dict(zip(head, rows.T, strict=True))
    weight = columns[counted[0]]
    bad = (weight < 0) | (np.min([columns[name] for name in VARIABLES], axis=0) <= 0)
    if bad.any():
        raise ParameterError(
            "centres of classes are positive, and counts not negative.",
            where=f"{where}:{lines[1 + int(np.argmax(bad))][0]}",
        )
    if counted == ["probability"] and abs(weight.sum() - 1) > 0.01:
        raise ParameterError(
            f"the probabilities have the sum {weight.sum():.4g} and not 1; if they are counts, call the "
            "column 'count'.",
            where=where,
        )
    if not weight.sum() > 0:
        raise ParameterError("all counts are zero.", where=where)
    some = weight > 0
    states = States(*(columns[name][some] for name in VARIABLES), weight[some] / weight.sum())
    if len(set(states)) != len(states):
        raise ParameterError("a class stands in the table twice.", where=where)
    return ScatterTable(states, where)


def _row(line: str, count: int, where: str) -> list[float]:
    cells = cells_of(line)
    try:
        numbers = [float(cell) for cell in cells]
    except ValueError:
        raise ParameterError(f"'{line.strip()}' is not a row of numbers.", where=where) from None
    if len(numbers) != count or not np.isfinite(numbers).all():
        raise ParameterError(f"the row is to have {count} finite numbers.", where=where)
    return numbers
