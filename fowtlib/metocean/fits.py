"""Short-term laws of responses from files: what a batch has found in bins and on contours."""

from __future__ import annotations

import csv
import io
import os
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from fowtlib.language.errors import ParameterError
from fowtlib.language.whole_files import write_text
from fowtlib.metocean.csv_columns import Columns, read_columns
from fowtlib.metocean.short_term import Either, Extreme, Gumbel, UpCrossings
from fowtlib.metocean.sides import SIDES, Sides, check_sides, label, side_of
from fowtlib.metocean.states import COLUMNS, States

_GUMBEL = ("location", "scale")
_RATES = ("q", "a", "b", "c", "threshold")
_PLACES = {"location", "b", "threshold"}  # numbers that lie on the axis of the response
_HALVES = ("abs above", "abs below")
_WORDS = ("response", "unit", "side", "name")
_NOT_RESPONSES = ("probability", "seed", "state", "weight")


@dataclass(frozen=True)
class Fits:
    """The laws of one response: in bins, which have probabilities, and in points of contours, which have none.

    runs: behind the law of each bin, where it was fitted here. side: "max"; "min", whose laws are of the largest value
    of the negative response, so that `sign` times their values is the response again; or "abs", of its absolute value.
    """

    response: str
    unit: str
    bins: tuple[States, Extreme] | None
    points: tuple[States, Extreme] | None
    runs: np.ndarray | None = None
    side: str = "max"

    @property
    def sign(self) -> float:
        """Of the response in the values of the laws."""
        return -1.0 if self.side == "min" else 1.0

    @property
    def label(self) -> str:
        """The response with its side: surge, heave (min), |yaw|."""
        return label(self.response, self.side)


def read_fits(path: str | os.PathLike[str], duration: float = 3600.0) -> dict[str, Fits]:
    """Laws by response and side, `Fits.label`, from a CSV with one row for each of them and state.

    Columns: response, unit and side (optional), wind_speed [m/s], Hs [m], Tp [s], probability (empty, or left out,
    where the state is a point of a contour), and location and scale of a Gumbel law, or q, a, b, c and threshold of a
    rate of up-crossings q exp(-a (y - b)^c) [1/s], for extremes in `duration` [s]. side: max, which is meant without
    it; min, of which location, b and threshold have the sign of the response, and distances from them count downward;
    abs, of the absolute value; or "abs above" and "abs below", whose rates of y up through x and of -y up through x
    together are that of the absolute value.
    """
    table = read_columns(
        path, "the table of fits", (*_GUMBEL, *_RATES, "probability"), words=_WORDS, may_be_empty=("probability",)
    )
    if "response" not in table.words:
        raise ParameterError("the table of fits needs the column 'response'.", where=table.path)
    forms = [form for form in (_GUMBEL, _RATES) if any(name in table.numbers for name in form)]
    if len(forms) != 1 or any(name not in table.numbers for name in forms[0]):
        raise ParameterError(
            f"the table of fits needs the columns {', '.join(_GUMBEL)}, or {', '.join(_RATES)}.", where=table.path
        )
    positive = ("scale",) if forms[0] == _GUMBEL else ("q", "a", "c")
    for name in positive:
        table.refuse(~(table.numbers[name] > 0), f"{name} must be positive.")

    def law(rows: np.ndarray) -> Extreme:
        values = {name: table.numbers[name][rows] for name in forms[0]}
        return Gumbel(**values) if forms[0] == _GUMBEL else UpCrossings(**values, duration=duration)

    names, sides = np.array(table.words["response"]), np.array(table.words.get("side", ["max"] * table.lines.size))
    sides[sides == ""] = "max"
    table.refuse(~np.isin(sides, (*SIDES, *_HALVES)), f"a side is {', '.join((*SIDES, *_HALVES))}.")
    down = sides == "min"
    for name in _PLACES & set(table.numbers):
        table.numbers[name][down] *= -1
    found: dict[tuple[str, str], Fits] = {}
    for response, side in dict.fromkeys(zip(names.tolist(), sides.tolist(), strict=True)):
        rows = np.flatnonzero((names == response) & (sides == side))
        unit = table.words["unit"][rows[0]] if "unit" in table.words else ""
        parts = [None if not some.size else (table.states(some, p), law(some)) for some, p in _parts(table, rows)]
        found[response, side] = Fits(response, unit, *parts, side=side)
    for response in dict.fromkeys(names.tolist()):
        halves = [found.pop((response, side), None) for side in _HALVES]
        if any(halves):
            found[response, "abs"] = _whole(response, halves, (response, "abs") in found, table.path)
    return {each.label: each for each in found.values()}


def _whole(response: str, halves: list[Fits | None], twice: bool, path: str) -> Fits:
    """The absolute value from the rates above and below."""
    one, other = halves
    if one is None or other is None or twice:
        raise ParameterError(f"'{response}' has the sides {' and '.join(_HALVES)} together, or abs.", where=path)
    parts: list[tuple[States, Extreme] | None] = []
    for above, below in ((one.bins, other.bins), (one.points, other.points)):
        if (above and list(above[0])) != (below and list(below[0])):
            raise ParameterError(f"'{response}': {' and '.join(_HALVES)} are of the same states in the same order.",
                                 where=path)  # fmt: skip
        parts.append(None if above is None or below is None else (above[0], Either(above[1], below[1])))
    return Fits(response, one.unit, *parts, side="abs")


