"""A batch as its report looks at it: which cases are done, which results are shown, what is extreme and where."""

from __future__ import annotations

from collections.abc import Sequence
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
ENDS = {"max": max, "min": min}


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
    def all(self) -> dict[str, dict[str, Any]]:
        """All statistics by case; see Batch.statistics."""
        return {row.name: self.batch.statistics(row.name) for row in self.done}

    @cached_property
    def units(self) -> dict[str, str]:
        """Of all results that a case has, in their order."""
        return {name: told["unit"] for row in self.done for name, told in row.statistics.items()}

    @cached_property
    def kept(self) -> dict[str, Row]:
        """By name, those of which the file of results is there."""
        return {row.name: row for row in self.done if row.result and (self.batch.folder / row.result).is_file()}

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
        return any(row.statistics.get(name, {}).get("std") for row in self.done)

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
    def unit(self) -> str:
        """That of the label, where it is known."""
        return UNITS.get(self.label, "")

    @property
    def label_words(self) -> str:
        """The label as the title of an axis."""
        return words(self.label) + (f" [{self.unit}]" if self.unit else "")

    def label_of(self, row: Row) -> float:
        """The value of that label; nan where a case has none."""
        value = row.case.labels.get(self.label, np.nan)
        return float(value) if isinstance(value, (int, float)) else np.nan

    def extreme(self, name: str, end: str) -> Row:
        """The case in which a result is largest ("max") or least ("min")."""
        having = [row for row in self.done if name in row.statistics]
        return ENDS[end](having, key=lambda row: row.statistics[name][end])

    def worst(self, name: str) -> tuple[Row, str]:
        """The case in which a result is farthest from its mean over all cases, and at which end."""
        middle = np.mean([row.statistics[name]["mean"] for row in self.done if name in row.statistics])
        ends = [(self.extreme(name, end), end) for end in ENDS]
        return max(ends, key=lambda item: abs(item[0].statistics[name][item[1]] - middle))

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
        told = [f"{len(self.done)} of {len(self.rows)} cases are done{''.join(f', {text}' for text in rest)}."]
        if simulated and spent:
            told.append(f"{time_span(simulated)} were simulated in {time_span(spent)} of one processor core, "
                        f"{number(simulated / spent)} times real time.")  # fmt: skip
        return told

    def places(self, rows: Sequence[Row]) -> dict[str, np.ndarray]:
        """Which of these cases have each value of the label, by the value in words."""
        if not self.label:
            return {}
        values = np.array([self.label_of(row) for row in rows])
        return {f"{value:g} {self.unit}".strip(): values == value for value in np.unique(values[np.isfinite(values)])}

    def groups(self) -> dict[str, list[Row]]:
        """Cases whose results are there, by label; of many values a few, evenly chosen."""
        kept = list(self.kept.values())
        if not self.label:
            return {"all cases": kept} if kept else {}
        found = list(self.places(kept).items())
        picked = np.unique(np.linspace(0, len(found) - 1, min(MOST_LINES, len(found))).round().astype(int))
        return {
            f"{words(self.label)} {value}": [row for row, inside in zip(kept, rows, strict=True) if inside]
            for value, rows in (found[k] for k in picked)
        }


def words(name: str) -> str:
    """A name as it is read."""
    return name.replace("_", " ")
