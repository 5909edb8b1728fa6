"""Modes of a real linear model in real numbers: what frequencies ask of them costs half of that of complex ones.

A pair of roots s +- i w with right vectors v, conj v and left ones l, conj l answers b exp(i omega t) with

    v l b/(i omega - s - i w) + its partner = (Re v)(P g + Q h) + (Im v)(Q g - P h),   g = (Re l) b, h = (Im l) b,
    P = 2 (i omega - s)/d,  Q = -2 w/d,  d = (i omega - s)^2 + w^2.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True, eq=False)
class RealModes:
    """Real amplitudes of modes: roots (p,) of pairs, one of each, and real ones (r,); n = 2 p + r.

    shapes (n, n): states by amplitudes, of pairs the real parts, then the imaginary ones, then real roots; of (n, n):
    what each amplitude has of the rates.
    """

    pairs: np.ndarray
    reals: np.ndarray
    shapes: np.ndarray
    of: np.ndarray

    @staticmethod
    def made(roots: np.ndarray, right: np.ndarray, left: np.ndarray) -> RealModes | None:
        """Those of the eigenvectors of a real matrix; None where these do not come in conjugate pairs."""
        pairs, reals = np.flatnonzero(roots.imag > 0), np.flatnonzero(roots.imag == 0)
        if 2 * pairs.size + reals.size != roots.size:
            return None
        shapes = np.hstack([right[:, pairs].real, right[:, pairs].imag, right[:, reals].real])
        of = np.vstack([left[pairs].real, left[pairs].imag, left[reals].real])
        return RealModes(roots[pairs], roots[reals].real, shapes, of)

    def answers(self, omega: np.ndarray, parts: np.ndarray) -> np.ndarray:
        """Amplitudes (n, q, k) at frequencies omega (q,) [rad/s], of what each has of the rates, `of` times b."""
        p, found = len(self.pairs), np.empty(parts.shape, dtype=complex)
        off = 1j * omega - self.pairs.real[:, None]
        over = 2 / (off**2 + self.pairs.imag[:, None] ** 2)
        P, Q = (off * over)[:, :, None], (-self.pairs.imag[:, None] * over)[:, :, None]
        g, h = parts[:p], parts[p : 2 * p]
        found[:p] = P * g + Q * h
        found[p : 2 * p] = Q * g - P * h
        found[2 * p :] = parts[2 * p :] / (1j * omega - self.reals[:, None])[:, :, None]
        return found
