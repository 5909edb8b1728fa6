"""Heights of single waves in a record, and whether a realisation of a sea is one that a test programme accepts."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from fowtlib.analysis.series import as_series
from fowtlib.components.environment.waves import irregular_waves
from fowtlib.language.errors import ModelError

if TYPE_CHECKING:
    from fowtlib.analysis.series import SeriesLike

HIGHEST = 1.87
"""Hmax / Hs that a record of three hours must have in it: C. Serret (2019), section 6.5.2."""


@dataclass(frozen=True)
class WaveHeights:
    """Waves between upward crossings of the mean: heights from crest to trough and periods (n,).

    significant: 4 sqrt(m0); third: mean of the highest third; highest: Hmax.
    """

    heights: np.ndarray
    periods: np.ndarray
    significant: float

    @property
    def third(self) -> float:
        """Mean of the highest third of the heights, H1/3."""
        return float(np.sort(self.heights)[-max(self.heights.size // 3, 1) :].mean())

    @property
    def highest(self) -> float:
        """The largest height."""
        return float(self.heights.max())

    @property
    def expected_ratio(self) -> float:
        """Most probable Hmax / Hs of as many waves in a narrow spectrum, sqrt(ln(n) / 2): 1.86 of 1000 waves."""
        return math.sqrt(math.log(self.heights.size) / 2)


def wave_heights(elevation: SeriesLike, *, discard: float = 0.0) -> WaveHeights:
    """The single waves of a record. Raises ModelError where there are fewer than three."""
    record = as_series(elevation).after(discard)
    y, t = record.values - record.values.mean(), record.time
    up = np.flatnonzero((y[:-1] <= 0) & (y[1:] > 0))
    if up.size < 4:
        raise ModelError(f"{record.name}: there are {max(up.size - 1, 0)} waves in the record; three are needed.")
    crossing = t[up] - y[up] * (t[up + 1] - t[up]) / (y[up + 1] - y[up])
    pieces = [(begin + 1, end + 1) for begin, end in zip(up[:-1], up[1:], strict=True)]
    heights = np.array([np.ptp(y[begin:end]) for begin, end in pieces])
    return WaveHeights(heights, np.diff(crossing), 4.0 * float(y.std()))


@dataclass(frozen=True)
class RealisationCheck:
    """Of one record of a sea with the significant height Hs: variance over Hs^2/16, and Hmax/Hs against its limit."""

    variance_ratio: float
    highest_ratio: float
    limit: float
    waves: int

    @property
    def accepted(self) -> bool:
        """Whether the highest wave is one that a programme asks for."""
        return self.highest_ratio >= self.limit


def check_realisation(
    elevation: SeriesLike, significant_height: float, *, limit: float = HIGHEST, discard: float = 0.0
) -> RealisationCheck:
    """Compare a record with the sea that was asked for; m0 = Hs^2/16. The limit is for records of three hours."""
    found = wave_heights(elevation, discard=discard)
    ratio = (found.significant / significant_height) ** 2
    return RealisationCheck(ratio, found.highest / significant_height, limit, found.heights.size)


def accepted_seeds(
    significant_height: float, peak_period: float, depth: float, *, count: int = 6, duration: float = 10800.0,
    repetition_period: float = 16384.0, gamma: float | None = None, limit: float = HIGHEST, discard: float = 0.0,
    tries: int = 1000,
) -> list[int]:  # fmt: skip
    """The first seeds of JONSWAP seas (of the kind "jonswap") whose highest wave at the origin reaches the limit.

    duration, discard [s] and repetition_period [s] as in the runs. Raises ModelError where too few are found.
    """
    if duration + discard > repetition_period:
        raise ModelError(f"runs of {duration + discard:g} s need a repetition period of as much, not "
                         f"{repetition_period:g} s.")  # fmt: skip
    options = {"gamma": gamma, "repetition_period": repetition_period}
    size = 2 ** math.ceil(math.log2(20 * repetition_period / peak_period))  # 20 samples or more to a peak period
    time, found = np.arange(size) * (repetition_period / size), []
    inside = (time >= discard) & (time <= discard + duration)
    for seed in range(1, tries + 1):
        waves = irregular_waves(significant_height, peak_period, depth, seed=seed, **options)
        lines = np.zeros(size // 2 + 1, dtype=complex)
        lines[np.rint(waves.omega * repetition_period / (2 * np.pi)).astype(int)] = waves.complex_amplitude * size / 2
        elevation = np.fft.irfft(lines, size)
        if check_realisation((time[inside], elevation[inside]), significant_height, limit=limit).accepted:
            found.append(seed)
            if len(found) == count:
                return found
    raise ModelError(f"of {tries} seeds {len(found)} have a wave of {limit:g} Hs, {count} are wanted; lower the limit.")
