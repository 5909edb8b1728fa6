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


def gain_slopes(covariance: np.ndarray) -> np.ndarray:
    """dG/d covariance (n, n, n, n) of `best_gain`: slopes of G[a, b] by symmetric changes [c, d]; zero at rest.

    Along the principal axes: those of the gains by the variances, and off the diagonal the turning of the axes,
    (G_i - G_j) / (s_i^2 - s_j^2), of which the integral of `best_gain` holds the quotient without a difference.
    """
    covariance = np.asarray(covariance, dtype=float)
    n = len(covariance)
    variances, axes = np.linalg.eigh((covariance + covariance.T) / 2)
    largest = variances[-1]
    if not largest > 0:
        return np.zeros((n,) * 4)
    shares = np.maximum(variances, 0.0) / largest
    t = np.tan(_ANGLES) ** 2
    fallen = 1 + 2 * t[:, None] * shares
    weights = _WEIGHTS / np.sin(_ANGLES) ** 2 / np.sqrt(np.pi) / np.sqrt(largest)
    root = np.sqrt(fallen.prod(axis=1))
    pairs = (weights * t / root)[:, None, None] / (fallen[:, :, None] * fallen[:, None, :])
    pairs = pairs.sum(axis=0)  # int w t / (f_i f_j sqrt(prod f))
    by_variance = pairs + 2 * np.diag(np.diag(pairs))  # of gain i by variance j
    turning = 2 * pairs  # (G_i - G_j) / (s_i^2 - s_j^2)
    found = np.zeros((n,) * 4)
    for i in range(n):
        for j in range(n):
            found[i, i, j, j] = by_variance[i, j]
            if i != j:
                found[i, j, i, j] += turning[i, j] / 2
                found[i, j, j, i] += turning[i, j] / 2
    return np.einsum("ai,bj,ck,dl,ijkl->abcd", axes, axes, axes, axes, found, optimize=True)
