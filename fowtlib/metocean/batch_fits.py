"""Laws of extremes from a batch: of the largest values of its runs, or of the up-crossings in its results."""

from __future__ import annotations

import warnings
from collections import Counter
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from fowtlib.language.errors import ModelError, did_you_mean
from fowtlib.metocean.batch_runs import (
    HINT,
    Batch,
    Key,
    Row,
    groups_of,
    largest_of,
    require_statistics,
    series_of,
    span_of,
    statistics_of,
)
from fowtlib.metocean.fits import Fits
from fowtlib.metocean.pooled_tails import EXPONENTIAL, GAUSSIAN, Pool, Tail, tail_of
from fowtlib.metocean.short_term import Either, Extreme, Gumbel, UpCrossings
from fowtlib.metocean.sides import Sides, check_sides, label, side_of
from fowtlib.metocean.states import States

if TYPE_CHECKING:
    from fowtlib.analysis.kept import KeptRuns
    from fowtlib.analysis.series import Series

LAWS = ("gumbel", "pooled", "rates", "gaussian")


def fits_of_batch(
    batch: Batch,
    responses: Sequence[str] | None = None,
    law: str | None = None,
    duration: float = 3600.0,
    progress: Callable[[int, int], None] = lambda done, total: None,
    side: Sides = "max",
) -> dict[str, Fits]:
    """By response, `Fits.label`, the law of its extreme value in `duration` [s] in each state of the batch.

    responses: names of results; None is all. side: "max", "min" or "abs", of all or by name. law: "gumbel" by
    moments from the maxima of several runs of a state. The others take the rates of up-crossings in all its runs: with
    one shape of the tail at each wind speed ("pooled"), a tail of each state ("rates"), or as of a Gaussian process
    ("gaussian"); a tail that falls slower than exponential is taken as such, and where there is none, the process is
    taken as Gaussian. None is the first where each state has two runs or more, else the second. An absolute value has
    the largest of both sides of each run, or the rates of both sides together. Where a run has no file of results, what
    its statistics have kept stands for it. A case is known as a state by its labels wind_speed, Hs and Tp, and as a bin
    by its label probability.
    """
    groups = groups_of(batch)
    known = list(dict.fromkeys(name for row in next(iter(groups.values())) for name in row.statistics))
    for name in responses or ():
        if name not in known:
            raise ModelError(f"{batch.folder}: there is no result '{name}'{did_you_mean(name, known)}")
    names = list(responses or known)
    check_sides(side, names, str(batch.folder))
    sides = {name: side_of(side, name) for name in names}
    fewest = min(len(rows) for rows in groups.values())
    chosen = law or ("gumbel" if fewest > 1 else "pooled")
    if chosen == "gumbel" and fewest < 2:
        raise ModelError(f"{batch.folder}: a state has one run alone; a Gumbel law needs several. Take --law pooled.")
    require_statistics(batch, groups, names)
    if chosen == "gumbel":
        found = _gumbel(batch, groups, sides, duration)
    else:
        found = _rates(batch, groups, sides, duration, chosen, progress)
    return {each.label: each for each in found}


def _gumbel(batch: Batch, groups: dict[Key, list[Row]], sides: dict[str, str], duration: float) -> list[Fits]:
    spans = {round(span_of(row), 6) for rows in groups.values() for row in rows if row.simulated is not None}
    if len(spans) != 1:
        raise ModelError(f"{batch.folder}: the runs are of different length, so that their maxima are not of one kind.")
    longer = duration / spans.pop()

    def law(name: str, keys: list[Key]) -> Gumbel:
        fit = Gumbel.of_runs([largest_of(row, name, sides[name]) for row in groups[key]] for key in keys)
        if not (fit.scale > 0).all():
            raise ModelError(
                f"{batch.folder}: '{name}' has one maximum in all runs of a state; name others with --results."
            )
        return Gumbel(fit.location + fit.scale * np.log(longer), fit.scale)

    return [_fits(name, side, groups, lambda keys, name=name: law(name, keys)) for name, side in sides.items()]


