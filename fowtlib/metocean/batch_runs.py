"""The runs of each state of a batch: their largest values, their series, or what is kept of them."""

from __future__ import annotations

import warnings
from collections.abc import Iterable, Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any, Protocol

from fowtlib.language.errors import ModelError
from fowtlib.metocean.states import COLUMNS, State

if TYPE_CHECKING:
    from fowtlib.analysis.kept import KeptRuns
    from fowtlib.analysis.series import Series

HINT = "Name the results to evaluate with --results."


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


Key = tuple[State, float | None]
"""A state, and its probability where it is a bin."""


def groups_of(batch: Batch) -> dict[Key, list[Row]]:
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


def require_statistics(batch: Batch, groups: Mapping[Key, list[Row]], names: Iterable[str]) -> None:
    """Refuse a run without statistics of a result: its values are not finite, or it has fewer than three points."""
    for row in (row for rows in groups.values() for row in rows):
        for name in names:
            if name in row.statistics:
                continue
            the_case = f"{batch.folder}: the case '{row.name}'"
            if row.statistics:
                raise ModelError(f"{the_case} has no statistics of '{name}'; name others with --results.")
            raise ModelError(f"{the_case} has none of any result: there are no statistics of '{name}'. {HINT}")


def span_of(row: Row) -> float:
    """How long a run was evaluated [s]."""
    return float(row.simulated or 0.0) - float(row.case.discard or 0.0)


def largest_of(row: Row, name: str, side: str) -> float:
    """The extreme of a run, outward positive."""
    kept = row.statistics[name]
    if side == "max":
        return float(kept["max"])
    lowest = -float(kept["min"])
    return lowest if side == "min" else max(float(kept["max"]), lowest)


def series_of(results: list[Any], name: str, side: str) -> list[Series]:
    """A result of all runs of a state, outward positive."""
    from fowtlib.analysis.series import as_records

    records = as_records([result[name] for result in results])
    return records if side == "max" else [replace(record, values=-record.values) for record in records]


def statistics_of(rows: list[Row], name: str, side: str) -> KeptRuns:
    """What is kept of a result in all runs of a state, outward positive."""
    from fowtlib.analysis.kept import kept_runs

    channels = [row.statistics[name] for row in rows]
    try:
        return kept_runs(channels, [span_of(row) for row in rows], name, side)
    except ModelError as error:
        raise ModelError(f"{rows[0].name}: {error} {HINT}") from None
