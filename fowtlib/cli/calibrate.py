"""`fowt calibrate`: parameters of a model with which its run is nearest to a record."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

from fowtlib.cli import loading, tables
from fowtlib.cli.files import FIGURES, check_target, say_saved
from fowtlib.cli.run import not_negative

if TYPE_CHECKING:
    from fowtlib.design.calibration import CalibrationStopped

EXAMPLES = """RECORD is a result file or a test (.nc, .csv, .outb) whose channels have the
names of results of the model. With --release the model is at rest at first and
let go as the record begins (a decay test, in still water, and in the mean of
its wind); else it starts as its file says, in the waves of --waves, which may
be those of the test: --waves record:FILE. Prints values with 95 % intervals,
and what is left of every channel. Parameters that the record does not tell,
alone or from each other, are refused.

examples:
  fowt calibrate oc3_spar_rigid heave.csv --release heave --wind none \\
      --fit platform.damping.translation[2] --plot fit.png
"""


def declare(commands: Any) -> None:
    """Add the command of this module."""
    text = "fit damping, drag, mass, stiffness or lengths of a model to a record"
    parser = commands.add_parser("calibrate", help=text, epilog=EXAMPLES)
    loading.declare(parser)
    add = parser.add_argument
    add("record", type=Path, metavar="RECORD", help="a result file or a test: .nc, .csv or .outb")
    add("--fit", required=True, type=names, metavar="PATH,...", help="the parameters that are fitted")
    add("--result", dest="results", type=names, metavar="NAME,...", help="channels that count; default: all common")
    add("--release", default="", metavar="NAME", help="the motion that is let go, in a decay test")
    add("--discard", type=not_negative, default=0.0, metavar="S", help="the first S seconds do not count")
    add("--plot", type=Path, metavar="FILE", help="draw record, runs, residuals: .png, .svg or .pdf")
    tables.declare(parser)
    parser.set_defaults(action=calibrate)


def names(text: str) -> list[str]:
    """Names joined by commas, for argparse."""
    found = [name.strip() for name in text.split(",")]
    if not all(found):
        raise argparse.ArgumentTypeError(f"'{text}' is no list of names joined by commas")
    return found


def calibrate(arguments: argparse.Namespace) -> int:
    """Fit, print the values and what is left, and draw it."""
    import fowtlib as fw
    from fowtlib.design.calibration import CalibrationStopped
    from fowtlib.solving.results import Result

    check_target(arguments.plot, FIGURES, arguments.force)
    tables.check(arguments)
    model = loading.load(arguments)
    if arguments.release:
        model, conditions = loading.load_at_rest(arguments)
        tables.say(arguments, conditions)
    record = Result.open(arguments.record)
    start = None if arguments.release else model.settings.get("start")
    try:
        found = fw.calibrate(
            model, record, arguments.fit, results=arguments.results, release=arguments.release, start=start,
            discard=arguments.discard, step=model.settings.get("step"),
        )  # fmt: skip
    except CalibrationStopped as stop:
        return _stopped(stop)
    if arguments.plot:
        found.plot(arguments.plot)
    for name, part in found.left.items():
        before = found.left_before[name]
        tables.say(arguments, f"left of {name}: {100 * part:.3g} % of its std (before: {100 * before:.3g} %)")
    if found.gradients != "exact":
        tables.say(arguments, f"by differences of runs: {found.gradients.partition(': ')[2]}")
    tables.show(arguments, ("parameter", "before", "value", "from", "to", "unit"), found.rows())
    say_saved(arguments.plot)
    return 0


def _stopped(stop: CalibrationStopped) -> int:
    """Say the values so far."""
    print(f"fowt calibrate: stopped after {stop.tried} runs. Nearest to the record so far, with "
          f"{100 * stop.left:.3g} % of its std left: {stop.shown}. A fit with these in the model (--set) goes on from "
          "there.", file=sys.stderr)  # fmt: skip
    return 130
