"""One time series as every analysis takes it: ``result["surge"]``, or a pair (time, values)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from fowtlib.language.errors import ModelError

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    import xarray
    from numpy.typing import ArrayLike

    from fowtlib.solving.results import Result


@dataclass(frozen=True)
class Series:
    """Values over time [s], with the unit and the name that errors and figures use."""

    time: np.ndarray
    values: np.ndarray
    unit: str = "1"
    name: str = "the series"
    long_name: str = ""

    @property
    def step(self) -> float:
        """Step of time, s; stops when the points are not equally spaced."""
        steps = np.diff(self.time)
        step = (self.time[-1] - self.time[0]) / steps.size
        if np.abs(steps - step).max() > 1e-4 * step:
            raise ModelError(
                f"{self.name}: the points of time are not equally spaced: steps of {steps.min():g} s to "
                f"{steps.max():g} s. Simulate with one output step, or interpolate first."
            )
        return float(step)

    def after(self, discard: float) -> Series:
        """The series without its first ``discard`` seconds."""
        if discard <= 0.0:
            return self
        keep = self.time >= self.time[0] + discard - 1e-9
        if keep.sum() < 2:
            span = self.time[-1] - self.time[0]
            raise ModelError(f"{self.name}: discarding {discard:g} s leaves nothing of a record of {span:g} s.")
        return Series(self.time[keep], self.values[keep], self.unit, self.name, self.long_name)


if TYPE_CHECKING:
    SeriesLike = xarray.DataArray | Series | tuple[ArrayLike, ArrayLike]
    Records = SeriesLike | Sequence[SeriesLike]


def as_records(records: Records, discard: float = 0.0) -> list[Series]:
    """One record, or a list of several of the same process, each without its first `discard` seconds."""
    if not isinstance(records, list):
        return [as_series(records).after(discard)]
    if not records:
        raise ModelError("there are no records to analyse.")
    made = [as_series(record).after(discard) for record in records]
    for record in made[1:]:
        if record.unit != made[0].unit:
            raise ModelError(f"{made[0].name}: the records have it in different units: {made[0].unit}, {record.unit}.")
    return made


def scalar_series(result: Result, names: Iterable[str] | None = None) -> list[Series]:
    """All scalar series of a result, or those named; vectors and matrices element by element.

    A name may be that of an element, such as "force[2]", and of any variable of the model.
    """
    stored = result.stored
    if names is not None:
        from fowtlib.solving.results import Result

        values = {name: result.array(name) for name in names}
        stored = Result(result.time, values, {name: result.unit(name) for name in values}).stored
    return [Series(result.time, values, unit, name) for name, unit, values in stored.columns()]


def as_series(source: SeriesLike, name: str = "") -> Series:
    """Accept a labelled DataArray with the coordinate ``time``, a Series, or a pair (time, values)."""
    if isinstance(source, Series):
        series = source
    elif hasattr(source, "coords"):
        label = str(source.name or "the series")
        attrs = source.attrs
        time, values = np.asarray(source["time"], dtype=float), np.asarray(source, dtype=float)
        series = Series(time, values, attrs.get("units", "1"), name or label, attrs.get("long_name", ""))
    else:
        time, values = (np.asarray(part, dtype=float) for part in source)
        series = Series(time, values, name=name or "the series")
    if series.values.ndim != 1 or series.values.shape != series.time.shape:
        raise ModelError(
            f"{series.name}: an analysis takes one value per point of time; "
            f"there are {series.time.size} points and values of shape {series.values.shape}."
        )
    if series.time.size < 3:
        raise ModelError(f"{series.name}: the record has {series.time.size} points, at least 3 are needed.")
    if not np.isfinite(series.values).all():
        first = series.time[~np.isfinite(series.values)][0]
        raise ModelError(f"{series.name}: the value at {first:g} s is not a finite number.")
    return series
