"""`fowt loads`: ultimate load matrix of results, with safety factors and the loads at the same time."""

from __future__ import annotations

import argparse
import csv
from pathlib import Path
from typing import Any

from fowtlib.cli import results, tables
from fowtlib.cli.files import check_target, say_saved
from fowtlib.cli.run import positive
from fowtlib.language.errors import ModelError, did_you_mean

EXAMPLES = r"""For each load its largest and smallest factored value over all results, with
the other loads at that time. FILE of --cases is a CSV table with the columns
result and, if wanted, safety_factor, load_case (a label such as 6.2) and
condition: results of one condition are its realisations (seeds).

examples:
  fowt loads run_*.nc --of thrust,tower_base_fore_aft_moment --factor 1.35
  fowt loads run_*.nc --of Mx,My,Fx --cases cases.csv --characteristic mean \
      -o loads.md
"""
COLUMNS = ("result", "safety_factor", "load_case", "condition")
MATRICES = (".csv", ".md")


def declare(commands: Any) -> None:
    """Add the command of this module."""
    parser = commands.add_parser("loads", help="ultimate load matrix of results with safety factors", epilog=EXAMPLES)
    results.declare(parser)
    add = parser.add_argument
    add("--of", type=results.names, required=True, metavar="NAMES", help="the loads: thrust,tower_base_torsion")
    add("--factor", type=positive, metavar="X", default=1.0, help="partial safety factor of all results; default: 1")
    add("--cases", type=Path, metavar="FILE", help="table of safety factors and labels (.csv)")
    add("--characteristic", choices=("worst", "mean", "upper half"), default="worst", metavar="WHAT",
        help="what stands for the realisations of a condition: worst, mean, or upper half; default: worst")  # fmt: skip
    tables.add_output(parser, "output", "save the matrix: .csv or .md (markdown)")
    tables.declare(parser, output=False)
    parser.set_defaults(action=show_loads)


def show_loads(arguments: argparse.Namespace) -> int:
    """Print the matrix."""
    from fowtlib.analysis.load_matrix import ultimate_loads

    check_target(arguments.output, MATRICES, arguments.force)
    opened = results.open_results(arguments.results)
    factors, labels, conditions = dict.fromkeys(opened, arguments.factor), {}, {}
    if arguments.cases:
        told = read_cases(arguments.cases, list(opened))
        factors |= {name: float(row["safety_factor"]) for name, row in told.items() if row.get("safety_factor")}
        labels = {name: row["load_case"] for name, row in told.items() if row.get("load_case")}
        conditions = {name: row["condition"] for name, row in told.items() if row.get("condition")}
    matrix = ultimate_loads(opened, arguments.of, factors, load_cases=labels, realisations=conditions,
                            characteristic=arguments.characteristic, discard=arguments.discard)  # fmt: skip
    tables.show(arguments, matrix.heads(), matrix.table(), f"factored loads of {len(opened)} results")
    if arguments.output:
        say_saved(matrix.save(arguments.output))
    return 0


def read_cases(path: Path, known: list[str]) -> dict[str, dict[str, str]]:
    """Rows of the table of cases by the name of the result."""
    try:
        with path.open(newline="", encoding="utf-8-sig") as file:
            reader = csv.DictReader(file)
            heads, rows = reader.fieldnames or [], [(reader.line_num, row) for row in reader]
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise ModelError(f"{path}: cannot be read: {getattr(error, 'strerror', None) or error}.") from None
    for head in heads:
        if head not in COLUMNS:
            raise ModelError(f"{path}:1: there is no column '{head}'{did_you_mean(head, COLUMNS)}")
    if "result" not in heads:
        raise ModelError(f"{path}:1: the first line names the columns; one of them is result.")
    found: dict[str, dict[str, str]] = {}
    for number, row in rows:
        name = (row["result"] or "").strip()
        if name not in known:
            raise ModelError(f"{path}:{number}: no result is called '{name}'{did_you_mean(name, known)}")
        if name in found:
            raise ModelError(f"{path}:{number}: '{name}' is named twice.")
        if None in row:
            raise ModelError(f"{path}:{number}: has more cells than the first line has columns.")
        found[name] = {key: (value or "").strip() for key, value in row.items()}
        try:
            positive(found[name].get("safety_factor") or "1")
        except argparse.ArgumentTypeError as error:
            raise ModelError(f"{path}:{number}: safety_factor: {error}.") from None
    return found
