"""The extreme wind speed model of IEC 61400-1, turbulent and steady."""

from __future__ import annotations

from typing import Any

from fowtlib.components.environment import iec
from fowtlib.components.environment.wind.base import Wind, mean_speed_at
from fowtlib.components.environment.wind.kaimal import KaimalWind
from fowtlib.components.environment.wind.normal import reference_speed
from fowtlib.language import Number, Scalar, Series, param


class ExtremeWind(KaimalWind, kind="ewm"):
    """Turbulent extreme wind speed model, EWM: mean V_ref, or 0.8 V_ref for 1 year, with sigma_1 = 0.11 V_hub.

    Its mean speed comes from the wind class, and its shear exponent is 0.11. Between the 10 minutes of the standard and
    the length of a run no factor is put; IEC 61400-3-1 gives 0.95 for one hour: reference_speed takes it.
    """

    void = ("mean_speed", "shear_exponent", "turbulence_class", "turbulence_intensity")

    shear_exponent: Scalar = param(default=iec.EXTREME_SHEAR, doc="exponent of the power law")
    wind_class: str = param(default="I", choices=iec.WIND_CLASSES, bound=True, doc="IEC wind class, of V_ref")
    reference_speed: Number = param(
        default=None, unit="m/s", min=0, bound=True, instead_of=("wind_class",), doc="V_ref; else by the wind class"
    )
    return_period: int = param(default=50, choices=iec.RETURN_PERIODS, bound=True, doc="in years")

    def given_speed(self) -> float:
        """The mean speed [m/s] at the hub."""
        reference = reference_speed(self.wind_class, self.reference_speed)
        return iec.extreme_speed(reference, self.return_period, turbulent=True)

    def standard_deviation(self) -> float:
        """Sigma [m/s] of the speed at a station, of the whole spectrum."""
        return iec.EXTREME_INTENSITY * self.given_speed()

    def mean_series(self) -> Series | None:
        """The speed of the class, in place of a mean speed that is given."""
        return Series.constant([0.0, self.given_speed()])

    def mean_at(self, station: int = 0) -> float:
        """Mean speed [m/s] at a station."""
        return mean_speed_at(self, self.given_speed(), station)


class SteadyExtremeWind(Wind, kind="ewm_steady"):
    """Steady extreme wind speed model, EWM: the gust 1.4 V_ref, or 0.8 times that for 1 year, all the time.

    V_e50(z) = 1.4 V_ref (z/z_hub)^0.11. Its speed comes from the wind class.
    """

    in_own_units = {"": "its speed and profile are those of a standard"}

    void = ("mean_speed", "shear_exponent")

    shear_exponent: Scalar = param(default=iec.EXTREME_SHEAR, doc="exponent of the power law")
    wind_class: str = param(default="I", choices=iec.WIND_CLASSES, bound=True, doc="IEC wind class, of V_ref")
    reference_speed: Number = param(
        default=None, unit="m/s", min=0, bound=True, instead_of=("wind_class",), doc="V_ref; else by the wind class"
    )
    return_period: int = param(default=50, choices=iec.RETURN_PERIODS, bound=True, doc="in years")

    def in_the_mean(self) -> dict[str, Any]:
        """Nothing: it is the same at all times."""
        return {}

    def given_speed(self) -> float:
        """The speed [m/s] at the hub."""
        return iec.extreme_speed(reference_speed(self.wind_class, self.reference_speed), self.return_period)

    def mean_series(self) -> Series | None:
        """The speed of the class, in place of a mean speed that is given."""
        return Series.constant([0.0, self.given_speed()])

    def mean_at(self, station: int = 0) -> float:
        """Speed [m/s] at a station."""
        return mean_speed_at(self, self.given_speed(), station)
