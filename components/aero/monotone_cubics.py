"""The monotone cubic through points: between two of them it stays between them, and its slope has no jumps.

The same as PchipInterpolator of SciPy, whose import takes longer than all else that a blade needs.
Source: F.N. Fritsch and J. Butland, SIAM J. Sci. Stat. Comput. 5 (1984) 300-304, for the slopes; the ends as in
D. Kahaner, C. Moler and S. Nash, Numerical Methods and Software (1989), 4.8.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


def monotone_cubics(x: Floats, y: Floats) -> Floats:
    """Coefficients by rising power of x - x[i] in each interval: (n - 1, m, 4), of columns y (n, m), n of 3 or more."""
    h = np.diff(x)[:, None]
    secant = np.diff(y, axis=0) / h
    slope = _slopes(h, secant)
    bend = (slope[:-1] + slope[1:] - 2 * secant) / h
    return np.stack([y[:-1], slope[:-1], (secant - slope[:-1]) / h - bend, bend / h], axis=-1)


def _slopes(h: Floats, secant: Floats) -> Floats:
    """Weighted harmonic means of the slopes on both sides; zero where they differ in sign."""
    before, after = secant[:-1], secant[1:]
    flat = np.sign(before) * np.sign(after) <= 0
    one, two = 2 * h[1:] + h[:-1], h[1:] + 2 * h[:-1]
    with np.errstate(divide="ignore", invalid="ignore"):
        mean = (one / before + two / after) / (one + two)
        inner = np.where(flat, 0.0, 1 / np.where(flat, 1.0, mean))
    ends = [_end(h[0], h[1], secant[0], secant[1]), _end(h[-1], h[-2], secant[-1], secant[-2])]
    return np.concatenate([ends[0][None], inner, ends[1][None]])


def _end(h: Floats, next_h: Floats, secant: Floats, next_secant: Floats) -> Floats:
    """Slope at an end: of the parabola through three points, as far as that keeps the shape."""
    slope = ((2 * h + next_h) * secant - h * next_secant) / (h + next_h)
    turned = np.sign(slope) != np.sign(secant)
    steep = (np.sign(secant) != np.sign(next_secant)) & (np.abs(slope) > 3 * np.abs(secant))
    return np.where(turned, 0.0, np.where(steep, 3 * secant, slope))
