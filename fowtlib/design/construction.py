"""Drafts and stability while a spar of steps is built afloat: what is built, filled and set in, stage by stage.

Closed forms of fowtlib.components.platform.layers; still water, upright, closed hull. No water is inside but what
is named as ballast.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from types import SimpleNamespace
from typing import Any

from scipy.optimize import brentq

from fowtlib.components.platform.layers import Moments, diameter_at, frustum, thinner, up_to
from fowtlib.components.platform.stepped_spar import (
    SteppedHull,
    height_of,
    hull_layers,
    room,
    shaft_layer,
    surface_moment,
)
from fowtlib.language.errors import ModelError
from fowtlib.language.math import pi


@dataclass(frozen=True)
class BuildStage:
    """A stage: hull built up to `top` [m above the keel], solid ballast and water in it, and what is set into it [kg].

    set_centre: of what is set in, above the keel [m]. free_surface: 1 for water in an open ring, 0 where it has none.
    """

    name: str
    top: float
    solid_ballast: float = 0.0
    water_ballast: float = 0.0
    set_mass: float = 0.0
    set_centre: float = 0.0
    free_surface: float = 1.0


@dataclass(frozen=True)
class StageRow:
    """How a stage floats; lengths [m], from the keel up; metacentric_height less what free surfaces take."""

    name: str
    top: float
    concrete_volume: float
    mass: float
    draft: float
    water_depth: float
    centre_of_buoyancy: float
    metacentric_radius: float
    centre_of_mass: float
    metacentric_height: float


def hull_sizes(model: Any, path: str = "spar") -> SimpleNamespace:
    """The numbers of a SteppedSpar of a model [SI] for `build_stages`; other sizes: model.with_parameters."""
    part = model.root.find(path)
    if not isinstance(part, SteppedHull):
        raise ModelError(f"'{path}' is not a SteppedSpar of '{model.title}'.")
    return SimpleNamespace(**{name: float(part.parameter_value(name)) for name in SteppedHull.parameters})


def build_stages(
    hull: Any, stages: Sequence[BuildStage], *, water_density: float = 1025.0, clearance: float = 2.0
) -> list[StageRow]:
    """How each of the stages floats. hull: numbers as of `hull_sizes`; clearance: of the keel over the seabed [m].

    Raises ModelError for a stage that sinks, or that holds more than it has room for, with its name.
    """
    return [_row(hull, stage, water_density, clearance) for stage in stages]


def ballast_for(hull: Any, stage: BuildStage, metacentric_height: float, *, water_density: float = 1025.0) -> float:
    """The least solid ballast [kg] with which a stage has a metacentric height [m].

    Raises ModelError where no ballast does that before the stage sinks.
    """

    def short(mass: float) -> float:
        given = BuildStage(**{**asdict(stage), "solid_ballast": mass})
        return _row(hull, given, water_density, 0.0).metacentric_height - metacentric_height

    if short(0.0) >= 0:
        return 0.0
    step = 1e5
    last = 0.0
    while True:
        try:
            if short(last + step) >= 0:
                return float(brentq(short, last, last + step, xtol=1.0))
        except ModelError as error:
            raise ModelError(f"{stage.name}: no ballast gives a metacentric height of {metacentric_height:g} m; with "
                             f"{last / 1e3:.0f} t it has {short(last) + metacentric_height:.2f} m, and with more "
                             f"{error.message.partition(': ')[2]}") from None  # fmt: skip
        last += step


def _row(hull: Any, stage: BuildStage, rho: float, clearance: float) -> StageRow:
    if not hull.plate_height <= stage.top <= height_of(hull) * (1 + 1e-9):
        raise ModelError(f"{stage.name}: the hull is built from {hull.plate_height:g} m to {height_of(hull):g} m above "
                         f"the keel, not to {stage.top:g} m.")  # fmt: skip
    built = _concrete(hull, stage.top)
    solid = _level(hull, stage, stage.solid_ballast / hull.ballast_density, "solid ballast")
    water = _level(hull, stage, stage.solid_ballast / hull.ballast_density + stage.water_ballast / rho, "ballast")
    filled = room(hull, solid)
    mass = built.times(hull.concrete_density) + filled.times(hull.ballast_density)
    mass = mass + (room(hull, water) - filled).times(rho)
    mass = mass + Moments(stage.set_mass, stage.set_mass * stage.set_centre, 0.0, 0.0)
    layers = hull_layers(hull)
    if mass.amount > rho * up_to(layers, stage.top).amount:
        raise ModelError(f"{stage.name}: it sinks: {mass.amount / 1e3:.0f} t, and up to its top it displaces "
                         f"{rho * up_to(layers, stage.top).amount / 1e3:.0f} t.")  # fmt: skip
    draft = float(brentq(lambda d: rho * up_to(layers, d).amount - mass.amount, 0.0, stage.top, xtol=1e-9))
    wet = up_to(layers, draft)
    radius = pi / 64 * float(diameter_at(layers, draft)) ** 4 / wet.amount
    lost = stage.free_surface * float(surface_moment(hull, water)) / wet.amount if stage.water_ballast else 0.0
    height = wet.centre + radius - mass.centre - lost
    return StageRow(stage.name, stage.top, built.amount, mass.amount, draft, draft + clearance, wet.centre, radius,
                    mass.centre, height)  # fmt: skip


def _concrete(hull: Any, top: float) -> Moments:
    """The plate and the walls up to a level."""
    plate, *above = hull_layers(hull)
    walls = up_to(above, top) - up_to(thinner(above, hull.wall), top)
    walls = walls + up_to([shaft_layer(hull, 1)], top) - up_to([shaft_layer(hull, 0)], top)
    return frustum(*plate) + walls.times(1 + hull.internals)


def _level(hull: Any, stage: BuildStage, volume: float, what: str) -> float:
    """The level [m] up to which a volume fills the ring."""
    most = room(hull, stage.top).amount
    if volume > most:
        raise ModelError(f"{stage.name}: the {what} has {volume:.0f} m^3, and there is room for {most:.0f} m^3.")
    return float(brentq(lambda z: room(hull, z).amount - volume, hull.plate_height - 1e-9, stage.top, xtol=1e-9))
