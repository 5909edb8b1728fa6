"""`fowt stability`: how a floater floats, its righting arms over heel, damage, and stages of construction."""

from __future__ import annotations

import argparse
import math
from pathlib import Path
from typing import TYPE_CHECKING, Any

from fowtlib.cli import loading, tables
from fowtlib.cli.files import FIGURES, check_target, say_saved
from fowtlib.cli.run import finite, numbers, positive
from fowtlib.language.errors import ModelError

if TYPE_CHECKING:
    from fowtlib.analysis.afloat import Afloat, Floating
    from fowtlib.analysis.righting import RightingCurve
    from fowtlib.modelfile import Model

EXAMPLES = r"""The hull is the Floater of the model, with all bodies where they are at the
start; moorings and wind do not count. It is free to sink and trim at every
heel. Ballast is as solid unless --slack says that its surface stays level.

With --stages no arms: draft, GM and depth of water at each stage of a file;
a stage at which GM is not above `least` is refused. See docs/hydrostatics.md.

With --stroke no arms: GM while a tower is raised by the water in its shaft, and
where it falls below --least, the tanks run dry or the cylinder is too small.

examples:
  fowt stability oo_star_rigid --heel 0:60:5 --plot arms.png
  fowt stability oc4.yaml --slack all --towards 90 --wind-moment 1.2e6,130
  fowt stability oc4.yaml --flood hull.upper_column_1
  fowt stability spar.yaml --stages building.yaml
  fowt stability dtif_raising --stroke 0.2:50:5 --least 1
"""
ARMS = "0:60:5"
STROKE_HEADS = ("place [m]", "GM [m]", "centre of mass [m]", "in the shaft [m^3]", "in the tanks [m^3]", "level [m]")
HEADS = ("heel [deg]", "GZ [m]", "righting moment [N m]", "trim [deg]", "draft [m]")


def declare(commands: Any) -> None:
    """Add the command of this module."""
    text = "draft, GM and righting arms over heel; damage; stages of construction"
    parser = commands.add_parser("stability", help=text, epilog=EXAMPLES)
    loading.declare(parser, wind=False, waves=False)
    parser.add_argument("--heel", metavar="A:B:STEP", default=ARMS, help="angles [deg] from 0; default: 0:60:5")
    parser.add_argument("--towards", type=finite, default=0.0, metavar="DEG",
                        help="side that goes down, from x to y of the hull; default: 0")  # fmt: skip
    parser.add_argument("--hold-trim", action="store_true", help="the hull is not free to trim")
    parser.add_argument("--slack", metavar="NAME", action="append", default=[],
                        help="ballast with a free surface, or all; may be repeated")  # fmt: skip
    parser.add_argument("--flood", metavar="MEMBER[:A:B]", action="append", default=[],
                        help="a member open to the sea, from A to B [m] of its start; may be repeated")  # fmt: skip
    parser.add_argument("--wind-moment", metavar="N,M", help="force [N] and lever [m] upright, for the area criterion")
    parser.add_argument("--flooding-angle", type=positive, metavar="DEG", help="heel at which water comes in")
    parser.add_argument("--stages", type=Path, metavar="FILE", help="stages of construction: .yaml")
    parser.add_argument("--stroke", metavar="A:B:STEP",
                        help="places [m] of a tower over its floor, to B, in steps of at most STEP")  # fmt: skip
    parser.add_argument("--least", type=finite, metavar="GM", help="least GM [m] along --stroke; default: 1")
    parser.add_argument("--plot", type=Path, metavar="FILE", help="draw the arms: .png, .svg or .pdf")
    tables.declare(parser)
    parser.set_defaults(action=show_stability)


def show_stability(arguments: argparse.Namespace) -> int:
    """Print how it floats and its righting arms, or its stages of construction."""
    import numpy as np

    tables.check(arguments)
    check_target(arguments.plot, FIGURES, arguments.force)
    model = loading.load(arguments)
    if arguments.stages is not None:
        return _show_stages(arguments, model)
    if arguments.stroke is not None:
        return _show_stroke(arguments, model)
    if arguments.least is not None:
        raise ModelError("--least is of --stroke; the stages of a file have their own.")
    from fowtlib.analysis.afloat_models import afloat
    from fowtlib.analysis.righting import righting_curve

    heels, wind = numbers(arguments.heel), _wind(arguments.wind_moment)
    if len(heels) < 4:
        raise ModelError(f"--heel: '{arguments.heel}' are no four angles from 0 upwards; give 0:60:5.")
    if arguments.flooding_angle is not None and wind is None:
        raise ModelError("--flooding-angle ends the areas of --wind-moment; give both.")
    hull = _damaged(arguments, model, afloat(model, slack="all" if "all" in arguments.slack else arguments.slack))
    curve = righting_curve(hull, np.radians(heels), math.radians(arguments.towards), not arguments.hold_trim)
    rows = [*_floating(hull.at(), hull), *_arms(arguments, curve, wind)]
    scales = (1.0, 1.0, curve.mass * curve.gravity, 1.0, 1.0)
    arms = [tuple(map(tables.rounded, row, scales)) for row in curve.rows()]
    if arguments.form:
        tables.show(arguments, HEADS, arms)
    else:
        tables.show_rows(("quantity", "value", "unit"), rows)
        print()
        tables.show(arguments, HEADS, arms, f"heel towards {arguments.towards:g} deg")
    if arguments.plot:
        curve.plot(arguments.plot, model.title or model.name, wind)
        say_saved(arguments.plot)
    return 0


