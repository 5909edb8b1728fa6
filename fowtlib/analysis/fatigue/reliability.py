"""Probability of fatigue failure of welds with a design fatigue factor: one weld, a series of them, inspected ones.

A weld fails when its Miner sum passes Delta. Of a life L, designed with the factor F (DFF) by an S-N curve of two
standard deviations below the mean, the sum after the time t is

    D(t) = t / (L F) B^m 10^-(2 s + s u),

with u and B random: u standard normal (the scatter of the S-N curve), B a factor on all stresses. Delta and B are
lognormal, so that one weld has P_F = Phi(-beta) in closed form. In a series, strengths (u, Delta) are independent from
weld to weld and the load B is the same for all.

Inspections that find nothing say that no crack is large: cracks of depth a grow after Paris' law, da/dN = C dK^m, from
an exponential initial depth, and are found with the probability of detection 1 - 1 / (1 + (a / X_0)^b). The growth is
calibrated to the S-N reliability of the same weld, as usual, because both describe one weld.

Sources: H.O. Madsen, S. Krenk, N.C. Lind, Methods of Structural Safety (1986); DNVGL-RP-0001 (2015), Probabilistic
methods for planning of inspection for fatigue cracks, sections 4, 5 and appendix B: scatter 0.2 of log10 N, Delta with
median 1 and coefficient of variation 0.3, initial depth 0.04 mm, X_0 = 0.45 mm and b = 0.90 of magnetic particles and
eddy currents above water under normal working conditions.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq, least_squares
from scipy.special import ndtr, ndtri

from fowtlib.language.errors import ModelError, SimulationError

Floats = NDArray[np.float64]

LOADS, STRENGTHS, DEPTHS = 32, 48, 120  # points of the integrals
FINE, LAST = 2001, 9.0  # points of an integral over the load alone, and its ends in standard deviations
TAIL = 1e-9  # probability below which initial depths are left out
FITTED = (0.25, 0.5, 0.75, 1.0)  # of the life: where the growth of cracks is calibrated
STEEPEST = 12.0  # calibrated scatter of the logarithm of the growth, at most


@dataclass(frozen=True)
class FatigueReliability:
    """Welds of one design fatigue factor; see the module.

    factor     F, design fatigue factor
    life       L, design life [years]
    welds      number of welds in series
    exponent   m of the S-N curve
    scatter    standard deviation s of log10 N of the curve
    miner      coefficient of variation of Delta, median 1
    load       coefficient of variation of B, mean 1
    Raises ModelError for numbers that have no meaning.
    """

    factor: float
    life: float = 20.0
    welds: int = 1
    exponent: float = 3.0
    scatter: float = 0.2
    miner: float = 0.3
    load: float = 0.2

    def __post_init__(self) -> None:
        if not (self.factor > 0 and self.life > 0 and self.exponent > 0):
            raise ModelError("a design fatigue factor, a life and an exponent are above 0.")
        if self.welds < 1 or self.welds % 1 != 0:
            raise ModelError(f"a series has one weld or more, a whole number, not {self.welds}.")
        if min(self.scatter, self.miner, self.load) < 0 or self.scatter == self.miner == 0:
            raise ModelError("scatter, miner and load are 0 or above, and the strength of a weld scatters.")

    @property
    def strength_deviation(self) -> float:
        """Standard deviation of the logarithm of the Miner sum that a weld bears, over the characteristic one."""
        return math.hypot(self.scatter * math.log(10), math.sqrt(math.log(1 + self.miner**2)))

    @property
    def load_deviation(self) -> float:
        """Standard deviation of ln(B^m)."""
        return self.exponent * math.sqrt(math.log(1 + self.load**2))

    def margin(self, time: float) -> float:
        """Mean of ln(Delta / D): what is left in the median after a time [years]."""
        if not time > 0:
            raise ModelError(f"reliability is asked for after a time above 0 years, not {time:g}.")
        mean_load = -self.exponent * math.log(1 + self.load**2) / 2  # of ln(B^m), where B has the mean 1
        return math.log(self.life * self.factor / time) + 2 * self.scatter * math.log(10) - mean_load

    def failure_probability(self, time: float) -> float:
        """Probability that one weld or more of the series has failed after a time [years]."""
        if self.welds == 1:
            deviation = math.hypot(self.strength_deviation, self.load_deviation)
            return float(ndtr(-self.margin(time) / deviation))
        load = np.linspace(-LAST, LAST, FINE)  # the trapezoidal rule, exact for what is smooth and falls off
        weights = np.exp(-(load**2) / 2)
        weights /= weights.sum()
        each = ndtr((self.load_deviation * load - self.margin(time)) / self.strength_deviation)
        return float(weights @ -np.expm1(self.welds * np.log1p(-np.minimum(each, 1 - 1e-16))))

    def reliability_index(self, time: float) -> float:
        """Beta = -Phi^-1(P_F) after a time [years]."""
        return float(-ndtri(self.failure_probability(time)))

    def annual_probability(self, time: float) -> float:
        """Probability of failing in the year that ends at a time [years], of those that have not failed before."""
        if not time > 1:
            raise ModelError(f"a year ends after more than 1 year, not {time:g}.")
        before = self.failure_probability(time - 1)
        return (self.failure_probability(time) - before) / (1 - before)


def factor_for(reliability_index: float, time: float, like: FatigueReliability) -> float:
    """The design fatigue factor at which a series like this one has a reliability index after a time [years].

    Raises ModelError for an index that no factor between 1e-6 and 1e6 gives.
    """

    def lacks(logarithm: float) -> float:
        return _with_factor(like, math.exp(logarithm)).reliability_index(time) - reliability_index

    ends = math.log(1e-6), math.log(1e6)
    if not lacks(ends[0]) < 0 < lacks(ends[1]):
        raise ModelError(f"no design fatigue factor between 1e-6 and 1e6 gives an index of {reliability_index:g}.")
    return math.exp(brentq(lacks, *ends, xtol=1e-12))


def equivalent_factor(series: FatigueReliability, time: float) -> float:
    """The factor with which one weld would be as reliable after a time [years] as the whole series is."""
    return factor_for(series.reliability_index(time), time, _with_factor(series, series.factor, welds=1))


@dataclass(frozen=True)
class Inspection:
    """How welds are looked at: detection 1 - 1 / (1 + (a / depth)^exponent) of a crack of depth a.

    depth [mm]: found with probability 1/2; initial_depth [mm]: mean of the exponential depth that cracks start with;
    wall [mm]: depth at which a weld has failed.
    """

    depth: float = 0.45
    exponent: float = 0.90
    initial_depth: float = 0.04
    wall: float = 25.0

    def __post_init__(self) -> None:
        if not (min(self.depth, self.exponent, self.initial_depth) > 0 and self.wall > 10 * self.initial_depth):
            raise ModelError("depths and the exponent are above 0, and the wall is thicker than ten initial cracks.")

    def detection(self, depth: Floats) -> Floats:
        """Probability of detecting cracks of these depths [mm]."""
        return 1 - 1 / (1 + (np.asarray(depth) / self.depth) ** self.exponent)


class InspectedReliability:
    """Reliability of welds at whose inspections nothing was found; see the module.

    The growth of cracks is a_0^(1 - m/2) - a^(1 - m/2) = g t / L, g lognormal with a part of each weld and the load
    B^m of all. Its median and its scatter are those with which one weld is as reliable at FITTED times as by its S-N
    curve. Raises ModelError for an exponent of 2 or less, and for inspections outside of the life; SimulationError
    where no growth is as reliable as the S-N curve.
    """

    def __init__(self, welds: FatigueReliability, inspections: Sequence[float], how: Inspection | None = None):
        if not welds.exponent > 2:
            raise ModelError(f"cracks grow with an exponent above 2, not {welds.exponent:g}.")
        self.welds, self.how = welds, how or Inspection()
        self.inspections = tuple(sorted(float(time) for time in inspections))
        if any(not time > 0 for time in self.inspections):
            raise ModelError("inspections are after more than 0 years.")
        self.power = welds.exponent / 2 - 1
        depth, self._depth_weights = _exponential(self.how.initial_depth, self.how.wall)
        self._start = depth**-self.power
        self._end = self.how.wall**-self.power
        strength, strength_weights = _normal(STRENGTHS)
        load, self._load_weights = _normal(LOADS)
        self._strength_weights = strength_weights
        self.median, self.growth_deviation = self._calibrated()
        growth = np.log(self.median) + self.growth_deviation * strength[None, :] + welds.load_deviation * load[:, None]
        self._growth = np.exp(growth)  # (loads, strengths), over the life

    def _calibrated(self) -> tuple[float, float]:
        """Median and scatter of the growth over a life, from the reliability of one weld by its S-N curve."""
        one = _with_factor(self.welds, self.welds.factor, welds=1)
        times = np.array(FITTED) * one.life
        wanted = np.array([one.reliability_index(time) for time in times])
        points, weights = _normal(4 * STRENGTHS)

        def indices(numbers: Floats) -> Floats:
            deviation = math.hypot(math.exp(numbers[1]), one.load_deviation)
            growth = np.exp(numbers[0] + deviation * points)[:, None] * FITTED
            needed = (growth + self._end) ** (-1 / self.power)  # an initial crack of this depth just fails
            return -ndtri(np.maximum(weights @ np.exp(-needed / self.how.initial_depth), 1e-300))

        typical = math.log(self.how.initial_depth**-self.power)
        found = least_squares(lambda numbers: indices(numbers) - wanted, [typical - 2.0, math.log(0.5)],
                              bounds=([-60.0, -7.0], [60.0, math.log(STEEPEST)]))  # fmt: skip
        worst = float(np.max(np.abs(found.fun)))
        if worst > 0.05:
            raise SimulationError(
                f"no growth of cracks is as reliable as the S-N curve: beta differs by {worst:.2g}; take another "
                "initial depth or wall."
            )
        return math.exp(found.x[0]), math.exp(found.x[1])

    def _alive(self, time: float) -> tuple[NDArray[np.bool_], Floats]:
        """Which (loads, strengths, depths) have not failed after a time, and how deep their cracks are [mm]."""
        left = self._start - self._growth[:, :, None] * (time / self.welds.life)
        alive = left > self._end
        return alive, np.where(alive, np.maximum(left, self._end), self._end) ** (-1 / self.power)

    def failure_probability(self, time: float) -> float:
        """Probability that one weld or more has failed after a time [years], where no inspection before found any."""
        if not time > 0:
            raise ModelError(f"reliability is asked for after a time above 0 years, not {time:g}.")
        weight = self._strength_weights[None, :, None] * self._depth_weights
        weight = np.broadcast_to(weight, (LOADS, STRENGTHS, DEPTHS))
        survived, sure = 1.0, weight
        for until in [*(t for t in self.inspections if t < time), time]:
            alive, depth = self._alive(until)
            before, after = sure.sum(axis=(1, 2)), (sure * alive).sum(axis=(1, 2))
            n, loads = self.welds.welds, self._load_weights
            survived *= float(loads @ after**n / (loads @ before**n))
            sure = sure * alive * (1 - self.how.detection(depth))
        return 1 - survived

    def reliability_index(self, time: float) -> float:
        """Beta = -Phi^-1(P_F) after a time [years]."""
        return float(-ndtri(self.failure_probability(time)))


def present_value(years: Sequence[float], interest: float = 0.05) -> float:
    """What payments of 1 after these years are worth today, at a real rate of interest: sum of (1 + interest)^-t."""
    given = np.asarray(list(years), dtype=float)
    if np.any(given < 0) or not interest > -1 or not np.all(np.isfinite([*given, interest])):
        raise ModelError("years are 0 or later, and an interest is a share such as 0.05.")
    return float(np.sum((1.0 + interest) ** -given))


def break_even_inspection(saved: float, inspections: Sequence[float], instead_of: Sequence[float] = (),
                          interest: float = 0.05) -> float:  # fmt: skip
    """Cost of one inspection up to which a design that needs more of them is the cheaper one.

    saved: what it costs less to build than the other design; inspections and instead_of: the years in which it and the
    other one are inspected. The result is in the unit of `saved`. ModelError where it has not more inspections.
    """
    more = present_value(inspections, interest) - present_value(instead_of, interest)
    if not more > 0:
        raise ModelError("the design that costs less to build has no more inspections; it is the cheaper one anyway.")
    return saved / more


def _with_factor(like: FatigueReliability, factor: float, welds: int | None = None) -> FatigueReliability:
    return replace(like, factor=factor, welds=welds or like.welds)


def _normal(count: int) -> tuple[Floats, Floats]:
    """Points and weights of means over a standard normal number."""
    points, weights = np.polynomial.hermite_e.hermegauss(count)
    return points, weights / weights.sum()


def _exponential(mean: float, most: float) -> tuple[Floats, Floats]:
    """Points and weights of means over an exponential depth, close where few are deeper."""
    last = min(-math.log(TAIL), most / mean)
    near, far = DEPTHS // 4, 3 * DEPTHS // 4
    edges = np.concatenate([np.linspace(0.0, 1.0, near, endpoint=False), np.linspace(1.0, last, far + 1)])
    weights = -np.diff(np.exp(-edges))
    middle = (edges[:-1] + 1) * np.exp(-edges[:-1]) - (edges[1:] + 1) * np.exp(-edges[1:])
    return mean * middle / weights, weights / weights.sum()
