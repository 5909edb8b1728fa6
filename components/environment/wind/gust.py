"""Wind with one gust."""

from __future__ import annotations

import numpy as np

from fowtlib.components.environment.iec import TURBULENCE_CLASSES, operating_gust
from fowtlib.components.environment.wind.base import Wind
from fowtlib.components.environment.wind.steady import SteadyWind
from fowtlib.language import Number, Series, param

PI = np.pi
SHAPES = {
    "eog": [(PI, -0.185j), (3 * PI, 0.37j), (5 * PI, -0.185j)],
    "1-cos": [(0.0, 0.5), (2 * PI, -0.5)],
}
"""Harmonics in s, from 0 to 1 during the gust: -0.37 sin(3 pi s) (1 - cos(2 pi s)) is dip, peak (0.74) and dip of IEC
61400-1 ed. 3, (18), and (1 - cos(2 pi s)) / 2 one hump of height 1."""


class GustWind(SteadyWind, kind="gust"):
    """Steady wind and one gust, which is not sheared and the same at all stations.

    "eog" is the extreme operating gust of IEC 61400-1 ed. 3, magnitude by (17) unless given; "1-cos" is one hump.
    """

    in_own_units = {"": "the gust of the standard has lengths and speeds of full scale"}

    start_time: Number = param(default=0.0, unit="s", min=0, bound=True, doc="start of the gust")
    gust_shape: str = param(default="eog", choices=tuple(SHAPES), bound=True, doc="time function")
    gust_speed: Number = param(
        default=None, unit="m/s", bound=True, instead_of=("rotor_diameter", "extreme_speed", "turbulence_class"),
        doc="magnitude; without a value by IEC (17)",
    )  # fmt: skip
    gust_duration: Number = param(default=10.5, unit="s", min=1e-3, bound=True, doc="duration of the gust")
    rotor_diameter: Number = param(default=126.0, unit="m", min=0, bound=True, doc="magnitude by IEC: rotor diameter")
    extreme_speed: Number = param(
        default=50.0, unit="m/s", min=0, bound=True, doc="magnitude by IEC: V_ref, 50 m/s for wind class I"
    )
    turbulence_class: str = param(
        default="B", choices=TURBULENCE_CLASSES, bound=True, doc="magnitude by IEC: turbulence class"
    )

    def magnitude(self) -> float:
        """Of the gust [m/s]."""
        if self.gust_speed is not None:
            return self.gust_speed
        sizes = self.rotor_diameter, self.reference_height, self.extreme_speed
        return operating_gust(self.given_speed(), self.turbulence_class, *sizes)

    def station_series(self) -> Series | None:
        """The gust in the fluctuation."""
        return fluctuation(self, self.magnitude(), SHAPES[self.gust_shape], self.gust_duration)


def fluctuation(wind: Wind, size: float, shape: list, duration: float, after: float = 0.0) -> Series:
    """Series of the stations: a fluctuation of a shape and a size from `start_time` on, the same at all."""
    return transition(wind, size * np.repeat([0.0, 1.0], len(wind.hubs)), shape, duration, after)


def transition(wind: Wind, sizes: np.ndarray, shape: list, duration: float, after: float = 0.0) -> Series:
    """Signals that follow the harmonics of a shape, each by its size, from `start_time` on; then `after` times that."""
    waves = [(omega, amplitude * sizes) for omega, amplitude in shape]
    return Series.transition(wind.start_time, duration, 0 * sizes, after * sizes, harmonics=waves)