def _wind(text: str | None) -> tuple[float, float] | None:
    """Force and lever of `--wind-moment`."""
    if text is None:
        return None
    found = numbers(text)
    if len(found) != 2 or found.min() <= 0 or ":" in text:
        raise ModelError(f"--wind-moment: '{text}' are not a force [N] and a lever [m] above zero, as 1.2e6,130.")
    return float(found[0]), float(found[1])


def _damaged(arguments: argparse.Namespace, model: Model, hull: Afloat) -> Afloat:
    """The hull with what --flood opens to the sea."""
    from fowtlib.analysis.afloat_models import compartment_of, the_floater

    for text in arguments.flood:
        name, *ends = text.split(":")
        try:
            low, high = (float(ends[0]), float(ends[1])) if ends else (0.0, None)
        except (ValueError, IndexError):
            raise ModelError(f"--flood: '{text}' is not MEMBER or MEMBER:A:B with distances [m].") from None
        hull = hull.with_flooded(compartment_of(the_floater(model.root), name, low, high))
    return hull


def _floating(upright: Floating, hull: Afloat) -> list[tuple[str, float, str]]:
    """Rows of how it floats held upright, and of how it comes to rest."""
    import numpy as np

    second, rest = np.diag(upright.second_moments), hull.at_rest()
    return [
        ("mass with liquids", upright.mass, "kg"),
        ("displaced volume", upright.volume, "m^3"),
        ("draft, upright", upright.draft, "m"),
        ("height of the frame over the water", upright.height, "m"),
        *((f"centre of mass {axis}", tables.rounded(float(value), 1.0), "m")
          for axis, value in zip("xyz", upright.centre_of_mass, strict=True)),
        *((f"centre of buoyancy {axis}", tables.rounded(float(value), 1.0), "m")
          for axis, value in zip("xyz", upright.centre_of_buoyancy, strict=True)),
        ("waterplane area", upright.waterplane_area, "m^2"),
        ("second moment of it along x", float(second[0]), "m^4"),
        ("second moment of it along y", float(second[1]), "m^4"),
        ("GM in pitch", float(upright.metacentric[0, 0]), "m"),
        ("GM in roll", float(upright.metacentric[1, 1]), "m"),
        ("least GM", upright.metacentric_height, "m"),
        ("heel at rest", math.degrees(rest.heel), "deg"),
        ("draft at rest", rest.draft, "m"),
        ("least GM at rest", rest.metacentric_height, "m"),
    ]  # fmt: skip


def _arms(
    arguments: argparse.Namespace, curve: RightingCurve, wind: tuple[float, float] | None
) -> list[tuple[str, float | None, str]]:
    """Rows of what the curve says."""
    at, arm = curve.largest
    vanishing = math.degrees(curve.vanishing)
    rows: list[tuple[str, float | None, str]] = [
        ("largest arm", arm, "m"), ("at the heel", math.degrees(at), "deg"),
        ("arms vanish at", None if math.isnan(vanishing) else vanishing, "deg"),
    ]  # fmt: skip
    if wind is None:
        return rows
    flooding = math.inf if arguments.flooding_angle is None else math.radians(arguments.flooding_angle)
    area = curve.wind_area(*wind, flooding)
    return [
        *rows,
        ("heel in the wind", math.degrees(area.first), "deg"),
        ("areas up to", math.degrees(area.end), "deg"),
        ("area of righting over that of the wind (1.3 are wanted)", area.ratio, "1"),
    ]


def _show_stages(arguments: argparse.Namespace, model: Model) -> int:
    """Print the stages of a file."""
    from fowtlib.analysis.afloat_models import the_floater
    from fowtlib.analysis.stage_file import read_stages
    from fowtlib.analysis.stages import STAGE_HEADS, construction_stages

    if arguments.plot or arguments.flood or arguments.wind_moment or arguments.slack:
        raise ModelError("--stages: arms, damage, wind and pictures are not of stages; what is slack the file says.")
    given = read_stages(arguments.stages)
    found = construction_stages(
        the_floater(model.root), given.stages, clearance=given.clearance, least=given.least, slack=given.slack
    )
    tables.show(arguments, STAGE_HEADS, [stage.row() for stage in found])
    return 0


def _show_stroke(arguments: argparse.Namespace, model: Model) -> int:
    """Print GM, levels and volumes for every place of a tower; then what its limits say."""
    from fowtlib.analysis.lifting import stroke

    others = (arguments.plot, arguments.flood, arguments.wind_moment, arguments.slack, arguments.flooding_angle,
              arguments.hold_trim, arguments.towards, arguments.heel != ARMS)  # fmt: skip
    if any(others):
        raise ModelError("--stroke: arms, damage, wind and pictures are not of a stroke; its free surfaces all count.")
    places = numbers(arguments.stroke)
    if len(places) < 2 or not 0 <= places[0] < places[-1] or ":" not in arguments.stroke:
        raise ModelError(f"--stroke: '{arguments.stroke}' are no two places [m] from 0 upwards; give 0:50:5.")
    top = float(arguments.stroke.split(":")[1])  # the way is looked at to its end, in equal steps of at most STEP
    way = stroke(model.compile(), top, float(places[0]), count=len(places) + (places[-1] < top - 1e-9))
    columns = (way.position, way.metacentric_height, way.centre_of_mass, way.shaft_volume, way.tank_volume, way.level)
    tables.show(arguments, STROKE_HEADS, [list(map(float, row)) for row in zip(*columns, strict=True)])
    way.check(1.0 if arguments.least is None else arguments.least)
    return 0
