"""Longitudinal wind at hub points: turbulence of IEC 61400-1 and shear. Plain numpy.

One series of the longitudinal speed stands for the wind over a whole rotor (no rotational sampling, no lateral or
vertical component). Series at several stations (the hubs) carry the Kaimal spectrum each and the exponential coherence
between them.

What a series of period T sampled at dt can hold: harmonics from 1/T to the cut-off f_c = 1/(4 dt). The cut-off keeps
a cubic spline through the samples within 1 % of the amplitude of the fastest harmonic. The variance outside is lost and
is not made up for by scaling, so every harmonic has the energy the standard gives it, and the standard deviation of a
series stays below sigma. Lost fraction of the variance, see `lost_variance` (V at 90 m, T = 4096 s):

    V [m/s]    dt = 0.25 s, f_c = 1 Hz                dt = 0.5 s, f_c = 0.5 Hz
    5          3.2 % below + 1.8 % above              3.2 % + 2.9 %
    11.4       1.4 % + 3.1 %                          1.4 % + 5.0 %
    18         0.9 % + 4.2 %                          0.9 % + 6.7 %
    25         0.7 % + 5.3 %                          0.7 % + 8.3 %

A harmonic above 0.5 Hz is not coherent over more than a few metres, so no rotor feels it as one; the part below 1/T
moves the mean of the record and belongs to the choice of mean speed.

Sources: IEC 61400-1 ed. 3 (2005), annex B.2 (Kaimal spectrum, coherence), the same in annex C of ed. 4 (2019); P.S.
Veers, SAND88-0152 (1988). How strong the turbulence is: module iec.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fowtlib.components.environment.iec import turbulence_scale
from fowtlib.components.environment.wind_file import WindSeries
from fowtlib.language.errors import ParameterError

MOST_SAMPLES = 4_000_000  # of a period of turbulence: 11 days at 4 Hz

Floats = NDArray[np.float64]


def kaimal(frequency: ArrayLike, mean_speed: float, sigma: float, height: float = 90.0) -> Floats:
    """One-sided Kaimal spectrum S_u(f) [m^2/s^2/Hz] of the longitudinal speed; its integral from 0 on is sigma^2.

    S = 4 sigma^2 (L/V) / (1 + 6 f L/V)^(5/3), L = 8.1 Lambda_1; `frequency` [Hz], V = `mean_speed` at hub `height`.
    """
    scale = 8.1 * turbulence_scale(height) / mean_speed
    return 4 * sigma**2 * scale / (1 + 6 * np.asarray(frequency, dtype=float) * scale) ** (5 / 3)


def kaimal_above(frequency: ArrayLike, mean_speed: float, height: float = 90.0) -> Floats:
    """Fraction of the Kaimal variance above `frequency` [Hz]: (1 + 6 f L/V)^(-2/3), exact."""
    scale = 8.1 * turbulence_scale(height) / mean_speed
    return (1 + 6 * np.asarray(frequency, dtype=float) * scale) ** (-2 / 3)


def lost_variance(
    mean_speed: float, height: float = 90.0, sample_step: float = 0.25, repetition_period: float = 4096.0
) -> tuple[float, float]:
    """Fractions of sigma^2 that a series does not hold: below its first harmonic's band, above its cut-off."""
    low, high = (0.5, _harmonics(sample_step, repetition_period) + 0.5)
    below, above = kaimal_above(np.array([low, high]) / repetition_period, mean_speed, height)
    return 1 - float(below), float(above)


def coherence(frequency: ArrayLike, distance: ArrayLike, mean_speed: float, height: float = 90.0) -> Floats:
    """Magnitude of the cross spectrum of two points over their own spectrum: exp(-12 sqrt((f r/V)^2 + (0.12 r/L)^2)).

    `frequency` [Hz] and `distance` r [m] in the plane across the wind are broadcast; L = 8.1 Lambda_1.
    """
    return np.exp(-np.asarray(distance, dtype=float) * coherence_decay(frequency, mean_speed, height))


def coherence_decay(frequency: ArrayLike, mean_speed: float, height: float = 90.0) -> Floats:
    """The rate [1/m] at which `coherence` decays with the distance."""
    length = 8.1 * turbulence_scale(height)
    return 12 * np.hypot(np.asarray(frequency, dtype=float) / mean_speed, 0.12 / length)


