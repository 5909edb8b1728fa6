"""A batch as its report looks at it: which cases are done, which results are shown, what is extreme and where."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from fowtlib.analysis.fatigue.loads import is_load
from fowtlib.language.errors import ModelError, NotFoundError, did_you_mean
from fowtlib.report.content import number, time_span
from fowtlib.solving.results.plots import PANELS

if TYPE_CHECKING:
    from fowtlib.cases import Batch
    from fowtlib.cases.registry import Row

OVER = ("wind_speed", "mean_speed", "speed", "significant_wave_height")  # labels to draw over, where there are some
UNITS = {"wind_speed": "m/s", "significant_wave_height": "m", "peak_period": "s", "wave_heading": "deg",
         "yaw_error": "deg"}  # fmt: skip
NOT_JUDGED = ("azimuth",)  # of which an extreme says nothing
MOST_SHOWN = 16  # results with figures
MOST_LINES = 5  # spectra in one figure


@dataclass
class View:
    """A batch as the report looks at it."""

    batch: Batch
    chosen: list[str]

    def __post_init__(self) -> None:
        self.rows: list[Row] = self.batch.rows()
        self.done = [row for row in self.rows if row.state == "done" and row.statistics]
        self.failed = [row for row in self.rows if row.state == "failed"]
        if not self.done:
            raise ModelError(f"{self.batch.folder}: no case is done, so there is nothing to report; fowt batch run.")
        for name in self.chosen:
            if name not in self.units:
                raise NotFoundError(f"the cases have no result '{name}'{did_you_mean(name, self.units, list_up_to=30)}")

    # --- what there is -----------------------------------------------------------------------------------------------

    @cached_property
    def channels(self) -> dict[str, dict[str, dict[str, Any]]]:
        """Statistics by case and result."""
        return {row.name: row.statistics for row in self.done}

    @cached_property
    def all(self) -> dict[str, dict[str, Any]]:
        """All statistics by case; see Batch.statistics."""
        return {row.name: self.batch.statistics(row.name) for row in self.done}

    @cached_property
    def units(self) -> dict[str, str]:
        """Of all results that a case has, in their order."""
        return {name: told["unit"] for case in self.channels.values() for name, told in case.items()}

    @cached_property
    def judged(self) -> list[str]:
        """Results whose extremes are of interest."""
        return [name for name in self.units if name not in NOT_JUDGED]

    @cached_property
    def loads(self) -> list[str]:
        """Forces, moments and stresses."""
        return [name for name in self.judged if is_load(self.units[name])]

    @cached_property
    def shown(self) -> list[str]:
        """Results with figures: those asked for, else the usual ones and the loads that vary."""
        if self.chosen:
            return self.chosen
        usual = [name for panel in PANELS for start in panel for name in self.judged if name.startswith(start)]
        moving = [name for name in dict.fromkeys([*usual, *self.loads, *self.judged]) if self._moves(name)]
        return moving[:MOST_SHOWN]

    def _moves(self, name: str) -> bool:
        return any(told.get(name, {}).get("std") for told in self.channels.values())

    @cached_property
    def label(self) -> str:
        """The label that figures are drawn over; "" where the cases have none with several numbers."""
        values: dict[str, set[float]] = {}
        for row in self.done:
            for key, value in row.case.labels.items():
                if isinstance(value, (int, float)):
                    values.setdefault(key, set()).add(float(value))
        several = [key for key, found in values.items() if len(found) > 1 and key != "seed"]
        return next((key for key in (*OVER, *several) if key in several), "")

    @property
    def label_words(self) -> str:
        """The label as the title of an axis, with its unit where that is known."""
        return words(self.label) + (f" [{UNITS[self.label]}]" if self.label in UNITS else "")

    def label_of(self, row: Row) -> float:
        """The value of that label; nan where a case has none."""
        value = row.case.labels.get(self.label, np.nan)
        return float(value) if isinstance(value, (int, float)) else np.nan

    def extreme(self, name: str, kind: str) -> tuple[Row, dict[str, Any]] | None:
        """The case in which a result is largest ("max") or least ("min"), and its statistics there."""
        having = [(row, self.channels[row.name][name]) for row in self.done if name in self.channels[row.name]]
        best = max if kind == "max" else min
        return best(having, key=lambda item: item[1][kind]) if having else None

    def worst(self, name: str) -> tuple[Row, dict[str, Any], str]:
        """The case in which a result is farthest from its mean over all cases; its statistics, and at which end."""
        ends = [(*found, kind) for kind in ("max", "min") if (found := self.extreme(name, kind))]
        middle = np.mean([told[name]["mean"] for told in self.channels.values() if name in told])
        return max(ends, key=lambda item: abs(item[1][item[2]] - middle))

    @property
    def title(self) -> str:
        """Of the page."""
        models = dict.fromkeys(Path(row.case.model).stem for row in self.rows)
        groups = ", ".join(filter(None, dict.fromkeys(row.case.group for row in self.rows)))
        return f"{', '.join(models)}: {groups or f'{len(self.rows)} cases'}"

    @property
    def lead(self) -> list[str]:
        """What comes first."""
        simulated = sum(row.simulated or 0.0 for row in self.done)
        spent = sum(row.processor or row.seconds or 0.0 for row in self.done)
        due = len(self.rows) - len(self.done) - len(self.failed)
        rest = [f"{len(self.failed)} failed"] * bool(self.failed) + [f"{due} not run yet"] * bool(due)
        words = [f"{len(self.done)} of {len(self.rows)} cases are done{''.join(f', {text}' for text in rest)}."]
        if simulated and spent:
            words.append(f"{time_span(simulated)} were simulated in {time_span(spent)} of one processor core, "
                         f"{number(simulated / spent)} times real time.")  # fmt: skip
        return words

    def places(self) -> dict[str, np.ndarray]:
        """Which of the cases that are done have each value of the label, by the value in words."""
        if not self.label:
            return {}
        values = np.array([self.label_of(row) for row in self.done])
        unit = f" {UNITS[self.label]}" if self.label in UNITS else ""
        return {f"{value:g}{unit}": values == value for value in np.unique(values[np.isfinite(values)])}

    def groups(self) -> dict[str, list[Row]]:
        """Cases whose results are there, by label; of many values a few, evenly chosen."""
        there = [row for row in self.done if self.batch.path(row.name)]
        if not self.label:
            return {"all cases": there} if there else {}
        values = np.unique([value for row in there if np.isfinite(value := self.label_of(row))])
        if not values.size:
            return {}
        picked = values[np.unique(np.linspace(0, len(values) - 1, min(MOST_LINES, len(values))).round().astype(int))]
        label, unit = words(self.label), f" {UNITS[self.label]}" if self.label in UNITS else ""
        return {f"{label} {value:g}{unit}": [row for row in there if self.label_of(row) == value] for value in picked}


def words(name: str) -> str:
    """A name as it is read."""
    return name.replace("_", " ")
