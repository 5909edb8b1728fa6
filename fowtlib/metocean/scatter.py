"""Scatter tables: how often each class of wind speed, wave height and peak period was observed."""

from __future__ import annotations

import os
from dataclasses import dataclass, replace

import numpy as np

from fowtlib.language.errors import ParameterError
from fowtlib.metocean.csv_columns import read_columns
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
    """A CSV with a header and the columns wind_speed [m/s], Hs [m], Tp [s], and probability or count.

    ParameterError with file and line for what cannot be.
    """
    table = read_columns(path, "the scatter table", COUNTS)
    counted = [name for name in COUNTS if name in table.numbers]
    if len(counted) != 1:
        raise ParameterError("the scatter table needs one column 'probability' or 'count'.", where=table.path)
    weight = table.numbers[counted[0]]
    table.refuse(weight < 0, f"a {counted[0]} is not negative.")
    if counted == ["probability"] and abs(weight.sum() - 1) > 0.01:
        raise ParameterError(
            f"the probabilities have the sum {weight.sum():.4g} and not 1; call the column 'count' if they are counts.",
            where=table.path,
        )
    if not weight.sum() > 0:
        raise ParameterError("all counts are zero.", where=table.path)
    some = weight > 0
    states = table.states(some, weight[some] / weight.sum())
    if len(set(states)) != len(states):
        raise ParameterError("a class stands in the table twice.", where=table.path)
    return ScatterTable(states, table.path)
