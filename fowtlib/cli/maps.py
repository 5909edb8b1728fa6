"""`fowt map`: quantities at rest over one or two parameters, with limits."""

from __future__ import annotations

import argparse
import warnings
from pathlib import Path
from typing import Any

from fowtlib.cli import loading, tables
from fowtlib.cli.files import FIGURES, check_target, say_saved
from fowtlib.cli.run import numbers
from fowtlib.language.errors import ModelError

EXAMPLES = """A quantity is a result of the model, any of its variables, a number of `fowt
sheet` (mass, C33, turbine: mass), or the period or damping ratio of a natural
mode. In still water, and in the wind of --wind or of the model, at its mean
speed. VALUES: first:last:step or a list, with a unit behind, or in SI.

examples:
  fowt map oc3_spar_rigid --over wind.mean_speed=4:11:0.5 --of pitch,surge
  fowt map oc3_spar_rigid --over 'platform.hull.mass=7200:7700:50 t' \\
      --over 'platform.mooring.yaw_stiffness=50:200:10 MN*m/rad' \\
      --of 'pitch,period of platform yaw' --limit 'pitch < 5 deg' \\
      --limit 'period of platform yaw < 9 s' --plot map.png
"""


def declare(commands: Any) -> None:
    """Add the command of this module."""
    text = "quantities at rest over one or two parameters, with limits"
    parser = commands.add_parser("map", help=text, epilog=EXAMPLES)
    loading.declare(parser, waves=False)
    add = parser.add_argument
    add("--over", type=grid, metavar="PATH=VALUES", action="append", required=True,
        help="a parameter; one or two times")  # fmt: skip
    add("--of", type=names, metavar="NAME,...", default=[], help="quantities")
    add("--limit", metavar="TEXT", action="append", default=[], help="such as 'pitch < 5 deg'; may be repeated")
    add("--free", metavar="PATH", action="append", default=[],
        help="a parameter that takes the value at which --target holds, at each point")  # fmt: skip
    add("--target", type=condition, metavar="NAME=VALUE", action="append", default=[],
        help="a condition, as many as --free")  # fmt: skip
    add("--plot", type=Path, metavar="FILE", help="draw curves or contours: .png, .svg or .pdf")
    tables.declare(parser)
    parser.set_defaults(action=show_map)


def grid(text: str) -> tuple[str, list[str]]:
    """`path=first:last:step unit`, for argparse."""
    path, given, values = text.partition("=")
    words, _, unit = values.strip().partition(" ")
    found = [f"{value!r} {unit}".strip() for value in numbers(words).tolist()]
    if not given or not path.strip() or not found:
        raise argparse.ArgumentTypeError(f"'{text}' is not path=first:last:step, with a unit behind where it is not SI")
    return path.strip(), found


def condition(text: str) -> tuple[str, str]:
    """`name=value`, for argparse."""
    name, given, value = text.partition("=")
    if not (given and name.strip() and value.strip()):
        raise argparse.ArgumentTypeError(f"'{text}' is not name=value, such as heave=0")
    return name.strip(), value.strip()


def names(text: str) -> list[str]:
    """Names between commas, for argparse."""
    return [word.strip() for word in text.split(",") if word.strip()]


def show_map(arguments: argparse.Namespace) -> int:
    """Print the grid point by point, and draw it; status 1 where no point keeps the limits."""
    from fowtlib.analysis.maps import parameter_map
    from fowtlib.cli.progress import part_bar

    check_target(arguments.plot, FIGURES, arguments.force)
    tables.check(arguments)
    over = dict(arguments.over)
    if len(over) < len(arguments.over):
        raise ModelError(f"--over: {arguments.over[-1][0]} is given twice.")
    model, conditions = loading.load_at_rest(arguments)
    plant = model.compile()
    with part_bar("points") as progress:
        found = parameter_map(plant, over, arguments.of, limits=arguments.limit, free=arguments.free,
                              targets=dict(arguments.target), progress=progress)  # fmt: skip
    if arguments.plot:
        found.plot(arguments.plot, "\n".join(filter(None, (model.title or model.name, conditions))))
    tables.say(arguments, conditions)
    tables.show(arguments, found.heads(), found.rows())
    for place, sentence in list(found.failures.items())[:1]:
        at = ", ".join(f"{a.path} = {a.values[k]:.6g} {a.unit}" for a, k in zip(found.axes, place, strict=True))
        warnings.warn(f"{_points(len(found.failures))} no equilibrium, or not all quantities; at {at}: {sentence}",
                      stacklevel=1)  # fmt: skip
    say_saved(arguments.plot)
    return int(bool(found.limits) and not found.feasible.any())


def _points(number: int) -> str:
    return "1 point has" if number == 1 else f"{number} points have"
