"""The best linear law of drag: stochastic linearisation of |u| u, for a random velocity u in some directions."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

_ANGLES, _WEIGHTS = np.polynomial.legendre.leggauss(96)
_ANGLES, _WEIGHTS = (1 + _ANGLES) * np.pi / 4, _WEIGHTS * np.pi / 4
SQUARED, DENSITY = np.tan(_ANGLES) ** 2, _WEIGHTS / np.sin(_ANGLES) ** 2 / np.sqrt(np.pi)
"""Points t, over the largest of the variances and the square of the mean, and weights of the integral over t."""


def best_gain(covariance: np.ndarray, mean: np.ndarray | None = None) -> np.ndarray:
    """G (n, n) of the linear law G (u - mean) nearest to the changes of |u| u, for a Gaussian u of this covariance.

    G = E[|u| u (u - m)^T] E[(u - m) (u - m)^T]^-1 = E[d(|u| u)/du], least in the mean square; m (n,) = 0 without a
    mean. Along the principal axes, with sqrt(x) as the integral of (1 - exp(-x t)) t^(-3/2) / (2 sqrt(pi)) over t > 0,

        G_ij = 1/(2 sqrt(pi)) int_0^inf t^(-3/2) (delta_ij (1 - F/w_i) + 2 t m_i m_j F/(w_i w_j)) dt,
        w_i = 1 + 2 t s_i^2,   F = prod_k w_k^(-1/2) exp(-t m_k^2/w_k),

    here with t = tan^2(angle) over the largest of the variances and the square of the mean. One direction:
    sqrt(8/pi) s without a mean, 2 m where it is much larger than s. Two equal ones without a mean: 3/2 sqrt(pi/2) s.
    """
    covariance = np.asarray(covariance, dtype=float)
    mean = np.zeros(len(covariance)) if mean is None else np.asarray(mean, dtype=float)
    return stacked_gains(covariance[None], mean[None])[0]


def best_gains(velocities: Sequence[np.ndarray], means: Sequence[np.ndarray]) -> list[np.ndarray]:
    """The gains of many laws, from values (n, k) of each whose sums of products are its covariance, and means (n,)."""
    return gains_of([u @ u.T for u in velocities], means)


def gains_of(covariances: Sequence[np.ndarray], means: Sequence[np.ndarray]) -> list[np.ndarray]:
    """The gains of many laws, from the covariance (n, n) and the mean (n,) of each."""
    sizes = [len(mean) for mean in means]
    width = max(sizes, default=0)
    if not width:
        return [np.zeros((0, 0)) for _ in means]
    # one that has fewer directions is one that does not move along the others
    covariance, mean = np.zeros((len(means), width, width)), np.zeros((len(means), width))
    for k, n in enumerate(sizes):
        covariance[k, :n, :n], mean[k, :n] = covariances[k], means[k]
    return [gain[:n, :n] for gain, n in zip(stacked_gains(covariance, mean), sizes, strict=True)]


def stacked_gains(covariance: np.ndarray, mean: np.ndarray) -> np.ndarray:
    """The gains (k, n, n) of covariances (k, n, n) and means (k, n)."""
    variances, axes = np.linalg.eigh((covariance + covariance.transpose(0, 2, 1)) / 2)
    variances = np.maximum(variances, 0.0)
    m = (axes.transpose(0, 2, 1) @ mean[:, :, None])[:, :, 0]
    largest = np.maximum(variances[:, -1], (m**2).sum(axis=1))
    size = np.where(largest > 0, largest, 1.0)[:, None]
    shares, m, t = variances / size, m / np.sqrt(size), SQUARED[:, None, None]
    w = 1 + 2 * t * shares
    F = np.exp(-(t * m**2 / w).sum(axis=2)) / np.sqrt(w.prod(axis=2))
    count, n = mean.shape
    along = DENSITY @ (1 - F[:, :, None] / w).reshape(DENSITY.size, -1)
    gains = np.eye(n) * along.reshape(count, 1, n)
    flows = np.flatnonzero(mean.any(axis=1))
    if flows.size:
        share = np.sqrt(2 * (SQUARED * DENSITY)[:, None] * F[:, flows])[:, :, None] * (m[flows] / w[:, flows])
        gains[flows] += share.transpose(1, 2, 0) @ share.transpose(1, 0, 2)
    return axes @ (gains * np.sqrt(largest)[:, None, None]) @ axes.transpose(0, 2, 1)
