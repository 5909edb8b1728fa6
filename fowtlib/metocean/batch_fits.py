"""Laws of extremes from a batch: of the largest values of its runs, or of the up-crossings in its results."""

from __future__ import annotations

import warnings
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from typing import Any, Protocol

import numpy as np

from fowtlib.language.errors import ModelError, did_you_mean
from fowtlib.metocean.fits import Fits
from fowtlib.metocean.pooled_tails import EXPONENTIAL, GAUSSIAN, Pool, Tail, tail_of
from fowtlib.metocean.short_term import Gumbel, UpCrossings
from fowtlib.metocean.states import COLUMNS, State, States

LAWS = ("gumbel", "pooled", "rates", "gaussian")


class Row(Protocol):
    """What is known of a case that was run; `fowtlib.cases.Row` is one."""

    name: str
    state: str
    simulated: float | None
    statistics: Mapping[str, Mapping[str, Any]]
    case: Any


class Batch(Protocol):
    """Cases that were run; `fowtlib.cases.Batch` is one."""

    folder: Any

    def rows(self) -> list[Any]: ...
    def path(self, name: str) -> Any: ...
    def result(self, name: str) -> Any: ...


def fits_of_batch(
    batch: Batch,
    responses: Sequence[str] | None = None,
    law: str | None = None,
    duration: float = 3600.0,
    progress: Callable[[int, int], None] = lambda done, total: None,
) -> dict[str, Fits]:
    """By response, the law of its largest value in `duration` [s] in each state of the batch.

    responses: names of results; None is all. law: "gumbel" by
    moments from the maxima of several runs of a state. The others take the rates of up-crossings in all its runs: with
    one shape of the tail at each wind speed ("pooled"), a tail of each state ("rates"), or as of a Gaussian process
    ("gaussian"); a tail that falls slower than exponential is taken as such, and where there is none, the process is
    taken as Gaussian. None is the first where each state has two runs or more, else the second. A case is known as a
    state by its labels wind_speed, Hs and Tp, and as a bin by its label probability.
    """
    groups = _groups(batch)
    known = list(dict.fromkeys(name for row in next(iter(groups.values())) for name in row.statistics))
    for name in responses or ():
        if name not in known:
            raise ModelError(f"{batch.folder}: there is no result '{name}'{did_you_mean(name, known)}")
    fewest = min(len(rows) for rows in groups.values())
    chosen = law or ("gumbel" if fewest > 1 else "pooled")
    if chosen == "gumbel" and fewest < 2:
        raise ModelError(f"{batch.folder}: a state has one run alone; a Gumbel law needs several. Take --law pooled.")
    names = list(responses or known)
    for row in (row for rows in groups.values() for row in rows):
        for name in names:
            if name not in row.statistics:
                raise ModelError(
                    f"{batch.folder}: the case '{row.name}' has no statistics of '{name}'; name others with --results."
                )
    if chosen == "gumbel":
        return _gumbel(batch, groups, names, duration)
    return _rates(batch, groups, names, duration, chosen, progress)


Key = tuple["State", float | None]


def _groups(batch: Batch) -> dict[Key, list[Row]]:
    """The runs of each state that are done."""
    groups: dict[Key, list[Row]] = {}
    missing: dict[Key, int] = {}
    for row in batch.rows():
        labels: Any = row.case.labels
        absent = [name for name in COLUMNS if not isinstance(labels.get(name), (int, float))]
        if absent:
            raise ModelError(
                f"{batch.folder}: the case '{row.name}' has no label {', '.join(absent)}; the cases of `fowt extremes "
                "--cases` have."
            )
        key = State(*(float(labels[name]) for name in COLUMNS)), labels.get("probability")
        if row.state == "done":
            groups.setdefault(key, []).append(row)
        else:
            missing[key] = missing.get(key, 0) + 1
    if not groups:
        raise ModelError(f"{batch.folder}: no case is done yet.")
    if missing:
        lost = sum(key[1] or 0.0 for key in missing if key not in groups)
        more = f"; states without any hold {100 * lost:.2g} % of the time and count as harmless" if lost else ""
        warnings.warn(f"{sum(missing.values())} cases of {batch.folder} are not done{more}.", stacklevel=1)
    return groups


