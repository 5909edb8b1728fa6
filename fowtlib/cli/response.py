"""`fowt response`: what random waves and wind do to a model, from its linear model, without a run."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from fowtlib.cli import loading, tables
from fowtlib.cli.files import FIGURES, check_target, say_saved
from fowtlib.cli.run import finite
from fowtlib.cli.weather import weather

LEAST = 1e-9  # deviation over the size of the mean, below which a person is not shown a result

EXAMPLES = """About the mean position, with the controllers in the loop. Below: mean, standard
deviation, that of each process alone, the median of the largest and of the
smallest value in --hours, and the damage-equivalent range of 1 Hz (Dirlik).
Left out: loads of second order, limits of controllers, changes of their region.

examples:
  fowt response oc3_spar_rigid --wind kaimal:18,class=B --waves jonswap:Hs=4,Tp=10
  fowt response oc3_spar_rigid --outputs surge,pitch,thrust --plot spectra.png
"""


def declare(commands: Any) -> None:
    """Add the command of this module."""
    text = "spectra, extremes and fatigue in random waves and wind, without a run"
    parser = commands.add_parser("response", help=text, epilog=EXAMPLES)
    loading.declare(parser)
    parser.add_argument("--outputs", metavar="A,B", help="results; default: all")
    parser.add_argument("--hours", type=finite, default=1.0, metavar="H", help="duration of the extremes; default: 1")
    parser.add_argument("--exponent", type=finite, default=4.0, metavar="M", help="of the S-N curve; default: 4")
    parser.add_argument("--plot", type=Path, metavar="FILE", help="draw the spectra: .png, .svg or .pdf")
    parser.add_argument("--spectra", type=Path, metavar="FILE", help="save the spectra: .csv or .nc")
    tables.declare(parser)
    parser.set_defaults(action=show_response)


def show_response(arguments: argparse.Namespace) -> int:
    """Print the statistics of every result, and draw and save the spectra."""
    from fowtlib.frequency import response

    check_target(arguments.plot, FIGURES, arguments.force)
    check_target(arguments.spectra, (".csv", ".nc"), arguments.force)
    tables.check(arguments)
    model = loading.load(arguments)
    names = arguments.outputs.split(",") if arguments.outputs else None
    found = response(model, outputs=names)
    moving = [name for name, mean in zip(found.outputs, found.mean, strict=True)
              if found.std(name) > LEAST * max(abs(mean), 1e-6)]  # fmt: skip
    if arguments.plot:
        found.plot(arguments.plot, outputs=moving)
    processes = list(found.shares)
    columns = ["result", "mean", "std", *(f"std by {name}" for name in processes), "largest", "smallest", "range"]
    rows = []
    for name in found.outputs if arguments.form else moving:
        extremes = [found.extreme(name, 3600 * arguments.hours, side=side) for side in ("max", "min")]
        shares = [found.std(name, process) for process in processes]
        mean, unit = float(found.mean[found.outputs.index(name)]), found.unit(name)
        load = found.equivalent_load(name, arguments.exponent)
        rows.append([f"{name} [{unit}]", mean, found.std(name), *shares, *extremes, load])
    tables.say(arguments, weather(model, arguments))
    tables.show(arguments, columns, rows)
    say_saved(arguments.plot)
    if arguments.spectra:
        say_saved(found.save(arguments.spectra))
    return 0
