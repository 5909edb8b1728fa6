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
    C = (C + C.T) / 2
    n = len(C)
    m = np.zeros(n) if mean is None else np.asarray(mean, dtype=float)
    largest = max(float(np.linalg.eigvalsh(C)[-1]), float(m @ m))
    if not largest > 0:
        return np.zeros((n,) * 4), np.zeros((n,) * 3)
    t = SQUARED / largest
    weights = DENSITY * np.sqrt(largest)
    W = np.linalg.inv(np.eye(n) + 2 * t[:, None, None] * C)
    a = W @ m
    F = np.sqrt(np.linalg.det(W)) * np.exp(-t * (a @ m))
    aa = a[:, :, None] * a[:, None, :]
    inside = 2 * t[:, None, None] * aa - W  # G = 1 + F inside
    by_F = F[:, None, None] * (2 * (t**2)[:, None, None] * aa - t[:, None, None] * W)  # of F by C
    by_C = np.einsum("t,tab,tcd->abcd", weights, inside, by_F)
    turned = np.einsum("t,tac,tdb->abcd", weights * F * 2 * t, W, W)  # F dW with the minus of -F W
    of_a = np.einsum("t,tac,td,tb->abcd", weights * F * 4 * t**2, W, a, a)  # of a a' by dW m, less its transpose
    by_C = by_C + turned - of_a - of_a.transpose(1, 0, 2, 3)
    by_C = (by_C + by_C.transpose(0, 1, 3, 2)) / 2
    along = np.einsum("t,tab,tk->abk", weights * F * -2 * t, inside, a)
    moved = np.einsum("t,tak,tb->abk", weights * F * 2 * t, W, a)
    return by_C, along + moved + moved.transpose(1, 0, 2)


def slope_at_mean(mean: np.ndarray, smoothing: float = 0.0) -> tuple[np.ndarray, np.ndarray]:
    """d(|u| u)/du at a mean u (n,), which the linear model has by itself: (n, n), and its slopes by u (n, n, n)."""
    n, speed = len(mean), float(np.hypot(np.linalg.norm(mean), smoothing))
    if not speed > AT_REST:
        return np.zeros((n, n)), np.zeros((n, n, n))
    one, u = np.eye(n), mean / speed
    by_mean = np.einsum("ab,k->abk", one, u) + np.einsum("ak,b->abk", one, u) + np.einsum("bk,a->abk", one, u)
    return slope_at(mean, smoothing), by_mean - np.einsum("a,b,k->abk", u, u, u)
