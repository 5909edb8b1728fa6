"""Laws of one random variable, by scipy.stats, with what the method of contours needs: standard normal variables.

A law maps a standard normal variable z to its value of the same probability, F(x) = Phi(z), and back. Both ways go over
logarithms of the upper tail, so that a value of z = 8 or of z = -8 is as exact as one of z = 0.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

_TINY = np.finfo(float).tiny


class Law(Protocol):
    """A continuous law of one variable; every method takes and gives arrays that broadcast with its parameters."""

    def pdf(self, x: Any) -> np.ndarray: ...
    def cdf(self, x: Any) -> np.ndarray: ...
    def sf(self, x: Any) -> np.ndarray: ...
    def ppf(self, q: Any) -> np.ndarray: ...
    def isf(self, q: Any) -> np.ndarray: ...
    def from_normal(self, z: Any) -> np.ndarray: ...
    def to_normal(self, x: Any) -> np.ndarray: ...


class _Frozen:
    """What scipy.stats gives, under the same names."""

    _law: Any

    def pdf(self, x: Any) -> np.ndarray:
        return self._law.pdf(x)

    def cdf(self, x: Any) -> np.ndarray:
        return self._law.cdf(x)

    def sf(self, x: Any) -> np.ndarray:
        """Probability of more than x."""
        return self._law.sf(x)

    def ppf(self, q: Any) -> np.ndarray:
        """The value that is not exceeded with probability q."""
        return self._law.ppf(q)

    def isf(self, q: Any) -> np.ndarray:
        """The value that is exceeded with probability q."""
        return self._law.isf(q)

    def mean(self) -> np.ndarray:
        return self._law.mean()

    def median(self) -> np.ndarray:
        return self._law.median()

    def std(self) -> np.ndarray:
        return self._law.std()


@dataclass(frozen=True)
class Weibull(_Frozen):
    """F(x) = 1 - exp(-(x / scale)^shape), for x >= 0."""

    shape: Any
    scale: Any

    @property
    def _law(self) -> Any:
        from scipy.stats import weibull_min

        return weibull_min(self.shape, scale=self.scale)

    def mode(self) -> np.ndarray:
        """The most probable value; 0 where the density falls from there."""
        shape = np.asarray(self.shape, dtype=float)
        return self.scale * np.maximum(1 - 1 / shape, 0.0) ** (1 / shape)

    def from_normal(self, z: Any) -> np.ndarray:
        from scipy.special import log_ndtr

        return self.scale * (-log_ndtr(-np.asarray(z, dtype=float))) ** (1 / np.asarray(self.shape, dtype=float))

    def to_normal(self, x: Any) -> np.ndarray:
        from scipy.special import ndtri_exp

        return -ndtri_exp(-((np.asarray(x, dtype=float) / self.scale) ** self.shape))


@dataclass(frozen=True)
class LogNormal(_Frozen):
    """The logarithm is normal, with mean `location` and standard deviation `deviation`."""

    location: Any
    deviation: Any

    @classmethod
    def of(cls, mean: Any, variation: Any) -> LogNormal:
        """By the mean of the variable itself and its coefficient of variation."""
        squared = np.asarray(variation, dtype=float) ** 2
        return cls(np.log(mean / np.sqrt(1 + squared)), np.sqrt(np.log1p(squared)))

    @property
    def _law(self) -> Any:
        from scipy.stats import lognorm

        return lognorm(self.deviation, scale=np.exp(self.location))

    def mode(self) -> np.ndarray:
        """The most probable value."""
        return np.exp(self.location - np.square(self.deviation))

    def from_normal(self, z: Any) -> np.ndarray:
        return np.exp(self.location + self.deviation * np.asarray(z, dtype=float))

    def to_normal(self, x: Any) -> np.ndarray:
        return (np.log(x) - self.location) / self.deviation


@dataclass(frozen=True)
class Mixture:
    """Laws of one variable, weighted: the marginal of a variable whose law is known at each value of others.

    weights: (n,), of sum 1. law: with parameters of shape (n,).
    """

    weights: np.ndarray
    law: Any

    def pdf(self, x: Any) -> np.ndarray:
        return self._sum(self.law.pdf, x)

    def cdf(self, x: Any) -> np.ndarray:
        return self._sum(self.law.cdf, x)

    def sf(self, x: Any) -> np.ndarray:
        """Probability of more than x."""
        return self._sum(self.law.sf, x)

    def ppf(self, q: Any) -> np.ndarray:
        """The value that is not exceeded with probability q, within (0, 1)."""
        return self._inverse(q, self.cdf, self.law.ppf)

    def isf(self, q: Any) -> np.ndarray:
        """The value that is exceeded with probability q, within (0, 1)."""
        return self._inverse(q, self.sf, self.law.isf)

    def mean(self) -> float:
        return float(self.weights @ self.law.mean())

    def _sum(self, of: Callable[[Any], np.ndarray], x: Any) -> np.ndarray:
        values = np.asarray(x, dtype=float)
        rows = np.array([self.weights @ of(value) for value in values.ravel()])
        return rows.reshape(values.shape)[()]

    def _inverse(self, q: Any, of: Callable[[Any], Any], inverse: Callable[[Any], np.ndarray]) -> np.ndarray:
        """Root in log probability; it lies between the least and the largest answer of the single laws."""
        from scipy.optimize import brentq

        wanted = np.asarray(q, dtype=float)
        found = []
        for value in wanted.ravel():
            ends = inverse(value)[self.weights > 0]
            low, high = float(ends.min()), float(ends.max())
            if not high > low:
                found.append(low)
                continue
            target = np.log(value)
            found.append(brentq(lambda x, t=target: np.log(max(of(x), _TINY)) - t, low, high, xtol=1e-12, rtol=1e-12))
        return np.array(found).reshape(wanted.shape)[()]
