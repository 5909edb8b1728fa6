"""Long-term extremes of a response: over all states (FLTA), on a contour (ECM), on several contours (MECM).

FLTA is what the others approximate: F(x) = sum of p_i F_i(x) over all states i, with the law F_i of the extreme within
the state; the extreme of N years is exceeded in one of all its states. ECM takes a fractile in the worst state of the
N-year contour. It misses what happens below that contour when a turbine stops at a wind speed; MECM (Q. Li, Z. Gao, T.
Moan, Modified environmental contour method for predicting long-term extreme responses of bottom-fixed offshore wind
turbines, Marine Structures 48 (2016)) adds the contour that ends at the cut-out speed, of M years: F(x)^(N/M) in its
worst state.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from fowtlib.language.errors import ParameterError
from fowtlib.metocean.contours import cut_off, radius, return_period, surface
from fowtlib.metocean.joint import ConditionalModel
from fowtlib.metocean.short_term import Extreme, Gumbel, ShortTerm
from fowtlib.metocean.states import YEAR, State, States, occurrences


@dataclass(frozen=True)
class LongTerm:
    """Long-term law of the extreme of a response in any one state, from all states with their probabilities.

    States that were left out count as harmless; `states.left_out` is their probability.
    """

    states: States
    laws: Extreme
    duration: float = 3600.0

    def exceedance(self, x: Any) -> Any:
        """Probability that the largest value of any one state exceeds x, a number or an array."""
        values = np.asarray(x, dtype=float)
        rows = np.array([self.states.weights @ self.laws.sf(value) for value in values.ravel()])
        return rows.reshape(values.shape)[()]

    def value(self, years: float) -> float:
        """The value with a return period of so many years: exceeded in one of all states of these years, on average."""
        from scipy.optimize import brentq

        target = 1 / occurrences(years, self.duration)
        total = float(self.states.weights.sum())
        if target >= total:
            raise ParameterError(
                f"the states have the probability {total:.3g} together, less than one in {1 / target:g}."
            )
        ends = np.asarray(self.laws.isf(target / total), dtype=float)[self.states.weights > 0]
        low, high = float(ends.min()), float(ends.max())  # of each law: so the sum lies on both sides
        if not (math.isfinite(low) and math.isfinite(high)):
            raise ParameterError("the short-term law of a state gives no finite extreme.")
        if high - low <= 1e-12 * max(abs(high), abs(low)):
            return high
        smallest = np.finfo(float).tiny
        return float(
            brentq(
                lambda x: math.log(max(self.exceedance(x), smallest) / target),
                low,
                high,
                rtol=1e-12,
                xtol=1e-12 * (high - low),
            )
        )

    def curve(self, years: Sequence[float]) -> np.ndarray:
        """Values with these return periods [years]."""
        return np.array([self.value(each) for each in years])

    def shares(self, x: float) -> np.ndarray:
        """Part of each state in the probability that x is exceeded; of sum 1."""
        parts = self.states.weights * self.laws.sf(x)
        return parts / parts.sum()


@dataclass(frozen=True)
class OnContour:
    """The worst state of a contour.

    value: of the response, the fractile of the law of N years in that state. return_period: of the contour [years].
    values: of all its states.
    """

    value: float
    state: State
    return_period: float
    beta: float
    fractile: float
    states: States = field(repr=False)
    values: np.ndarray = field(repr=False)


def full_long_term(states: States, short_term: ShortTerm, *, duration: float = 3600.0) -> LongTerm:
    """FLTA: states with their probabilities (bins, or a sample) and the short-term law of each."""
    weights = states.weights  # refuses points of a contour
    laws = short_term(states)
    if np.shape(laws.sf(0.0)) not in ((), weights.shape):
        raise ParameterError(f"the short-term law is to give one value for each of {len(states)} states.")
    return LongTerm(states, laws, duration)


def excess_of_fits(found: LongTerm, runs: Any, years: float, *, draws: int = 12, seed: int = 1) -> float:
    """By what factor a value of FLTA is expected to be too high because its Gumbel laws come from few runs each.

    runs: maxima behind each law, (n,) or a number. The scale of a law scatters, and of many states those with too large
    a one decide. The parametric bootstrap draws as many maxima from the fitted laws, fits these, and compares; the
    value over this factor is the estimate without bias, as good as the bootstrap. Of a negative value, such as that of
    a least tension with its sign turned, it is 1 + the excess over its size.
    """
    if not isinstance(found.laws, Gumbel):
        raise ParameterError("the excess of fits is known of Gumbel laws that were fitted to maxima.")
    count = np.broadcast_to(np.asarray(runs, dtype=int), (len(found.states),))
    rng = np.random.default_rng(seed)
    location, scale = (np.broadcast_to(v, count.shape) for v in (found.laws.location, found.laws.scale))
    values = []
    for _ in range(draws):
        again = np.empty((2, count.size))
        for n in np.unique(count):
            some = np.flatnonzero(count == n)
            drawn = Gumbel(location[some, None], scale[some, None]).isf(rng.uniform(size=(some.size, n)))
            law = Gumbel.of_maxima(drawn)
            again[:, some] = law.location, law.scale
        values.append(LongTerm(found.states, Gumbel(*again), found.duration).value(years))
    value = found.value(years)
    return 1.0 + (float(np.mean(values)) - value) / abs(value)


def on_contour(
    states: States, short_term: ShortTerm, *, years: float, beta: float, fractile: float, duration: float = 3600.0
) -> OnContour:
    """Worst of the states of one contour of radius beta, for a return period of so many years.

    Each law is raised to N/M, the number of times that the contour's return period M goes into N years; 1 on their own
    contour.
    """
    if not 0 < fractile < 1:
        raise ParameterError(f"a fractile lies between 0 and 1, and is not {fractile:g}.")
    period = return_period(beta, duration)
    q = -math.expm1(math.log(fractile) * period / years)  # F^(N/M) = p, as a probability of exceedance
    values = np.broadcast_to(np.asarray(short_term(states).isf(q), dtype=float), (len(states),))
    if not np.isfinite(values).all():
        raise ParameterError("the short-term law of a state of the contour gives no finite extreme.")
    worst = int(values.argmax())
    return OnContour(float(values[worst]), list(states)[worst], period, beta, fractile, states, values)


def environmental_contour(
    joint: ConditionalModel,
    short_term: ShortTerm,
    *,
    years: float = 50.0,
    fractile: float = 0.9,
    duration: float = 3600.0,
    states: States | None = None,
    **rings: Any,
) -> OnContour:
    """ECM: the fractile (usually 0.7 to 0.9) of the worst state of the contour; rings: options of `surface`."""
    beta = radius(years, duration)
    chosen = surface(joint, beta, **rings) if states is None else states
    return on_contour(chosen, short_term, years=years, beta=beta, fractile=fractile, duration=duration)


@dataclass(frozen=True)
class Modified:
    """MECM: the largest value of several contours; the first is that of ECM."""

    contours: tuple[OnContour, ...]

    @property
    def worst(self) -> OnContour:
        """The contour that governs."""
        return max(self.contours, key=lambda contour: contour.value)

    @property
    def value(self) -> float:
        """The extreme of the response."""
        return self.worst.value


def modified_contours(
    joint: ConditionalModel,
    short_term: ShortTerm,
    cut_offs: Sequence[float],
    *,
    years: float = 50.0,
    fractile: float = 0.9,
    cut_off_fractile: float = 0.5,
    duration: float = 3600.0,
    **rings: Any,
) -> Modified:
    """MECM: the contour of N years with its fractile, and the contours that end at wind speeds [m/s] with theirs.

    cut_offs: the cut-out speed, and others where the turbine changes what it does; to try several shows how much the
    answer depends on them. rings: options of `surface`, but for wind_speeds.
    """
    found = [environmental_contour(joint, short_term, years=years, fractile=fractile, duration=duration, **rings)]
    for speed in cut_offs:
        beta, period = cut_off(joint, speed, duration)
        if period > years:
            raise ParameterError(
                f"{speed:g} m/s is exceeded once in {period:.4g} years, less often than once in {years:g}: "
                "no contour below that of the return period ends there.",
                where=joint.name,
            )
        states = surface(joint, beta, **rings)
        found.append(
            on_contour(states, short_term, years=years, beta=beta, fractile=cut_off_fractile, duration=duration)
        )
    return Modified(tuple(found))


def years_of(exceedance: Any, duration: float = 3600.0) -> Any:
    """Return period [years] of a probability of exceedance in one state."""
    return duration / YEAR / np.asarray(exceedance, dtype=float)
