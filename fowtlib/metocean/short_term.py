"""Distribution of the extreme of a response within one state, for many states at once.

What the methods of the long term take is a function of `States` that returns an `Extreme`: a frozen distribution of
scipy.stats with parameters of shape (n,), one of the two classes here, or anything with these three methods.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

from fowtlib.language.errors import ParameterError
from fowtlib.metocean.states import State, States


class Extreme(Protocol):
    """Law of the largest value of a response in each of n states; x and q are numbers or arrays (n,)."""

    def cdf(self, x: Any) -> Any: ...
    def sf(self, x: Any) -> Any: ...
    def isf(self, q: Any) -> Any: ...


ShortTerm = Callable[[States], Extreme]
_HALVINGS = 60  # of the interval of a root, to the last digit


@dataclass(frozen=True)
class Gumbel:
    """F(x) = exp(-exp(-(x - location) / scale)), with parameters of shape (n,) in the unit of the response."""

    location: Any
    scale: Any

    @classmethod
    def of_maxima(cls, maxima: Any) -> Gumbel:
        """By the method of moments, from the largest values of runs with different seeds, (n, seeds) or (seeds,)."""
        array = np.asarray(maxima, dtype=float)
        if array.shape[-1] < 2:
            raise ParameterError("a Gumbel law needs the maxima of two runs or more with different seeds.")
        scale = np.sqrt(6) / np.pi * array.std(axis=-1, ddof=1)
        return cls(array.mean(axis=-1) - np.euler_gamma * scale, scale)

    @classmethod
    def of_runs(cls, maxima: Iterable[Any]) -> Gumbel:
        """The same of the runs of each state, of which there may be more in one than in another."""
        laws = [cls.of_maxima(each) for each in maxima]
        return cls(np.array([law.location for law in laws]), np.array([law.scale for law in laws]))

    def cdf(self, x: Any) -> np.ndarray:
        return 1 - self.sf(x)

    def sf(self, x: Any) -> np.ndarray:
        """Probability of a larger value."""
        with np.errstate(over="ignore"):  # far below the location: certain
            return -np.expm1(-np.exp((self.location - np.asarray(x, dtype=float)) / self.scale))

    def isf(self, q: Any) -> np.ndarray:
        """The value that is exceeded with probability q."""
        with np.errstate(divide="ignore"):
            return self.location - self.scale * np.log(-np.log1p(-np.asarray(q, dtype=float)))


@dataclass(frozen=True)
class UpCrossings:
    """From the rate of up-crossings nu(x) = q exp(-a (x - b)^c) [1/s] for x >= threshold: F(x) = exp(-nu(x) duration).

    A Gaussian process with mean b, deviation s and zero-crossing period T has q = 1/T, a = 1/(2 s^2), c = 2. All but
    duration [s] may have the shape (n,). Below the threshold, where the rate was not fitted, every state counts as
    exceeding.
    """

    q: Any
    a: Any
    b: Any
    c: Any
    duration: float = 3600.0
    threshold: Any = None

    @classmethod
    def of(cls, tails: Sequence[Any], duration: float = 3600.0) -> UpCrossings:
        """Of fits to single states, which have q, a, b, c and threshold as attributes, such as those of `analysis`."""
        return cls(*(np.array([float(getattr(tail, name)) for tail in tails]) for name in "qabc"), duration,
                   np.array([float(tail.threshold) for tail in tails]))  # fmt: skip

    def sf(self, x: Any) -> np.ndarray:
        """Probability of a larger value."""
        first = self.b if self.threshold is None else np.maximum(self.threshold, self.b)
        above = np.maximum(np.asarray(x, dtype=float) - self.b, 0.0)
        rate = self.q * np.exp(-self.a * above**self.c)
        return np.where(np.asarray(x) < first, 1.0, -np.expm1(-rate * self.duration))

    def cdf(self, x: Any) -> np.ndarray:
        return 1 - self.sf(x)

    def isf(self, q: Any) -> np.ndarray:
        """The value that is exceeded with probability q; not below the threshold."""
        first = self.b if self.threshold is None else np.maximum(self.threshold, self.b)
        with np.errstate(divide="ignore"):
            rate = -np.log1p(-np.asarray(q, dtype=float)) / self.duration
            above = np.log(self.q / rate) / self.a
        return np.maximum(self.b + np.maximum(above, 0.0) ** (1 / np.asarray(self.c, dtype=float)), first)


class Each:
    """Single laws, one for each state, as one `Extreme`."""

    def __init__(self, laws: Sequence[Extreme]):
        self.laws = tuple(laws)

    def cdf(self, x: Any) -> np.ndarray:
        return self._all("cdf", x)

    def sf(self, x: Any) -> np.ndarray:
        return self._all("sf", x)

    def isf(self, q: Any) -> np.ndarray:
        return self._all("isf", q)

    def _all(self, name: str, values: Any) -> np.ndarray:
        each = np.broadcast_to(values, (len(self.laws),))
        return np.array([float(getattr(law, name)(value)) for law, value in zip(self.laws, each, strict=True)])


@dataclass(frozen=True)
class Either:
    """The larger of two independent values: of a response and of its negative, so that it is the absolute value."""

    one: Extreme
    other: Extreme

    def sf(self, x: Any) -> np.ndarray:
        """Probability of a larger value."""
        first, second = self.one.sf(x), self.other.sf(x)
        return first + second - first * second

    def cdf(self, x: Any) -> np.ndarray:
        return self.one.cdf(x) * self.other.cdf(x)

    def isf(self, q: Any) -> np.ndarray:
        """The value that is exceeded with probability q: it lies between those of q and of q/2 of the single laws."""
        wanted = np.asarray(q, dtype=float)
        low, high = (np.array(np.maximum(self.one.isf(p), self.other.isf(p)), dtype=float)
                     for p in (wanted, wanted / 2))  # fmt: skip
        for _ in range(_HALVINGS):
            middle = 0.5 * (low + high)
            beyond = self.sf(middle) > wanted
            low, high = np.where(beyond, middle, low), np.where(beyond, high, middle)
        return high


def one_by_one(law: Callable[[State], Extreme]) -> ShortTerm:
    """A function of one state (wind speed, wave height, peak period) as a function of many."""
    return lambda states: Each([law(state) for state in states])


def known(states: States, laws: Extreme) -> ShortTerm:
    """Laws that were fitted to runs in these states, as a function; it refuses a state in which there was no run."""
    places = {state: index for index, state in enumerate(states)}

    def find(wanted: States) -> Extreme:
        missing = [state for state in wanted if state not in places]
        if missing:
            u, h, t = missing[0]
            raise ParameterError(
                f"there is no fit for {len(missing)} of {len(wanted)} states; the first is {u:g} m/s, "
                f"Hs {h:.4g} m, Tp {t:.4g} s."
            )
        index = np.array([places[state] for state in wanted])
        return laws if np.array_equal(index, np.arange(len(states))) else _some(laws, index)

    return find


def _some(laws: Extreme, index: np.ndarray) -> Extreme:
    """The laws of some states."""
    if isinstance(laws, Each):
        return Each([laws.laws[i] for i in index])
    if isinstance(laws, Either):
        return Either(_some(laws.one, index), _some(laws.other, index))
    if isinstance(laws, (Gumbel, UpCrossings)):
        some = {key: np.asarray(value)[index] if np.ndim(value) else value for key, value in vars(laws).items()}
        return type(laws)(**some)
    raise ParameterError("these laws cannot be taken apart; give Gumbel, UpCrossings, Either or Each.")
