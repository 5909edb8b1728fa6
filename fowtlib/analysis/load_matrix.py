"""Ultimate loads of a section as a matrix: the extremes of each load over all cases, with the others at the same time.

    |  extreme  | load case | safety factor |   Mx    |   My   | ...
    |  Mx max   |   6.2     |     1.10      | largest | at the same time ...
    |  Mx min   |   6.2     |     1.10      | smallest| ...

Rows are factored: all loads of a row are multiplied with the partial safety factor of its case, also those that come
from weight. Extremes are chosen among factored values. The form is that of wind turbine certification, IEC 61400-1,
and of table 3.4 in Serret (2019), Development of the Deepwater Turbine Installation-Floating concept.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from fowtlib.analysis.maximum import SIDES
from fowtlib.language.errors import ModelError, did_you_mean, one_of
from fowtlib.solving.results import Result
from fowtlib.solving.results.tables import write_table

CHARACTERISTIC = ("worst", "mean", "upper half")


@dataclass(frozen=True)
class LoadRow:
    """The extreme of one channel and the loads at its time [s], factored.

    case: the run it comes from; load_case: its label in the table. scale: of a characteristic value that is a mean over
    realisations, its ratio to the value of the run that comes nearest, with which the row is scaled.
    """

    channel: str
    side: str
    case: str
    load_case: str
    safety_factor: float
    time: float
    values: tuple[float, ...]
    scale: float = 1.0

    @property
    def extreme(self) -> str:
        return f"{self.channel} {self.side}"


@dataclass(frozen=True)
class LoadMatrix:
    """Rows "max" and "min" for each of the channels, in their units."""

    channels: tuple[str, ...]
    units: tuple[str, ...]
    rows: tuple[LoadRow, ...]

    @property
    def values(self) -> np.ndarray:
        """Factored loads, (2 n, n) for n channels."""
        return np.array([row.values for row in self.rows])

    def row(self, channel: str, side: str) -> LoadRow:
        for row in self.rows:
            if (row.channel, row.side) == (channel, side):
                return row
        raise ModelError(f"the load matrix has no row '{channel} {side}'{did_you_mean(channel, self.channels)}")

    def heads(self) -> tuple[str, ...]:
        units = (f"{name} [{unit}]" for name, unit in zip(self.channels, self.units, strict=True))
        return ("extreme", "load case", "safety factor", *units, "case", "time [s]", "scale")

    def table(self) -> list[tuple[Any, ...]]:
        """Rows below `heads`."""
        return [(row.extreme, row.load_case, row.safety_factor, *row.values, row.case, row.time, row.scale)
                for row in self.rows]  # fmt: skip

    def markdown(self) -> str:
        """The table as markdown, the extremes in bold."""
        heads = self.heads()[:-2]
        lines = ["| " + " | ".join(heads) + " |", "| --- | --- |" + " ---: |" * (1 + len(self.channels)) + " --- |"]
        for row in self.rows:
            cells = [_shown(value) for value in row.values]
            i = self.channels.index(row.channel)
            cells[i] = f"**{cells[i]}**"
            lines.append(f"| {row.extreme} | {row.load_case} | {row.safety_factor:.2f} | " + " | ".join(cells)
                         + f" | {row.case} |")  # fmt: skip
        return "\n".join(lines) + "\n"

    def save(self, path: str | Path) -> Path:
        """Write the table as .csv, or as .md (markdown)."""
        return write_table(path, self.heads(), self.table(), "a load matrix", self.markdown)

    def broken_rules(self) -> list[str]:
        """Sentences about what cannot be in a load matrix; [] for a sound one.

        Each row's own load is the largest (smallest) of its column, and rows of the same case and time are the same.
        The first rule need not hold for means over realisations.
        """
        found, values = [], self.values
        for i, row in enumerate(self.rows):
            j, sign = self.channels.index(row.channel), SIDES[row.side]
            best = int(np.argmax(sign * values[:, j]))
            if sign * values[best, j] > sign * values[i, j]:
                found.append(f"{row.extreme} is {values[i, j]:g}, but the row {self.rows[best].extreme} has "
                             f"{values[best, j]:g}.")  # fmt: skip
            for other in self.rows[:i]:
                same = (row.case, row.time, row.scale) == (other.case, other.time, other.scale)
                if same and row.values != other.values:
                    found.append(f"{other.extreme} and {row.extreme} are of {row.case} at {row.time:g} s, but differ.")
        return found


@dataclass(frozen=True)
class _Case:
    """Of one run: loads at each extreme, (side, extreme of channel, channel), and their times, (side, channel)."""

    name: str
    loads: np.ndarray
    times: np.ndarray
    units: tuple[str, ...]


def ultimate_loads(
    cases: Mapping[str, Any],
    channels: Sequence[str],
    safety_factors: float | Mapping[str, float] = 1.0,
    *,
    load_cases: Mapping[str, str] | None = None,
    realisations: Mapping[str, str] | None = None,
    characteristic: str | Mapping[str, str] = "worst",
    discard: float = 0.0,
) -> LoadMatrix:
    """Load matrix of several cases.

    cases           name -> Result, or output of `case_statistics`, or {channel: values} with or without "time"
    channels        the loads, for example Mx, My, Mz, Fx, Fy, Fz of one section
    safety_factors  one, or of each case by name
    load_cases      name of a case -> its label in the table, such as "6.2"; default: the name
    realisations    name of a case -> name of the condition of which it is one realisation (a seed); default: each alone
    characteristic  what stands for several realisations: "worst", the "mean" of their extremes, or that of the "upper
                    half" (IEC 61400-1, 7.6.2.2: mean for turbulent wind, upper half with faults, worst for gusts);
                    one word, or by name of the condition. The loads at the same time are those of the realisation that
                    comes nearest, scaled with the ratio of the two extremes if they have one sign
    discard         seconds left out at the beginning, of results and of values with time

    Raises ModelError: no cases, a channel that a case lacks, units that differ, no safety factor for a case.
    """
    if not cases:
        raise ModelError("there are no cases to take loads from.")
    if not channels or len(set(channels)) < len(channels):
        raise ModelError("a load matrix takes the names of one or more channels, each once.")
    labels, groups = load_cases or {}, realisations or {}
    for what, names in (("load_cases", labels), ("realisations", groups)):
        for name in names:
            if name not in cases:
                raise ModelError(f"{what}: there is no case '{name}'{did_you_mean(name, cases)}")
    extremes = [_extremes(name, source, channels, discard) for name, source in cases.items()]
    for case in extremes[1:]:
        for channel, unit, first in zip(channels, case.units, extremes[0].units, strict=True):
            if unit != first:
                raise ModelError(f"{channel}: is in {first} in {extremes[0].name}, and in {unit} in {case.name}.")
    factors = {name: _factor(name, safety_factors) for name in cases}
    conditions: dict[str, list[_Case]] = {}
    for case in extremes:
        conditions.setdefault(groups.get(case.name, case.name), []).append(case)
    words = {name: characteristic if isinstance(characteristic, str) else characteristic.get(name, "worst")
             for name in conditions}  # fmt: skip
    for word in words.values():
        if word not in CHARACTERISTIC:
            raise ModelError(f"what stands for several realisations is {one_of(CHARACTERISTIC)}, not '{word}'.")
    rows = []
    for i, channel in enumerate(channels):
        for s, side in enumerate(SIDES):
            candidates = [_candidate(members, words[name], s, i, factors) for name, members in conditions.items()]
            value, case, scale = max(candidates, key=lambda found: SIDES[side] * found[0])
            factor = factors[case.name]
            values = (factor * scale * case.loads[s, i]).tolist()
            values[i] = value
            rows.append(LoadRow(channel, side, case.name, labels.get(case.name, case.name), factor,
                                float(case.times[s, i]), tuple(values), scale))  # fmt: skip
    return LoadMatrix(tuple(channels), extremes[0].units, tuple(rows))


def _candidate(
    members: list[_Case], word: str, s: int, i: int, factors: Mapping[str, float]
) -> tuple[float, _Case, float]:
    """Characteristic value of one condition, factored, the realisation nearest to it, and the scale of its loads."""
    sign = list(SIDES.values())[s]
    values = np.array([factors[case.name] * case.loads[s, i, i] for case in members])
    worst_first = np.argsort(-sign * values, kind="stable")
    if word == "worst" or len(members) == 1:
        best = int(worst_first[0])
        return float(values[best]), members[best], 1.0
    taken = values if word == "mean" else values[worst_first[: math.ceil(len(values) / 2)]]
    value = float(taken.mean())
    nearest = int(np.argmin(np.abs(values - value)))
    one_sign = values[nearest] * value > 0.0
    return value, members[nearest], float(value / values[nearest]) if one_sign else 1.0


def _factor(name: str, factors: float | Mapping[str, float]) -> float:
    if isinstance(factors, Mapping):
        if name not in factors:
            raise ModelError(f"there is no safety factor for the case '{name}'.")
        factors = factors[name]
    if not (math.isfinite(factors) and factors > 0.0):
        raise ModelError(f"the safety factor of the case '{name}' must be above 0 and finite, not {factors:g}.")
    return float(factors)


def _extremes(name: str, source: Any, channels: Sequence[str], discard: float) -> _Case:
    if isinstance(source, Mapping) and "at_extremes" in source:
        return _of_statistics(name, source, channels)
    if isinstance(source, Result):
        try:
            time, loads = source.time, [source.array(channel) for channel in channels]
        except ModelError as error:
            raise error.at(name) from None
        units = tuple(source.unit(channel) for channel in channels)
    else:
        missing = [channel for channel in channels if channel not in source]
        if missing:
            raise ModelError(f"{name}: has no channel '{missing[0]}'{did_you_mean(missing[0], source)}")
        units = ("1",) * len(channels)
        loads = [np.asarray(source[channel], dtype=float) for channel in channels]
        time = np.asarray(source.get("time", np.arange(loads[0].size)), dtype=float)
        if discard and "time" not in source:
            raise ModelError(f"{name}: has no 'time', so that nothing can be left out of its beginning.")
    for channel, values in zip(channels, loads, strict=True):
        if values.shape != time.shape or not time.size:
            raise ModelError(
                f"{name}: the channels of a load matrix have one value for each of {time.size} points of time; "
                f"{channel} has values of shape {values.shape}."
            )
    table = np.array(loads)
    keep = time >= time[0] + discard - 1e-9
    if not keep.any():
        raise ModelError(f"{name}: discarding {discard:g} s leaves nothing of {time[-1] - time[0]:g} s.")
    time, table = time[keep], table[:, keep]
    for channel, values in zip(channels, table, strict=True):
        if not np.isfinite(values).all():
            raise ModelError(f"{name}: {channel} at {time[~np.isfinite(values)][0]:g} s is not a finite number.")
    at = np.array([table.argmax(axis=1), table.argmin(axis=1)])
    return _Case(name, np.moveaxis(table[:, at], 0, -1), time[at], units)


def _of_statistics(name: str, told: Mapping[str, Any], channels: Sequence[str]) -> _Case:
    names: list[str] = told["at_extremes"]["names"]
    for channel in channels:
        if channel not in names:
            why = told.get("refused", {}).get(channel)
            raise ModelError(f"{name}: {channel}: {why}" if why else
                             f"{name}: has no channel '{channel}'{did_you_mean(channel, names)}")  # fmt: skip
    chosen = [names.index(channel) for channel in channels]
    loads = np.array([[[told["at_extremes"][side][i][j] for j in chosen] for i in chosen] for side in SIDES])
    times = np.array([[told["channels"][channel][f"{side}_time"] for channel in channels] for side in SIDES])
    return _Case(name, loads, times, tuple(told["channels"][channel]["unit"] for channel in channels))


def _shown(value: float) -> str:
    return f"{value:.0f}" if abs(value) >= 1e4 else f"{value:.4g}"
