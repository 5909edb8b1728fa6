"""One shape of the tail for all states of a wind speed: rates of up-crossings over the own mean and deviation.

An hour of a slow motion is too short for a tail of its own: read ten deviations further out, what scatters high
decides. All states of one wind speed together have a hundred hours. Each state keeps its mean m, its deviation s and
the rate nu_0 at which it passes its mean; what they share is the rate over (x - m) / s, relative to nu_0:

    nu(x) = nu_0 q exp(-a ((x - m) / s - b)^c)
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Hashable, Iterable
from contextlib import suppress
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from fowtlib.language.errors import ModelError

if TYPE_CHECKING:
    from fowtlib.analysis.kept import KeptRuns
    from fowtlib.analysis.tails import CrossingRates

LEVELS = np.arange(1.4, 8.01, 0.1)  # deviations above the mean at which passages are counted
EXPONENTIAL = "an exponential tail in place of one that falls slower"
GAUSSIAN = "as of a Gaussian process, for want of a tail,"
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
    """Collects counts of passages of one response, run by run, so that no series has to be kept."""

    def __init__(self, name: str = "") -> None:
        self.name = name  # for messages
        self.states: dict[Hashable, _Own] = {}
        self.counts: dict[float, list[np.ndarray]] = {}
        self.spans: dict[float, list[float]] = {}
        self.mean_passages: dict[float, float] = {}
        self.lowest: dict[float, float] = {}

    def add(self, key: Hashable, group: float, records: list[Any]) -> None:
        """The runs of a state, which belongs to a group such as its wind speed."""
        from fowtlib.analysis.crossings import count_in_pieces, count_up_crossings
        from fowtlib.analysis.kept import is_constant
        from fowtlib.analysis.series import as_records

        series = as_records(records)
        together = np.concatenate([record.values for record in series])
        mean, std = float(together.mean()), float(together.std())
        if is_constant(mean, std):
            raise ModelError(f"{series[0].name} does not change; name the results to evaluate with --results.")
        values = [(record.values - mean) / std for record in series]
        pieces = [count_in_pieces(one.time, part, LEVELS, PIECES) for one, part in zip(series, values, strict=True)]
        counts, spans = (np.concatenate(parts) for parts in zip(*pieces, strict=True))
        passages = sum(int(count_up_crossings(part, [0.0])[0]) for part in values)
        lowest = float((together.min() - mean) / std)
        self._keep(key, group, mean, std, passages, counts, spans, lowest)

    def add_kept(self, key: Hashable, group: float, runs: KeptRuns) -> None:
        """The runs of a state by what `case_statistics` has kept of them; they are not cut into pieces."""
        passages = float(runs.passages([runs.mean]).sum())
        counts = runs.passages(runs.mean + LEVELS * runs.std)
        lowest = (runs.lowest - runs.mean) / runs.std
        self._keep(key, group, runs.mean, runs.std, passages, counts, runs.spans, lowest)

    def _keep(
        self,
        key: Hashable,
        group: float,
        mean: float,
        std: float,
        passages: float,
        counts: Iterable[np.ndarray],
        spans: np.ndarray,
        lowest: float,
    ) -> None:
        """passages: of the mean. counts, spans [s]: of each piece. lowest: in deviations from the mean."""
        self.states[key] = _Own(mean, std, passages / float(spans.sum()))
        self.mean_passages[group] = self.mean_passages.get(group, 0.0) + passages
        self.counts.setdefault(group, []).extend(counts)
        self.spans.setdefault(group, []).extend(spans)
        self.lowest[group] = min(self.lowest.get(group, 0.0), lowest)

    def tails(self, group_of: Callable[[Hashable], float]) -> tuple[dict[Hashable, Tail], Counter[str]]:
        """The tail of each state; and for how many groups it is EXPONENTIAL or GAUSSIAN, for want of a better."""
        shapes: dict[float, Tail] = {}
        kinds: Counter[str] = Counter()
        for group in self.counts:
            shapes[group], kind = self._shape(group)
            kinds[kind] += 1
        found = {}
        for key, (mean, std, own) in self.states.items():
            q, a, b, c, threshold = shapes[group_of(key)]
            found[key] = Tail(own * q, a / std**c, mean + std * b, c, mean + std * threshold)
        return found, kinds

    def _shape(self, group: float) -> tuple[Tail, str]:
        """Over the mean and in deviations, relative to the rate at which the mean is passed; and its kind."""
        from fowtlib.analysis.tails import CrossingRates

        rate = self.mean_passages[group] / sum(self.spans[group])
        rates = CrossingRates(LEVELS, np.array(self.counts[group]), np.array(self.spans[group]), self.lowest[group])
        if rate > 0:
            with suppress(ModelError):
                tail, kind = tail_of(rates, self.name)
                return tail._replace(q=tail.q / rate), kind
        return Tail(1.0, 0.5, 0.0, 2.0, 0.0), GAUSSIAN


def tail_of(rates: CrossingRates, name: str) -> tuple[Tail, str]:
    """The tail that fits the rates, and "", or EXPONENTIAL where that falls slower. ModelError without a tail."""
    from fowtlib.analysis.tails import fit_rates

    fit = fit_rates(rates, name=name)
    if fit.c < 1:
        return exponential(rates), EXPONENTIAL
    return Tail(fit.q, fit.a, fit.b, fit.c, fit.threshold), ""


def exponential(rates: CrossingRates) -> Tail:
    """Least squares with c = 1, and the weights of `fit_rates`.

    A tail that falls slower than this comes from levels that a few slow motions have passed; far beyond the data it
    has no end. Raises ModelError where the rates do not fall.
    """
    y, log_rate, weight = rates.certain()
    slope, at_zero = np.polyfit(y - y[0], log_rate, 1, w=weight)
    if not slope < 0:
        raise ModelError("the rates do not fall.")
    return Tail(float(np.exp(at_zero)), float(-slope), float(y[0]), 1.0, float(y[0]))
