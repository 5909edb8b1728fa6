"""Power spectral densities, one-sided and per hertz: the integral over frequency [Hz] is the variance of the signal.

Per rad/s the density is S(f) / (2 pi). Source of the method: Welch (1967), as in scipy.signal.welch.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from fowtlib.analysis.series import Series, as_series
from fowtlib.language.errors import ModelError
from fowtlib.solving.results.tables import write_table

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from fowtlib.analysis.series import SeriesLike


def widths(frequency: np.ndarray) -> np.ndarray:
    """What each density stands for [Hz]: the spacing of a record's, else up to the middles between them."""
    steps = np.diff(frequency)
    if np.allclose(steps, steps[0], rtol=1e-6, atol=0.0):
        return np.full(frequency.size, steps[0])
    return (np.append(steps, 0.0) + np.append(0.0, steps)) / 2


def mean_square_below(frequency: np.ndarray, density: np.ndarray) -> np.ndarray:
    """What densities (..., q) have between the lowest frequency and each, by the rule of the trapezoid: (..., q)."""
    steps = np.diff(frequency) * (density[..., 1:] + density[..., :-1]) / 2
    return np.concatenate([np.zeros((*density.shape[:-1], 1)), np.cumsum(steps, axis=-1)], axis=-1)


@dataclass(frozen=True)
class Spectrum:
    """One-sided density S(f) [unit^2/Hz] over rising frequencies f [Hz]: of a record equally spaced from 0 upward."""

    frequency: np.ndarray
    density: np.ndarray
    unit: str = "1"
    name: str = ""
    long_name: str = ""
    averages: float = 1.0  # equivalent number of independent periodograms behind each value

    def plot(self, path: str | Path | None = None, **options: Any) -> Figure:
        """Density over frequency; options of fowtlib.view.plot_spectra."""
        from fowtlib.solving.results.plots import plot_spectra

        return plot_spectra(self, path, **options)

    def save(self, path: str | Path) -> Path:
        """Write a table as CSV, one row per frequency."""
        heads = ("frequency [Hz]", f"{self.name or 'density'} [({self.unit})^2/Hz]")
        return write_table(path, heads, zip(self.frequency.tolist(), self.density.tolist(), strict=True), "a spectrum")

    def moment(self, order: int = 0, low: float = 0.0, high: float = np.inf) -> float:
        """Spectral moment m_n, the integral of f^n S(f) over [low, high] Hz; m_0 is the variance.

        With circular frequencies in rad/s, as much of the literature has it, m_n is (2 pi)^n times as large.
        """
        f = self.frequency
        inside = (f >= low) & (f <= high)
        if order < 0:
            inside &= f > 0
        return float(np.sum(f[inside] ** order * (self.density * self._widths)[inside]))

    @cached_property
    def _widths(self) -> np.ndarray:
        return widths(self.frequency)

    @property
    def equally_spaced(self) -> bool:
        """Whether the frequencies are, as those of a record."""
        steps = np.diff(self.frequency)
        return bool(np.allclose(steps, steps[0], rtol=1e-6, atol=0.0))

    def scaled(self, factor: float, unit: str) -> Spectrum:
        """The spectrum of ``factor`` times the signal, in ``unit``: of the stress in a tube from that of its moment."""
        return replace(self, density=self.density * factor**2, unit=unit)

    @property
    def std(self) -> float:
        """Standard deviation of the signal, sqrt(m_0)."""
        return float(np.sqrt(self.moment(0)))

    @property
    def significant_height(self) -> float:
        """Significant height of a sea, 4 sqrt(m_0)."""
        return 4.0 * self.std

    @property
    def peak_frequency(self) -> float:
        """Frequency of the largest density, Hz."""
        return float(self.frequency[np.argmax(self.density)])

    @property
    def zero_crossing_period(self) -> float:
        """Mean period between upward zero crossings, sqrt(m_0 / m_2), s."""
        return float(np.sqrt(self.moment(0) / self.moment(2)))

    @property
    def up_crossing_rate(self) -> float:
        """Upward crossings of the mean in a second, sqrt(m_2 / m_0), of a Gaussian signal."""
        return float(np.sqrt(self.moment(2) / self.moment(0)))

    @property
    def maxima_rate(self) -> float:
        """Maxima in a second, sqrt(m_4 / m_2), of a Gaussian signal."""
        return float(np.sqrt(self.moment(4) / self.moment(2)))

    @property
    def irregularity(self) -> float:
        """Up-crossings over maxima, m_2 / sqrt(m_0 m_4): 1 for a narrow spectrum, towards 0 for a broad one."""
        return self.up_crossing_rate / self.maxima_rate

    def median_filtered(self, order: int = 15, keep_level: bool = True) -> Spectrum:
        """Smooth by a running median over ``order`` (odd) frequencies.

        The median of a periodogram lies below its mean (by ln 2 for many values of one periodogram, because they are
        exponentially distributed). ``keep_level`` divides by that factor, so that broad spectra keep their variance.
        A line (regular wave) or a resonance narrower than half the window is cut off: do not read peaks from it.
        Below 0 Hz the density goes on as it does above, S(-f) = S(f), so that slow motions keep their level. Zeros in
        its place, as a plain median filter takes them, would cut it off within half a window of 0 Hz. At 0 Hz itself
        the mean has been taken off, and the next value stands for it.
        """
        from scipy.ndimage import median_filter

        if order < 1 or order % 2 == 0:
            raise ModelError(f"the median filter takes an odd order such as 15, not {order}.")
        if order == 1:
            return self
        smooth = median_filter(np.concatenate([self.density[1:2], self.density[1:]]), order, mode="mirror")
        if keep_level:
            smooth = smooth / _median_level(order, self.averages)
        return replace(self, density=smooth)


