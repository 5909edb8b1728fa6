"""A guide: a slide that knows with what it leans on its carrier."""

from __future__ import annotations

from fowtlib.components.mechanics.joints import Prismatic
from fowtlib.components.mechanics.rotations import unit_axis
from fowtlib.language import RealOutput, Scalar, Vector, eq, param, port, var
from fowtlib.language import math as m

LEAST = 1.0  # N; the length of a load on a ring is smooth below it


class Guide(Prismatic):
    """A slide on two rings that ride on the sliding side, one at frame_b and one further along n.

    What the slide hands over across its axis, force and moment, the two rings carry by forces across the axis; the
    moment about the axis goes into a key. The rings fit without play.
    """

    ring_distance: Scalar = param(unit="m", min=1e-3, doc="distance of the second ring from frame_b, along n")

    load: RealOutput = port(unit="N", doc="sum of the loads on the two rings")

    first_ring: Vector = var(unit="N", doc="force of the carrier on the ring at frame_b, world")
    second_ring: Vector = var(unit="N", doc="force of the carrier on the other ring, world")

    def equations(self):
        n, force, moment = self.frame_a.R @ unit_axis(self.n), -self.frame_b.f, -self.frame_b.t
        return [
            *super().equations(),
            eq(self.second_ring, m.cross(moment, n) / self.ring_distance),
            eq(self.first_ring, force - n * m.dot(n, force) - self.second_ring),
            eq(self.load, m.smooth_norm(self.first_ring, LEAST) + m.smooth_norm(self.second_ring, LEAST)),
        ]
