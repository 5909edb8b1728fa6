"""Two result sets of the same case, of two programs for example: differences of their statistics, with traffic lights.

Results are paired by name, also where one has the names of OpenFAST's channels; a list of pairs (`Pair`, or a CSV file)
says what the names do not. The second one is the reference: a difference is that of the first in percent of the second.
Lights after Serret (2019), section 3.10: green up to 10 %, amber up to 30 %, red beyond.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from fowtlib.analysis.agreement import Agreement, agreement, denominator
from fowtlib.analysis.case_statistics import case_statistics
from fowtlib.analysis.series import Series
from fowtlib.language.data_files import cells_of
from fowtlib.language.errors import ModelError, UnitError, did_you_mean
from fowtlib.language.units import conversion, parse_unit
from fowtlib.solving.results import Result
from fowtlib.solving.results.openfast import result_of
from fowtlib.solving.results.tables import write_table

if TYPE_CHECKING:
    from matplotlib.figure import Figure

LIMITS = (10.0, 30.0)  # percent: the largest difference of a green and of an amber light
LIGHTS = ("green", "amber", "red", "none")
MEASURES = ("mean", "std", "min", "max")
RELATIVE_TO = ("value", "range", "larger", "smaller", "mean")
MAP_COLUMNS = ("first", "second", "sign", "first_unit", "second_unit")
_NOTHING = 1e-9  # of the largest value of a channel, and absolute: what is left by rounding


@dataclass(frozen=True)
class Pair:
    """A channel of the first result and the one of the second that is the same quantity.

    sign: -1 where the second counts the other way. Units: where a file does not say them, or says them wrong; else "".
    """

    first: str
    second: str
    sign: float = 1.0
    first_unit: str = ""
    second_unit: str = ""


@dataclass(frozen=True)
class Difference:
    """One measure of one channel in both results, in the unit of the first; percent: None where there is no scale."""

    name: str
    other: str
    unit: str
    measure: str
    first: float
    second: float
    percent: float | None
    light: str


@dataclass(frozen=True)
class Comparison:
    """Differences by channel and measure; what only one result has; and why a channel could not be compared."""

    rows: tuple[Difference, ...]
    limits: tuple[float, float] = LIMITS
    first_only: tuple[str, ...] = ()
    second_only: tuple[str, ...] = ()
    refused: Mapping[str, str] = field(default_factory=dict)
    relative_to: str = "value"

    @property
    def measures(self) -> list[str]:
        return list(dict.fromkeys(row.measure for row in self.rows))

    @property
    def names(self) -> list[str]:
        return list(dict.fromkeys(row.name for row in self.rows))

    def __getitem__(self, key: tuple[str, str]) -> Difference:
        for row in self.rows:
            if (row.name, row.measure) == key:
                return row
        raise ModelError(f"there is no {key[1]} of '{key[0]}' to compare{did_you_mean(key[0], self.names)}")

    def count(self) -> dict[str, int]:
        """How many lights there are of each colour."""
        found = Counter(row.light for row in self.rows)
        return {light: found[light] for light in LIGHTS}

    def summary(self) -> str:
        """One sentence: the lights, and the largest difference."""
        lights = ", ".join(f"{number} {light}" for light, number in self.count().items() if number and light != "none")
        told = [row for row in self.rows if row.percent is not None]
        if not told:
            return "nothing was compared."
        worst = max(told, key=lambda row: abs(row.percent or 0.0))
        return (f"{len(self.names)} channels, {len(self.rows)} values: {lights}; "
                f"largest difference: {worst.measure} of {worst.name}, {worst.percent:+.3g} %.")  # fmt: skip

    def heads(self) -> tuple[str, ...]:
        return ("result", "other name", "unit", "measure", "first", "second", "difference [%]", "light")

    def table(self) -> list[tuple[Any, ...]]:
        """One row per channel and measure, below `heads`."""
        return [(row.name, row.other, row.unit, row.measure, row.first, row.second, row.percent, row.light)
                for row in self.rows]  # fmt: skip

    def markdown(self) -> str:
        """One row per channel: the differences in percent with the words of their lights."""
        lines = ["| result | unit | " + " | ".join(f"{measure} [%]" for measure in self.measures) + " |",
                 "| --- | --- |" + " ---: |" * len(self.measures)]  # fmt: skip
        for name in self.names:
            cells = {row.measure: row for row in self.rows if row.name == name}
            shown = [cell_text(cells[measure]) for measure in self.measures]
            lines.append(f"| {name} | {cells[self.measures[0]].unit} | " + " | ".join(shown) + " |")
        return "\n".join(lines) + "\n"

    def save(self, path: str | Path) -> Path:
        """Write all numbers as .csv, or the differences as .md (markdown)."""
        return write_table(path, self.heads(), self.table(), "a comparison", self.markdown)

    def plot(self, path: str | Path | None = None, **options: Any) -> Figure:
        """Differences in the colours of their lights; options of pictures.plot_lights."""
        from fowtlib.analysis.pictures import plot_lights

        return plot_lights(self, path, **options)


def compare_results(
    first: Result,
    second: Result,
    pairs: Sequence[Pair] | None = None,
    *,
    discard: float = 0.0,
    limits: tuple[float, float] = LIMITS,
    measures: Mapping[str, Callable[[Series], float]] | None = None,
    relative_to: str = "value",
) -> Comparison:
    """Mean, standard deviation, minimum and maximum of all channels that both results have, and their differences.

    pairs        which channels belong together, besides those of one name; a pair of the list goes before the name.
                 Names may be those of fowtlib or of OpenFAST, without regard to capitals
    discard      seconds left out at the beginning of both
    limits       percent, of green and of amber lights
    measures     more of them, name -> function of a Series: {"DEL 4": lambda series: ...}
    relative_to  "value": percent of the second's value; "range": of the second's range, maximum - minimum, which also
                 means something where a mean is near zero; "larger", "smaller" or "mean": of the larger or smaller of
                 both values, or of their mean, as published tables have it that do not say which

    Numbers below 1e-9 of the largest value of a channel, or below 1e-9, are rounding: two of them differ by 0 %, and a
    difference from such a one has no percent and no light. Raises ModelError: nothing to compare, units of different
    dimension, a pair that names what is not there.
    """
    if relative_to not in RELATIVE_TO:
        raise ModelError(
            "differences are relative to the 'value' or to the 'range', or to the 'larger', the 'smaller' or the "
            f"'mean' of both values, not to '{relative_to}'."
        )
    if not 0.0 < limits[0] <= limits[1]:
        raise ModelError(
            f"the limits of the lights are two rising numbers above 0, not {limits[0]:g} and {limits[1]:g}."
        )
    ours, theirs = (_columns(result) for result in (first, second))
    chosen = _pairs(ours, theirs, pairs or ())
    if not chosen:
        raise ModelError(
            "the two results have no channel in common, also not under the names of OpenFAST; say in a list of pairs "
            f"which belong together. The first has {', '.join(list(ours)[:8])}; "
            f"the second {', '.join(list(theirs)[:8])}."
        )
    refused, values = {}, {}
    units = {name: _unit(ours, name, pair.first_unit) for name, pair in chosen.items()}
    for name, pair in chosen.items():
        try:
            values[name] = _converted(theirs, pair, units[name])
        except ModelError as error:  # of a pair that only the names have made: one of many
            if pairs and any(wanted.first.lower() == name.lower() for wanted in pairs):
                raise
            refused[name] = str(error)
    if not values:
        raise ModelError(" ".join(refused.values()))
    one = Result(first.time, {name: ours[name][1] for name in values}, units)
    other = Result(second.time, values)
    told, reference = case_statistics(one, discard, percentiles=()), case_statistics(other, discard, percentiles=())
    refused |= {**told["refused"], **reference["refused"]}
    rows = []
    for name, pair in chosen.items():
        if name in refused:
            continue
        numbers = {key: (told["channels"][name][key], reference["channels"][name][key]) for key in MEASURES}
        for key, function in (measures or {}).items():
            numbers[key] = tuple(
                float(function(Series(run.time, run.array(name), one.unit(name), name).after(discard)))
                for run in (one, other)
            )
        largest = max(abs(numbers[key][which]) for key in ("min", "max") for which in (0, 1))
        span = numbers["max"][1] - numbers["min"][1]
        for key, (a, b) in numbers.items():
            percent = _percent(a, b, _scale(a, b, span, relative_to), largest)
            rows.append(Difference(name, pair.second, one.unit(name), key, a, b, percent, _light(percent, limits)))
    used = {pair.second for pair in chosen.values()}
    first_only = tuple(name for name in ours if name not in chosen)
    second_only = tuple(name for name in theirs if name not in used)
    return Comparison(tuple(rows), limits, first_only, second_only, refused, relative_to)


def compare_over_time(
    first: Result, second: Result, pairs: Sequence[Pair] | None = None, *, discard: float = 0.0,
) -> list[Agreement]:
    """Correlation and root mean square difference of all channels that both results have: see analysis.agreement.

    For results of the same waves, as of a test and of the run in its measured record. pairs, discard, errors: as for
    compare_results.
    """
    ours, theirs = (_columns(result) for result in (first, second))
    chosen = _pairs(ours, theirs, pairs or ())
    if not chosen:
        raise ModelError("the two results have no channel in common; say in a list of pairs which belong together.")
    found = []
    for name, pair in chosen.items():
        unit = _unit(ours, name, pair.first_unit)
        one = Series(first.time, ours[name][1], unit, name).after(discard)
        other = Series(second.time, _converted(theirs, pair, unit), unit, name).after(discard)
        found.append(agreement(one, other))
    return found


def read_pairs(path: str | Path) -> list[Pair]:
    """Pairs from a CSV file with the columns first, second and, if wanted, sign, first_unit, second_unit.

    Lines that begin with # are comments. Raises ModelError with file and line.
    """
    path = Path(path)
    try:
        lines = path.read_text(encoding="utf-8-sig").splitlines()
    except (OSError, UnicodeDecodeError) as error:
        raise ModelError(f"{path}: cannot be read: {getattr(error, 'strerror', None) or error}.") from None
    rows = [(number, cells_of(line)) for number, line in enumerate(lines, 1)
            if line.strip() and not line.lstrip().startswith("#")]  # fmt: skip
    if not rows:
        raise ModelError(f"{path}: is empty; its first line is {','.join(MAP_COLUMNS[:2])}.")
    number, heads = rows[0]
    for head in heads:
        if head not in MAP_COLUMNS:
            raise ModelError(f"{path}:{number}: there is no column '{head}'{did_you_mean(head, MAP_COLUMNS)}")
    if not {"first", "second"} <= set(heads) or len(set(heads)) < len(heads):
        raise ModelError(f"{path}:{number}: a list of pairs has the columns first and second, each once.")
    pairs = []
    for number, cells in rows[1:]:
        told = dict(zip(heads, cells, strict=False))
        if len(cells) > len(heads) or not (told.get("first") and told.get("second")):
            raise ModelError(f"{path}:{number}: a pair names a channel of both results, below {','.join(heads)}.")
        sign = told.get("sign") or "1"
        if sign not in ("1", "-1", "+1", "+", "-"):
            raise ModelError(f"{path}:{number}: the sign is 1 or -1, not '{sign}'.")
        units = told.get("first_unit", ""), told.get("second_unit", "")
        for unit in filter(None, units):
            try:
                parse_unit(unit)
            except UnitError as error:
                raise ModelError(f"{path}:{number}: {error}") from None
        pairs.append(Pair(told["first"], told["second"], -1.0 if sign.startswith("-") else 1.0, *units))
    return pairs


def cell_text(row: Difference) -> str:
    """The difference of a row with the word of its light."""
    return "-" if row.percent is None else f"{round(row.percent, 1) + 0.0:+.1f} {row.light}"


def _columns(result: Result) -> dict[str, tuple[str, np.ndarray]]:
    """Unit and values of all scalar series by name."""
    return {name: (unit, values) for name, unit, values in result.stored.columns()}


def _pairs(ours: Mapping[str, Any], theirs: Mapping[str, Any], wanted: Sequence[Pair]) -> dict[str, Pair]:
    """Name in the first -> pair with the names as the results have them."""
    chosen: dict[str, Pair] = {}
    for pair in wanted:
        first, second = _find(pair.first, ours, "first"), _find(pair.second, theirs, "second")
        if first in chosen:
            raise ModelError(f"the list of pairs names '{pair.first}' twice.")
        chosen[first] = Pair(first, second, pair.sign, pair.first_unit, pair.second_unit)
    taken = {pair.second for pair in chosen.values()}
    by_name = {_canonical(name, theirs): name for name in theirs if name not in taken}
    for name in ours:
        same = name if name in theirs and name not in taken else by_name.get(_canonical(name, ours))
        if name not in chosen and same is not None:
            chosen[name] = Pair(name, same)
    return {name: chosen[name] for name in ours if name in chosen}


def _find(name: str, columns: Mapping[str, Any], which: str) -> str:
    if name in columns:
        return name
    for known, (unit, _) in columns.items():
        if known.lower() == name.lower() or _canonical(known, columns) == result_of(name, unit, columns).name.lower():
            return known
    raise ModelError(f"the {which} result has no '{name}'{did_you_mean(name, columns, list_up_to=20)}")


def _canonical(name: str, columns: Mapping[str, Any]) -> str:
    """What fowtlib calls a channel, in small letters."""
    return result_of(name, columns[name][0], columns).name.lower()


def _unit(columns: Mapping[str, Any], name: str, stated: str) -> str:
    return stated or columns[name][0] or "1"


def _converted(columns: Mapping[str, Any], pair: Pair, unit: str) -> np.ndarray:
    """Values of the second channel in the unit and with the sign of the first."""
    own = _unit(columns, pair.second, pair.second_unit)
    values = columns[pair.second][1]
    if own != unit:
        try:
            one, out = parse_unit(own), parse_unit(unit)
        except UnitError as error:
            raise ModelError(f"{pair.first} and {pair.second} cannot be compared: {error}") from None
        if one.dimension != out.dimension:
            raise ModelError(
                f"{pair.first} is in {unit}, and {pair.second} in {own}: these cannot be compared. If a file says a "
                "wrong unit, state the right one in the list of pairs."
            )
        values = values * conversion(one, out)
    return pair.sign * values


def _scale(a: float, b: float, span: float, relative_to: str) -> float:
    """What a difference is divided by."""
    if relative_to == "range":
        return span
    return denominator(a, b, "test" if relative_to == "value" else relative_to)


def _percent(a: float, b: float, scale: float, largest: float) -> float | None:
    least = max(_NOTHING * largest, _NOTHING)
    if abs(a - b) <= least:
        return 0.0
    return 100.0 * (a - b) / scale if scale > least and math.isfinite(a) and math.isfinite(b) else None


def _light(percent: float | None, limits: tuple[float, float]) -> str:
    if percent is None:
        return "none"
    return LIGHTS[sum(abs(percent) > limit for limit in limits)]