def _median_level(order: int, averages: float) -> float:
    """Expected median of ``order`` spectral values over their mean; the values follow chi-square with 2 x averages."""
    from scipy.stats import beta, chi2

    half = (order + 1) / 2
    grid = (np.arange(2000) + 0.5) / 2000  # the median of n uniform numbers follows Beta(half, half)
    return float(np.mean(chi2.ppf(beta.ppf(grid, half, half), 2 * averages)) / (2 * averages))


def power_spectrum(
    series: SeriesLike,
    *,
    discard: float = 0.0,
    segment: float | None = None,
    window: str | None = None,
    median: int = 0,
    name: str = "",
) -> Spectrum:
    """One-sided power spectral density of a series about its mean.

    series   ``result["surge"]`` or (time, values), equally spaced
    discard  seconds left out at the beginning
    segment  length [s] of the half-overlapping segments of Welch's average; None takes the whole record once
    window   of scipy.signal; default "hann" for segments, "boxcar" for the whole record (the variance is then exact)
    median   order of a running median (15 is usual for whole records; see Spectrum.median_filtered); 0 for none
    """
    from scipy import signal

    record = as_series(series, name).after(discard)
    step = record.step
    count = record.values.size if segment is None else int(round(segment / step))
    if count < 8 or count > record.values.size:
        raise ModelError(
            f"{record.name}: a segment of {count * step:g} s does not fit: the record has "
            f"{record.values.size} points over {record.values.size * step:g} s, a segment takes 8 points or more."
        )
    window = window or ("boxcar" if segment is None else "hann")
    values = record.values - record.values.mean()
    frequency, density = signal.welch(values, 1.0 / step, window, count, detrend=False, scaling="density")
    segments = 1 + (record.values.size - count) // max(count - count // 2, 1)
    averages = 18.0 * segments**2 / (19.0 * segments - 1.0)  # half-overlapping Hann segments are nearly independent
    spectrum = Spectrum(frequency, density, record.unit, record.name, record.long_name, averages)
    return spectrum.median_filtered(median) if median else spectrum


