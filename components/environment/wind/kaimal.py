"""Turbulent wind at the stations."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from fowtlib.components.environment import iec, turbulence
from fowtlib.components.environment.disc_turbulence import places_density
from fowtlib.components.environment.wind.steady import SteadyWind
from fowtlib.components.environment.wind_file import WindSeries
from fowtlib.language import Number, Series, param
from fowtlib.language.run_time import RestingPlaces, TurningRings

_turbulence = lru_cache(maxsize=8)(turbulence.kaimal_series)


class KaimalWind(SteadyWind, kind="kaimal"):
    """Kaimal turbulence at the stations: the normal turbulence model by class, or an intensity.

    It is the fluctuation, not sheared (IEC 61400-1 annex B). What a series holds and loses: module turbulence.
    """

    in_own_units = {"": "the turbulence of the standard has lengths and speeds of full scale"}

    turbulence_class: str = param(default="B", choices=iec.TURBULENCE_CLASSES, bound=True, doc="IEC turbulence class")
    turbulence_intensity: Number = param(
        default=None, min=0, max=2, bound=True, instead_of=("turbulence_class",),
        doc="sigma/V; without a value by the class",
    )  # fmt: skip
    seed: int = param(default=1, min=0, bound=True, doc="number of the realisation")
    sample_step: Number = param(
        default=0.25, unit="s", min=0, bound=True, doc="sampling; harmonics up to 1/(4 sample_step)"
    )
    repetition_period: Number = param(default=4096.0, unit="s", min=0, bound=True, doc="period of the realisation")

    def standard_deviation(self) -> float:
        """Sigma [m/s] of the speed at a station, of the whole spectrum."""
        if self.turbulence_intensity is None:
            return iec.normal_turbulence(self.given_speed(), self.turbulence_class)
        return self.turbulence_intensity * self.given_speed()

    def spectral_density(self, omega: ArrayLike) -> np.ndarray:
        """Kaimal spectrum and coherence of IEC 61400-1, annex B.2, without the limits of a series."""
        speed, sigma = self.given_speed(), self.standard_deviation()
        frequency = np.atleast_1d(np.asarray(omega, dtype=float))[:, None, None] / (2 * np.pi)
        distance = np.linalg.norm(self.hubs[:, None] - self.hubs[None], axis=2)
        height = self.reference_height
        spectrum = turbulence.kaimal(frequency, speed, sigma, height) / (2 * np.pi)
        return spectrum * turbulence.coherence(frequency, distance, speed, height)

    def places_density(self, omega: np.ndarray, places: Sequence[TurningRings | RestingPlaces]) -> np.ndarray:
        speed, sigma, height = self.given_speed(), self.standard_deviation(), self.reference_height

        def spectrum(omega: np.ndarray) -> np.ndarray:
            return turbulence.kaimal(omega / (2 * np.pi), speed, sigma, height) / (2 * np.pi)

        return places_density(omega, places, spectrum, turbulence.PlaneCoherence(speed, float(height)))

    def disc_series(self, places: Sequence[TurningRings | RestingPlaces], number: int) -> WindSeries:
        """Of the same random numbers as the series of the stations, and coherent with them."""
        speed, sigma, height = self.given_speed(), self.standard_deviation(), self.reference_height

        def shares(frequency: np.ndarray) -> np.ndarray:
            alone = turbulence.kaimal(frequency, speed, sigma, height) / (2 * np.pi)
            return self.places_density(2 * np.pi * frequency, places) / alone[:, None, None]

        stations, grid = tuple(map(tuple, self.hubs.tolist())), self._grid()
        found = turbulence.kaimal_series(stations, speed, sigma, height=height, shares=shares, **grid)
        ends = np.cumsum([0, *(item.channels for item in places)])
        return replace(found, values=found.values[:, ends[number] : ends[number + 1]])

    def _grid(self) -> dict[str, Any]:
        return {name: getattr(self, name) for name in ("seed", "sample_step", "repetition_period")}

    def turbulence(self) -> WindSeries:
        """The turbulent fluctuation at the stations as numbers."""
        speed, sigma = self.given_speed(), self.standard_deviation()
        stations = tuple(map(tuple, self.hubs.tolist()))
        return _turbulence(stations, speed, sigma, height=self.reference_height, **self._grid())

    def station_series(self) -> Series | None:
        """The turbulence in the fluctuation."""
        series = self.turbulence()
        values = np.hstack([np.zeros_like(series.values), series.values])
        return Series.samples(values, series.step, series.start, periodic=True)

    def period(self) -> float:
        """That of the realisation [s]."""
        return self.turbulence().end
