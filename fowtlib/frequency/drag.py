"""The best linear law of drag: stochastic linearisation of |u| u, for a random velocity u in some directions."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

_ANGLES, _WEIGHTS = np.polynomial.legendre.leggauss(96)
_ANGLES, _WEIGHTS = (1 + _ANGLES) * np.pi / 4, _WEIGHTS * np.pi / 4
_SQUARED, _DENSITY = np.tan(_ANGLES) ** 2, _WEIGHTS / np.sin(_ANGLES) ** 2 / np.sqrt(np.pi)


def best_gain(covariance: np.ndarray) -> np.ndarray:
    """G (n, n) of the linear law G u nearest to |u| u in the mean square, for a Gaussian u of this covariance (n, n).

    G = E[|u| u u^T] E[u u^T]^-1 = E[d(|u| u)/du], with mean zero. Along the principal axes, with sqrt(x) as the
    integral of (1 - exp(-x t)) t^(-3/2) / (2 sqrt(pi)) over t > 0,

        G_i = 1/(2 sqrt(pi)) int_0^inf t^(-3/2) (1 - 1/(1 + 2 t s_i^2) prod_j (1 + 2 t s_j^2)^(-1/2)) dt,

    here with t = tan^2(angle) over the largest variance. One direction: sqrt(8/pi) s. Two equal ones: 3/2 sqrt(pi/2) s.
    """
    return _gains(np.asarray(covariance, dtype=float)[None])[0]


def best_gains(velocities: Sequence[np.ndarray]) -> list[np.ndarray]:
    """The gains of many laws, from values (n, k) of each whose sums of products are its covariance."""
    gains: list[np.ndarray] = [np.zeros((0, 0))] * len(velocities)
    for size in {len(u) for u in velocities}:
        of_size = [number for number, u in enumerate(velocities) if len(u) == size]
        u = np.stack([velocities[number] for number in of_size])
        for number, gain in zip(of_size, _gains(u @ u.transpose(0, 2, 1)), strict=True):
            gains[number] = gain
    return gains


def _gains(covariance: np.ndarray) -> np.ndarray:
    """The gains (k, n, n) of covariances (k, n, n)."""
    variances, axes = np.linalg.eigh((covariance + covariance.transpose(0, 2, 1)) / 2)
    largest = np.maximum(variances[:, -1], 0.0)
    shares = np.maximum(variances, 0.0) / np.where(largest > 0, largest, 1.0)[:, None]
    fallen = 1 + 2 * _SQUARED[:, None, None] * shares
    inside = 1 - 1 / (fallen * np.sqrt(fallen.prod(axis=2))[:, :, None])
    gains = np.tensordot(_DENSITY, inside, axes=1) * np.sqrt(largest)[:, None]
    return (axes * gains[:, None, :]) @ axes.transpose(0, 2, 1)
