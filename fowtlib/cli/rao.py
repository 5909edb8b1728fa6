"""`fowt rao`: response per metre of wave over frequency, from the linear model or from runs."""

from __future__ import annotations

import argparse
import math
import warnings
from pathlib import Path
from typing import TYPE_CHECKING, Any

from fowtlib.cli import loading, tables
from fowtlib.cli.files import FIGURES, check_target, say_saved
from fowtlib.cli.run import finite, numbers, positive
from fowtlib.language.errors import ModelError

if TYPE_CHECKING:
    from fowtlib import Model
    from fowtlib.analysis.rao import Rao

AT_REST = 1e-9  # amplitude per metre of wave below which a person is not shown a motion

EXAMPLES = """About the mean position, in the wind of --wind or of the model, at its mean
speed. Without --frequencies every 0.005 Hz, closer near the natural modes.

Of rotors of blade elements that turn, the linear model is the mean over a
revolution. Where a motion grows in the wind of the model, so that there is no
steady response, the answer is that without wind, and says so; --runs takes the
response in that wind from runs in regular waves, with drag, one per frequency.

examples:
  fowt rao oc3_spar_rigid --plot rao.png
  fowt rao oc3_spar_rigid --wind none --frequencies 0.05,0.1 --heading 30
  fowt rao oc3_spar_rigid --wind steady:18 --frequencies 0.1 --runs 2
"""


def declare(commands: Any) -> None:
    """Add the command of this module."""
    text = "response per metre of wave over frequency, from the linear model"
    parser = commands.add_parser("rao", help=text, epilog=EXAMPLES)
    loading.declare(parser, waves=False)
    form = "first:last:step"
    parser.add_argument("--frequencies", type=frequencies, metavar=form, help="wave frequencies [Hz]")
    parser.add_argument("--heading", type=finite, default=0.0, metavar="DEG", help="heading of the waves; default: 0")
    text = "from runs in regular waves of this height [m], one for each of --frequencies"
    parser.add_argument("--runs", type=positive, metavar="HEIGHT", help=text)
    parser.add_argument("--plot", type=Path, metavar="FILE", help="draw the response: .png, .svg or .pdf")
    tables.declare(parser)
    parser.set_defaults(action=show_rao)


def frequencies(text: str) -> list[float]:
    """`0.02:0.2:0.005`, both ends included, or single frequencies `0.05,0.1`; for argparse."""
    values = numbers(text)
    if not len(values) or values.min() <= 0:
        raise argparse.ArgumentTypeError(f"'{text}' is not first:last:step in Hz, for example 0.02:0.2:0.005")
    return values.tolist()


def show_rao(arguments: argparse.Namespace) -> int:
    """Print amplitude and phase of every motion, and draw them."""
    check_target(arguments.plot, FIGURES, arguments.force)
    tables.check(arguments)
    if arguments.runs and not arguments.frequencies:
        raise ModelError("--runs: one run for each frequency; give them by --frequencies, for example 0.05,0.1.")
    model, conditions = loading.load_at_rest(arguments)
    rao, conditions = _response(arguments, model, conditions)
    silent = [f for f, row in zip(rao.frequency, rao.response, strict=True) if not row.any()]
    if silent:
        warnings.warn(f"no wave load from {min(silent):g} Hz on: the hydrodynamic data end below.", stacklevel=1)
    moving = [name for name in rao.outputs if rao.amplitude(name).max() > AT_REST]
    if arguments.plot:
        about = "\n".join(filter(None, (model.title or model.name, conditions.partition(", waves")[0])))
        from fowtlib.solving.results.plots import plot_rao

        plot_rao(rao, path=arguments.plot, outputs=moving, title=about)
    names = rao.outputs if arguments.form else moving
    heads = [(f"{name} [{rao.unit(name)}]", f"{name} phase [deg]") for name in names]
    series = [rao.frequency, *(values for name in names for values in (rao.amplitude(name), rao.phase(name)))]
    columns = ("frequency [Hz]", *(head for pair in heads for head in pair))
    tables.say(arguments, conditions)
    tables.show(arguments, columns, [list(map(float, row)) for row in zip(*series, strict=True)])
    say_saved(arguments.plot)
    return 0


def _response(arguments: argparse.Namespace, model: Model, conditions: str) -> tuple[Rao, str]:
    """The response, and the conditions in which it was found."""
    from fowtlib.analysis import linear_rao, simulated_rao
    from fowtlib.analysis.plants import UnstableError

    heading = math.radians(arguments.heading)
    if arguments.runs:
        rao = simulated_rao(model, arguments.frequencies, height=arguments.runs, heading=heading, in_wind=True)
        wind = conditions.partition("waves ")[0]
        return rao, f"{wind}waves regular, {arguments.runs:g} m high (--runs)"
    try:
        return linear_rao(model.compile(), arguments.frequencies, heading=heading), conditions
    except UnstableError as error:
        wind = conditions.partition(", waves")[0]
        if "wind" not in model.root.parts or model.root.parts["wind"].kind == "none":
            raise
        ways = "--runs HEIGHT finds it from runs in waves, with drag"
        if arguments.wind:
            raise UnstableError(f"{wind}: {error} Take another wind, or --wind none; {ways}.") from None
        warnings.warn(f"{wind}: {error} What follows is without wind; {ways}.", stacklevel=1)
        parked = model.with_parameters({"wind.kind": "none"})
        return linear_rao(parked.compile(), arguments.frequencies, heading=heading), (
            f"wind none (in place of {wind.removeprefix('wind ')})" + conditions[len(wind) :]
        )
