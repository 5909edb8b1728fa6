"""How the best linear law of drag changes with the covariance and the mean of the velocity; see frequency.drag."""

from __future__ import annotations

import numpy as np

from fowtlib.frequency.drag import DENSITY, SQUARED
from fowtlib.language.quadratic_laws import slope_at

AT_REST = 1e-6  # m/s; a mean below it counts as none


def gain_slopes(covariance: np.ndarray, mean: np.ndarray | None = None) -> tuple[np.ndarray, np.ndarray]:
    """Slopes of the gain E[d(|u| u)/du] of a Gaussian u: by its covariance (n, n, n, n), and by its mean (n, n, n).

    [a, b, c, d]: of G[a, b] by symmetric changes of the covariance. Zero for a velocity that is zero. With
    W = (1 + 2 t C)^-1, a = W m, F = sqrt(det W) exp(-t m.a) the gain is the integral over t of
    t^(-3/2) / (2 sqrt(pi)) (1 - F W + 2 t F a a'), and under it

        dW = -2 t W dC W,  dF = F (2 t^2 a' dC a - t tr(W dC) - 2 t a.dm),  da = dW m + W dm.

    The substitution is that of the gain, so that these are slopes of its numbers but for the error of the integral,
    about 1e-8.
    """
    C = np.asarray(covariance, dtype=float)
    m = np.zeros(len(C)) if mean is None else np.asarray(mean, dtype=float)
    by_covariance, by_mean = stacked_slopes(C[None], m[None])
    return by_covariance[0], by_mean[0]


def stacked_slopes(covariances: np.ndarray, means: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The same of covariances (k, n, n) and means (k, n): (k, n, n, n, n) and (k, n, n, n)."""
    C, m = (covariances + covariances.transpose(0, 2, 1)) / 2, means
    count, n = m.shape
    largest = np.maximum(np.linalg.eigvalsh(C)[:, -1], (m**2).sum(axis=1))
    still = ~(largest > 0)
    largest = np.where(still, 1.0, largest)
    t = (SQUARED[:, None] / largest).T  # (k, t)
    weights = DENSITY * np.sqrt(largest)[:, None]
    tensor = t[:, :, None, None]
    W = np.linalg.inv(np.eye(n) + 2 * tensor * C[:, None])
    a = (W @ m[:, None, :, None])[..., 0]
    F = np.sqrt(np.linalg.det(W)) * np.exp(-t * (a @ m[:, :, None])[..., 0])
    aa = a[..., :, None] * a[..., None, :]
    inside = 2 * tensor * aa - W  # G = 1 + F inside
    by_F = F[:, :, None, None] * (2 * tensor**2 * aa - tensor * W)  # of F by C

    def summed(factor: np.ndarray, one: np.ndarray, other: np.ndarray) -> np.ndarray:
        """Integral of a factor times the products of all elements of two: (k, elements, elements)."""
        one, other = (block.reshape(count, t.shape[1], -1) for block in (one, other))
        return (factor[:, :, None] * one).transpose(0, 2, 1) @ other

    by_C = summed(weights, inside, by_F).reshape(count, n, n, n, n)
    turned = summed(weights * F * 2 * t, W, W).reshape(count, n, n, n, n).transpose(0, 1, 3, 4, 2)  # a c, d b
    of_a = summed(weights * F * 4 * t**2, W, aa).reshape(count, n, n, n, n).transpose(0, 1, 4, 2, 3)  # a c, d b
    by_C = by_C + turned - of_a - of_a.transpose(0, 2, 1, 3, 4)
    by_C = (by_C + by_C.transpose(0, 1, 2, 4, 3)) / 2
    along = summed(weights * F * -2 * t, inside, a).reshape(count, n, n, n)
    moved = summed(weights * F * 2 * t, W, a).reshape(count, n, n, n).transpose(0, 1, 3, 2)  # a k, b
    by_mean = along + moved + moved.transpose(0, 2, 1, 3)
    by_C[still], by_mean[still] = 0.0, 0.0
    return by_C, by_mean


def slope_at_mean(mean: np.ndarray, smoothing: float = 0.0) -> tuple[np.ndarray, np.ndarray]:
    """d(|u| u)/du at a mean u (n,), which the linear model has by itself: (n, n), and its slopes by u (n, n, n)."""
    n, speed = len(mean), float(np.hypot(np.linalg.norm(mean), smoothing))
    if not speed > AT_REST:
        return np.zeros((n, n)), np.zeros((n, n, n))
    one, u = np.eye(n), mean / speed
    by_mean = np.einsum("ab,k->abk", one, u) + np.einsum("ak,b->abk", one, u) + np.einsum("bk,a->abk", one, u)
    return slope_at(mean, smoothing), by_mean - np.einsum("a,b,k->abk", u, u, u)
