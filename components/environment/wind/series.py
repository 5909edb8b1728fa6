"""Wind speeds from a file."""

from __future__ import annotations

import numpy as np

from fowtlib.components.environment.wind.base import Wind, station_height
from fowtlib.components.environment.wind_file import WindSeries, read_series
from fowtlib.language import Series, param
from fowtlib.language.errors import ParameterError


class SeriesWind(Wind, kind="file"):
    """The speed of each station from a CSV file, see wind_file.read_series; a run past its end stops there.

    Between the samples it is a cubic spline with two continuous derivatives, which overshoots where the samples jump;
    "monotone" is the cubic of Fritsch and Carlson (1980), which stays between the samples, and "linear" straight.
    """

    in_own_units = {"": "the file has seconds and speeds of its own"}

    void = ("mean_speed",)
    of_data = True

    file: str = param(default="", bound=True, doc="CSV with time [s] and speed [m/s] of each station")
    interpolation: str = param(
        default="cubic", choices=("cubic", "monotone", "linear"), bound=True, doc="between the samples"
    )

    def read(self) -> WindSeries:
        """What the file says."""
        if not self.file:
            raise ParameterError(
                f"{self.label}.file has no value; a wind of kind 'file' needs the path of a CSV file."
            )
        return read_series(self.file, len(self.hubs))

    def station_series(self) -> Series | None:
        """The speeds in the base, which is sheared above and below the stations."""
        series = self.read()
        values = np.hstack([series.values, np.zeros_like(series.values)])
        return Series.samples(values, series.step, series.start, interpolation=self.interpolation)

    def mean_at(self, station: int = 0) -> float:
        """Mean [m/s] of the series of a station."""
        station_height(self, station)
        return float(self.read().values[:, station].mean())
