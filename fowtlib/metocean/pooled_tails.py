"""One shape of the tail for all states of a wind speed: rates of up-crossings over the own mean and deviation.

An hour of a slow motion is too short for a tail of its own: read ten deviations further out, what scatters high
decides. All states of one wind speed together have a hundred hours. Each state keeps its mean m, its deviation s and
the rate nu_0 at which it passes its mean; what they share is the rate over (x - m) / s, relative to nu_0:

    nu(x) = nu_0 q exp(-a ((x - m) / s - b)^c)
"""

from __future__ import annotations

from collections.abc import Callable, Hashable
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from fowtlib.language.errors import ModelError

if TYPE_CHECKING:
    from fowtlib.analysis.kept import KeptRuns
    from fowtlib.analysis.tails import CrossingRates

LEVELS = np.arange(1.4, 8.01, 0.1)  # deviations above the mean at which passages are counted
PIECES = 10  # into which each run is cut, to see how certain the rates are


class Tail(NamedTuple):
    """nu(x) = q exp(-a (x - b)^c) [1/s] from the threshold on."""

    q: float
    a: float
    b: float
    c: float
    threshold: float


class _Own(NamedTuple):
    """What a state keeps."""

    mean: float
    std: float
    rate: float


class Pool:
    """Collects counts of passages, run by run, so that no series has to be kept."""

    def __init__(self, name: str = "") -> None:
        self.name = name  # for messages
        self.states: dict[Hashable, _Own] = {}
        self.counts: dict[float, list[np.ndarray]] = {}
        self.spans: dict[float, list[float]] = {}
        self.mean_passages: dict[float, float] = {}
        self.lowest: dict[float, float] = {}

    def add(self, key: Hashable, group: float, records: list[Any]) -> None:
        """The runs of a state, which belongs to a group such as its wind speed."""
        from fowtlib.analysis.crossings import count_up_crossings
        from fowtlib.analysis.series import as_records

        series = as_records(records)
        together = np.concatenate([record.values for record in series])
        mean, std = float(together.mean()), float(together.std())
        if not std > 1e-9 * max(abs(mean), 1e-300):
            raise ModelError(f"{series[0].name} does not change; name the results to evaluate with --results.")
        passages, span = 0.0, 0.0
        for record in series:
            values = (record.values - mean) / std
            passages += float(count_up_crossings(values, [0.0])[0])
            span += float(record.time[-1] - record.time[0])
            edges = np.linspace(0, values.size - 1, PIECES + 1).astype(int)
            for first, last in zip(edges[:-1], edges[1:], strict=True):
                self.counts.setdefault(group, []).append(count_up_crossings(values[first : last + 1], LEVELS))
                self.spans.setdefault(group, []).append(float(record.time[last] - record.time[first]))
            self.lowest[group] = min(self.lowest.get(group, 0.0), float(values.min()))
        self.states[key] = _Own(mean, std, passages / span)
        self.mean_passages[group] = self.mean_passages.get(group, 0.0) + passages

    def add_kept(self, key: Hashable, group: float, runs: KeptRuns) -> None:
        """The runs of a state by what `case_statistics` has kept of them; they are not cut into pieces."""
        self.counts.setdefault(group, []).extend(runs.passages(runs.mean + LEVELS * runs.std))
        self.spans.setdefault(group, []).extend(runs.spans)
        self.lowest[group] = min(self.lowest.get(group, 0.0), (runs.lowest - runs.mean) / runs.std)
        self.states[key] = _Own(runs.mean, runs.std, runs.mean_rate)
        passages = runs.mean_rate * float(runs.spans.sum())
        self.mean_passages[group] = self.mean_passages.get(group, 0.0) + passages

    def tails(self, group_of: Callable[[Hashable], float]) -> tuple[dict[Hashable, Tail], int]:
        """The tail of each state; and for how many groups there was none, so that a Gaussian process stands for it."""
        shapes, plain = {}, 0
        for group in self.counts:
            rate = self.mean_passages[group] / sum(self.spans[group])
            shape = self._shape(group, rate)
            plain += shape is None
            shapes[group] = shape or Tail(1.0, 0.5, 0.0, 2.0, 0.0)
        found = {}
        for key, (mean, std, own) in self.states.items():
            q, a, b, c, threshold = shapes[group_of(key)]
            found[key] = Tail(own * q, a / std**c, mean + std * b, c, mean + std * threshold)
        return found, plain

    def _shape(self, group: float, rate: float) -> Tail | None:
        """Over the mean and in deviations, relative to the rate at which the mean is passed; None without a tail."""
        from fowtlib.analysis.tails import CrossingRates, fit_rates

        if not rate > 0:
            return None
        rates = CrossingRates(LEVELS, np.array(self.counts[group]), np.array(self.spans[group]), self.lowest[group])
        try:
            fit = fit_rates(rates, name=self.name)
            tail = exponential(rates) if fit.c < 1 else Tail(fit.q, fit.a, fit.b, fit.c, fit.threshold)
        except ModelError:
            return None
        return tail._replace(q=tail.q / rate)


def exponential(rates: CrossingRates) -> Tail:
    """Least squares with c = 1, and the weights of `fit_rates`.

    A tail that falls slower than this comes from levels that a few slow motions have passed; far beyond the data it
    has no end. Raises ModelError where the rates do not fall.
    """
    nu, half = rates.rate, rates.half_width
    used = nu > half
    y, log_rate = rates.levels[used], np.log(nu[used])
    weight = 1.0 / np.log((nu[used] + half[used]) / (nu[used] - half[used]))
    slope, at_zero = np.polyfit(y - y[0], log_rate, 1, w=weight)
    if not slope < 0:
        raise ModelError("the rates do not fall.")
    return Tail(float(np.exp(at_zero)), float(-slope), float(y[0]), 1.0, float(y[0]))