def _rates(
    batch: Batch, groups: dict[Key, list[Row]], sides: dict[str, str], duration: float, law: str, progress: Any
) -> list[Fits]:
    ends = [(name, end) for name, side in sides.items() for end in (("max", "min") if side == "abs" else (side,))]
    tails: dict[tuple[str, str], dict[Any, Tail]] = {end: {} for end in ends}
    kinds: dict[tuple[str, str], Counter[str]] = {end: Counter() for end in ends}
    pools = {end: Pool(label(*end)) for end in ends}
    for number, (key, rows) in enumerate(groups.items()):
        whole = all(batch.path(row.name) is not None for row in rows)
        results = [batch.result(row.name) for row in rows] if whole else []
        for end in ends:
            runs = series_of(results, *end) if whole else statistics_of(rows, *end)
            if law == "pooled":
                _add(pools[end], key, runs)
                continue
            tails[end][key], kind = _tail(runs, label(*end)) if law == "rates" else (_gaussian(runs, label(*end)), "")
            kinds[end][kind] += 1
        progress(number + 1, len(groups))
    if law == "pooled":
        for end, pool in pools.items():
            tails[end], kinds[end] = pool.tails(lambda key: key[0].wind_speed)
    for end, counts in kinds.items():
        places = f"{len(pools[end].counts)} wind speeds" if law == "pooled" else f"{len(groups)} states"
        for kind in (EXPONENTIAL, GAUSSIAN):
            if counts[kind]:
                warnings.warn(f"{label(*end)}: {kind} in {counts[kind]} of {places}.", stacklevel=1)

    def of(name: str, side: str, keys: list[Key]) -> Extreme:
        if side == "abs":
            return Either(of(name, "max", keys), of(name, "min", keys))
        return UpCrossings.of([tails[name, side][key] for key in keys], duration)

    return [_fits(name, side, groups, lambda keys, name=name, side=side: of(name, side, keys))
            for name, side in sides.items()]  # fmt: skip


def _add(pool: Pool, key: Key, runs: list[Series] | KeptRuns) -> None:
    if isinstance(runs, list):
        pool.add(key, key[0].wind_speed, runs)
    else:
        pool.add_kept(key, key[0].wind_speed, runs)


def _tail(runs: list[Series] | KeptRuns, name: str) -> tuple[Tail, str]:
    """The tail of the rates, and what was made of it where it could not be fitted as it is."""
    from fowtlib.analysis.tails import crossing_rates, rates_of_runs

    try:
        return tail_of(crossing_rates(runs) if isinstance(runs, list) else rates_of_runs(runs, name), name)
    except ModelError:
        return _gaussian(runs, name), GAUSSIAN


def _gaussian(runs: list[Series] | KeptRuns, name: str) -> Tail:
    from fowtlib.analysis.extremes import gaussian_maximum

    try:
        if isinstance(runs, list):
            plain = gaussian_maximum(runs)
            mean, std, rate = plain.mean, plain.std, plain.mean_rate
        else:
            mean, std, rate = runs.mean, runs.std, runs.mean_rate
            if not rate > 0:
                raise ModelError(f"{name}: never passes its mean upward; the runs are too short.")
    except ModelError as error:
        raise ModelError(f"{error} {HINT}") from None
    return Tail(rate, 0.5 / std**2, mean, 2.0, mean)


def _fits(name: str, side: str, groups: dict[Key, list[Row]], law: Any) -> Fits:
    def part(with_probability: bool) -> tuple[States, Any] | None:
        keys = [key for key in groups if (key[1] is not None) == with_probability]
        if not keys:
            return None
        columns = np.array([key[0] for key in keys]).T
        probability = np.array([key[1] for key in keys], dtype=float) if with_probability else None
        return States(*columns, probability), law(keys)

    unit = str(next(iter(groups.values()))[0].statistics[name]["unit"])
    runs = np.array([len(rows) for key, rows in groups.items() if key[1] is not None])
    bins = part(True)
    return Fits(name, unit, bins, part(False), runs if bins and hasattr(bins[1], "location") else None, side)
