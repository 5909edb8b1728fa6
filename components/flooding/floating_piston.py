"""A shaft with a floating piston as a part."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from fowtlib.components.environment.world import World
from fowtlib.components.flooding.connectors import Water
from fowtlib.components.flooding.rings import AroundAPiston
from fowtlib.components.flooding.shaft import centre, levels, on_the_axis, on_the_frames
from fowtlib.components.mechanics.connectors import Frame, TranslationalFlange
from fowtlib.language import (
    RealOutput,
    Scalar,
    Vector,
    assert_,
    der,
    eq,
    facts,
    outer,
    param,
    port,
    shapes,
    var,
)
from fowtlib.language import math as m
from fowtlib.language.bounds import POSITIVE
from fowtlib.language.declarations import join


class FloatingPiston(AroundAPiston):
    """Water in a round shaft in which a round piston slides: it lifts the piston, and is pumped through the floor.

    The shaft's axis is z of frame_a, in the middle of its floor; frame_b, in the middle of the foot of the piston, is
    parallel to it. A slide (Prismatic, Guide; LooseGuide to within its play) between the two holds them in line, whose
    axis is joined to `axis`: its position s is the height of the foot above the floor. V is conserved but for what
    passes the port. Physics, and what is left out: fowtlib.components.flooding.shaft.
    A run stops where the water stands above the shaft or above the top of the piston, and where none is left to pump.
    """

    diameter: Scalar = param(unit="m", min=POSITIVE, doc="inner diameter of the shaft")
    height: Scalar = param(unit="m", min=POSITIVE, doc="height of the shaft above its floor")
    piston_diameter: Scalar = param(unit="m", min=POSITIVE, doc="diameter of the piston")
    piston_height: Scalar = param(unit="m", min=POSITIVE, doc="height of the piston")
    volume_start: Scalar = param(unit="m^3", min=0, doc="water at the start")
    density: Scalar = param(default=None, unit="kg/m^3", min=0, doc="density of the water; without: World's")
    gap_loss: Scalar = param(default=1.5, min=0, doc="pressure lost at both ends of the gap, over rho u^2/2")
    gap_friction: Scalar = param(default=0.02, min=0, doc="Darcy's friction factor along the gap")

    world: World = outer(World)
    frame_a: Frame = port(doc="middle of the floor of the shaft")
    frame_b: Frame = port(doc="middle of the foot of the piston")
    axis: TranslationalFlange = port(doc="axis of the slide between them")
    water: Water = port(optional=True, doc="opening in the floor")
    lost_power: RealOutput = port(unit="W", doc="power lost in the gap")

    volume: Scalar = var(unit="m^3", state="always", start=volume_start, doc="volume of the water")
    level: Scalar = var(unit="m", state="never", doc="surface above the floor, on the axis")
    immersion: Scalar = var(unit="m", state="never", doc="how deep the piston is in the water")
    lift: Scalar = var(unit="N", doc="force of the water on the piston along the axis")
    gap_pressure: Scalar = var(unit="Pa", doc="pressure lost by the flow in the gap")
    energy: Scalar = var(unit="J", doc="of the water in the shaft: potential above the floor, and kinetic of the gap")
    mass: Scalar = var(unit="kg", state="never", doc="mass of the water")
    centre: Vector = var(unit="m", state="never", doc="centre of the water, from frame_a, resolved in it")
    velocity: Vector = var(unit="m/s", state="avoid", doc="velocity of frame_a, world")

    area = property(lambda self: m.pi / 4 * self.diameter**2)
    piston_area = property(lambda self: m.pi / 4 * self.piston_diameter**2)

    def density_now(self):
        """Density of the water [kg/m^3]."""
        return self.world.water_density if self.density is None else self.density

    def turning(self):
        """What a metre along the axis adds to the acceleration of the shaft, (3,), world."""
        a, n = self.frame_a, self.frame_a.R[:, 2]
        return m.cross(der(a.w), n) + m.cross(a.w, m.cross(a.w, n))

    def equations(self):
        found = levels(self)
        return [
            eq(der(self.volume), self.water.volume_flow),
            eq(self.velocity, der(self.frame_a.r)),
            [eq(self.level, found.surface), eq(self.immersion, found.immersion)],
            [eq(self.mass, self.density_now() * self.volume), eq(self.centre, centre(self, found))],
            *on_the_axis(self, found),
            *on_the_frames(self, found),
            *_limits(self),
        ]

    def facts(self) -> list[facts.Fact]:
        return [facts.Reading("mass"), facts.Reading("volume"), facts.Reading("level")]

    def drawing(self) -> shapes.Drawing:
        of = {"floor": self.frame_a, "foot": self.frame_b, "level": join(self.path, "level")}
        return [shapes.Curve(of, _column, float(self.parameter_value("diameter")), material="water")]


def _column(at: Mapping[str, Any]) -> np.ndarray:
    """The axis of the water, (n_time, 2, 3), from the floor to the surface."""
    along = at["foot"] - at["floor"]
    axis = along / np.maximum(np.linalg.norm(along, axis=1, keepdims=True), 1e-9)
    return np.stack([at["floor"], at["floor"] + axis * np.reshape(at["level"], (-1, 1))], axis=1)


_OVER_THE_PISTON = (
    "the water stands over the top of the piston, {immersion} m above its foot, and it is {height} m high: its "
    "displacement is too small for the weight on it, or it is held; make it larger, or stop the pump"
)
_OVER_THE_SHAFT = "the water runs over the top of the shaft: it stands {surface} m above the floor of its {height} m"
_EMPTY = "the shaft is empty and water is still taken out of it: stop the pump when its volume is {volume} m^3"


def _limits(shaft: FloatingPiston) -> list:
    c, h, V = shaft.immersion, shaft.level, shaft.volume
    return [
        shaft.stays_a_ring(),
        assert_(c < shaft.piston_height, _OVER_THE_PISTON, immersion=c, height=shaft.piston_height),
        assert_(h < shaft.height, _OVER_THE_SHAFT, surface=h, height=shaft.height),
        assert_(shaft.volume > -1e-6 * shaft.area, _EMPTY, volume=V),
    ]
