"""A mooring line as an elastic catenary over the seabed."""

from __future__ import annotations

from fowtlib.components.environment.world import World
from fowtlib.components.mechanics.connectors import Frame
from fowtlib.components.mooring import catenary
from fowtlib.language import (
    Component,
    Number,
    Scalar,
    Vector,
    assert_,
    eq,
    fix_orientation,
    outer,
    param,
    port,
    shapes,
    var,
)
from fowtlib.language import math as m
from fowtlib.language.declarations import join
from fowtlib.language.errors import ParameterError


class CatenaryLine(Component):
    """Quasi-static elastic catenary from an anchor on the seabed to a fairlead; taut, slack, grounded or lifted.

    Equations: fowtlib.components.mooring.catenary (Jonkman, NREL/TP-500-41958, 2007, section 2.6). Two algebraic
    unknowns: the vertical tension, and a coordinate p = H / (w L) - slack / L of the horizontal one that keeps it
    positive; Newton finds them from one fixed start. The line pulls its fairlead towards the anchor and down.
    Valid for a flat seabed at the level of the anchor and a fairlead above it; no line dynamics, current or bending.
    A slack line hangs vertically, its excess lies on the seabed, and it warns.
    """

    length: Scalar = param(unit="m", min=0, doc="unstretched length")
    axial_stiffness: Scalar = param(unit="N", min=0, doc="axial stiffness EA")
    mass_per_length: Scalar = param(default=0.0, unit="kg/m", min=0, doc="mass per length in air")
    diameter: Scalar = param(default=0.0, unit="m", min=0, doc="diameter of a bar that displaces the same water")
    weight_per_length: Number = param(default=None, unit="N/m", min=0, doc="weight in water, instead of mass, diameter")
    friction: Scalar = param(default=0.0, min=0, doc="friction coefficient of the seabed")
    anchor_position: Vector = param(default=(0, 0, 0), unit="m", doc="anchor, world; unless a frame is its anchor")

    world: World = outer(World)
    fairlead: Frame = port(doc="upper end")
    anchor: Frame = port(optional=True, doc="lower end, when the anchor is part of a body")

    weight: Scalar = var(unit="N/m", doc="weight in water per length")
    coordinate: Scalar = var(start=1.0, doc="positive: horizontal tension over weight; negative: slack over length")
    vertical_tension: Scalar = var(
        unit="N", start=lambda self: 0.6 * self.length * _weight(self), doc="vertical tension at the fairlead"
    )
    horizontal_tension: Scalar = var(unit="N", doc="horizontal tension at the fairlead")
    tension: Scalar = var(unit="N", doc="tension at the fairlead")
    anchor_tension: Scalar = var(unit="N", doc="tension at the anchor")
    seabed_length: Scalar = var(unit="m", doc="length of line on the seabed")
    distance: Scalar = var(unit="m", doc="horizontal distance from anchor to fairlead")
    rise: Scalar = var(unit="m", doc="height of the fairlead above the anchor")

    def equations(self):
        H, V, fairlead, reach = self.horizontal_tension, self.vertical_tension, self.fairlead, _reach(self)
        pull = catenary.tension_from(self.coordinate, self, m)
        x, z = catenary.span(pull, V, self, m)
        plan, direction = m.vertcat(reach[0], reach[1]), m.vertcat(reach[0], reach[1]) / self.distance
        H_anchor = m.fmax(H - self.friction * self.weight * self.seabed_length, 0)
        V_anchor = m.fmax(V - self.weight * self.length, 0)
        return [
            eq(self.weight, _weight(self)),
            eq(self.distance, m.smooth_norm(plan, 1e-6 * self.length)),
            eq(self.rise, reach[2]),
            eq(x - catenary.slack_length(pull, self), self.distance),
            eq(z, self.rise),
            eq(H, pull),
            eq(self.tension, m.sqrt(H**2 + V**2)),
            eq(self.anchor_tension, m.sqrt(H_anchor**2 + V_anchor**2)),
            eq(self.seabed_length, m.fmax(self.length - V / self.weight, 0)),
            [eq(fairlead.f, m.vertcat(H * direction, V)), eq(fairlead.t, m.zeros(3))],
            _hold_anchor(self, m.vertcat(-H_anchor * direction, -V_anchor)),
            assert_(self.rise > 0, "the fairlead is below its anchor, so that the line would cross the seabed"),
            assert_(self.coordinate > 0, "the line is slack: it hangs vertically, its excess on the seabed", "warning"),
            assert_(self.tension < 0.05 * self.axial_stiffness, "the line is stretched by more than 5 %", "warning"),
        ]

    def drawing(self) -> shapes.Drawing:
        numbers = (self.parameter_value(name) for name in ("length", "axial_stiffness", "friction"))
        length, stiffness, friction = numbers

        def form(at):
            line = catenary.Line(length, at["weight"][0], stiffness, friction)  # the same at every moment
            return catenary.profile_between(at["anchor"], at["fairlead"], at["H"], at["V"], line, points=31)

        scalars = {"H": "horizontal_tension", "V": "vertical_tension", "weight": "weight"}
        of = {key: join(self.path, name) for key, name in scalars.items()}
        diameter = self.parameter_value("diameter")
        return [shapes.Curve({**of, "anchor": self.anchor, "fairlead": self.fairlead}, form, diameter or None)]


def _reach(line):
    """From the anchor to the fairlead, world."""
    return line.fairlead.r - line.anchor.r


def _weight(line):
    """Weight in water per length, given or from mass and diameter."""
    given = line.weight_per_length
    if (given is not None) == line.is_set("mass_per_length"):
        raise ParameterError(
            f"{line.label} needs its weight once: give mass_per_length and diameter, or weight_per_length (in water)."
        )
    if given is not None:
        return given
    return catenary.weight_in_water(line.mass_per_length, line.diameter, line.world.gravity, line.world.water_density)


def _hold_anchor(line, load):
    """The anchor is a frame of a body, which takes the load of the line, or a point of the seabed."""
    if line.anchor.connected:
        return [eq(line.anchor.f, load), eq(line.anchor.t, m.zeros(3))]
    if not line.is_set("anchor_position"):
        raise ParameterError(f"{line.label} has no anchor: give anchor_position, or connect a frame to its anchor.")
    return [eq(line.anchor.r, line.anchor_position), fix_orientation(line.anchor, m.eye(3), m.zeros(3))]
