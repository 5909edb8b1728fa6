"""Options of the commands about wind and sea at a site, and how they say what they took."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING, Any

from fowtlib.cli.run import finite, numbers, positive

if TYPE_CHECKING:
    from fowtlib.metocean import ConditionalModel


def declare(parser: Any, height: float | None) -> None:
    """Add the site, the return period and the height of the wind."""
    parser.add_argument("site", metavar="SITE", help="norway_5, northern_north_sea, or a file of a joint distribution")
    parser.add_argument(
        "--return-period", type=positive, default=50.0, metavar="YEARS", help="default: %(default)g years"
    )
    parser.add_argument(
        "--duration", type=seconds, default=3600.0, metavar="TIME", help="of a state [s], or 10min, 1h, 3h; default: 1h"
    )
    default = f"{height:g} m" if height else "that of the distribution"
    parser.add_argument(
        "--height", type=positive, default=height, metavar="M", help=f"of the wind speed [m]; default: {default}"
    )
    parser.add_argument(
        "--shear", type=finite, metavar="A", help="exponent of the power law up to there; default: the site's"
    )


def seconds(text: str) -> float:
    """A time with unit, or in seconds; for argparse."""
    from fowtlib.language.errors import ModelError
    from fowtlib.language.units import to_si

    try:
        value = float(to_si(text, "s"))
    except (ModelError, TypeError, ValueError):
        value = 0.0
    if not 0 < value < float("inf"):
        raise argparse.ArgumentTypeError(f"'{text}' is not a time, for example 10min or 1h")
    return value


def positives(text: str) -> list[float]:
    """`4:24:2`, both ends included, or single values `4,12,25`, all positive; for argparse."""
    values = numbers(text)
    if not len(values) or values.min() <= 0:
        raise argparse.ArgumentTypeError(f"'{text}' is not first:last:step or a list of positive numbers")
    return values.tolist()


def opened(arguments: argparse.Namespace) -> ConditionalModel:
    """The joint distribution, for wind speeds at the height that was asked for."""
    from fowtlib.metocean import site

    joint = site(arguments.site)
    if arguments.height is None:
        return joint
    return joint.at(arguments.height, arguments.shear)


def wind_height(joint: ConditionalModel) -> float:
    """Height [m] of the wind speeds of a distribution."""
    return joint.height or joint.reference_height


def words(joint: ConditionalModel) -> str:
    """Title and height of a distribution."""
    height = wind_height(joint)
    shear = f", shear exponent {joint.shear_exponent:g}" if height != joint.reference_height else ""
    return f"{joint.title or joint.name}, wind at {height:g} m{shear}"


def time(years: float) -> str:
    """A return period as people say it."""
    from fowtlib.metocean.states import YEAR

    return f"{years:g} years" if years >= 1 else f"{years * YEAR / 3600:.4g} h"
