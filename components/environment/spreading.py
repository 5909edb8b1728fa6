"""How the energy of a short-crested sea is shared among directions: DNV-RP-C205 (2010), 3.5.8.7.

D(theta) = Gamma(1 + n/2) / (sqrt(pi) Gamma(1/2 + n/2)) cos^n(theta) about the main direction, |theta| <= pi/2, the same
at all frequencies; n is 2 to 4 in a wind sea, 6 and more in a swell.

With x = sin(theta), D dtheta is (1 - x^2)^((n - 1)/2) dx: the directions are the points of Gauss and Jacobi for this
weight, so that few of them stand for all, exactly for polynomials in x up to the degree 2 count - 1. A realisation
gives each harmonic one direction ("single summation"): over time the sea is the same at all places, as one of several
directions at one frequency is not (E.R. Jefferys, Applied Ocean Research 9, 1987). The harmonics take the directions in
turn, by multiples of the golden section, so that each band of frequencies has all of them.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from fowtlib.components.environment.waves import Floats

GOLDEN = (np.sqrt(5) - 1) / 2


@lru_cache(maxsize=32)
def spread_directions(exponent: float, count: int) -> tuple[Floats, Floats]:
    """Directions (count,) [rad] about the main one, rising, and their shares of the energy, which add up to 1."""
    from scipy.special import roots_jacobi  # slow to import

    points, weights = roots_jacobi(count, (exponent - 1) / 2, (exponent - 1) / 2)
    return np.arcsin(points), weights / weights.sum()


def directions_of(harmonics: np.ndarray, exponent: float, count: int, seed: int) -> Floats:
    """The direction [rad] about the main one of each harmonic, by its number (n,)."""
    angles, shares = spread_directions(exponent, count)
    start = np.random.default_rng([seed, 0, 1]).random()  # beside the streams of phases and of turbulence
    place = np.searchsorted(np.cumsum(shares), (start + harmonics * GOLDEN) % 1.0)
    return angles[np.minimum(place, count - 1)]
