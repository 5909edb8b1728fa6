"""Extremes from the maxima of blocks, by Gumbel's distribution, and those of a Gaussian process.

    maxima = block_maxima(result["surge"], 600.0, discard=400.0)
    fit = fit_gumbel(maxima, 600.0)
    fit.return_value(3 * 3600.0), fit.bounds(3 * 3600.0)

Sources: Gumbel (1958), Statistics of Extremes; Coles (2001), An Introduction to Statistical Modeling of Extreme Values;
Cartwright and Longuet-Higgins (1956), Proc. Royal Society A 237; Davenport (1964), Proc. Inst. Civil Engineers 28.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Self

import numpy as np

from fowtlib.analysis.crossings import count_up_crossings, gaussian_rate
from fowtlib.analysis.maximum import Maximum, checked_sample, sign_of
from fowtlib.analysis.series import as_records
from fowtlib.language.errors import ModelError

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from numpy.typing import ArrayLike

    from fowtlib.analysis.series import Records, Series

FEWEST_MAXIMA = 5
METHODS = ("moments", "likelihood")


def block_maxima(records: Records, block: float, *, side: str = "max", discard: float = 0.0) -> np.ndarray:
    """Largest (side "max") or smallest value of each block of `block` seconds, of one record or a list of several.

    A last block that is not whole is left out. Blocks should be many correlation times long, so that their maxima are
    independent.
    """
    return np.concatenate([_block_maxima(record, block, sign_of(side)) for record in as_records(records, discard)])


def _block_maxima(record: Series, block: float, sign: float) -> np.ndarray:
    since = record.time - record.time[0]
    step = float(since[-1]) / (since.size - 1)
    count = int((since[-1] + step) / block + 1e-9) if block > 0.0 else 0
    if count < 1 or block < step:
        raise ModelError(
            f"{record.name}: a record of {since[-1]:g} s at steps of {step:g} s has no block of {block:g} s."
        )
    index = np.floor(since / block + 1e-9).astype(int)
    highest = np.full(count, -np.inf)
    inside = index < count
    np.maximum.at(highest, index[inside], sign * record.values[inside])
    return sign * highest


@dataclass(frozen=True)
class Gumbel(Maximum):
    """Largest value in a block of `duration` seconds, F(x) = exp(-exp(-(x - location) / scale)).

    In another time T it is of the same form, with the location moved by scale ln(T / duration).
    """

    location: float
    scale: float
    duration: float
    method: str = ""

    def rate(self, level: ArrayLike) -> np.ndarray:
        away = self.sign * (np.asarray(level, dtype=float) - self.location)
        return np.exp(-away / self.scale) / self.duration

    def level(self, rate: float) -> float:
        return float(self.location - self.sign * self.scale * np.log(rate * self.duration))

    def expected(self, duration: float | None = None) -> float:
        """Mean of the extreme value in `duration` [s]; of one block by default."""
        longer = 1.0 if duration is None else duration / self.duration
        return float(self.location + self.sign * self.scale * (np.euler_gamma + np.log(longer)))

    @property
    def std(self) -> float:
        """Standard deviation of the extreme value, the same for any duration."""
        return float(self.scale * np.pi / np.sqrt(6.0))

    def again(self, rng: np.random.Generator, parametric: bool) -> Self:
        count = self.sample.size
        if parametric:
            drawn = self.location + self.sign * rng.gumbel(0.0, self.scale, count)
        else:
            drawn = rng.choice(self.sample, count)
        return fit_gumbel(drawn, self.duration, method=self.method, side=self.side)

    def plot(self, path: str | Path | None = None, **options: Any) -> Figure:
        """Gumbel paper with the maxima, the fit and its confidence bounds; options of pictures.plot_gumbel."""
        from fowtlib.analysis.pictures import plot_gumbel

        return plot_gumbel(self, path, **options)


def fit_gumbel(
    maxima: ArrayLike, duration: float, *, method: str = "moments", side: str = "max", name: str = "", unit: str = "1"
) -> Gumbel:
    """Gumbel's distribution of maxima in blocks of `duration` [s], or of one per run of that length.

    method  "moments": scale = sqrt(6) s / pi with the standard deviation s of the sample (n - 1), location = mean -
            0.57722 scale; "likelihood": most likely values (scipy)
    side    "min" when the values are minima
    Raises ModelError for fewer than 5 values, values that are not finite, and values that are all equal.
    """
    sign = sign_of(side)
    sample = checked_sample(maxima, FEWEST_MAXIMA, f"{name or 'the series'}, {side}ima of blocks")
    if method == "moments":
        scale = float(np.sqrt(6.0) / np.pi * sample.std(ddof=1))
        location = float(sample.mean()) - sign * float(np.euler_gamma) * scale
    elif method == "likelihood":
        from scipy.stats import gumbel_r

        location, scale = map(float, gumbel_r.fit(sign * sample))
        location *= sign
    else:
        raise ModelError(f"Gumbel's distribution is fitted by 'moments' or by 'likelihood', not by '{method}'.")
    if not duration > 0.0:
        raise ModelError(f"the duration of a block must be above 0, not {duration:g} s.")
    return Gumbel(location, scale, float(duration), method, sign=sign, unit=unit, name=name, sample=sample)


@dataclass(frozen=True)
class GaussianMaximum(Maximum):
    """Largest value of a Gaussian process with `mean`, `std` and the rate [1/s] at which it passes its mean upward.

    F(y; T) = exp(-nu_0 T exp(-(y - mean)^2 / (2 std^2))), of levels above the mean (of a minimum, below it).
    """

    mean: float
    std: float
    mean_rate: float
    plain_only = "the extreme of a Gaussian process"

    def rate(self, level: ArrayLike) -> np.ndarray:
        """At and inside of the mean it is that of the mean: F is then an upper bound, and next to nothing."""
        away = np.maximum(self.sign * (np.asarray(level, dtype=float) - self.mean), 0.0)
        return gaussian_rate(away, 0.0, self.std, self.mean_rate)

    def level(self, rate: float) -> float:
        if not rate < self.mean_rate:
            raise ModelError(
                f"{self.name or 'the process'}: passes its mean {self.mean_rate:g} times a second only; "
                f"no level beyond is passed {rate:g} times a second. Take a longer duration."
            )
        return self.mean + self.sign * self.std * float(np.sqrt(2.0 * np.log(self.mean_rate / rate)))

    def expected(self, duration: float) -> float:
        """Mean of the extreme value in `duration` [s], mean + std (k + 0.5772 / k), k = sqrt(2 ln(nu_0 T))."""
        k = abs(self.return_value(duration) - self.mean) / self.std
        return float(self.mean + self.sign * self.std * (k + np.euler_gamma / k))

    def again(self, rng: np.random.Generator, parametric: bool) -> Self:
        """Mean, deviation and rate of pieces of the record, drawn with replacement."""
        weights, mean, square, crossings, span = self.sample[rng.integers(0, len(self.sample), len(self.sample))].T
        total = weights.sum()
        middle = float(weights @ mean / total)
        std = float(np.sqrt(weights @ square / total - middle**2))
        return replace(self, mean=middle, std=std, mean_rate=float(crossings.sum() / span.sum()))


def gaussian_maximum(records: Records, *, side: str = "max", discard: float = 0.0, pieces: int = 20) -> GaussianMaximum:
    """Extreme of a series as if it were a Gaussian process: from its mean, deviation and mean crossing rate.

    The check of the other fits where skewness is near 0 and kurtosis near 3. records: one, or a list of several of the
    same process. pieces: into which each record is cut, for bounds.
    """
    series, sign = as_records(records, discard), sign_of(side)
    together = checked_sample(np.concatenate([record.values for record in series]), 3, series[0].name)
    mean = float(together.mean())
    rows = []
    for record in series:
        edges = np.linspace(0, record.values.size - 1, min(pieces, record.values.size - 1) + 1).astype(int)
        for first, last in zip(edges[:-1], edges[1:], strict=True):
            part = record.values[first : last + 1]
            crossings = count_up_crossings(part, [mean])[0]
            span = record.time[last] - record.time[first]
            rows.append((last - first, part[:-1].mean(), (part[:-1] ** 2).mean(), crossings, span))
    _, _, _, crossings, span = np.sum(rows, axis=0)
    if not crossings > 0.0:
        raise ModelError(f"{series[0].name}: never passes its mean upward; the record is too short.")
    return GaussianMaximum(mean, float(together.std()), float(crossings / span), sign=sign, unit=series[0].unit,
                           name=series[0].name, sample=np.array(rows))  # fmt: skip
