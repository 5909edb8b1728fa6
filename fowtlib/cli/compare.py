"""`fowt compare`: two results of the same case against each other, with traffic lights."""

from __future__ import annotations

import argparse
import warnings
from pathlib import Path
from typing import Any

from fowtlib.cli import tables
from fowtlib.cli.files import FIGURES, check_target, say_saved
from fowtlib.cli.run import not_negative
from fowtlib.language.errors import ModelError

RELATIVE_TO = ("value", "range", "larger", "smaller", "mean")
EXAMPLES = """B is the reference: differences are in percent of its values, green up to the
first of --limits, amber up to the second, red beyond. Channels are paired by
name, also under the names of OpenFAST. FILE of --map is a CSV table with the
columns first, second and, if wanted, sign (1 or -1), first_unit, second_unit.

examples:
  fowt compare run.nc openfast.outb --discard 400 --plot lights.png
  fowt compare run.nc bladed.csv --map names.csv --equivalent-loads 4,10
  fowt compare run.nc tank_test.csv --over-time
"""


def declare(commands: Any) -> None:
    """Add the command of this module."""
    text = "compare the statistics of two results, with traffic lights"
    parser = commands.add_parser("compare", help=text, epilog=EXAMPLES)
    add = parser.add_argument
    add("first", type=Path, metavar="A", help="a result file: .nc, .csv or .outb")
    add("second", type=Path, metavar="B", help="the reference, a result file too")
    add("--map", type=Path, metavar="FILE", help="table of channels that belong together (.csv)")
    add("--discard", type=not_negative, metavar="S", default=0.0, help="without the first S seconds of both")
    add("--limits", type=limits, metavar="P,Q", default=(10.0, 30.0), help="of green and amber [%%]; default: 10,30")
    add("--relative-to", choices=RELATIVE_TO, default="value", metavar="WHAT",
        help="percent of the value of B, its range (maximum - minimum), or the larger, smaller or mean of both values; "
             "default: value")  # fmt: skip
    add("--over-time", action="store_true", help="instead: correlation and RMSE, of records of the same waves")
    add("--equivalent-loads", type=exponents, metavar="M,...", default=(),
        help="damage-equivalent loads too, for these exponents")  # fmt: skip
    add("--strict", action="store_true", help="exit status 1 if there is a red light")
    add("--plot", type=Path, metavar="FILE", help="draw the lights: .png, .svg or .pdf")
    tables.declare(parser)
    parser.set_defaults(action=show_comparison)


def limits(text: str) -> tuple[float, float]:
    """Two rising numbers, for argparse."""
    try:
        green, amber = map(float, text.split(","))
    except ValueError:
        green = amber = 0.0
    if not 0.0 < green <= amber:
        raise argparse.ArgumentTypeError(f"'{text}' is not two rising percentages, such as 10,30")
    return green, amber


def exponents(text: str) -> list[float]:
    """Numbers above zero, for argparse."""
    try:
        values = [float(word) for word in text.split(",")]
    except ValueError:
        values = [0.0]
    if min(values) <= 0.0:
        raise argparse.ArgumentTypeError(f"'{text}' is not a list of exponents, such as 4,10")
    return values


def show_comparison(arguments: argparse.Namespace) -> int:
    """Print the differences; a person gets one row per channel, a machine all numbers."""
    from fowtlib.analysis.comparison import cell_text, compare_results, read_pairs
    from fowtlib.solving.results import Result

    check_target(arguments.plot, FIGURES, arguments.force)
    tables.check(arguments)
    pairs = read_pairs(arguments.map) if arguments.map else None
    first, second = Result.open(arguments.first), Result.open(arguments.second)
    if arguments.over_time:
        return _over_time(arguments, first, second, pairs)
    comparison = compare_results(
        first, second, pairs, discard=arguments.discard, limits=arguments.limits, relative_to=arguments.relative_to,
        measures={f"DEL {m:g}": _equivalent_load(m) for m in arguments.equivalent_loads},
    )  # fmt: skip
    for name, why in comparison.refused.items():
        warnings.warn(f"{name} is left out: {why}", stacklevel=1)
    if abs(first.duration - second.duration) > 1e-3 * second.duration:
        warnings.warn(f"A lasts {first.duration:g} s and B {second.duration:g} s: extremes of records of different "
                      "length differ for that alone.", stacklevel=1)  # fmt: skip
    if arguments.plot:
        comparison.plot(arguments.plot, title=f"{arguments.first.name} against {arguments.second.name}")
    tables.say(arguments, comparison.summary())
    if arguments.form:
        tables.show(arguments, comparison.heads(), comparison.table())
    else:
        tables.save(arguments, comparison.heads(), comparison.table())
        cells = {(row.name, row.measure): row for row in comparison.rows}
        rows = []
        for name in comparison.names:
            mean = cells[name, "mean"]
            lights = (cell_text(cells[name, measure]) for measure in comparison.measures)
            rows.append((name, mean.other, mean.unit, *lights))
        tables.show_rows(("result", "other name", "unit", *(f"{m} [%]" for m in comparison.measures)), rows)
        for which, names in (("A", comparison.first_only), ("B", comparison.second_only)):
            tables.say(arguments, f"only in {which}: {', '.join(names)}" if names else "")
    say_saved(arguments.plot)
    return int(arguments.strict and comparison.count()["red"] > 0)


def _over_time(arguments: argparse.Namespace, first: Any, second: Any, pairs: Any) -> int:
    """Print correlation and root mean square differences, with what these are divided by."""
    from fowtlib.analysis.comparison import compare_over_time

    if arguments.plot or arguments.strict or arguments.equivalent_loads:
        raise ModelError("--over-time has no lights: leave out --plot, --strict and --equivalent-loads.")
    found = compare_over_time(first, second, pairs, discard=arguments.discard)
    columns = ("result", "unit", "correlation", "RMSE", "std of B", "RMSE / std", "RMSE / range")
    rows = [
        (row.name, row.unit, row.correlation, row.rmse, row.test_std, row.rmse_of_std, row.rmse_of_range)
        for row in found
    ]
    tables.show(arguments, columns, rows, f"{arguments.first.name} against {arguments.second.name}")
    return 0


def _equivalent_load(exponent: float) -> Any:
    from fowtlib.analysis.fatigue import damage_equivalent_load

    return lambda series: float(damage_equivalent_load(series, exponent))
