"""A measured wave elevation: its file, and the harmonics that it is made of."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fowtlib.components.environment.waves import WaveComponents, wave_number
from fowtlib.components.environment.wind_file import read_series
from fowtlib.language.data_files import remembered
from fowtlib.language.errors import ParameterError

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class WaveRecord:
    """Elevations (n,) [m] at one point, at start + i step [s]."""

    name: str
    start: float
    step: float
    elevation: Floats

    @property
    def time(self) -> Floats:
        """Times of the samples (n,), s."""
        return self.start + self.step * np.arange(len(self.elevation))

    @property
    def end(self) -> float:
        """Time of the last sample, s."""
        return self.start + self.step * (len(self.elevation) - 1)

    def tapered(self, taper: float) -> Floats:
        """Elevation less its mean, with ramps (1 - cos) / 2 of `taper` seconds at both ends."""
        from_end = self.step * np.minimum(np.arange(len(self.elevation)), np.arange(len(self.elevation))[::-1])
        window = 0.5 * (1 - np.cos(np.pi * np.clip(from_end / taper, 0, 1))) if taper > 0 else 1.0
        return (self.elevation - self.elevation.mean()) * window

    def share_outside(self, lowest: float, highest: float, taper: float = 0.0) -> float:
        """Share of the variance at frequencies outside of a band [rad/s]."""
        power = np.abs(np.fft.rfft(self.tapered(taper))[1:]) ** 2
        omega = 2 * np.pi * np.fft.rfftfreq(len(self.elevation), self.step)[1:]
        inside = power[(omega >= lowest) & (omega <= highest)].sum()
        return float(1 - inside / power.sum()) if power.sum() else 0.0


@remembered()
def read_record(path: str) -> WaveRecord:
    """A record from a CSV file with the columns time [s] and elevation [m]; see wind_file.read_series for its form."""
    series = read_series(path, 1, what="record of waves", quantity="elevation")
    return WaveRecord(path, series.start, series.step, series.values[:, 0])


def record_waves(
    record: WaveRecord,
    depth: float,
    gravity: float,
    heading: float = 0.0,
    start: float = 0.0,
    gauge: tuple[float, float] = (0.0, 0.0),
    band: tuple[float, float] = (0.0, math.inf),
    taper: float = 0.0,
    padding: float = 0.0,
) -> WaveComponents:
    """The waves of which a record at `gauge` (x, y) is made: discrete Fourier components in `band` [rad/s].

    Mean off, ramps of `taper` [s] at both ends, zeros behind the end for at least `padding` [s]; with N samples then,
    the components have the frequencies 2 pi j / (N step) and the amplitudes 2 |Y_j| / N. Frequencies from pi / step on
    are not resolved and left out. t = 0 of the waves is the time `start` [s] of the record; each component goes back to
    the origin with its wave number. Outside of the record, and of the tapers, the sea is that of the padded record.
    Raises ParameterError where `start` is outside of the record, or nothing is left.
    """
    lowest, highest = band
    if not record.start <= start < record.end:
        raise ParameterError(
            f"{record.name}: the start {start:g} s lies outside of the record, {record.start:g} to {record.end:g} s."
        )
    if 2 * taper >= record.end - record.start:
        raise ParameterError(
            f"{record.name}: two tapers of {taper:g} s leave nothing of {record.end - record.start:g} s."
        )
    samples = record.tapered(taper)
    count = _even_fast(len(samples) + math.ceil(padding / record.step))
    omega = 2 * np.pi * np.fft.rfftfreq(count, record.step)
    complex_amplitude = 2 / count * np.fft.rfft(samples, count)
    kept = (omega >= max(lowest, 0.5 * omega[1])) & (omega <= highest) & (omega < omega[-1])
    if not kept.any():
        low, high = omega[1] / (2 * np.pi), omega[-1] / (2 * np.pi)
        raise ParameterError(
            f"{record.name}: no frequency of the record lies between {lowest / (2 * np.pi):.3g} and "
            f"{highest / (2 * np.pi):.3g} Hz; it resolves {low:.3g} to {high:.3g} Hz."
        )
    omega, complex_amplitude = omega[kept], complex_amplitude[kept]
    number = wave_number(omega, depth, gravity)
    along = gauge[0] * math.cos(heading) + gauge[1] * math.sin(heading)
    complex_amplitude = complex_amplitude * np.exp(1j * (omega * (start - record.start) + number * along))
    return WaveComponents(
        omega, np.abs(complex_amplitude), np.angle(complex_amplitude), number, heading, count * record.step, depth
    )


def _even_fast(count: int) -> int:
    """The next even number whose prime factors are small."""
    from scipy.fft import next_fast_len

    return 2 * int(next_fast_len(math.ceil(count / 2), real=True))
