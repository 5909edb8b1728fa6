"""`fowt wind-field`: generate a turbulent wind over a plane, for `--wind field:FILE`."""

from __future__ import annotations

import argparse
import math
from pathlib import Path
from typing import Any

from fowtlib.cli import tables
from fowtlib.cli.files import check_target, say_saved
from fowtlib.cli.progress import part_bar
from fowtlib.cli.run import finite, positive
from fowtlib.language.errors import ParameterError

ENDINGS = (".bts",)
EXAMPLES = r"""The field is as wide as all rotors and their motion: two rotors of 63 m radius
at y = -69.3 m and 69.3 m need 265 m, and some metres more for sway and roll.

examples:
  fowt wind-field hub.bts --speed 11.4 --width 160 --height 160
  fowt wind-field two.bts --speed 11.4 --class A --width 300 --height 150 \
      --time 4000 --seed 3
  fowt run two_rotor_spar_rigid --wind field:two.bts
"""


def declare(commands: Any) -> None:
    """Add the command of this module."""
    parser = commands.add_parser("wind-field", help="generate a turbulent wind field (.bts)", epilog=EXAMPLES)
    parser.add_argument("file", type=Path, metavar="FILE", help="the field, in TurbSim's format: .bts")
    parser.add_argument("--speed", type=positive, required=True, metavar="V", help="mean speed at hub height [m/s]")
    parser.add_argument("--width", type=positive, required=True, metavar="M", help="across the wind, about y = 0 [m]")
    parser.add_argument("--height", type=positive, required=True, metavar="M", help="height of the plane [m]")
    parser.add_argument("--hub-height", type=positive, default=90.0, metavar="M", help="default: %(default)g m")
    parser.add_argument("--bottom", type=positive, metavar="M", help="lowest row [m]; default: centred at the hub")
    parser.add_argument("--spacing", type=positive, default=10.0, metavar="M", help="at most; default: %(default)g m")
    parser.add_argument("--time", type=positive, default=600.0, metavar="S", help="until it repeats; default: 600 s")
    parser.add_argument("--step", type=positive, default=0.05, metavar="S", help="default: %(default)g s")
    strength = parser.add_mutually_exclusive_group()
    parser.add_argument("--model", choices=("ntm", "etm", "ewm"), metavar="NAME",
                        help="turbulence of IEC 61400-1: ntm, normal; etm, extreme; ewm, of the extreme wind speed; "
                             "default: ntm")  # fmt: skip
    parser.add_argument("--wind-class", choices=("I", "II", "III"), metavar="I|II|III", help="of etm; default: I")
    strength.add_argument("--class", dest="turbulence_class", choices=("A+", "A", "B", "C"),
                          metavar="A+|A|B|C", help="turbulence class of IEC 61400-1; default: B")  # fmt: skip
    strength.add_argument("--intensity", type=positive, metavar="TI", help="standard deviation of u over mean speed")
    parser.add_argument("--spectrum", choices=("kaimal", "von_karman"), default="kaimal", metavar="NAME",
                        help="kaimal or von_karman; default: kaimal")  # fmt: skip
    parser.add_argument("--shear", type=finite, default=0.2, metavar="A", help="power law; default: %(default)g")
    parser.add_argument("--lateral", choices=("none", "iec"), default="none", metavar="NAME",
                        help="coherence of v and w: none, or iec, that of u; default: none")  # fmt: skip
    parser.add_argument("--seed", type=int, default=1, metavar="N", help="number of the realisation; default: 1")
    tables.declare(parser)
    parser.set_defaults(action=generate)


def _intensity(arguments: argparse.Namespace) -> float | None:
    """Standard deviation of u over the mean speed; None: that of normal turbulence. ParameterError for idle options."""
    from fowtlib.components.environment import iec

    model, given = arguments.model, arguments.intensity
    idle = [
        ("--model", "--intensity", model is not None and given is not None),
        ("--wind-class", "--model other than etm", arguments.wind_class is not None and model != "etm"),
        ("--class", "--model ewm", arguments.turbulence_class is not None and model == "ewm"),
    ]
    for option, because, wrong in idle:
        if wrong:
            raise ParameterError(f"{option} would do nothing with {because}; leave one of them out.")
    if model == "ewm":
        return iec.EXTREME_INTENSITY
    if model == "etm":
        reference = iec.REFERENCE_SPEED[arguments.wind_class or "I"]
        sigma = iec.extreme_turbulence(arguments.speed, arguments.turbulence_class or "B", reference)
        return sigma / arguments.speed
    return given


def generate(arguments: argparse.Namespace) -> int:
    """Write the field, and say what it holds."""
    from fowtlib.components.environment import generate_field

    check_target(arguments.file, ENDINGS, arguments.force)
    intensity = _intensity(arguments)
    columns, rows = (
        max(2, math.ceil(size / arguments.spacing - 1e-9) + 1) for size in (arguments.width, arguments.height)
    )
    with part_bar("generating the wind field") as report:
        grid = generate_field(
            arguments.file, mean_speed=arguments.speed, width=arguments.width, height=arguments.height, columns=columns,
            rows=rows, duration=arguments.time, time_step=arguments.step, hub_height=arguments.hub_height,
            bottom=arguments.bottom, spectrum=arguments.spectrum, turbulence_class=arguments.turbulence_class or "B",
            turbulence_intensity=intensity, shear_exponent=arguments.shear,
            lateral_coherence=arguments.lateral, seed=arguments.seed, progress=report,
        ).grid  # fmt: skip
    table = [
        ("y", "m", float(grid.y[0]), float(grid.y[-1]), columns),
        ("z", "m", float(grid.z[0]), float(grid.z[-1]), rows),
        ("time", "s", 0.0, grid.duration, grid.steps),
    ]
    tables.show(arguments, ("axis", "unit", "from", "to", "points"), table, f"{arguments.speed:g} m/s at the hub")
    say_saved(arguments.file)
    return 0