def write_fits(path: str | os.PathLike[str], fits: Iterable[Fits]) -> None:
    """The table that `read_fits` reads; all laws are Gumbel's, or all are rates of up-crossings with a threshold."""
    rows: list[list[Any]] = []
    forms = set()
    for each in fits:
        for states, law in filter(None, (each.bins, each.points)):
            pairs = zip(_HALVES, (law.one, law.other), strict=True) if isinstance(law, Either) else [(each.side, law)]
            for side, single in pairs:
                form, columns = _columns(each.response, side, single, len(states))
                forms.add(form)
                for index, state in enumerate(states):
                    probability = "" if states.probability is None else repr(float(states.probability[index]))
                    numbers = (repr(float(value)) for value in (*state, *columns[:, index]))
                    rows.append([each.response, each.unit, side, probability, *numbers])
    if len(forms) != 1:
        raise ParameterError("a table of fits has laws of one form, and one at least.")
    text = io.StringIO()
    out = csv.writer(text, lineterminator="\n")
    head = [f"{name} [{unit}]" for name, unit in COLUMNS.items()]
    out.writerows([["response", "unit", "side", "probability", *head, *forms.pop()], *rows])
    write_text(Path(path), text.getvalue())


def _columns(response: str, side: str, law: Extreme, count: int) -> tuple[tuple[str, ...], np.ndarray]:
    """The numbers of laws as they are written, (columns, states), with the names of the columns."""
    form = _GUMBEL if isinstance(law, Gumbel) else _RATES
    if not isinstance(law, (Gumbel, UpCrossings)) or getattr(law, "threshold", 0) is None:
        raise ParameterError(f"{response}: only Gumbel laws, and rates with a threshold, can be written.")
    signs = [-1.0 if side == "min" and name in _PLACES else 1.0 for name in form]
    return form, np.array([sign * np.broadcast_to(getattr(law, name), (count,))
                           for sign, name in zip(signs, form, strict=True)])  # fmt: skip


def read_maxima(path: str | os.PathLike[str], side: Sides = "max") -> dict[str, Fits]:
    """Gumbel laws by `Fits.label`, by the method of moments, from a CSV with one row for each run.

    Columns: wind_speed [m/s], Hs [m], Tp [s], probability (as in `read_fits`), name, seed, state and weight, which are
    left aside, and one for each response with its largest value in the run, the unit in brackets behind its name. Each
    state needs two runs or more. side: of all responses or by name: "min", where the column has the smallest values,
    or "abs", where it has the largest absolute ones.
    """
    table = read_columns(path, "the table of maxima", None, words=_WORDS, may_be_empty=("probability",))
    responses = [name for name in table.numbers if name not in (*COLUMNS, *_NOT_RESPONSES)]
    if not responses:
        raise ParameterError("the table of maxima has no column of a response.", where=table.path)
    parts: list[tuple[States, list[np.ndarray]] | None] = []
    for rows, probability in _parts(table, np.arange(table.lines.size), once=False):
        if not rows.size:
            parts.append(None)
            continue
        keys = np.stack([table.numbers[name][rows] for name in COLUMNS], axis=1)
        unique, first, group = np.unique(keys, axis=0, return_index=True, return_inverse=True)
        runs = [rows[group.ravel() == number] for number in range(len(unique))]
        for some in runs:
            if some.size < 2:
                u, h, t = (table.numbers[name][some[0]] for name in COLUMNS)
                raise ParameterError(
                    f"there is one run alone at {u:g} m/s, Hs {h:g} m, Tp {t:g} s; a Gumbel law needs several seeds.",
                    where=f"{table.path}:{table.lines[some[0]]}",
                )
        parts.append((table.states(rows[first], None if probability is None else probability[first]), runs))
    check_sides(side, responses, table.path)
    found = {}
    for response in responses:
        which = side_of(side, response)
        values = -table.numbers[response] if which == "min" else table.numbers[response]
        table.refuse((values < 0) & (which == "abs"), f"'{response}': an absolute value is not negative.")
        laws = [None if part is None else (part[0], _gumbel(values, part[1], table, response)) for part in parts]
        runs = None if parts[0] is None else np.array([len(some) for some in parts[0][1]])
        each = Fits(response, table.units.get(response, ""), *laws, runs, which)
        found[each.label] = each
    return found


def _gumbel(values: np.ndarray, runs: list[np.ndarray], table: Columns, response: str) -> Gumbel:
    law = Gumbel.of_runs(values[some] for some in runs)
    for some, each in zip(runs, law.scale, strict=True):
        if not each > 0:
            table.refuse(np.isin(np.arange(values.size), some), f"'{response}' has one maximum in all runs of a state.")
    return law


def _parts(table: Columns, rows: np.ndarray, once: bool = True) -> list[tuple[np.ndarray, np.ndarray | None]]:
    """Rows with probabilities, and rows without."""
    given = table.numbers.get("probability", np.full(table.lines.size, np.nan))
    bins, points = rows[np.isfinite(given[rows])], rows[np.isnan(given[rows])]
    table.refuse(given < 0, "a probability is not negative.")
    if once:
        for some in (bins, points):
            keys = np.stack([table.numbers[name][some] for name in COLUMNS], axis=1)
            _, index = np.unique(keys, axis=0, return_index=True)
            twice = np.setdiff1d(np.arange(some.size), index)
            if twice.size:
                bad = np.isin(np.arange(table.lines.size), some[twice])
                table.refuse(bad, "the response has a fit in this state already.")
    return [(bins, given[bins]), (points, None)]
