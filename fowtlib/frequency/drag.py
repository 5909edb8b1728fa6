"""The best linear law of drag: stochastic linearisation of |u| u, for a random velocity u in some directions."""

from __future__ import annotations

import numpy as np

_ANGLES, _WEIGHTS = np.polynomial.legendre.leggauss(96)
_ANGLES, _WEIGHTS = (1 + _ANGLES) * np.pi / 4, _WEIGHTS * np.pi / 4


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
    variances, axes = np.linalg.eigh((covariance + covariance.T) / 2)
    variances = np.maximum(variances, 0.0)
    m = np.zeros(len(variances)) if mean is None else axes.T @ np.asarray(mean, dtype=float)
    largest = max(variances[-1], m @ m)
    if not largest > 0:
        return np.zeros_like(covariance)
    shares, m = variances / largest, m / np.sqrt(largest)
    t = (np.tan(_ANGLES) ** 2)[:, None]
    w = 1 + 2 * t * shares
    F = np.exp(-(t * m**2 / w).sum(axis=1)) / np.sqrt(w.prod(axis=1))
    inside = np.eye(len(m)) * (1 - F[:, None] / w)[:, None, :]
    inside += (2 * t * F[:, None])[..., None] * (m / w)[:, :, None] * (m / w)[:, None, :]
    gains = np.tensordot(_WEIGHTS / np.sin(_ANGLES) ** 2, inside, axes=1) / np.sqrt(np.pi)
    return axes @ (gains * np.sqrt(largest)) @ axes.T
