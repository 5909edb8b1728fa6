"""`fowt fatigue`: damage-equivalent loads of a result."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from fowtlib.cli import tables
from fowtlib.cli.run import finite, positive
from fowtlib.language.errors import ModelError

EXAMPLES = """The range of a steady cycle at --frequency that does the damage of the whole
series, by rainflow counting; M is the exponent of the S-N curve.

examples:
  fowt fatigue run.nc
  fowt fatigue run.nc thrust fairlead_tension_1 --exponent 3 5 --discard 100
  fowt fatigue openfast.outb --exponent 4 10 --output loads.csv
"""


def declare(commands: Any) -> None:
    """Add the command of this module."""
    text = "damage-equivalent loads of a result, by rainflow counting"
    parser = commands.add_parser("fatigue", help=text, epilog=EXAMPLES)
    parser.add_argument("result", type=Path, metavar="RESULT", help="a result: .nc, .csv, or .outb, also of OpenFAST")
    parser.add_argument("names", nargs="*", metavar="NAME", help="its series; default: all forces, moments, stresses")
    parser.add_argument(
        "--exponent", nargs="+", type=positive, default=[4.0, 10.0], metavar="M",
        help="of the S-N curve, one or more; default: 4 (welded steel) and 10 (glass fibre)",
    )  # fmt: skip
    parser.add_argument("--discard", type=not_negative, default=0.0, metavar="S", help="left out at the start [s]")
    parser.add_argument(
        "--frequency", type=positive, default=1.0, metavar="HZ", help="of the equivalent cycles [Hz]; default: 1"
    )
    parser.add_argument("--bins", type=whole, metavar="N", help="sort ranges into N classes; default: as they are")
    tables.declare(parser)
    parser.set_defaults(action=show_loads)


def not_negative(text: str) -> float:
    """A number of zero or more, for argparse."""
    value = finite(text)
    if value < 0:
        raise argparse.ArgumentTypeError(f"'{text}' is below 0")
    return value


def whole(text: str) -> int:
    """1, 2, ..., for argparse."""
    if not text.isdecimal() or int(text) < 1:
        raise argparse.ArgumentTypeError(f"'{text}' is not a number of classes (1, 2, ...)")
    return int(text)


def show_loads(arguments: argparse.Namespace) -> int:
    """Print the equivalent loads, a row per series and a column per exponent."""
    from fowtlib.analysis import equivalent_loads
    from fowtlib.solving.results import Result

    tables.check(arguments)
    path, exponents = arguments.result, list(dict.fromkeys(arguments.exponent))
    result = Result.open(path)
    try:
        loads = equivalent_loads(
            result, exponents, names=arguments.names, discard=arguments.discard, frequency=arguments.frequency,
            bins=arguments.bins,
        )  # fmt: skip
    except ModelError as error:
        raise error.at(str(path)) from None
    if not loads:
        raise ModelError(f"{path}: no series of it is a force, a moment or a stress; name the series that you mean.")
    first = result.time[0] + arguments.discard
    tables.say(
        arguments,
        f"ranges of {arguments.frequency:g} Hz that do the damage of {first:g} to {result.time[-1]:g} s",
    )
    units = {name: unit for name, unit, _ in result.stored.columns()}
    rows = [(name, units.get(name, result.unit(name)), *loads[name].values()) for name in loads]
    tables.show(arguments, ("result", "unit", *(f"m = {m:g}" for m in exponents)), rows)
    return 0
