"""Turbulent wind at the stations."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fowtlib.components.environment import turbulence
from fowtlib.components.environment.wind.steady import SteadyWind
from fowtlib.components.environment.wind_file import WindSeries
from fowtlib.language import Number, Series, param

_turbulence = lru_cache(maxsize=8)(turbulence.kaimal_series)


class KaimalWind(SteadyWind, kind="kaimal"):
    """Kaimal turbulence at the stations: the normal turbulence model by class, or an intensity.

    It is the fluctuation, not sheared (IEC 61400-1 annex B). What a series holds and loses: module turbulence.
    """

    turbulence_class: str = param(default="B", choices=("A", "B", "C"), bound=True, doc="IEC turbulence class")
    turbulence_intensity: Number = param(default=None, min=0, bound=True, doc="sigma/V; without a value by the class")
    seed: int = param(default=1, min=0, bound=True, doc="number of the realisation")
    sample_step: Number = param(
        default=0.25, unit="s", min=0, bound=True, doc="sampling; harmonics up to 1/(4 sample_step)"
    )
    repetition_period: Number = param(default=4096.0, unit="s", min=0, bound=True, doc="period of the realisation")

    def sigma(self) -> float:
        """Standard deviation of the speed [m/s]."""
        speed = self.given_speed()
        if self.turbulence_intensity is None:
            return turbulence.normal_turbulence(speed, self.turbulence_class)
        return self.turbulence_intensity * speed

    def spectral_density(self, omega: ArrayLike) -> NDArray[np.float64]:
        """One-sided spectra of the fluctuation at the m stations, each with each, (n, m, m) [m^2/s^2 per rad/s].

        omega: circular frequencies (n,) [rad/s], positive. Their integral over all of them is the variance sigma^2, and
        between two stations the covariance. A realisation ends at 1/(4 sample_step), with the variance up to there.
        """
        frequency = np.atleast_1d(np.asarray(omega, dtype=float)) / (2 * np.pi)
        speed, points = self.given_speed(), self.hubs
        own = turbulence.kaimal(frequency, speed, self.sigma(), self.reference_height) / (2 * np.pi)
        apart = np.linalg.norm(points[:, None] - points[None, :], axis=-1)
        shared = turbulence.coherence(frequency[:, None, None], apart, speed, self.reference_height)
        return own[:, None, None] * shared

    def turbulence(self) -> WindSeries:
        """The turbulent fluctuation at the stations as numbers."""
        speed, sigma = self.given_speed(), self.sigma()
        grid = {name: getattr(self, name) for name in ("seed", "sample_step", "repetition_period")}
        stations = tuple(map(tuple, self.hubs.tolist()))
        return _turbulence(stations, speed, sigma, height=self.reference_height, **grid)

    def station_series(self) -> Series | None:
        """The turbulence in the fluctuation."""
        series = self.turbulence()
        values = np.hstack([np.zeros_like(series.values), series.values])
        return Series.samples(values, series.step, series.start, periodic=True)

    def period(self) -> float:
        """That of the realisation [s]."""
        return self.turbulence().end