def _gumbel(batch: Batch, groups: dict[Key, list[Row]], names: list[str], duration: float) -> dict[str, Fits]:
    spans = {round(row.simulated - (row.case.discard or 0.0), 6) for rows in groups.values() for row in rows
             if row.simulated is not None}  # fmt: skip
    if len(spans) != 1:
        raise ModelError(f"{batch.folder}: the runs are of different length, so that their maxima are not of one kind.")
    longer = duration / spans.pop()

    def law(name: str, keys: list[Key]) -> Gumbel:
        fit = Gumbel.of_runs([row.statistics[name]["max"] for row in groups[key]] for key in keys)
        if not (fit.scale > 0).all():
            raise ModelError(
                f"{batch.folder}: '{name}' has one maximum in all runs of a state; name others with --results."
            )
        return Gumbel(fit.location + fit.scale * np.log(longer), fit.scale)

    return {name: _fits(name, groups, lambda keys, name=name: law(name, keys)) for name in names}


def _rates(
    batch: Batch, groups: dict[Key, list[Row]], names: list[str], duration: float, law: str, progress: Any
) -> dict[str, Fits]:
    tails: dict[str, dict[Any, Tail]] = {name: {} for name in names}
    kinds: dict[str, Counter[str]] = {name: Counter() for name in names}
    pools = {name: Pool(name) for name in names}
    for number, (key, rows) in enumerate(groups.items()):
        if law == "pooled" and len(rows) == 1 and batch.path(rows[0].name) is None:
            _add_kept(pools, key, rows[0])
            progress(number + 1, len(groups))
            continue
        results = [batch.result(row.name) for row in rows]
        for name in names:
            records = [result[name] for result in results]
            if law == "pooled":
                pools[name].add(key, key[0].wind_speed, records)
                continue
            tails[name][key], kind = _tail(name, records) if law == "rates" else (_gaussian(records), "")
            kinds[name][kind] += 1
        progress(number + 1, len(groups))
    if law == "pooled":
        for name, pool in pools.items():
            tails[name], kinds[name] = pool.tails(lambda key: key[0].wind_speed)
    for name, counts in kinds.items():
        places = f"{len(pools[name].counts)} wind speeds" if law == "pooled" else f"{len(groups)} states"
        for kind in (EXPONENTIAL, GAUSSIAN):
            if counts[kind]:
                warnings.warn(f"{name}: {kind} in {counts[kind]} of {places}.", stacklevel=1)
    return {
        name: _fits(name, groups, lambda keys, name=name: UpCrossings.of([tails[name][key] for key in keys], duration))
        for name in names
    }


def _add_kept(pools: dict[str, Pool], key: Key, row: Row) -> None:
    """A run of which statistics alone are kept."""
    span = float(row.simulated or 0.0) - float(row.case.discard or 0.0)
    for name, pool in pools.items():
        try:
            pool.add_kept(key, key[0].wind_speed, row.statistics[name], span)
        except ModelError as error:
            raise ModelError(f"{row.name}: {name}: {error} Name the results to evaluate with --results.") from None


def _tail(name: str, records: list[Any]) -> tuple[Tail, str]:
    """The tail of the rates, and what was made of it where it could not be fitted as it is."""
    from fowtlib.analysis.tails import crossing_rates

    try:
        return tail_of(crossing_rates(records), name)
    except ModelError:
        return _gaussian(records), GAUSSIAN


def _gaussian(records: list[Any]) -> Tail:
    from fowtlib.analysis.extremes import gaussian_maximum

    try:
        plain = gaussian_maximum(records)
    except ModelError as error:
        raise ModelError(f"{error} Name the results to evaluate with --results.") from None
    return Tail(plain.mean_rate, 0.5 / plain.std**2, plain.mean, 2.0, plain.mean)


def _fits(name: str, groups: dict[Key, list[Row]], law: Any) -> Fits:
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
    return Fits(name, unit, bins, part(False), runs if bins and hasattr(bins[1], "location") else None)
