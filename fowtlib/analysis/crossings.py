"""How often a series passes a level on its way up: counts at many levels, and Rice's rate of a Gaussian process.

A crossing is counted between two points of time, the first at or below the level and the second above it.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from fowtlib.language.errors import ModelError

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from fowtlib.analysis.spectra import Spectrum


def count_up_crossings(values: np.ndarray, levels: ArrayLike) -> np.ndarray:
    """Number of upward crossings of each of the rising `levels`; values (n,)."""
    levels = np.asarray(levels, dtype=float)
    below = np.searchsorted(levels, values)  # how many levels lie below each value
    before, after = below[:-1], below[1:]
    rising = after > before
    begun, ended = (np.bincount(ends[rising], minlength=levels.size + 1) for ends in (before, after))
    return np.cumsum(begun - ended)[: levels.size]


def count_in_pieces(
    time: np.ndarray, values: np.ndarray, levels: ArrayLike, pieces: int
) -> tuple[np.ndarray, np.ndarray]:
    """Upward crossings in pieces of a record, (pieces, levels), and the spans [s] of these."""
    edges = np.linspace(0, values.size - 1, pieces + 1).astype(int)
    parts = [values[first : last + 1] for first, last in zip(edges[:-1], edges[1:], strict=True)]
    return np.array([count_up_crossings(part, levels) for part in parts]), np.diff(time[edges])


def gaussian_rate(level: ArrayLike, mean: float, std: float, mean_rate: float) -> np.ndarray:
    """Rate [1/s] at which a stationary Gaussian process passes a level upward, nu_0 exp(-(y - mean)^2 / (2 std^2)).

    mean_rate: nu_0, of its mean; of a spectrum: `mean_crossing_rate`. Source: Rice (1944), Bell System Technical
    Journal 23 and 24.
    """
    if not std > 0.0:
        raise ModelError(f"the crossings of a Gaussian process need a standard deviation above 0, not {std:g}.")
    return mean_rate * np.exp(-0.5 * ((np.asarray(level, dtype=float) - mean) / std) ** 2)


def mean_crossing_rate(spectrum: Spectrum, low: float = 0.0, high: float = np.inf) -> float:
    """Rate [1/s] at which a Gaussian process of this spectrum passes its mean upward, sqrt(m_2 / m_0), m_n per Hz.

    With moments over circular frequency it is sqrt(m_2 / m_0) / (2 pi). The second moment grows with noise at high
    frequencies: `low` and `high` [Hz] bound what is taken.
    """
    variance = spectrum.moment(0, low, high)
    if not variance > 0.0:
        raise ModelError(f"{spectrum.name or 'the spectrum'}: has no variance between {low:g} and {high:g} Hz.")
    return float(np.sqrt(spectrum.moment(2, low, high) / variance))
