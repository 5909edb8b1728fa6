"""`fowt decay`: release a motion from an offset in still water, and read its period and damping."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from fowtlib.cli import loading, tables
from fowtlib.cli.files import FIGURES, check_target, say_saved
from fowtlib.cli.progress import progress_bar
from fowtlib.cli.run import finite, positive

EXAMPLES = """About the mean position: in still water, and in the wind of --wind or of the
model, at its mean speed.

examples:
  fowt decay oc3_spar_rigid --wind none --dof surge --offset 10 --plot surge.png
"""


def declare(commands: Any) -> None:
    """Add the command of this module."""
    parser = commands.add_parser("decay", help="free decay of one motion: period, damping ratio, plot", epilog=EXAMPLES)
    loading.declare(parser, waves=False)
    parser.add_argument("--dof", required=True, metavar="NAME", help="the result that is released, for example surge")
    parser.add_argument("--offset", required=True, type=finite, metavar="X", help="distance from rest [m or deg]")
    parser.add_argument("--time", type=positive, default=600.0, metavar="S", help="duration [s]; default: 600")
    parser.add_argument("--plot", type=Path, metavar="FILE", help="draw the decay: .png, .svg or .pdf")
    tables.declare(parser)
    parser.set_defaults(action=show_decay)


def show_decay(arguments: argparse.Namespace) -> int:
    """Print period and damping ratio of a free decay, and draw it."""
    from fowtlib.analysis import free_decay

    check_target(arguments.plot, FIGURES, arguments.force)
    tables.check(arguments)
    model, conditions = loading.load_at_rest(arguments)
    plant = model.compile()
    with progress_bar() as report:
        decay = free_decay(plant, arguments.dof, arguments.offset, duration=arguments.time, progress=report)
    if arguments.plot:
        from fowtlib.solving.results.plots import plot_decay

        plot_decay(decay, path=arguments.plot)
    unit = decay.series.unit
    rows = [
        ("rest", tables.rounded(decay.rest, arguments.offset), unit),
        ("period", decay.period, "s"),
        ("frequency", decay.frequency, "Hz"),
        ("damping ratio", decay.damping_ratio, "1"),
        ("damping ratio at zero amplitude", decay.damping_at_zero, "1"),
        ("damping ratio per amplitude", decay.damping_slope, f"1/{unit}"),
    ]
    tables.say(arguments, conditions)
    tables.show(arguments, ("quantity", "value", "unit"), rows, f"free decay of {arguments.dof}")
    say_saved(arguments.plot)
    return 0
