"""`fowt contours`: states of wind and sea with a return period."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from fowtlib.cli import site, tables
from fowtlib.cli.files import FIGURES, check_target, say_saved
from fowtlib.cli.run import positive

EXAMPLES = r"""Without --wind the contour of wind speed and wave height, with the median peak
period. With --wind the surface of all three: at each wind speed a ring of wave
heights and peak periods. --cut-out adds the contour that ends at a wind speed.

examples:
  fowt contours norway_5 --return-period 50 --plot contour.png
  fowt contours norway_5 --height 90 --wind 4:32:4 --points 24 \
      --output states.csv
  fowt contours norway_5 --height 90 --cut-out 25 --upper
"""
LINE = 180  # points of a line in a picture


def declare(commands: Any) -> None:
    """Add the command of this module."""
    text = "states of wind and sea with a return period, on a contour or a surface"
    parser = commands.add_parser("contours", help=text, epilog=EXAMPLES)
    site.declare(parser, height=None)
    form = "first:last:step"
    parser.add_argument("--wind", type=site.positives, metavar=form, help="wind speeds of the surface's rings [m/s]")
    parser.add_argument("--cut-out", type=site.positives, default=[], metavar="V", help="wind speeds [m/s], 12,25")
    parser.add_argument(
        "--points", type=int, default=24, metavar="N", help="of a contour or ring; default: %(default)d"
    )
    parser.add_argument("--upper", action="store_true", help="only the half with waves above their median")
    parser.add_argument(
        "--fractile", type=positive, metavar="P", help="inflate: the median shall stand for this fractile of a response"
    )
    parser.add_argument("--plot", type=Path, metavar="FILE", help="draw the contours: .png, .svg or .pdf")
    tables.declare(parser)
    parser.set_defaults(action=show_contours)


def show_contours(arguments: argparse.Namespace) -> int:
    """Print the states of every contour, and draw them."""
    from fowtlib.metocean import contour, cut_off, inflated, radius, surface

    check_target(arguments.plot, FIGURES, arguments.force)
    tables.check(arguments)
    joint = site.opened(arguments)
    beta = radius(arguments.return_period, arguments.duration)
    name = site.time(arguments.return_period)
    if arguments.fractile is not None:
        beta = inflated(beta, fractile=arguments.fractile)
        name += f", inflated for {100 * arguments.fractile:g} %"
    levels = [(name, beta)]
    for speed in arguments.cut_out:
        at_end, period = cut_off(joint, speed, arguments.duration)
        levels.append((f"{site.time(period)}, to {speed:g} m/s", at_end))
    options = {"points": arguments.points, "upper": arguments.upper}
    found = []
    for label, size in levels:
        if arguments.wind is None:
            found.append((label, contour(joint, size, **options)))
        else:
            top = float(joint.wind_speed.from_normal(size))
            reached = [speed for speed in arguments.wind if speed <= top * (1 + 1e-12) or size == beta]
            if reached:
                found.append((label, surface(joint, size, wind_speeds=reached, **options)))
    if arguments.plot:
        _draw(arguments, joint, levels)
    told = ", ".join(f"{label}: beta {size:.4f}" for label, size in levels)
    tables.say(arguments, f"{site.words(joint)}; states of {arguments.duration / 3600:.4g} h; {told}")
    columns = ("contour", "wind_speed [m/s]", "Hs [m]", "Tp [s]")
    tables.show(arguments, columns, [(label, *state) for label, states in found for state in states])
    say_saved(arguments.plot)
    return 0


def _draw(arguments: argparse.Namespace, joint: Any, levels: list[tuple[str, float]]) -> None:
    from fowtlib.metocean import contour, surface
    from fowtlib.metocean.pictures import plot_contours

    lines = [(label, contour(joint, size, points=LINE, upper=arguments.upper)) for label, size in levels]
    rings = [
        (f"{speed:g} m/s", surface(joint, levels[0][1], wind_speeds=[speed], points=LINE, upper=arguments.upper))
        for speed in arguments.wind or ()
    ]
    title = f"{site.words(joint)}; states of {arguments.duration / 3600:.4g} h"
    height = site.wind_height(joint)
    plot_contours(lines, arguments.plot, rings=rings, open_lines=arguments.upper, height=height, title=title)
