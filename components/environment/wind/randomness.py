"""What the frequency domain is told of a wind: how its signals and its field follow from their spectra."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from fowtlib.components.environment.field_wind import NO_FIELD
from fowtlib.components.environment.wind.discs import Turbulence
from fowtlib.language import Series
from fowtlib.language.run_time import RestingPlaces, TurningRings

if TYPE_CHECKING:
    from fowtlib.components.environment.wind.base import Wind


class StationSignals:
    """Own part of the base, and fluctuation, of all stations; see RandomSignals of fowtlib.language.run_time."""

    def __call__(self, wind: Wind) -> Series | None:
        return wind.station_series()

    def process(self, wind: Wind) -> Turbulence:
        return Turbulence(wind)

    def response(self, wind: Wind, omega: ArrayLike) -> np.ndarray:
        n, all_channels = len(wind.hubs), Turbulence(wind).channels
        channels = np.zeros((2 * n, all_channels), dtype=complex)
        if not hasattr(type(wind), "field_density"):  # in a field the stations are points like others
            channels[n:, :n] = np.eye(n)
        return np.broadcast_to(channels, (np.size(omega), *channels.shape))


class FieldNumbers:
    """The numbers of the field of a run; see RandomField of fowtlib.language.run_time."""

    def __call__(self, wind: Wind) -> Any:
        return wind.field() or NO_FIELD

    def process(self, wind: Wind) -> Wind:
        return wind

    def along(self, wind: Wind) -> np.ndarray:
        angle = float(wind.parameter_value("direction"))
        return np.array([math.cos(angle), math.sin(angle), 0.0])

    def density(self, wind: Wind, omega: np.ndarray, places: Sequence[TurningRings | RestingPlaces]) -> np.ndarray:
        if hasattr(type(wind), "field_density"):  # kinds with a field
            return wind.field_density(omega, places)
        channels = sum(item.channels for item in places)
        return np.zeros((len(omega), channels, channels))
