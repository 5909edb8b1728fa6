"""`fowt scale`: a model in another scale by Froude similarity, as a model file."""

from __future__ import annotations

import argparse
import math
from fractions import Fraction
from pathlib import Path
from typing import Any

from fowtlib.cli import loading, tables
from fowtlib.cli.files import check_target, say_saved
from fowtlib.language.errors import ModelError

EXAMPLES = """New = factor x old: lengths by --by, times by its square root, masses by
density ratio times its cube; --by 1/45 makes a tank model of a prototype.
Prints the factors; hydrodynamic data and beams are scaled too and written
beside FILE. Turbulence and gusts of standards, controller libraries and files
in their own units cannot be scaled: take another wind, for example.

examples:
  fowt scale oc3_spar_rigid --wind none --by 1/45 -o oc3_tank.yaml
  fowt scale oc3_spar_rigid --wind none --by 1/45 --density-ratio 1000/1025
"""


def declare(commands: Any) -> None:
    """Add the command of this module."""
    text = "a model in another scale (Froude), as a model file; the factors"
    parser = commands.add_parser("scale", help=text, epilog=EXAMPLES)
    loading.declare(parser)
    add = parser.add_argument
    add("--by", required=True, type=ratio, metavar="R", help="length of the new model over the old one, such as 1/45")
    add("--density-ratio", type=ratio, default=1.0, metavar="R", help="density of the new water over the old one")
    add("--wind-ratio", type=ratio, default=1.0, metavar="R", help="of wind speeds, beyond the scale of speeds")
    add("--unit", action="append", default=[], metavar="PATH=UNIT", help="unit of a signal that nothing says")
    add("-o", "--output", type=Path, metavar="FILE", help="save the model: .yaml")
    tables.declare(parser, output=False)
    parser.set_defaults(action=scale)


def ratio(text: str) -> float:
    """A positive number or quotient such as 1/45, for argparse."""
    try:
        value = float(Fraction(text)) if "/" not in text else math.prod(_parts(text))
    except (ValueError, ZeroDivisionError):
        value = math.nan
    if not (math.isfinite(value) and value > 0):
        raise argparse.ArgumentTypeError(f"'{text}' is no ratio above 0, such as 1/45 or 1000/1025")
    return value


def _parts(text: str) -> tuple[float, float]:
    above, below = text.split("/")
    return float(above), 1 / float(below)


def scale(arguments: argparse.Namespace) -> int:
    """Scale a model, print the factors and save it."""
    import fowtlib as fw
    from fowtlib.analysis.scaling import store_data
    from fowtlib.language.similarity import Similarity, factors
    from fowtlib.language.whole_files import write_text

    check_target(arguments.output, (".yaml",), arguments.force)
    units = dict(_unit(text) for text in arguments.unit)
    model = loading.load(arguments)
    ratios = {"density_ratio": arguments.density_ratio, "wind_ratio": arguments.wind_ratio}
    other = fw.scaled(model, arguments.by, **ratios, units=units)
    written = []
    if arguments.output:
        written = store_data(other, arguments.output)
        write_text(arguments.output, fw.dump(other))
    rows = factors(Similarity(arguments.by, arguments.density_ratio, arguments.wind_ratio)).items()
    tables.show(arguments, ("quantity", "new / old"), rows, f"{arguments.model} in the scale {arguments.by:.5g}")
    say_saved(*written, arguments.output)
    return 0


def _unit(text: str) -> tuple[str, str]:
    path, sign, unit = text.partition("=")
    if not sign or not path or not unit:
        raise ModelError(f"--unit: '{text}' is not PATH=UNIT, such as drive.y=N.")
    return path, unit
