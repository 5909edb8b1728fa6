"""`fowt decay`: period and damping of a motion released from an offset in still water, or of a record."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING, Any

from fowtlib.cli import loading, tables
from fowtlib.cli.files import FIGURES, check_target, say_saved
from fowtlib.cli.progress import progress_bar
from fowtlib.cli.run import finite, not_negative, positive
from fowtlib.language.errors import ModelError

if TYPE_CHECKING:
    from fowtlib.analysis import Decay

FITS = ("sinusoid", "line", "equation")
RECORDS = (".nc", ".csv", ".outb")

EXAMPLES = """About the mean position: in still water, and in the wind of --wind or of the
model, at its mean speed. In place of MODEL a result file or a measured record
(.nc, .csv, .outb; a CSV file has a first line such as time [s],heave [m]).

--fit adds numbers with their 95 % intervals: sinusoid (one damping for all
cycles), line (linear and quadratic damping from half cycles, Faltinsen 1990) or
equation (both, from the equation of motion fitted to the record).

examples:
  fowt decay oc3_spar_rigid --wind none --dof surge --offset 10 --plot surge.png
  fowt decay heave_test.csv --dof heave --fit line
"""


def declare(commands: Any) -> None:
    """Add the command of this module."""
    parser = commands.add_parser("decay", help="free decay of one motion: period, damping ratio, plot", epilog=EXAMPLES)
    loading.declare(parser, waves=False)
    parser.add_argument("--dof", required=True, metavar="NAME", help="the result that is released, for example surge")
    parser.add_argument("--offset", type=finite, metavar="X", help="distance from rest [m or deg]; not of a record")
    parser.add_argument("--time", type=positive, default=600.0, metavar="S", help="duration [s]; default: 600")
    parser.add_argument("--discard", type=not_negative, metavar="S", help="without the first S seconds of a record")
    parser.add_argument("--fit", choices=FITS, metavar="WAY", help="with intervals: sinusoid, line or equation")
    parser.add_argument("--plot", type=Path, metavar="FILE", help="draw the decay: .png, .svg or .pdf")
    tables.declare(parser)
    parser.set_defaults(action=show_decay)


def show_decay(arguments: argparse.Namespace) -> int:
    """Print period and damping ratio of a free decay, and draw it."""
    check_target(arguments.plot, FIGURES, arguments.force)
    tables.check(arguments)
    measured = Path(arguments.model).suffix in RECORDS
    decay, conditions = _of_record(arguments) if measured else _of_model(arguments)
    rows = _rows(decay, arguments.offset or 0.0)
    columns: tuple[str, ...] = ("quantity", "value", "unit")
    if arguments.fit:
        from fowtlib.analysis.decay_fits import METHODS

        fit = METHODS[arguments.fit](decay.series)
        fitted = fit.rows(float(decay.amplitude[0]))
        rows = [(name, value, unit, None, None) for name, value, unit in rows]
        rows += [(f"{name} ({arguments.fit})", value, unit, low, high) for name, value, low, high, unit in fitted]
        columns = (*columns, "from", "to")
        left = f"left over: {fit.residual:.3g} {decay.series.unit}, correlation of neighbours {fit.correlation:.2f}"
        conditions = "\n".join(filter(None, (conditions, f"{arguments.fit}: {left}")))
    if arguments.plot:
        from fowtlib.solving.results.plots import plot_decay

        plot_decay(decay, path=arguments.plot)
    tables.say(arguments, conditions)
    tables.show(arguments, columns, rows, f"free decay of {arguments.dof}")
    say_saved(arguments.plot)
    return 0


def _of_model(arguments: argparse.Namespace) -> tuple[Decay, str]:
    """The decay of a run, and its conditions."""
    from fowtlib.analysis import free_decay

    if arguments.offset is None:
        raise ModelError("--offset: say how far from rest the motion begins, for example --offset 10.")
    if arguments.discard is not None:
        raise ModelError("--discard is for records; the run of a model begins with the release.")
    model, conditions = loading.load_at_rest(arguments)
    plant = model.compile()
    with progress_bar() as report:
        decay = free_decay(plant, arguments.dof, arguments.offset, duration=arguments.time, progress=report)
    return decay, conditions


def _of_record(arguments: argparse.Namespace) -> tuple[Decay, str]:
    """The decay of a file, and what was left out of it."""
    from fowtlib.analysis import analyse_decay
    from fowtlib.analysis.series import as_series
    from fowtlib.solving.results import Result

    for option in ("offset", "wind", "settings"):
        if getattr(arguments, option) not in (None, []):
            name = "set" if option == "settings" else option
            raise ModelError(f"--{name} is for a model; {arguments.model} is a record.")
    series = as_series(Result.open(arguments.model)[arguments.dof])
    discarded = f"without the first {arguments.discard:g} s" if arguments.discard else ""
    return analyse_decay(series.after(arguments.discard or 0.0)), discarded


def _rows(decay: Decay, size: float) -> list[tuple[Any, ...]]:
    """Quantity, value, unit."""
    unit = decay.series.unit
    return [
        ("rest", tables.rounded(decay.rest, size), unit),
        ("period", decay.period, "s"),
        ("frequency", decay.frequency, "Hz"),
        ("damping ratio", decay.damping_ratio, "1"),
        ("damping ratio at zero amplitude", decay.damping_at_zero, "1"),
        ("damping ratio per amplitude", decay.damping_slope, f"1/{unit}"),
    ]
