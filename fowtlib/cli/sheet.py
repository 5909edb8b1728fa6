"""`fowt sheet`: the numbers of a model that people compare first, beside those of another model or program."""

from __future__ import annotations

import argparse
import math
from pathlib import Path
from typing import TYPE_CHECKING, Any

from fowtlib.cli import loading, tables
from fowtlib.cli.rao import frequencies
from fowtlib.cli.run import finite
from fowtlib.language.errors import ModelError

if TYPE_CHECKING:
    from fowtlib.analysis.sheet import Sheet

EXAMPLES = r"""Masses, centres, inertia; displaced volume, stiffness C and added mass A of
floating bodies about their frames; position and tensions at rest; natural
periods; response to waves of the linear model. Still water, no wind unless
--wind says so.

OTHER is a model, or a table (.csv) with the columns quantity, value and unit:
one that `fowt sheet -o` wrote, or the numbers of a report or another program
under the same names of quantities. Differences are in percent of them.

examples:
  fowt sheet oc3_spar_rigid -o spar.csv
  fowt sheet two_rotor_spar_rigid --against oc3_spar_rigid
  fowt sheet oc3_spar_rigid --against published.csv \
      --set platform.mooring.length=900
"""


def declare(commands: Any) -> None:
    """Add the command of this module."""
    text = "masses, stiffness, periods, tensions: a model on one page"
    parser = commands.add_parser("sheet", help=text, epilog=EXAMPLES)
    loading.declare(parser, waves=False)
    parser.add_argument("--against", metavar="OTHER", help="a model, or a table of numbers: .csv")
    form = "first:last:step"
    parser.add_argument("--frequencies", type=frequencies, metavar=form, help="of the response to waves [Hz]")
    parser.add_argument("--heading", type=finite, default=0.0, metavar="DEG", help="heading of the waves; default: 0")
    tables.declare(parser)
    parser.set_defaults(action=show_sheet)


def show_sheet(arguments: argparse.Namespace) -> int:
    """Print the sheet, or the differences to another."""
    tables.check(arguments)
    other = _other(arguments) if arguments.against else None
    arguments.wind = arguments.wind or "none"
    model, conditions = _at_rest(arguments)
    sheet = _sheet(arguments, model)
    tables.say(arguments, conditions)
    if other is None:
        tables.show(arguments, ("group", "quantity", "value", "unit"), sheet.rows())
        return 0
    rows = [(d.quantity, d.unit, d.first, d.second, d.percent) for d in sheet.against(other)]
    if not rows:
        raise ModelError(f"{other.name}: has no quantity of this sheet; its names are those of `fowt sheet`.")
    tables.show(arguments, ("quantity", "unit", sheet.name, other.name, "difference [%]"), rows)
    for one, another in ((sheet, other), (other, sheet)):
        if alone := one.without(another):
            tables.say(arguments, f"only {one.name} has: {', '.join(alone)}")
    return 0


def _at_rest(arguments: argparse.Namespace) -> tuple[Any, str]:
    """A model without wind has no part for `--wind none`."""
    if arguments.wind == "none" and "wind" not in loading.load_file(arguments, arguments.model).root.parts:
        arguments.wind = None
    return loading.load_at_rest(arguments)


def _sheet(arguments: argparse.Namespace, model: Any) -> Sheet:
    from fowtlib.analysis.sheet import FREQUENCIES, model_sheet

    chosen = arguments.frequencies or FREQUENCIES
    return model_sheet(model.compile(), frequencies=chosen, heading=math.radians(arguments.heading))


def _other(arguments: argparse.Namespace) -> Sheet:
    from fowtlib.analysis.sheet import Sheet

    if Path(arguments.against).suffix == ".csv":
        return Sheet.read(arguments.against)
    values = {**vars(arguments), "model": arguments.against, "settings": [], "wind": arguments.wind or "none"}
    given = argparse.Namespace(**values)
    return _sheet(given, _at_rest(given)[0])
