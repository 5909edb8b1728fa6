"""The largest value of a stationary series in a given time, through the rate at which the series passes a level.

Passages of a high level are rare and independent, so their number in a time T follows Poisson's law, and the largest
value stays below y with the probability F(y; T) = exp(-nu(y) T). Every kind of fit gives its own rate nu(y):

    Gumbel           extremes.py   maxima of blocks
    GaussianMaximum  extremes.py   mean, deviation and crossing rate of a Gaussian process
    PeakTail         peaks.py      peaks over a threshold
    CrossingTail     tails.py      up-crossing rates of many levels

The smallest value is the same with the sign turned: `side` of the functions that fit. Numbers keep their own sign.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from fowtlib.language.errors import ModelError

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

MOST_PROBABLE = math.exp(-1.0)  # the probability to stay below the level that is passed once per duration on average
SIDES = {"max": 1.0, "min": -1.0}
_REFUSED = 0.05  # part of the samples of a bootstrap that may have no fit


@dataclass(frozen=True)
class Bounds:
    """A value with the bounds of its confidence interval; `samples` of the bootstrap had a fit."""

    value: float
    low: float
    high: float
    confidence: float
    samples: int


@dataclass(frozen=True, kw_only=True)
class Maximum:
    """Base of the distributions of the largest value (sign = 1) or the smallest one (sign = -1) in a time."""

    sign: float = 1.0
    unit: str = "1"
    name: str = ""
    sample: Any = field(default=None, repr=False, compare=False)  # what it was fitted to
    plain_only: ClassVar[str] = ""  # of a fit without a parametric bootstrap: how an error calls it

    @property
    def side(self) -> str:
        return "max" if self.sign > 0 else "min"

    def rate(self, level: ArrayLike) -> np.ndarray:
        """Rate [1/s] at which a level is passed outward: nu(y)."""
        raise NotImplementedError

    def level(self, rate: float) -> float:
        """The level that is passed at this rate [1/s]: the inverse of `rate`."""
        raise NotImplementedError

    def again(self, rng: np.random.Generator, parametric: bool) -> Maximum:
        """The fit to another sample of equal size, drawn from this one or, if parametric, from the fit."""
        raise NotImplementedError

    def distribution(self, level: ArrayLike, duration: float) -> np.ndarray:
        """Probability that nothing in `duration` [s] lies beyond a level, F = exp(-nu T)."""
        return np.exp(-self.rate(level) * _positive(duration, "duration"))

    def return_value(self, duration: float, p: float = MOST_PROBABLE) -> float:
        """What the extreme value in `duration` [s] stays within with probability p.

        The default, 1/e, is the most probable extreme: it is passed once per duration on average.
        """
        if not 0.0 < p < 1.0:
            raise ModelError(f"a probability lies between 0 and 1, not at {p:g}.")
        return self.level(-math.log(p) / _positive(duration, "duration"))

    def bounds(
        self,
        duration: float,
        p: float = MOST_PROBABLE,
        *,
        confidence: float = 0.95,
        count: int = 500,
        seed: int = 0,
        parametric: bool = False,
    ) -> Bounds:
        """Confidence interval of a return value by bootstrap: percentiles of the values of `count` other samples.

        Plain samples are drawn from the data with replacement; parametric ones from the fitted distribution, which
        assumes that it is the right one. Equal seeds give equal bounds. Source: Efron and Tibshirani (1993), An
        Introduction to the Bootstrap.
        """
        (value,) = self.bounds_over(duration, [p], confidence, count, seed, parametric)
        return value

    def bounds_over(
        self,
        duration: float,
        p: Sequence[float],
        confidence: float = 0.95,
        count: int = 500,
        seed: int = 0,
        parametric: bool = False,
    ) -> list[Bounds]:
        """The same for several probabilities with one set of samples."""
        if self.sample is None:
            raise ModelError("there are no confidence bounds without the sample: this distribution was not fitted.")
        if parametric and self.plain_only:
            raise ModelError(f"{self.plain_only} has no parametric bootstrap; take the plain one.")
        if not (0.0 < confidence < 1.0 and count >= 20):
            raise ModelError("a bootstrap takes a confidence between 0 and 1 and at least 20 samples.")
        rng, drawn = np.random.default_rng(seed), []
        for _ in range(count):
            try:
                other = self.again(rng, parametric)
                drawn.append([other.return_value(duration, each) for each in p])
            except ModelError:  # a sample of equal values, or a tail that is too short
                continue
        if len(drawn) < (1.0 - _REFUSED) * count:
            raise ModelError(
                f"{self.name or 'the series'}: {count - len(drawn)} of {count} samples of the bootstrap have no fit: "
                "the data are too few for confidence bounds. Take longer or more records."
            )
        edges = np.quantile(drawn, [0.5 - 0.5 * confidence, 0.5 + 0.5 * confidence], axis=0)
        return [
            Bounds(self.return_value(duration, each), float(low), float(high), confidence, len(drawn))
            for each, low, high in zip(p, *edges, strict=True)
        ]


def sign_of(side: str) -> float:
    """+1 for "max", -1 for "min"."""
    if side not in SIDES:
        raise ModelError(f"the side of an extreme is 'max' or 'min', not '{side}'.")
    return SIDES[side]


def checked_sample(values: ArrayLike, least: int, what: str) -> np.ndarray:
    """The values as an array; ModelError when they are too few, not finite, or all equal. what: "block maxima"."""
    sample = np.asarray(values, dtype=float).ravel()
    if sample.size < least:
        raise ModelError(
            f"{what}: there are {sample.size}, and a fit takes {least} or more. Take longer or more records."
        )
    wrong = np.flatnonzero(~np.isfinite(sample))
    if wrong.size:
        raise ModelError(f"{what}: number {wrong[0] + 1} of {sample.size} is not a finite number.")
    if np.ptp(sample) <= 1e-12 * np.abs(sample).max():
        raise ModelError(f"{what}: all {sample.size} are equal to {sample[0]:g}; a constant has no distribution.")
    return sample


def _positive(value: float, what: str) -> float:
    if not (value > 0.0 and math.isfinite(value)):
        raise ModelError(f"the {what} must be above 0 and finite, not {value:g} s.")
    return value
