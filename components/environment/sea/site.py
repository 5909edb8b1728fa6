"""Sea states of a site as IEC 61400-3-1 names them: normal, severe and extreme, and the extreme wave."""

from __future__ import annotations

import numpy as np

from fowtlib.components.environment import iec
from fowtlib.components.environment.sea.base import Sea, the_wind
from fowtlib.components.environment.sea.jonswap import JonswapSea
from fowtlib.components.environment.sea.regular import RegularWaves
from fowtlib.language import Array, Number, param
from fowtlib.language.bounds import POSITIVE
from fowtlib.language.errors import ParameterError

PARTS = {"short": 0.0, "middle": 0.5, "long": 1.0}
"""Where in the range of iec.design_wave_period a period lies."""


class NormalSea(JonswapSea, kind="nss"):
    """Normal sea state, NSS: a JONSWAP sea whose Hs is the expected one in the mean wind of the model, with its Tp.

    `states` is what is known of the site, E[Hs | V] and Tp, linear between its rows; outside of them there is an error.
    The mean wind is that at station 0, unless `wind_speed` is given.
    """

    units_within = {"states": ("m/s", "m", "s")}

    void = ("significant_wave_height", "peak_period")

    states: Array = param(
        default=None, bound=True, doc="rows of mean wind speed [m/s], Hs [m] and Tp [s] of the site, by rising speed"
    )
    wind_speed: Number = param(
        default=None, unit="m/s", min=0, bound=True, doc="V; without a value the mean of the wind of the model"
    )

    def state(self) -> tuple[float, float]:
        """Hs [m] and Tp [s]."""
        table = np.atleast_2d(np.asarray(self.given("states"), dtype=float))
        if table.ndim != 2 or table.shape[1] != 3 or np.any(np.diff(table[:, 0]) <= 0) or np.any(table[:, 1:] < 0):
            raise ParameterError(
                f"{self.label}.states: give rows of wind speed, Hs and Tp by rising speed, "
                "as in [[4, 1.1, 8.5], [12, 2.4, 9.6]]."
            )
        speed, known = self.speed(), table[:, 0]
        if not known[0] <= speed <= known[-1]:
            raise ParameterError(
                f"{self.label}.states covers wind of {known[0]:g} to {known[-1]:g} m/s, and there is one of "
                f"{speed:g} m/s; add rows to it, or give wind_speed."
            )
        return tuple(float(np.interp(speed, known, column)) for column in table.T[1:])

    def speed(self) -> float:
        """The mean wind [m/s] that the sea goes with."""
        if self.wind_speed is not None:
            return float(self.wind_speed)
        return the_wind(self, "states").mean_at(0)


class SevereSea(NormalSea, kind="sss"):
    """Severe sea state, SSS: as the normal one, with Hs of `states` so severe that with the wind it has 50 years.

    Where that is not known, the standard allows the Hs of 50 years at every wind: `significant_wave_height`, with
    `peak_period` or, without it, the middle of the range of iec.design_wave_period.
    """

    void = ()

    significant_wave_height: Number = param(
        default=None, unit="m", min=0, bound=True, instead_of=("states", "wind_speed"), doc="SSS: Hs at every wind"
    )

    def state(self) -> tuple[float, float]:
        """Hs [m] and Tp [s]."""
        height, period = self.significant_wave_height, self.peak_period
        if height is None:
            height, expected = super().state()
        else:
            expected = iec.design_wave_period(height, gravity=self.world.gravity)
        return height, expected if period is None else period


class ExtremeSea(JonswapSea, kind="ess"):
    """Extreme sea state, ESS: a JONSWAP sea of the Hs of 50 years or of 1 year, for runs of 3 hours or of one.

    The heights are those of 3 hours; a run of 1 hour takes 1.09 times as much, so that its highest wave is the same.
    Without peak_period it lies in the range that the standard gives for the period of single extreme waves, which is
    common for Tp where nothing better is known: see iec.design_wave_period.
    """

    void = ("significant_wave_height",)

    height_50: Number = param(default=None, unit="m", min=0, bound=True, doc="Hs of 3 hours, once in 50 years")
    height_1: Number = param(default=None, unit="m", min=0, bound=True, doc="Hs of 3 hours, once a year")
    return_period: int = param(default=50, choices=iec.RETURN_PERIODS, bound=True, doc="in years")
    hours: int = param(default=3, choices=(3, 1), bound=True, doc="length of the runs that stand for the sea state")
    peak_period: Number = param(
        default=None, unit="s", min=POSITIVE, bound=True, instead_of=("period_choice",), doc="ESS: Tp"
    )
    period_choice: str = param(default="middle", choices=tuple(PARTS), bound=True, doc="place of Tp in its range")

    def state(self) -> tuple[float, float]:
        """Hs [m] and Tp [s]."""
        height = _height(self)
        period = self.peak_period
        if period is None:
            period = iec.design_wave_period(height, PARTS[self.period_choice], self.world.gravity)
        return height * (iec.ONE_HOUR if self.hours == 1 else 1.0), period


class ExtremeWave(RegularWaves, kind="ewh"):
    """Extreme wave height, EWH: one regular wave, 1.86 times as high as the Hs of 50 years or of 1 year.

    Its period lies within 11.1 sqrt(Hs/g) and 14.3 sqrt(Hs/g) unless it is given. It is a linear wave, which is less
    steep at its crest than the nonlinear one that the standard asks for; waves.regular_waves.
    """

    void = ("wave_height",)

    height_50: Number = param(default=None, unit="m", min=0, bound=True, doc="Hs of 3 hours, once in 50 years")
    height_1: Number = param(default=None, unit="m", min=0, bound=True, doc="Hs of 3 hours, once a year")
    return_period: int = param(default=50, choices=iec.RETURN_PERIODS, bound=True, doc="in years")
    factor: Number = param(default=iec.HIGHEST_WAVE, min=0, bound=True, doc="height of the wave over Hs")
    wave_period: Number = param(
        default=None, unit="s", min=POSITIVE, bound=True, instead_of=("period_choice",), doc="EWH: period"
    )
    period_choice: str = param(default="middle", choices=tuple(PARTS), bound=True, doc="place of it in its range")

    def wave(self) -> tuple[float, float]:
        """Height [m] from trough to crest, and period [s]."""
        height, period = _height(self), self.wave_period
        if period is None:
            period = iec.design_wave_period(height, PARTS[self.period_choice], self.world.gravity)
        return self.factor * height, period


def _height(sea: Sea) -> float:
    """Hs [m] of the return period."""
    return float(sea.given("height_50" if sea.parameter_value("return_period") == 50 else "height_1"))