@dataclass(frozen=True)
class PlaneCoherence:
    """`coherence` in one mean speed [m/s] and height [m] of the hub, of frequency and distance."""

    mean_speed: float
    height: float

    def __call__(self, frequency: ArrayLike, distance: ArrayLike) -> Floats:
        return coherence(frequency, distance, self.mean_speed, self.height)

    def decay(self, frequency: ArrayLike) -> Floats:
        """The rate [1/m] at which it decays with the distance, exponentially."""
        return coherence_decay(frequency, self.mean_speed, self.height)


def power_law(speed: float, reference_height: float, height: ArrayLike, exponent: float) -> Floats:
    """Mean speed [m/s] at `height` z [m] from `speed` at `reference_height`: V (z / z_ref)^exponent."""
    return speed * (np.asarray(height, dtype=float) / reference_height) ** exponent


def kaimal_series(
    stations: Sequence[Sequence[float]],
    mean_speed: float,
    sigma: float,
    *,
    height: float = 90.0,
    seed: int = 1,
    sample_step: float = 0.25,
    repetition_period: float = 4096.0,
    shares: Callable[[Floats], Floats] | None = None,
) -> WindSeries:
    """Fluctuation about the mean at `stations` ((y, z) [m] across the wind): Kaimal spectra, exponential coherence.

    Veers' method: at every harmonic the coherence matrix is factorised, C = H H^T, and the complex amplitude at station
    i is A sum_{j <= i} H_ij exp(i phi_j) with random phases phi_j, one set per station. A^2/2 is the integral of the
    Kaimal spectrum over the harmonic's band 1/T, exactly. So the first station's series has the same variance for every
    seed, and it does not change when stations are added; the variance of the others scatters about the same mean.
    Mean speed V and `height` [m] of the hub fix the length scale, the same sigma [m/s] holds at every station
    (IEC 61400-1 annex B). The series repeats after `repetition_period` [s], which is rounded to whole samples.

    The first station shares its random numbers with a sea of the same seed; what that does: waves.irregular_waves.
    Give wind and sea different seeds.

    shares(frequency [Hz] (f,)): Hermitian (f, m, m), spectra of the stations and of what is linear in the turbulence
    elsewhere, over the Kaimal spectrum: m series in place of those of the stations, the stations first and the same.
    """
    points = np.asarray(stations, dtype=float).reshape(len(stations), -1)
    if points.shape[1:] != (2,):
        raise ParameterError(f"stations must be (y, z) pairs, got {list(stations)}")
    if not mean_speed > 0:
        raise ParameterError(f"turbulence needs a positive mean speed, got {mean_speed:g} m/s")
    count = round(repetition_period / sample_step)
    if count > MOST_SAMPLES:
        raise ParameterError(
            f"a repetition period of {repetition_period:g} s has {count:.3g} samples of {sample_step:g} s; "
            f"the limit is {MOST_SAMPLES}."
        )
    harmonics = _harmonics(sample_step, repetition_period)
    if harmonics < 16:
        raise ParameterError(f"repetition period {repetition_period:g} s holds too few samples of {sample_step:g} s")
    period = count * sample_step
    number = np.arange(1, harmonics + 1)
    band = -np.diff(kaimal_above((np.arange(harmonics + 1) + 0.5) / period, mean_speed, height))
    distance = np.linalg.norm(points[:, None, :] - points[None, :, :], axis=-1)
    matrix = coherence(number[:, None, None] / period, distance, mean_speed, height)
    if shares is not None:
        matrix = shares(number / period)
    size = matrix.shape[1]
    factor = np.linalg.cholesky(matrix + 1e-12 * np.eye(size))  # stations may coincide
    phases = np.stack([np.random.default_rng([seed, i]).random(harmonics) for i in range(size)], axis=-1)
    noise = np.einsum("fij,fj->fi", factor, np.exp(2j * np.pi * phases))
    half = np.zeros((size, count // 2 + 1), dtype=complex)
    half[:, number] = (0.5 * count * sigma * np.sqrt(2 * band)[:, None] * noise).T
    return WindSeries(0.0, period / count, np.fft.irfft(half, count, axis=1).T, periodic=True)


def _harmonics(sample_step: float, repetition_period: float) -> int:
    """Number of harmonics below the cut-off, a quarter of the sampling rate."""
    return round(repetition_period / sample_step) // 4
