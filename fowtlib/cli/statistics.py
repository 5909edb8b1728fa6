"""`fowt statistics`: mean, deviation, extremes, percentiles and more of results, of one or over many."""

from __future__ import annotations

import argparse
import math
from typing import Any

from fowtlib.cli import results, tables
from fowtlib.language.errors import ModelError

EXAMPLES = """Of one result its statistics; of several, over all of them: the mean, the
deviation within each (std) and about the mean of all (total_std), the largest
and smallest value with their results, and the means of maxima and minima.

examples:
  fowt statistics run.nc --discard 400 --percentiles 1,50,99
  fowt statistics seed_*.nc --of surge,pitch
"""
FEW = [5.0, 50.0, 95.0]


def declare(commands: Any) -> None:
    """Add the command of this module."""
    parser = commands.add_parser("statistics", help="statistics of results, of one or over many", epilog=EXAMPLES)
    results.declare(parser)
    parser.add_argument("--of", type=results.names, metavar="NAMES", help="only these series: surge,pitch")
    parser.add_argument("--percentiles", type=percentiles, metavar="P,...", default=FEW, help="default: 5,50,95")
    parser.add_argument("--each", action="store_true", help="of several results, a row for each")
    tables.declare(parser)
    parser.set_defaults(action=show_statistics)


def percentiles(text: str) -> list[float]:
    """Numbers from 0 to 100, for argparse."""
    try:
        values = [float(word) for word in text.split(",")]
    except ValueError:
        values = [math.nan]
    if not all(0.0 <= value <= 100.0 for value in values):
        raise argparse.ArgumentTypeError(f"'{text}' is not a list of percentiles from 0 to 100, such as 5,50,95")
    return sorted(set(values))


def show_statistics(arguments: argparse.Namespace) -> int:
    """Print one row per series, or per series and result."""
    import warnings

    from fowtlib.analysis.case_statistics import case_statistics, over_cases

    tables.check(arguments)
    cases = {}
    for name, result in results.open_results(arguments.results).items():
        try:
            cases[name] = case_statistics(result, arguments.discard, percentiles=arguments.percentiles,
                                          names=arguments.of)  # fmt: skip
        except ModelError as error:
            raise error.at(name) from None
    for name, told in cases.items():
        for channel, why in told["refused"].items():
            warnings.warn(f"{name}: {channel} is left out: {why}", stacklevel=1)
    several = len(cases) > 1
    if several and not arguments.each:
        over = over_cases(cases)
        missing = sorted({name for told in cases.values() for name in told["channels"]} - {*over})
        if missing:
            warnings.warn(f"left out, because not every result has them: {', '.join(missing)}", stacklevel=1)
        if not over:
            raise ModelError("these results have no series in common.")
        keys = ("unit", "mean", "std", "total_std", "max", "max_case", "mean_max", "min", "min_case", "mean_min")
        rows = []
        for name, told in over.items():
            size = max(abs(told["min"]), abs(told["max"]))
            rows.append((name, *(tables.rounded(told[key], size) for key in keys)))
        tables.show(arguments, ("result", *keys), rows, f"{len(cases)} results")
        return 0
    keys = ("mean", "std", "min", "max", "skewness", "kurtosis")
    rates = ("mean crossing rate [1/s]",)
    shown = [f"{p:g}" for p in arguments.percentiles]
    columns = (*(("case",) if several else ()), "result", "unit", *keys, *(f"{p} %" for p in shown), *rates)
    rows = []
    for case, told in cases.items():
        for name, row in told["channels"].items():
            size = max(abs(row["min"]), abs(row["max"]))
            numbers = (*(tables.rounded(row[key], size) for key in keys[:4]), row["skewness"], row["kurtosis"])
            fractiles = (tables.rounded(row["percentiles"][p], size) for p in shown)
            rows.append((*((case,) if several else ()), name, row["unit"], *numbers, *fractiles,
                         row["mean_crossing_rate"]))  # fmt: skip
    told = next(iter(cases.values()))
    tables.show(arguments, columns, rows, f"{told['first']:g} s to {told['last']:g} s")
    return 0
