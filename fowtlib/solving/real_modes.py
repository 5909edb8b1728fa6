"""Modes of a real linear model in real numbers: what frequencies ask of them costs half of that of complex ones.

A pair of roots s +- i w with right vectors v, conj v and left ones l, conj l answers b exp(i omega t) with

    v l b/(i omega - s - i w) + its partner = (Re v)(P g + Q h) + (Im v)(Q g - P h),   g = (Re l) b, h = (Im l) b,
    P = 2 (i omega - s)/d,  Q = -2 w/d,  d = (i omega - s)^2 + w^2.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

EXACT = 1e-15  # of the largest share of functions of frequency, below which one is rounding


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

    def functions(self, omega: np.ndarray) -> np.ndarray:
        """P and Q of the pairs, and 1/(i omega - s) of the real roots, at frequencies omega (q,) [rad/s]: (n, q)."""
        off = 1j * omega - self.pairs.real[:, None]
        over = 2 / (off**2 + self.pairs.imag[:, None] ** 2)
        return np.concatenate([off * over, -self.pairs.imag[:, None] * over, 1 / (1j * omega - self.reals[:, None])])

    def answers(self, functions: np.ndarray, parts: np.ndarray) -> np.ndarray:
        """Amplitudes (n, q, k), of what each has of the rates, `of` times b (n, q, k).

        A symmetric matrix at each frequency: with the conjugate functions it answers backwards, from shapes' to of'.
        """
        p, found = len(self.pairs), np.empty(parts.shape, dtype=complex)
        first, second, rest = slice(p), slice(p, 2 * p), slice(2 * p, None)
        P, Q, alone = (functions[part, :, None] for part in (first, second, rest))
        g, h = parts[first], parts[second]
        found[first] = P * g + Q * h
        found[second] = Q * g - P * h
        found[rest] = alone * parts[rest]
        return found

    def between(self, C: np.ndarray, B: np.ndarray) -> np.ndarray:
        """C (i omega - A)^-1 B as sums of the functions, for C (m, n) and B (n, k): (m, k, n)."""
        p = len(self.pairs)
        parts = slice(p), slice(p, 2 * p), slice(2 * p, None)
        by_shape, of = (C @ self.shapes)[:, None], (self.of @ B).T
        (c, d, e), (g, h, b) = [by_shape[..., part] for part in parts], [of[:, part] for part in parts]
        return np.concatenate([c * g - d * h, c * h + d * g, e * b], axis=2)

    def faster(self, rate: float) -> np.ndarray:
        """Which of the functions belong to roots above a rate [rad/s] (n,)."""
        pairs = np.abs(self.pairs) > rate
        return np.concatenate([pairs, pairs, np.abs(self.reals) > rate])


@dataclass(frozen=True, eq=False)
class FewFunctions:
    """The functions of modes as real sums of fewer: functions (n, q) = of (n, f) @ values (f, q), to rounding.

    Those of roots far above all frequencies are nearly straight lines; the others stay as they are. The last one is 1,
    of what answers at once.
    """

    of: np.ndarray
    values: np.ndarray

    @staticmethod
    def made(functions: np.ndarray, fast: np.ndarray) -> FewFunctions:
        """Those of functions (n, q), of which those that are fast (n,) are put together."""
        together = np.hstack([functions[fast].real, functions[fast].imag])
        size = np.maximum(np.abs(together).max(axis=1, initial=0.0), 1e-300)[:, None]
        left, share, right = np.linalg.svd(together / size, full_matrices=False)
        count = int(np.sum(share > EXACT * share.max(initial=0.0)))
        slow, q = int(np.sum(~fast)), functions.shape[1]
        of, values = np.zeros((len(functions), slow + count + 1)), np.ones((slow + count + 1, q), dtype=complex)
        of[~fast, :slow], values[:slow] = np.eye(slow), functions[~fast]
        of[fast, slow:-1] = size * left[:, :count] * share[:count]
        values[slow:-1] = right[:count, :q] + 1j * right[:count, q:]
        return FewFunctions(of, values)

    def summed(self, rows: np.ndarray) -> np.ndarray:
        """Re sum of each function times rows (n, q): (f, n)."""
        return self.values.real @ rows.real.T - self.values.imag @ rows.imag.T
