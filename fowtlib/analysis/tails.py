"""Extremes from the rates at which a series passes many levels upward, extrapolated by nu(y) = q exp(-a (y - b)^c).

Source: Naess and Gaidai (2008), Journal of Engineering Mechanics 134, 628-636; Naess and Moan (2012), Stochastic
Dynamics of Marine Structures, chapter 10. A Gaussian process has c = 2, b = mean, q = the rate of the mean.
"""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Self

import numpy as np

from fowtlib.analysis.case_statistics import CROSSING_STEP
from fowtlib.analysis.crossings import count_in_pieces
from fowtlib.analysis.kept import KeptRuns, kept_runs
from fowtlib.analysis.maximum import Maximum, checked_sample, sign_of
from fowtlib.analysis.peaks import THRESHOLD
from fowtlib.analysis.series import as_records
from fowtlib.language.errors import ModelError, did_you_mean

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from numpy.typing import ArrayLike

    from fowtlib.analysis.series import Records

LEVELS = 40
FEWEST_LEVELS = 6
_HALF_WIDTH = 1.96  # of a 95 % interval, in standard deviations
_LARGEST_POWER = 5.0
_SMALLEST_POWER = 0.5


@dataclass(frozen=True)
class CrossingRates:
    """Counts of outward passages, (pieces, levels), in pieces of records that are spans [s] long."""

    levels: np.ndarray
    counts: np.ndarray
    spans: np.ndarray
    lowest: float  # of all values, times the sign

    @property
    def rate(self) -> np.ndarray:
        """Passages per second of all pieces together."""
        return self.counts.sum(axis=0) / self.spans.sum()

    @property
    def half_width(self) -> np.ndarray:
        """Half of the 95 % confidence interval of the rate, 1.96 s / sqrt(j) over j pieces.

        At least that of Poisson's law, so that pieces which happen to agree do not look certain.
        """
        pieces = len(self.spans)
        spread = (self.counts / self.spans[:, None]).std(axis=0, ddof=1) / np.sqrt(pieces) if pieces > 1 else 0.0
        return _HALF_WIDTH * np.maximum(spread, np.sqrt(self.rate / self.spans.sum()))

    def certain(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Levels whose lower bound C- is above 0, ln of their rates, and weights 1 / (ln C+ - ln C-) for a fit."""
        nu, half = self.rate, self.half_width
        used = nu > half
        nu, half = nu[used], half[used]
        return self.levels[used], np.log(nu), 1.0 / np.log((nu + half) / (nu - half))


@dataclass(frozen=True)
class CrossingTail(Maximum):
    """nu(y) = q exp(-a (y - b)^c) beyond `threshold`; of minima y - b counts downward."""

    q: float
    a: float
    b: float
    c: float
    threshold: float
    plain_only = "a fit to up-crossing rates"

    def rate(self, level: ArrayLike) -> np.ndarray:
        """On the inner side of the threshold it is that of the threshold: F is then an upper bound."""
        away = self.sign * (np.asarray(level, dtype=float) - self.b)
        return self.q * np.exp(-self.a * np.maximum(away, self.sign * (self.threshold - self.b)) ** self.c)

    def level(self, rate: float) -> float:
        most = float(self.rate(self.threshold))
        if not rate <= most * (1.0 + 1e-12):
            raise ModelError(
                f"{self.name or 'the series'}: the level that is passed {rate:g} times a second lies on the inner side "
                f"of the threshold, which is passed {most:g} times. Lower the threshold, or take a longer duration."
            )
        return float(self.b + self.sign * (np.log(self.q / rate) / self.a) ** (1.0 / self.c))

    def again(self, rng: np.random.Generator, parametric: bool) -> Self:
        """The fit to pieces of the records, drawn with replacement."""
        rates: CrossingRates = self.sample
        drawn = rng.integers(0, len(rates.spans), len(rates.spans))
        again = CrossingRates(rates.levels, rates.counts[drawn], rates.spans[drawn], rates.lowest)
        return fit_rates(again, side=self.side, unit=self.unit, name=self.name, start=(self.b, self.c))

    def plot(self, path: str | Path | None = None, **options: Any) -> Figure:
        """Rates with their confidence over the level, and the fit; options of pictures.plot_crossings."""
        from fowtlib.analysis.pictures import plot_crossings

        return plot_crossings(self, path, **options)


def crossing_rates(
    records: Records,
    threshold: float | None = None,
    *,
    side: str = "max",
    discard: float = 0.0,
    levels: int = LEVELS,
    pieces: int = 10,
) -> CrossingRates:
    """Rates at which one record, or several of the same process, pass `levels` levels from the threshold outward.

    threshold  begin of the tail; None: mean + 1.4 standard deviations (- 1.4 for minima)
    pieces     into which each record is cut, to see how certain the rates are; long against the slowest motion
    """
    series, sign = as_records(records, discard), sign_of(side)
    values = [sign * record.values for record in series]
    together = np.concatenate(values)
    checked_sample(together, 3, series[0].name)
    begin = together.mean() + THRESHOLD * together.std() if threshold is None else sign * threshold
    end = together.max()
    if not begin < end:
        raise ModelError(f"{series[0].name}: nothing lies beyond the threshold {sign * begin:g}.")
    heights = np.linspace(begin, end, levels, endpoint=False)
    counted = [count_in_pieces(record.time, part, heights, pieces) for record, part in zip(series, values, strict=True)]
    counts, spans = (np.concatenate(parts) for parts in zip(*counted, strict=True))
    return CrossingRates(sign * heights, counts, spans, float(together.min()))


def rates_of_case(
    told: Mapping[str, Any], name: str, *, side: str = "max", threshold: float = THRESHOLD
) -> CrossingRates:
    """Rates of a channel from the output of `case_statistics`, `threshold` standard deviations off the mean and beyond.

    One record in one piece, so that the rates are as certain as Poisson's law says.
    """
    if name not in told["channels"]:
        why = told.get("refused", {}).get(name)
        raise ModelError(f"{name}: {why}" if why else
                         f"the statistics have no channel '{name}'{did_you_mean(name, told['channels'])}")  # fmt: skip
    runs = kept_runs([told["channels"][name]], [told["last"] - told["first"]], name, side)
    rates = rates_of_runs(runs, name, threshold)
    return replace(rates, levels=sign_of(side) * rates.levels)


def rates_of_runs(runs: KeptRuns, name: str, threshold: float = THRESHOLD) -> CrossingRates:
    """Rates at which runs pass levels from `threshold` standard deviations above the mean on, each run in one piece."""
    first = int(np.ceil(threshold / CROSSING_STEP - 1e-9))
    last = max(int(np.floor((mean + std * CROSSING_STEP * steps[-1] - runs.mean) / (runs.std * CROSSING_STEP) + 1e-9))
               for mean, std, steps, _ in runs.passed)  # fmt: skip
    levels = runs.mean + runs.std * CROSSING_STEP * np.arange(first, max(last, first))
    if not levels.size:
        raise ModelError(f"{name}: nothing lies beyond {threshold:g} standard deviations.")
    return CrossingRates(levels, runs.passages(levels), runs.spans, runs.lowest)


def fit_crossings(
    records: Records,
    threshold: float | None = None,
    *,
    side: str = "max",
    discard: float = 0.0,
    levels: int = LEVELS,
    pieces: int = 10,
) -> CrossingTail:
    """Tail of the rates of one record, or of several of the same process; arguments of `crossing_rates`.

    Raises ModelError where fewer than 6 levels are passed often enough to be certain.
    """
    rates = crossing_rates(records, threshold, side=side, discard=discard, levels=levels, pieces=pieces)
    first = as_records(records)[0]
    return fit_rates(rates, side=side, unit=first.unit, name=first.name)


def fit_rates(
    rates: CrossingRates,
    *,
    side: str = "max",
    unit: str = "1",
    name: str = "",
    start: tuple[float, float] | None = None,
) -> CrossingTail:
    """Least squares of w (ln nu_i - ln q + a (y_i - b)^c)^2, w = (ln C+ - ln C-)^-2 of the 95 % bounds C of a rate.

    Levels whose lower bound is not above 0 are left out. For given b and c the best ln q and a follow from a linear
    regression, so that two numbers are searched for: b between the lowest value of the record and the threshold, c
    between 0.5 and 5, with a warning at 0.5. start: b and c, for the search.
    """
    from scipy.optimize import least_squares

    sign = sign_of(side)
    used, log_rate, weight = rates.certain()  # weight: the root of w
    if used.size < FEWEST_LEVELS:
        raise ModelError(
            f"{name or 'the series'}: only {used.size} levels beyond {rates.levels[0]:g} are passed often "
            f"enough to be certain, and a fit takes {FEWEST_LEVELS}. Take longer or more records, or a threshold "
            "nearer to the mean."
        )
    y = sign * used
    begin = float(y[0])
    size = float(y[-1]) - begin
    low, high = np.array([min(rates.lowest, begin - size), _SMALLEST_POWER]), np.array([begin, _LARGEST_POWER])

    def regression(b: float, c: float) -> tuple[float, float, np.ndarray]:
        """The best ln q and a, and the weighted differences."""
        x = np.maximum((y - b) / size, 0.0) ** c
        w = weight**2 / np.sum(weight**2)
        middle, mean = w @ x, w @ log_rate
        slope = -(w @ ((x - middle) * (log_rate - mean))) / (w @ (x - middle) ** 2)
        return mean + slope * middle, slope, weight * (log_rate - mean + slope * (x - middle))

    tries = [(sign * start[0], start[1])] if start else [(0.5 * (low[0] + begin), c) for c in (1.0, 2.0)]
    found = min(
        (least_squares(lambda z: regression(*z)[2], np.clip(z, low, high), bounds=(low, high), x_scale=(size, 1.0))
         for z in tries), key=lambda one: one.cost)  # fmt: skip
    b, c = map(float, found.x)
    log_q, slope, _ = regression(b, c)
    if start is None and c <= _SMALLEST_POWER * (1.0 + 1e-6):
        warnings.warn(
            f"{name or 'the series'}: the power c of the tail lies at its least, {c:g}: the rates fall more and more "
            "slowly, as of a mixture of two processes. Choose a threshold further out.",
            stacklevel=3,
        )
    if not slope > 0.0:
        raise ModelError(f"{name or 'the series'}: the rates do not fall beyond {rates.levels[0]:g}; there is no tail.")
    return CrossingTail(float(np.exp(log_q)), float(slope / size**c), sign * b, c, float(rates.levels[0]),
                        sign=sign, unit=unit, name=name, sample=rates)  # fmt: skip
