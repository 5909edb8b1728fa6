"""Harmonic content of a steady periodic response, by least squares at known frequencies."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from fowtlib.analysis.series import as_series
from fowtlib.language.errors import ModelError

if TYPE_CHECKING:
    from fowtlib.analysis.series import SeriesLike


@dataclass(frozen=True)
class HarmonicFit:
    """x(t) = mean + Re(sum_k coefficients[k - 1] exp(i k 2 pi f t)) + rest; t is the time of the series itself.

    unsteadiness is the change of the first harmonic between the two halves of the fitted record, relative to it;
    residual is the standard deviation of the rest, in the unit of the series.
    """

    frequency: float
    mean: float
    coefficients: np.ndarray
    residual: float
    unsteadiness: float
    unit: str = "1"

    @property
    def amplitude(self) -> float:
        """Amplitude of the first harmonic."""
        return float(abs(self.coefficients[0]))

    @property
    def phase(self) -> float:
        """Phase of the first harmonic, rad: x = amplitude cos(2 pi f t + phase)."""
        return float(np.angle(self.coefficients[0]))


def harmonic_fit(
    series: SeriesLike, frequency: float, *, harmonics: int = 1, discard: float = 0.0, name: str = ""
) -> HarmonicFit:
    """Fit mean and harmonics of ``frequency`` [Hz] to the last whole number of periods after ``discard`` seconds."""
    record = as_series(series, name).after(discard)
    time, values = record.time, record.values
    span = time[-1] - time[0]
    periods = int(np.floor(span * frequency + 1e-6))
    if periods < 2:
        raise ModelError(
            f"{record.name}: {span:g} s hold {span * frequency:.3g} periods of {frequency:g} Hz, two are needed. "
            "Simulate longer, or discard less."
        )
    inside = time > time[-1] - periods / frequency + 1e-9 * span
    time, values = time[inside], values[inside]
    if time.size < 4 * periods * harmonics:
        raise ModelError(
            f"{record.name}: fewer than four points per period of the harmonics; take a smaller output step."
        )
    mean, coefficients, residual = _solve(time, values, frequency, harmonics)
    half = time.size // 2
    early, late = (
        _solve(time[part], values[part], frequency, harmonics)[1][0] for part in (slice(half), slice(half, None))
    )
    size = max(abs(coefficients[0]), 1e-300)
    return HarmonicFit(frequency, mean, coefficients, residual, float(abs(late - early) / size), record.unit)


def _solve(time: np.ndarray, values: np.ndarray, frequency: float, harmonics: int) -> tuple[float, np.ndarray, float]:
    angle = 2.0 * np.pi * frequency * np.outer(time, np.arange(1, harmonics + 1))
    basis = np.hstack([np.ones((time.size, 1)), np.cos(angle), -np.sin(angle)])
    weights = np.linalg.lstsq(basis, values, rcond=None)[0]
    rest = values - basis @ weights
    return float(weights[0]), weights[1 : harmonics + 1] + 1j * weights[harmonics + 1 :], float(rest.std())
