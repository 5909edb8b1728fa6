"""A mooring line that ends in a delta (crow-foot): two legs from a node to two fairleads, against yaw."""

from __future__ import annotations

import numpy as np

from fowtlib.components.environment.world import World
from fowtlib.components.mechanics.bodies import FixedTranslation
from fowtlib.components.mechanics.connectors import Frame
from fowtlib.components.mooring.catenary_line import CatenaryLine, line_weight
from fowtlib.language import (
    Array,
    Component,
    Scalar,
    Vector,
    assert_,
    eq,
    facts,
    fix_orientation,
    outer,
    param,
    port,
    shapes,
    var,
)
from fowtlib.language import math as m
from fowtlib.language.bounds import POSITIVE


class CrowFoot(Component):
    """Two legs from fairleads on a body to a massless node, where a line, or anything else with a Frame, goes on.

    A leg is straight and elastic: it pulls with T = EA (distance / length - 1), or, in its place, (T + sqrt(T^2 +
    slack_tension^2)) / 2, which is never negative; half of its weight in water hangs at each of its ends. The node is
    where the pulls of legs and line are in equilibrium. Unknowns are its place from the middle of the fairleads and EA
    times the strain of each leg: with the place alone a millimetre of a stiff leg is many times the pull of the line,
    and a search from a guess, or the next step of a run, does not arrive.
    What straight legs leave out is their sag, which takes (w L / T)^2 / 24 of their length. A slack leg warns.
    """

    length: Scalar = param(unit="m", min=1e-3, doc="unstretched length of each leg")
    axial_stiffness: Scalar = param(unit="N", min=1e-3, doc="axial stiffness EA of a leg")
    mass_per_length: Scalar = param(default=None, unit="kg/m", min=0, doc="mass per length in air")
    diameter: Scalar = param(default=0.0, unit="m", min=0, doc="diameter of a bar that displaces the same water")
    weight_per_length: Scalar = param(default=None, unit="N/m", doc="weight in water, instead of mass and diameter")
    slack_tension: Scalar = param(default=1000.0, unit="N", min=1e-6, doc="width of the rounding where a leg is slack")
    node_start: Vector = param(unit="m", doc="first guess of the node, from the middle of the fairleads, world")

    world: World = outer(World)
    left: Frame = port(doc="fairlead of one leg")
    right: Frame = port(doc="fairlead of the other leg")
    node: Frame = port(doc="where the line goes on; keeps the axes of the world")

    offset: Vector = var(unit="m", start=node_start, doc="node from the middle of the fairleads, world")
    pulls: Array = var(
        unit="N", shape=(2,), start=lambda self: m.vertcat(self.slack_tension, self.slack_tension),
        doc="EA times the strain of the left and right leg",
    )  # fmt: skip
    left_tension: Scalar = var(unit="N", doc="mean tension of the left leg")
    right_tension: Scalar = var(unit="N", doc="mean tension of the right leg")

    def equations(self):
        ends, node, half_apart = (self.left, self.right), self.node, (self.left.r - self.right.r) / 2
        half = m.vertcat(0, 0, line_weight(self) * self.length / 2)
        ways = [side * half_apart - self.offset for side in (1, -1)]
        pulls = [self.pulls[i] for i in range(2)]
        sizes = [self.length * (1 + pull / self.axial_stiffness) for pull in pulls]
        tensions = [m.smooth_max(pull, 0, self.slack_tension) for pull in pulls]
        forces = [way / m.norm(way) * T for way, T in zip(ways, tensions, strict=True)]
        return [
            eq(node.r, (self.left.r + self.right.r) / 2 + self.offset),
            fix_orientation(node, m.eye(3), m.zeros(3)),
            [eq(size**2, m.dot(way, way)) for size, way in zip(sizes, ways, strict=True)],
            [eq(variable, T) for variable, T in zip((self.left_tension, self.right_tension), tensions, strict=True)],
            [[eq(end.f, force + half), eq(end.t, m.zeros(3))] for end, force in zip(ends, forces, strict=True)],
            eq(node.f, 2 * half - forces[0] - forces[1]),
            assert_(m.fmin(*pulls) > 0, "a leg is slack", "warning"),
        ]

    def drawing(self) -> shapes.Drawing:
        diameter = self.parameter_value("diameter") or None
        return [shapes.link(self.node, end, diameter, "line") for end in (self.left, self.right)]

    def facts(self) -> list[facts.Fact]:
        return [facts.Reading("left_tension"), facts.Reading("right_tension")]


class DeltaLine(Component):
    """A CatenaryLine from an anchor to a CrowFoot, whose legs go to two fairleads on a body.

    With a horizontal pull H, the node R from the axis and l from the anchor, and the stiffness k of the legs against a
    sideways displacement of the node, k = sum of EA / L sin^2 + T / L cos^2 of the angles between legs and line, it
    resists yaw with H (1 + R / l) (k R - H) / (k + H / l): stiff legs make the node the fairlead. Where k R < H the
    delta turns over. `line` and `delta` are its parts. A spring stands for such legs in NREL/TP-500-47535 (J. Jonkman,
    2010); see YawSpring.
    """

    fairleads: Array = param(shape=(2, 3), unit="m", doc="the fairleads of the two legs, resolved in the frame")
    leg_length: Scalar = param(unit="m", min=1e-3, doc="unstretched length of each leg")
    length: Scalar = param(unit="m", min=POSITIVE, doc="unstretched length of the line from the anchor to the node")
    axial_stiffness: Scalar = param(unit="N", min=POSITIVE, doc="axial stiffness EA of line and legs")
    mass_per_length: Scalar = param(default=None, unit="kg/m", min=0, doc="mass per length in air, of both")
    diameter: Scalar = param(default=0.0, unit="m", min=0, doc="diameter of a bar that displaces the same water")
    weight_per_length: Scalar = param(default=None, unit="N/m", doc="weight in water, instead of mass and diameter")
    friction: Scalar = param(default=0.0, min=0, doc="friction coefficient of the seabed")
    anchor_position: Vector = param(unit="m", doc="anchor, world")

    frame: Frame = port(doc="frame of the body")

    def build(self):
        given = ("axial_stiffness", "mass_per_length", "diameter", "weight_per_length")
        common = {name: getattr(self, name) for name in given if self.parameter_value(name) is not None}
        for side, i in (("left", 0), ("right", 1)):
            setattr(self, side, FixedTranslation(r=m.vertcat(*(self.fairleads[i, k] for k in range(3)))))
        start = 0.9 * float(self.parameter_value("leg_length")) * _direction(self)
        self.delta = CrowFoot(length=self.leg_length, node_start=start, **common)
        self.line = CatenaryLine(
            length=self.length, friction=self.friction, anchor_position=self.anchor_position, **common
        )
        for side, end in ((self.left, self.delta.left), (self.right, self.delta.right)):
            self.connect(self.frame, side.frame_a)
            self.connect(side.frame_b, end)
        self.connect(self.delta.node, self.line.fairlead)


def _direction(line: DeltaLine):
    """Unit vector from the middle of the fairleads, of a body not displaced, towards the anchor, half as steep."""
    way = np.asarray(line.parameter_value("anchor_position")) - np.mean(line.parameter_value("fairleads"), axis=0)
    way = way * [1, 1, 0.5]
    return way / np.linalg.norm(way)
