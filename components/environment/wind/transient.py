"""The transient conditions of IEC 61400-1: operating gust, direction change, coherent gust, wind shear."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from fowtlib.components.environment import iec
from fowtlib.components.environment.wind.gust import SHAPES, fluctuation, transition
from fowtlib.components.environment.wind.normal import NormalProfile, reference_speed
from fowtlib.language import Number, Series, param
from fowtlib.language.errors import ParameterError

RISE = [(0.0, 0.5), (math.pi, -0.5)]
"""Harmonics of (1 - cos(pi s)) / 2, which rises from 0 to 1."""

RETURN = [(0.0, 1.0), (2 * math.pi, -1.0)]
"""Harmonics of 1 - cos(2 pi s), which rises from 0 to 2 and falls back."""


def rotor_diameter(wind: Any) -> float:
    """D [m] that is given, or that of the largest rotor; ParameterError where the model has no rotor either."""
    if wind.rotor_diameter is not None:
        return float(wind.rotor_diameter)
    parts = [wind, *wind.enclosing()][-1].walk()
    found = [part.disk_diameter() for part in parts if hasattr(type(part), "disk_diameter")]
    if not found:
        raise ParameterError(
            f"{wind.label}.rotor_diameter has no value and the model has no rotor; a wind of kind '{wind.kind}' needs "
            "it."
        )
    return max(found)


class Transient(NormalProfile):
    """Wind of the normal profile in which something happens from `start_time` on. Partial."""

    start_time: Number = param(default=0.0, unit="s", min=0, bound=True, doc="when it begins")
    turbulence_class: str = param(
        default="B", choices=iec.TURBULENCE_CLASSES, bound=True, doc="IEC turbulence class, of sigma_1"
    )
    rotor_diameter: Number = param(
        default=None, unit="m", min=0, bound=True, doc="D; without a value that of the largest rotor of the model"
    )

    def sizes(self) -> tuple[float, str, float, float]:
        """What most of the formulas need: mean speed, turbulence class, rotor diameter, height of the hub."""
        return self.given_speed(), self.turbulence_class, rotor_diameter(self), self.reference_height


class OperatingGust(Transient, kind="eog"):
    """Extreme operating gust, EOG: V(z) - 0.37 V_gust sin(3 pi t/T) (1 - cos(2 pi t/T)), T = 10.5 s.

    Dip, peak and dip, the same at all heights and stations; V_gust: iec.operating_gust. That of edition 2 (1999), which
    older designs are made with, is of a return period: T = 14 s for 50 years; V_gust: iec.second_edition_gust.
    """

    wind_class: str = param(default="I", choices=iec.WIND_CLASSES, bound=True, doc="IEC wind class, of V_ref")
    reference_speed: Number = param(
        default=None, unit="m/s", min=0, bound=True, instead_of=("wind_class",), doc="V_ref; else by the wind class"
    )
    edition: int = param(default=3, choices=(3, 2), bound=True, doc="of IEC 61400-1; 3: that of later ones, too")
    gust_years: int = param(default=50, choices=iec.RETURN_PERIODS, bound=True, doc="edition 2: return period in years")

    def station_series(self) -> Series | None:
        """The gust in the fluctuation."""
        if self.edition == 2:
            size = iec.second_edition_gust(*self.sizes(), self.gust_years)
            return fluctuation(self, size, SHAPES["eog"], iec.SECOND_EDITION_GUSTS[self.gust_years][1])
        size = iec.operating_gust(*self.sizes(), reference_speed(self.wind_class, self.reference_speed))
        return fluctuation(self, size, SHAPES["eog"], iec.DURATIONS["eog"])


class DirectionChange(Transient, kind="edc"):
    """Extreme direction change, EDC: the wind turns by theta_e within T = 6 s as (1 - cos(pi t/T)) / 2, and stays.

    theta_e = 4 atan(sigma_1 / (V (1 + 0.1 D/Lambda_1))), to the side of `sign`.
    """

    sign: int = param(default=1, choices=(1, -1), bound=True, doc="1: from x towards y, -1: the other way")

    def shape_series(self) -> Series | None:
        """The turn."""
        return _shape(self, 0, self.sign * iec.direction_change(*self.sizes()), RISE, iec.DURATIONS["edc"], after=1.0)


class CoherentGust(Transient, kind="ecd"):
    """Extreme coherent gust with direction change, ECD: within T = 10 s 15 m/s more, the same everywhere, and a turn.

    Both as (1 - cos(pi t/T)) / 2, and they stay. The turn is 180 deg below 4 m/s and 720 deg m/s / V above, to the side
    of `sign`. The formulas have no turbulence class and no rotor diameter.
    """

    void = ("turbulence_class", "rotor_diameter")

    sign: int = param(default=1, choices=(1, -1), bound=True, doc="1: from x towards y, -1: the other way")

    def station_series(self) -> Series | None:
        """The gust in the fluctuation."""
        return fluctuation(self, iec.COHERENT_GUST, RISE, iec.DURATIONS["ecd"], after=1.0)

    def shape_series(self) -> Series | None:
        """The turn."""
        size = self.sign * iec.coherent_direction(self.given_speed())
        return _shape(self, 0, size, RISE, iec.DURATIONS["ecd"], after=1.0)


class ExtremeShear(Transient, kind="ews"):
    """Extreme wind shear, EWS: V(z) + sign g (z - z_i) (1 - cos(2 pi t/T)), T = 12 s, or with y - y_i across the wind.

    g = (2.5 m/s + 0.2 beta sigma_1 (D/Lambda_1)^(1/4)) / D, beta = 6.4. It is linear about each station, also beyond
    the rotor: near the ground the wind may turn round.
    """

    plane: str = param(default="vertical", choices=("vertical", "horizontal"), bound=True, doc="shear over z, or y")
    sign: int = param(default=1, choices=(1, -1), bound=True, doc="1: more wind above, or on the side of y; -1: less")

    def shape_series(self) -> Series | None:
        """The shear."""
        column = 1 if self.plane == "vertical" else 2
        size = self.sign * iec.extreme_shear(*self.sizes())
        return _shape(self, column, size, RETURN, iec.DURATIONS["ews"])


def _shape(wind: Transient, column: int, size: float, shape: list, duration: float, after: float = 0.0) -> Series:
    """Turn and shears, of which one has a shape and a size."""
    return transition(wind, size * np.eye(3)[column], shape, duration, after)
