"""`fowt size`: sizes from targets."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

from fowtlib.cli import loading, tables
from fowtlib.cli.files import check_target, say_saved
from fowtlib.language.whole_files import write_text

if TYPE_CHECKING:
    from fowtlib.design.sizing import SizingStopped

EXAMPLES = """FILE says which parameters of a model are free, within which bounds, and what
the model shall do at rest (docs/sizing.md). As many values as sizes: its
equations are solved for the sizes. Bounds among the targets, or an objective:
the best sizes are sought. Exit status 2: no sizes keep all targets; the
message names those that are against each other.

examples:
  fowt size spar.yaml
  fowt size spar.yaml --output sizes.json
"""


def declare(commands: Any) -> None:
    """Add the command of this module."""
    parser = commands.add_parser("size", help="sizes from what a model shall do at rest", epilog=EXAMPLES)
    parser.add_argument("file", metavar="FILE", type=Path, help="free sizes and targets (.yaml)")
    tables.add_output(parser, "output", "save all of it (.json)")
    tables.declare(parser, output=False)
    loading.declare_leave(parser)
    parser.set_defaults(action=size)


def size(arguments: argparse.Namespace) -> int:
    """Read the file, find the sizes, and show them."""
    import json

    from fowtlib.design.sizing import SizingStopped
    from fowtlib.design.sizing_file import read_sizing

    check_target(arguments.output, (".json",), arguments.force)
    file = read_sizing(arguments.file, load_model=lambda name: loading.load_file(arguments, name))
    try:
        found = file.found()
    except SizingStopped as stop:
        return _stopped(stop)
    if arguments.form == "json":
        tables.show_json(found.plain())
    elif arguments.form == "csv":
        sys.stdout.write(tables.csv_text(*found.size_rows()))
    else:
        print(f"{file.title}, by {found.way}\n")
        for rows in (found.size_rows(), found.result_rows()):
            tables.show_rows(*rows)
            print()
    if arguments.output:
        write_text(arguments.output, json.dumps(found.plain(), indent=1))
    say_saved(arguments.output)
    return 0


def _stopped(stop: SizingStopped) -> int:
    """Say the sizes so far."""
    print(f"fowt size: stopped after {stop.tried} sizes. Nearest to the targets so far, which miss them by "
          f"{stop.left:.3g} of their scales: {stop.shown}. A search with these as first guesses, the third numbers in "
          "'free', goes on from there.", file=sys.stderr)  # fmt: skip
    return 130
