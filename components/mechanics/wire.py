"""Straight wires: stays, guys, tendons."""

from __future__ import annotations

import math

from fowtlib.components.environment.world import World
from fowtlib.components.mechanics.interfaces import TwoFrames
from fowtlib.language import Number, RealOutput, Scalar, assert_, der, eq, facts, outer, param, port, shapes, var
from fowtlib.language import math as m
from fowtlib.language.bounds import POSITIVE


class AxialWire(TwoFrames):
    """A straight wire between two origins with nothing but axial stiffness, EA / l; no sag, no bending.

    `length` is the distance of its ends where the tension is `pretension`: with pretension 0 the unstretched length.
    tension = pretension + EA / l (distance - length) + damping d(distance)/dt, l = length / (1 + pretension / EA).
    As it is, the wire can push, which is said as a warning. With tension_only the tension T above becomes
    (T + sqrt(T^2 + slack_tension^2)) / 2: smooth, never negative, slack_tension / 2 at T = 0, and within a part of
    (slack_tension / 2 T)^2 of T when taut; the damper cannot push either. Its mass is lumped, half at each end.
    """

    axial_stiffness: Scalar = param(unit="N", min=POSITIVE, doc="Young's modulus times metallic area, EA")
    length: Scalar = param(unit="m", min=POSITIVE, doc="distance of the ends at which the tension is the pretension")
    pretension: Scalar = param(default=0.0, unit="N", min=0, doc="tension at that distance")
    damping: Scalar = param(default=0.0, unit="N*s/m", min=0, doc="axial damping")
    mass_per_length: Number = param(default=0.0, unit="kg/m", min=0, doc="mass per unstretched length")
    tension_only: bool = param(default=False, doc="the wire goes slack instead of pushing")
    slack_tension: Scalar = param(default=1000.0, unit="N", min=1e-9, doc="width of the rounding, with tension_only")

    world: World = outer(World)
    tension: RealOutput = port(unit="N", doc="tension, positive pulls the ends together")

    distance: Scalar = var(unit="m", state="never", doc="distance of the two ends")

    def unstretched(self):
        """Length without tension."""
        return self.length / (1 + self.pretension / self.axial_stiffness)

    def equations(self):
        a, b = self.frame_a, self.frame_b
        line = b.r - a.r
        direction = line / self.distance
        rate = m.dot(direction, der(b.r) - der(a.r))
        stretch = self.distance - self.length
        linear = self.pretension + self.axial_stiffness / self.unstretched() * stretch + self.damping * rate
        half = self.mass_per_length * self.unstretched() / 2
        gravity = m.vertcat(0, 0, -self.world.gravity)
        weight = [half * (der(der(end.r)) - gravity) if self.mass_per_length else 0 for end in (a, b)]
        pushing = "the wire is in compression: give it more pretension, or tension_only"
        return [
            eq(self.distance, m.norm(line)),
            eq(self.tension, m.smooth_max(linear, 0, self.slack_tension) if self.tension_only else linear),
            [eq(a.f, weight[0] - direction * self.tension), eq(b.f, weight[1] + direction * self.tension)],
            [eq(a.t, m.zeros(3)), eq(b.t, m.zeros(3))],
            assert_(self.distance > 1e-9, "the two ends of the wire meet, so its direction is undetermined"),
            [] if self.tension_only else assert_(self.tension > -1e-3 * self.slack_tension, pushing, level="warning"),
        ]

    def drawing(self) -> shapes.Drawing:
        diameter = (4 * self.mass_per_length / (math.pi * 7850)) ** 0.5 or None  # of a bar of steel
        return [shapes.link(self.frame_a, self.frame_b, diameter, "line")]

    def facts(self) -> list[facts.Fact]:
        length, pretension, stiffness = (self.parameter_value(n) for n in ("length", "pretension", "axial_stiffness"))
        half = self.parameter_value("mass_per_length") * length / (1 + pretension / stiffness) / 2
        ends = [facts.Mass(end, half) for end in (self.frame_a, self.frame_b)]
        return [*ends, facts.Reading("tension")]
