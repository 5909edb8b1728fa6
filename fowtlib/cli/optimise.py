"""`fowt optimise`: the best design of a design file."""

from __future__ import annotations

import argparse
import sys
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from fowtlib.cli import loading, tables
from fowtlib.cli.files import FIGURES, check_target, say_saved
from fowtlib.cli.run import count, positive
from fowtlib.language.errors import ModelError

if TYPE_CHECKING:
    from fowtlib.design import Front, Optimum
    from fowtlib.design.file import DesignFile

JOURNAL = ".jsonl"
METHODS = ("ipopt", "slsqp", "trust-constr", "successive")  # of fowtlib.design, which is slow to import
EXAMPLES = """DESIGN is a design file (docs/design.md) or a shipped one: its model, the
variables, what is to become least, the constraints, the cases. Each design
that is tried is kept in a journal at once, DESIGN.jsonl here unless --journal
says another place, from which --resume goes on after Ctrl-C or a crash.
--front also makes RESULT least, in POINTS steps: a Pareto front.
Exit status 1: no design was found that keeps all constraints.

examples:
  fowt optimise two_rotor_spar_hull --plot hull.png
  fowt optimise my_spar.yaml --starts 8 --seed 1 --output my_spar.json
  fowt optimise my_spar.yaml --resume
  fowt optimise my_spar.yaml --evaluate
  fowt optimise two_rotor_spar_hull --front 'pitch @ thrust=6' --plot front.png
"""


class OptionError(ModelError):
    """A mistake in an option, which no line of the file is at fault for."""


def declare(commands: Any) -> None:
    """Add the command of this module."""
    text = "the design that keeps all constraints at the least cost"
    parser = commands.add_parser("optimise", help=text, epilog=EXAMPLES)
    add = parser.add_argument
    add("design", metavar="DESIGN", help="a design file (.yaml), or the name of a shipped design")
    add("--method", choices=METHODS, metavar="METHOD",
        help="ipopt, slsqp, trust-constr or successive; else that of the file, else ipopt")  # fmt: skip
    add("--starts", type=count, metavar="N", help="searches from N starts, all but the first at random")
    add("--seed", type=count, metavar="N", help="of the random starts")
    add("--iterations", type=count, metavar="N", help="of one search, at most")
    add("--processes", type=count, metavar="N", help="that evaluate cases at once; else one")
    add("--tolerance", type=positive, metavar="X", help="of optimum and constraints, of their sizes")
    add("--evaluate", action="store_true", help="the start as it is, without a search")
    add("--front", type=front, metavar="RESULT=POINTS", help="a Pareto front with a second result")
    add("--journal", type=Path, metavar="FILE", help="where each design is kept that is tried (.jsonl)")
    add("--resume", action="store_true", help="go on from the journal")
    add("--plot", type=Path, metavar="FILE", help="draw sizes, constraints and the way: .png, .svg or .pdf")
    tables.add_output(parser, "output", "save all of it (.json), or a front (.csv)")
    tables.declare(parser, output=False)
    loading.declare_leave(parser)
    parser.set_defaults(action=optimise)


def front(text: str) -> tuple[str, int]:
    """`result=points`, for argparse."""
    result, given, points = text.rpartition("=")
    if not (given and result.strip() and points.strip().isdecimal() and int(points) > 1):
        raise argparse.ArgumentTypeError(f"'{text}' is not RESULT=POINTS, such as mass=6")
    return result.strip(), int(points)


def optimise(arguments: argparse.Namespace) -> int:
    """Read the design, search, and show what was found; status 1 where no design keeps the constraints."""
    from fowtlib.design.file import find_design, read_design

    check_target(arguments.plot, FIGURES, arguments.force)
    check_target(arguments.output, (".csv",) if arguments.front else (".json",), arguments.force)
    if arguments.evaluate and arguments.front:
        raise ModelError("--evaluate shows the start alone, and --front searches; give one of them.")
    alone = arguments.evaluate or arguments.front
    if alone and (arguments.resume or arguments.journal):
        raise ModelError("--journal and --resume are of a search, not of --evaluate and --front.")
    path = find_design(arguments.design)
    journal = None if alone else _journal(arguments, path)
    file = read_design(path, load_model=lambda name: loading.load_file(arguments, name))
    options = _options(arguments, file)
    if arguments.processes is not None:
        file = replace(file, design=replace(file.design, processes=arguments.processes))
    try:
        if arguments.front:
            return _front(arguments, file, options)
        if arguments.evaluate:
            found = file.design.evaluate()
        else:
            found = file.design.optimise(**options, journal=journal, resume=arguments.resume, say=_say)
    except OptionError:
        raise
    except ModelError as error:
        raise file.located(error) from None
    except KeyboardInterrupt:
        kept = f"{journal} keeps what was found; go on with --resume." if journal else "nothing was saved."
        print(f"fowt optimise: stopped; {kept}", file=sys.stderr)
        return 130
    _show(arguments, found)
    return int(not found.feasible)


def _journal(arguments: argparse.Namespace, path: Path) -> Path:
    """The journal, which is not written over unasked."""
    journal = arguments.journal or Path(path.stem + JOURNAL)
    if arguments.resume:
        if not journal.exists():
            raise ModelError(f"--resume: there is no journal {journal}; name it with --journal, or begin without.")
    elif journal.exists() and not arguments.force and journal.suffix == JOURNAL:
        raise ModelError(f"{journal} is there already: go on from it with --resume, begin anew with --force, or name "
                         "another with --journal.")  # fmt: skip
    check_target(journal, (JOURNAL,), force=True)
    return journal


def _options(arguments: argparse.Namespace, file: DesignFile) -> dict[str, Any]:
    keys = ("method", "starts", "seed", "iterations", "tolerance")
    return {**file.optimiser, **{key: getattr(arguments, key) for key in keys if getattr(arguments, key) is not None}}


def _say(line: str) -> None:
    print(line, file=sys.stderr, flush=True)


def _front(arguments: argparse.Namespace, file: DesignFile, options: dict[str, Any]) -> int:
    from fowtlib.design import pareto

    result, points = arguments.front
    try:
        found: Front = pareto(file.design, result, points, say=_say, **options)
    except ModelError as error:
        if f"'{result.partition(' @ ')[0]}'" in error.message or f"'{result}'" in error.message:
            raise OptionError(error.message, where="--front") from None
        raise
    heads, rows = found.rows()
    if arguments.plot:
        found.plot(arguments.plot)
    tables.show(arguments, heads, rows, found.title)
    say_saved(arguments.plot)
    if arguments.output:
        say_saved(found.save(arguments.output))
    return int(not all(optimum.feasible for optimum in found.optima))


def _show(arguments: argparse.Namespace, found: Optimum) -> None:
    if arguments.plot:
        found.plot(arguments.plot)
    if arguments.form == "json":
        tables.show_json(found.plain())
    elif arguments.form == "csv":
        sys.stdout.write(tables.csv_text(*found.variable_rows()))
    else:
        print(f"{found.title}: {found.sentence}")
        print(f"{found.objective}: {found.start_objective:.6g} -> {found.value:.6g}\n")
        for heads, rows in (found.variable_rows(), found.constraint_rows(), found.search_rows()):
            if rows and (rows is not None and (heads[0] != "start" or len(rows) > 1)):
                tables.show_rows(heads, rows)
                print()
    if arguments.output:
        found.save(arguments.output)
    say_saved(arguments.plot, arguments.output)