def realisation(spectrum: Spectrum, duration: float, step: float, *, seed: int, mean: float = 0.0) -> Series:
    """One Gaussian series of a spectrum: a sum of its harmonics with random amplitudes and phases.

    The series is periodic in ``duration`` [s]; its variance is that of the spectrum on average over seeds. Where the
    frequencies of the spectrum are not equally spaced, as those of a response, each harmonic has what lies about it,
    and the first one what lies below it, too.
    Source: Shinozuka and Jan (1972), by inverse Fourier transform.
    """
    if not (np.isfinite(duration) and step > 0):
        raise ModelError(f"a series takes a duration and a step above 0 s, not {duration:g} s and {step:g} s.")
    count = int(round(duration / step))
    if count < 8:
        raise ModelError(f"a series of {duration:g} s in steps of {step:g} s is too short; it takes 8 steps or more.")
    spacing = 1.0 / (count * step)
    equal, given = spectrum.equally_spaced, spectrum.frequency[1] - spectrum.frequency[0]
    name = spectrum.name or "the spectrum"
    if equal and spacing > 1.001 * given:
        raise ModelError(
            f"{name} has a density every {given:g} Hz; a series of {duration:g} s would take one every {spacing:g} Hz "
            f"and miss what lies between. Take {1 / given:g} s or more."
        )
    lost = spectrum.moment(0, 0.5 / step) / (spectrum.moment(0) or 1.0)
    if lost > 1e-3:
        raise ModelError(
            f"{100 * lost:.2g} % of the variance of {name} lies above {0.5 / step:g} Hz, which steps of {step:g} s "
            "cannot follow; take shorter ones."
        )
    frequency = np.fft.rfftfreq(count, step)
    if equal:
        density = np.interp(frequency, spectrum.frequency, spectrum.density, left=0.0, right=0.0)
    else:
        density = _about(frequency, spectrum)
    density[0] = 0.0
    if count % 2 == 0:
        density[-1] = 0.0  # half the sampling rate has no phase
    parts = np.random.default_rng(seed).standard_normal((2, frequency.size))
    harmonics = 0.5 * count * np.sqrt(density * spacing) * (parts[0] - 1j * parts[1])
    values = mean + np.fft.irfft(harmonics, count)
    return Series(step * np.arange(count), values, spectrum.unit, f"{name}, seed {seed}", spectrum.long_name)


def _about(frequency: np.ndarray, spectrum: Spectrum) -> np.ndarray:
    """Mean density about each of equally spaced frequencies from 0: narrow peaks between them keep their variance."""
    below = mean_square_below(spectrum.frequency, spectrum.density)
    spacing = frequency[1]
    edges = np.concatenate([[0.0, 0.0], frequency[1:] + spacing / 2])
    return np.diff(np.interp(edges, spectrum.frequency, below)) / spacing


def average(spectra: Sequence[Spectrum]) -> Spectrum:
    """Mean of spectra of equal frequencies, such as those of several seeds."""
    if not spectra:
        raise ModelError("there are no spectra to average.")
    first = spectra[0]
    for other in spectra[1:]:
        if other.frequency.shape != first.frequency.shape or not np.allclose(other.frequency, first.frequency):
            raise ModelError(
                "spectra can be averaged when their frequencies agree: take records of equal length and step."
            )
    density = np.mean([spectrum.density for spectrum in spectra], axis=0)
    return replace(first, density=density, averages=sum(spectrum.averages for spectrum in spectra))


@dataclass(frozen=True)
class SpectrumComparison:
    """How a measured spectrum agrees with a target between two frequencies.

    variance_ratio  m_0 measured over m_0 of the target
    deviation       root mean square of (measured - target), over the target's root mean square
    """

    variance_ratio: float
    deviation: float


def compare(
    spectrum: Spectrum, target: Callable[[np.ndarray], np.ndarray], low: float = 0.0, high: float = np.inf
) -> SpectrumComparison:
    """Compare with target(f [Hz]) -> density [unit^2/Hz] over [low, high] Hz."""
    inside = (spectrum.frequency >= low) & (spectrum.frequency <= high) & (spectrum.frequency > 0)
    if inside.sum() < 2:
        raise ModelError(
            f"there are fewer than two frequencies between {low:g} Hz and {high:g} Hz; "
            f"the spectrum ends at {spectrum.frequency[-1]:g} Hz in steps of {spectrum.frequency[1]:g} Hz."
        )
    measured, wanted = spectrum.density[inside], np.asarray(target(spectrum.frequency[inside]), dtype=float)
    deviation = np.sqrt(np.mean((measured - wanted) ** 2) / np.mean(wanted**2))
    return SpectrumComparison(float(measured.sum() / wanted.sum()), float(deviation))
