"""Extremes from peaks over a threshold, with the generalized Pareto or the exponential distribution.

Sources: Pickands (1975), Annals of Statistics 3; Coles (2001), chapter 4; the default threshold, mean + 1.4 std, after
Moriarty, Holley and Butterfield (2004), NREL/TP-500-34421.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Self

import numpy as np

from fowtlib.analysis.maximum import Maximum, checked_sample, sign_of
from fowtlib.analysis.series import as_records
from fowtlib.language.errors import ModelError

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from fowtlib.analysis.series import Records

FEWEST_PEAKS = 10
THRESHOLD = 1.4  # standard deviations from the mean
_EXPONENTIAL = 1e-9  # a shape below that makes no difference
_LOWEST_SHAPE = -1.0  # below, the likelihood grows without bound as the end of the tail comes to the largest peak


@dataclass(frozen=True)
class Peaks:
    """Largest (or smallest) value of each cluster beyond the threshold, its time, and the length of the record [s]."""

    time: np.ndarray
    values: np.ndarray
    threshold: float
    span: float
    side: str = "max"
    unit: str = "1"
    name: str = ""


def peaks(
    records: Records,
    threshold: float | None = None,
    *,
    side: str = "max",
    separation: float = 0.0,
    discard: float = 0.0,
) -> Peaks:
    """Peaks beyond a threshold; None takes the mean + 1.4 standard deviations (- 1.4 for minima).

    A cluster is what lies beyond the threshold between two passages of the mean. Peaks that are closer than
    `separation` [s] are one, of which the larger stays: slow motions come in groups. Of a list of records of the same
    process, all peaks together, with the threshold and the mean of all.
    """
    series, sign = as_records(records, discard), sign_of(side)
    together = sign * checked_sample(np.concatenate([record.values for record in series]), 3, series[0].name)
    mean = float(together.mean())
    edge = mean + THRESHOLD * float(together.std()) if threshold is None else sign * threshold
    if edge < mean:
        raise ModelError(
            f"{series[0].name}: the threshold {threshold:g} lies on the inner side of the mean {sign * mean:g}, "
            "where clusters of peaks have no meaning. Choose one further out."
        )
    kept = [_peaks(record.time, sign * record.values, mean, edge, separation) for record in series]
    time, values = (np.concatenate([getattr(record, key)[chosen] for record, chosen in zip(series, kept, strict=True)])
                    for key in ("time", "values"))  # fmt: skip
    span = float(sum(record.time[-1] - record.time[0] for record in series))
    return Peaks(time, values, float(sign * edge), span, side, series[0].unit, series[0].name)


def _peaks(time: np.ndarray, values: np.ndarray, mean: float, edge: float, separation: float) -> list[int]:
    above = values > mean
    cluster = np.cumsum(np.r_[False, above[1:] & ~above[:-1]])
    highest = np.full(cluster[-1] + 1, -np.inf)
    np.maximum.at(highest, cluster, values)
    chosen = np.flatnonzero((values == highest[cluster]) & (values > edge))
    chosen = chosen[np.r_[True, np.diff(cluster[chosen]) > 0]] if chosen.size else chosen  # the first of equal ones
    kept: list[int] = []
    for i in map(int, chosen):
        if kept and time[i] - time[kept[-1]] < separation:
            kept[-1] = i if values[i] > values[kept[-1]] else kept[-1]
        else:
            kept.append(i)
    return kept


@dataclass(frozen=True)
class PeakTail(Maximum):
    """Peaks beyond `threshold` at `peak_rate` [1/s], their excess of generalized Pareto distribution.

    nu(y) = peak_rate (1 + shape e / scale)^(-1 / shape) with the excess e = y - threshold; shape 0 is the exponential
    distribution, nu = peak_rate exp(-e / scale); with a shape below 0 nothing lies beyond threshold - scale / shape.
    """

    threshold: float
    scale: float
    shape: float
    peak_rate: float
    fitted_shape: bool = True
    span: float = 0.0

    def rate(self, level: ArrayLike) -> np.ndarray:
        """On the inner side of the threshold it is that of the threshold: F is then an upper bound."""
        excess = np.maximum(self.sign * (np.asarray(level, dtype=float) - self.threshold), 0.0) / self.scale
        if abs(self.shape) < _EXPONENTIAL:
            return self.peak_rate * np.exp(-excess)
        with np.errstate(divide="ignore"):
            return self.peak_rate * np.exp(-np.log1p(np.maximum(self.shape * excess, -1.0)) / self.shape)

    def level(self, rate: float) -> float:
        if not rate <= self.peak_rate:
            raise ModelError(
                f"{self.name or 'the series'}: the level that is passed {rate:g} times a second lies on the inner side "
                f"of the threshold, with {self.peak_rate:g} peaks a second. Lower the threshold, or take a longer "
                "duration."
            )
        return float(self.threshold + self.sign * self._excess(np.log(self.peak_rate / rate)))

    def _excess(self, x: ArrayLike) -> np.ndarray:
        """What one peak in exp(x) exceeds."""
        x = np.asarray(x, dtype=float)
        return self.scale * (x if abs(self.shape) < _EXPONENTIAL else np.expm1(self.shape * x) / self.shape)

    def again(self, rng: np.random.Generator, parametric: bool) -> Self:
        count = rng.poisson(self.sample.size)  # the number of peaks is random too
        if parametric:
            values = self.threshold + self.sign * self._excess(rng.standard_exponential(count))
        else:
            values = rng.choice(self.sample, count)
        found = Peaks(np.zeros(count), values, self.threshold, self.span, self.side, self.unit, self.name)
        return fit_peaks(found, shape=None if self.fitted_shape else self.shape)


def fit_peaks(found: Peaks, *, shape: float | None = None) -> PeakTail:
    """Generalized Pareto distribution of the excess of peaks, by likelihood. shape: 0 for exponential; None fits it.

    The shape is kept at or above -1, where the likelihood has a maximum. Raises ModelError for fewer than 10 peaks, and
    for peaks that are all equal.
    """
    sign = sign_of(found.side)
    what = f"{found.name or 'the series'}, peaks beyond {found.threshold:g}"
    excess = sign * (checked_sample(found.values, FEWEST_PEAKS, what) - found.threshold)
    if excess.min() < 0.0 or not found.span > 0.0:
        raise ModelError(f"{what}: some lie on the inner side of the threshold, or the record has no length.")
    if shape is None:
        fitted, scale = _pareto(excess)
    elif shape == 0.0:
        fitted, scale = 0.0, float(excess.mean())
    else:
        from scipy.stats import genpareto

        fitted, _, scale = map(float, genpareto.fit(excess, f0=shape, floc=0.0))
    return PeakTail(found.threshold, scale, fitted, excess.size / found.span, shape is None, found.span,
                    sign=sign, unit=found.unit, name=found.name, sample=np.asarray(found.values))  # fmt: skip


def _pareto(excess: np.ndarray) -> tuple[float, float]:
    """Most likely shape and scale.

    With theta = shape / scale the most likely shape is mean(ln(1 + theta e)), so that one number is left to search for
    (Davison 1984, Grimshaw 1993); 20 times faster than the general search of scipy.stats.
    """
    from scipy.optimize import minimize_scalar

    mean, largest = float(excess.mean()), float(excess.max())

    def shape(theta: np.ndarray) -> np.ndarray:
        return np.log1p(np.multiply.outer(theta, excess)).mean(axis=-1)

    def loss(theta: np.ndarray) -> np.ndarray:
        theta = np.asarray(theta, dtype=float)
        near = np.abs(theta) * mean < 1e-8
        k = np.where(near, 0.0, shape(theta))
        scale = np.where(near, mean, k / np.where(near, 1.0, theta))
        return np.where(k >= _LOWEST_SHAPE, np.log(scale) + k + 1.0, np.inf)

    lowest = -(1.0 - 1e-9) / largest
    grid = np.concatenate([lowest * np.linspace(1.0, 0.02, 50), np.linspace(0.0, 10.0 / mean, 80)])
    losses = loss(grid)
    best = int(np.argmin(losses))
    around = grid[max(best - 1, 0)], grid[min(best + 1, grid.size - 1)]
    found = minimize_scalar(lambda theta: float(loss(theta)), bounds=around, method="bounded",
                            options={"xatol": 1e-7 / mean})  # fmt: skip
    theta = float(found.x) if found.fun < losses[best] else float(grid[best])
    if abs(theta) * mean < 1e-8:
        return 0.0, mean
    k = float(shape(theta))
    return k, k / theta
