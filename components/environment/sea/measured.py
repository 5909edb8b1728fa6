"""Waves that were measured."""

from __future__ import annotations

import warnings
from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike

from fowtlib.components.environment.sea.base import Sea
from fowtlib.components.environment.sea.record import WaveRecord, read_record, record_waves
from fowtlib.components.environment.waves import WaveComponents
from fowtlib.language import Number, Vector, param

SPILLED = 0.01  # share of the record's variance outside of the band that is worth a warning


class MeasuredSea(Sea, kind="record"):
    """Long-crested waves whose elevation at one point is that of a record, from a CSV file of time and elevation.

    The Fourier components of the record between `lowest_frequency` and `highest_frequency` are the waves, see
    record.record_waves: its mean is taken off, `taper` seconds at both ends grow from nothing and die out, and at least
    `padding` seconds of still water follow before the record comes again. Between the tapers the elevation at `gauge`
    is that of the record without what lies outside of the band. t = 0 is the time `start` of the record.
    """

    in_own_units = {"file": "a record has seconds and metres of its own"}

    file: str = param(default="", bound=True, doc="record: CSV file with time [s] and elevation [m]")
    start: Number = param(default=None, unit="s", bound=True, doc="record: its time at t = 0; else its first")
    gauge: Vector = param(default=(0, 0, 0), unit="m", bound=True, doc="record: where it was measured; z is not used")
    lowest_frequency: Number = param(
        default=2 * np.pi * 0.02, unit="rad/s", min=0, bound=True, doc="record: slower waves are left out"
    )
    highest_frequency: Number = param(
        default=2 * np.pi * 0.5, unit="rad/s", min=0, bound=True, doc="record: faster waves are left out"
    )
    taper: Number = param(default=10.0, unit="s", min=0, bound=True, doc="record: length of the ramp at each end")
    padding: Number = param(default=60.0, unit="s", min=0, bound=True, doc="record: still water behind it")

    def components(self) -> WaveComponents:
        record, world = self.record(), self.world
        start = self.parameter_value("start")
        return _components(
            record, world.water_depth, world.gravity, self.wave_heading(), record.start if start is None else start,
            tuple(np.asarray(self.parameter_value("gauge"), dtype=float)[:2].tolist()), self._band(), self.taper,
            self.padding,
        )  # fmt: skip

    def record(self) -> WaveRecord:
        """What was measured."""
        return read_record(self.given("file"))

    def longest_run(self) -> float:
        record, start = self.record(), self.parameter_value("start")
        return record.end - (record.start if start is None else start)

    def spectral_density(self, omega: ArrayLike) -> np.ndarray:
        """Raw periodogram of the components: a^2 / (2 d_omega) at the nearest of them."""
        waves, omega = self.components(), np.asarray(omega, dtype=float)
        step = 2 * np.pi / waves.period
        nearest = np.rint(omega / step).astype(int) - round(float(waves.omega[0]) / step)
        inside = (nearest >= 0) & (nearest < len(waves))
        return np.where(inside, waves.amplitude[np.where(inside, nearest, 0)] ** 2 / (2 * step), 0.0)

    def warn(self) -> None:
        """Of a band that leaves a part of the record out."""
        self.components()  # an error of the record comes first
        spilled = self.record().share_outside(*self._band(), self.taper)
        if spilled > SPILLED:
            low, high = (value / (2 * np.pi) for value in self._band())
            warnings.warn(
                f"{self.label}: {spilled:.1%} of the variance of {self.file} lies outside of {low:.3g} to {high:.3g} "
                "Hz and is left out; change lowest_frequency and highest_frequency.",
                stacklevel=3,
            )

    def _band(self) -> tuple[float, float]:
        return self.lowest_frequency, self.highest_frequency


_components = lru_cache(maxsize=8)(record_waves)
