"""`fowt sensitivity`: how the results of a run change with parameters."""

from __future__ import annotations

import argparse
import math
from pathlib import Path
from typing import TYPE_CHECKING, Any

from fowtlib.cli import events, loading, tables
from fowtlib.cli.files import FIGURES, check_target, say_saved
from fowtlib.cli.progress import progress_bar
from fowtlib.cli.run import not_negative, positive
from fowtlib.cli.weather import weather
from fowtlib.language.errors import ModelError, SimulationError

if TYPE_CHECKING:
    from fowtlib.solving import Sensitivities

START = (
    "equilibrium: the mean position, which moves with the parameters; rest: nothing moves; file: the start values of "
    "the model file; or a FILE: the end of a result (.nc), a saved state (.json); default: simulation.start of the "
    "model file, or file"
)
EXAMPLES = r"""The derivatives of a run of the solver fixed, exact for what it computes, from
one run for all parameters. Below: those of mean, standard deviation, largest
and smallest value, and the damage-equivalent range of 1 Hz; in the unit of the
result per SI unit of the parameter. --output saves them at each output point.

examples:
  fowt sensitivity oc3_spar_rigid --wind steady:14 --waves regular:H=4,T=9 \
      --parameter platform.mooring.length --parameter platform.hull.mass \
      --time 200 --result surge --result fairlead_tension_2 --plot slopes.png
"""


def declare(commands: Any) -> None:
    """Add the command of this module."""
    text = "how the results of a run in time change with parameters"
    parser = commands.add_parser("sensitivity", help=text, epilog=EXAMPLES)
    loading.declare(parser)
    parser.add_argument(
        "--parameter", dest="parameters", metavar="PATH", action="append", required=True,
        help="a tunable parameter, or an element of it: a.b[0]; may be repeated",
    )  # fmt: skip
    parser.add_argument(
        "--result", dest="results", metavar="NAME", action="append",
        help="a result or a variable by path; may be repeated; default: all results that change",
    )  # fmt: skip
    parser.add_argument("--time", type=positive, metavar="S", help="end time [s]; default: the model file's")
    parser.add_argument(
        "--output-step", type=positive, metavar="S", help="time between results [s]; default: the model file's"
    )
    parser.add_argument("--step", metavar="T", help="step of the solver fixed [s], or 12.5ms")
    parser.add_argument("--tolerance", type=positive, metavar="RTOL", help="relative; default: the model file's")
    parser.add_argument("--start", metavar="HOW", default="", help=START)
    events.declare_option(parser)
    parser.add_argument(
        "--discard", type=not_negative, metavar="S", default=0.0, help="numbers without the first S seconds"
    )
    parser.add_argument("--exponent", type=positive, default=4.0, metavar="M", help="of the S-N curve; default: 4")
    parser.add_argument("--plot", type=Path, metavar="FILE", help="draw the changes for 1 %%: .png, .svg or .pdf")
    tables.add_output(parser, "output", "save the derivatives over time: .nc or .csv")
    tables.declare(parser, output=False)
    parser.set_defaults(action=show_sensitivities)


def show_sensitivities(arguments: argparse.Namespace) -> int:
    """Print the derivatives of the numbers of a run, and draw and save those of its results over time."""
    from fowtlib.solving import sensitivities

    check_target(arguments.plot, FIGURES, arguments.force)
    check_target(arguments.output, (".nc", ".csv"), arguments.force)
    happening = events.chosen(arguments)
    model = loading.load(arguments)
    plant = model.compile()
    try:
        with progress_bar() as report:
            found = sensitivities(plant, arguments.parameters, arguments.results, t_end=arguments.time,
                                  output_step=arguments.output_step, start=arguments.start, step=arguments.step,
                                  tolerance=arguments.tolerance, events=happening, progress=report)  # fmt: skip
    except ModelError as error:
        for word, option in (("by: ", "--parameter: "), ("start: ", "--start: ")):
            if error.message.startswith(word):
                error.message = option + error.message.removeprefix(word)
        raise
    names = [name for name in found.results if arguments.results or _changes(found, name)]
    rows = [row for name in names for row in _rows(found, name, arguments.discard, arguments.exponent)]
    if arguments.plot:
        found.plot(arguments.plot, names)
    tables.say(arguments, weather(model, arguments))
    columns = ("result", "parameter", "its value", "unit of slope", "mean", "std", "max", "min", "range")
    tables.show(arguments, columns, rows, f"{arguments.discard:g} s to {found.time[-1]:g} s, d result / d parameter")
    tables.say(arguments, _memory(found))
    if arguments.output:
        found.save(arguments.output)
    say_saved(arguments.output, arguments.plot)
    return 0


def _changes(found: Sensitivities, name: str) -> bool:
    return bool((found.derivatives[:, found.results.index(name)] != 0).any())


def _rows(found: Sensitivities, name: str, discard: float, exponent: float) -> list[list[Any]]:
    """For each parameter the slopes of the numbers of a result; None where it does not move."""
    from fowtlib.analysis import damage_equivalent_load

    numbers = [found.mean(name, discard)]
    try:
        spread = [found.std(name, discard)]
        load = [found.slopes_of(lambda t, y: damage_equivalent_load((t, y), exponent), name, discard=discard)]
    except SimulationError:
        spread, load = [None], [None]
    numbers += [*spread, found.maximum(name, discard), found.minimum(name, discard), *load]
    rows = []
    for k, parameter in enumerate(found.parameters):
        slopes = [None if number is None else float(number.by[k]) for number in numbers]
        rows.append([name, parameter, float(found.at[k]), found.unit(name, parameter), *slopes])
    return rows


def _memory(found: Sensitivities) -> str:
    """Whether the motion forgets its start, in the second half of the run."""
    half = (found.time[0] + found.time[-1]) / 2
    if not math.isfinite(found.growth):
        return f"whether the motion forgets its start cannot be told from {found.time[-1]:g} s; take a longer run"
    growth = "forgets its start" if found.growth < 0 else "does not forget its start"
    return f"from {half:g} s on the motion {growth}: perturbations change by {found.growth:+.3g} 1/s"
