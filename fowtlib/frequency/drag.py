"""The best linear law of drag: stochastic linearisation of |u| u, for a random velocity u in some directions."""

from __future__ import annotations

import numpy as np

_ANGLES, _WEIGHTS = np.polynomial.legendre.leggauss(96)
_ANGLES, _WEIGHTS = (1 + _ANGLES) * np.pi / 4, _WEIGHTS * np.pi / 4


def best_gain(covariance: np.ndarray) -> np.ndarray:
    """G (n, n) of the linear law G u nearest to |u| u in the mean square, for a Gaussian u of this covariance (n, n).

    G = E[|u| u u^T] E[u u^T]^-1 = E[d(|u| u)/du], with mean zero. Along the principal axes, with sqrt(x) as the
    integral of (1 - exp(-x t)) t^(-3/2) / (2 sqrt(pi)) over t > 0,

        G_i = 1/(2 sqrt(pi)) int_0^inf t^(-3/2) (1 - 1/(1 + 2 t s_i^2) prod_j (1 + 2 t s_j^2)^(-1/2)) dt,

    here with t = tan^2(angle) over the largest variance. One direction: sqrt(8/pi) s. Two equal ones: 3/2 sqrt(pi/2) s.
    """
    covariance = np.asarray(covariance, dtype=float)
    variances, axes = np.linalg.eigh((covariance + covariance.T) / 2)
    largest = variances[-1]
    if not largest > 0:
        return np.zeros_like(covariance)
    shares = np.maximum(variances, 0.0) / largest
    t = np.tan(_ANGLES) ** 2
    fallen = 1 + 2 * t[:, None] * shares
    inside = 1 - 1 / (fallen * np.sqrt(fallen.prod(axis=1))[:, None])
    gains = (_WEIGHTS / np.sin(_ANGLES) ** 2) @ inside / np.sqrt(np.pi)
    return (axes * (gains * np.sqrt(largest))) @ axes.T
