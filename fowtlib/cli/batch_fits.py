"""Laws of extremes from a batch: of the largest values of its runs, or of the up-crossings in its results."""

from __future__ import annotations

import warnings
from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from fowtlib.cli.progress import part_bar
from fowtlib.language.errors import ModelError, did_you_mean

if TYPE_CHECKING:
    from fowtlib.analysis.tails import CrossingRates
    from fowtlib.cases import Batch, Row
    from fowtlib.metocean import Fits, State, States

LAWS = ("gumbel", "rates", "gaussian")
EXPONENTIAL = "an exponential tail in place of one that falls slower"
GAUSSIAN = "as of a Gaussian process, for want of a tail,"


def fits_of_batch(path: Path, responses: Sequence[str] | None, law: str | None, duration: float) -> dict[str, Fits]:
    """By response, the law of its largest value in `duration` [s] in each state of the batch.

    path: of the cases file, or of the folder of the batch. responses: names of results; None is all. law: "gumbel" by
    moments from the maxima of several runs of a state; "rates" from the up-crossings in the results of all its runs,
    exponential where the fitted tail falls slower than that, and as of a Gaussian process where too few levels are
    passed; "gaussian" as of such a process in all states; None is the first where each state has two runs or more, else
    the second. A case is known as a state by its labels wind_speed, Hs and Tp, and as a bin by its label probability.
    """
    from fowtlib.cases import Batch

    folder = path if path.is_dir() else path.with_suffix(".batch")
    if not folder.is_dir():
        raise ModelError(f"{folder}: there is no such folder; begin the batch with fowt batch run {path}.")
    batch = Batch.open(folder)
    groups = _groups(batch)
    known = list(dict.fromkeys(name for row in next(iter(groups.values())) for name in row.statistics))
    for name in responses or ():
        if name not in known:
            raise ModelError(f"{batch.folder}: there is no result '{name}'{did_you_mean(name, known)}")
    fewest = min(len(rows) for rows in groups.values())
    chosen = law or ("gumbel" if fewest > 1 else "rates")
    if chosen == "gumbel" and fewest < 2:
        raise ModelError(f"{batch.folder}: a state has one run alone; a Gumbel law needs several. Take --law rates.")
    names = list(responses or known)
    if chosen == "gumbel":
        return _gumbel(batch, groups, names, duration)
    return _rates(batch, groups, names, duration, fitted=chosen == "rates")


Key = tuple["State", float | None]


def _groups(batch: Batch) -> dict[Key, list[Row]]:
    """The runs of each state that are done."""
    from fowtlib.metocean import State
    from fowtlib.metocean.states import COLUMNS

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
    from fowtlib.metocean import Gumbel

    spans = {round(row.simulated - (row.case.discard or 0.0), 6) for rows in groups.values() for row in rows
             if row.simulated is not None}  # fmt: skip
    if len(spans) != 1:
        raise ModelError(f"{batch.folder}: the runs are of different length, so that their maxima are not of one kind.")
    longer = duration / spans.pop()

    def law(name: str, keys: list[Key]) -> Gumbel:
        fits = [Gumbel.of_maxima([row.statistics[name]["max"] for row in groups[key]]) for key in keys]
        scale = np.array([fit.scale for fit in fits])
        if not (scale > 0).all():
            raise ModelError(
                f"{batch.folder}: '{name}' has one maximum in all runs of a state; name others with --results."
            )
        return Gumbel(np.array([fit.location for fit in fits]) + scale * np.log(longer), scale)

    return {name: _fits(name, groups, lambda keys, name=name: law(name, keys)) for name in names}


def _rates(
    batch: Batch, groups: dict[Key, list[Row]], names: list[str], duration: float, fitted: bool
) -> dict[str, Fits]:
    from fowtlib.metocean import UpCrossings

    tails: dict[str, dict[Key, Any]] = {name: {} for name in names}
    kinds: dict[str, Counter[str]] = {name: Counter() for name in names}
    with part_bar("fitting rates of up-crossings") as report:
        for number, (key, rows) in enumerate(groups.items()):
            results = [batch.result(row.name) for row in rows]
            for name in names:
                records = [result[name] for result in results]
                tails[name][key], kind = _tail(records) if fitted else (_gaussian(records), "")
                kinds[name][kind] += 1
            report(number + 1, len(groups))
    for name, counts in kinds.items():
        for kind in (EXPONENTIAL, GAUSSIAN):
            if counts[kind]:
                warnings.warn(f"{name}: {kind} in {counts[kind]} of {len(groups)} states.", stacklevel=1)
    return {
        name: _fits(name, groups, lambda keys, name=name: UpCrossings.of([tails[name][key] for key in keys], duration))
        for name in names
    }


def _tail(records: list[Any]) -> tuple[Any, str]:
    """The tail of the rates, and what was made of it where it could not be fitted as it is."""
    from fowtlib.analysis.tails import crossing_rates, fit_rates

    try:
        rates = crossing_rates(records)
        tail = fit_rates(rates)
        return (tail, "") if tail.c >= 1 else (_exponential(rates), EXPONENTIAL)
    except ModelError:
        return _gaussian(records), GAUSSIAN


def _gaussian(records: list[Any]) -> _Tail:
    from fowtlib.analysis.extremes import gaussian_maximum

    try:
        plain = gaussian_maximum(records)
    except ModelError as error:
        raise ModelError(f"{error} Name the results to evaluate with --results.") from None
    return _Tail(plain.mean_rate, 0.5 / plain.std**2, plain.mean, 2.0, plain.mean)


def _exponential(rates: CrossingRates) -> _Tail:
    """Least squares with c = 1, and the weights of `fit_rates`.

    A tail that falls slower than this comes from levels that a few slow motions have passed; far beyond the data it
    has no end.
    """
    nu, half = rates.rate, rates.half_width
    used = nu > half
    y, log_rate = rates.levels[used], np.log(nu[used])
    weight = 1.0 / np.log((nu[used] + half[used]) / (nu[used] - half[used]))
    slope, at_zero = np.polyfit(y - y[0], log_rate, 1, w=weight)
    if not slope < 0:
        raise ModelError("the rates do not fall.")
    return _Tail(float(np.exp(at_zero)), float(-slope), float(y[0]), 1.0, float(y[0]))


class _Tail(NamedTuple):
    q: float
    a: float
    b: float
    c: float
    threshold: float


def _fits(name: str, groups: dict[Key, list[Row]], law: Any) -> Fits:
    from fowtlib.metocean import Fits, States

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
