"""The velocity of a nacelle, for floating feedback."""

from __future__ import annotations

import math

from fowtlib.components.mechanics.connectors import Frame
from fowtlib.language import Component, RealOutput, Scalar, der, eq, initial, param, port, var
from fowtlib.language import math as m


class NacelleVelocity(Component):
    """Horizontal velocity of a frame along its x axis, as an inclinometer or accelerometer at a tower top gives it.

    A low-pass of first order takes off the tower's own motion. It is the velocity over ground: that of the slow drift
    of a platform is part of it.
    """

    memory = "velocity sensor"

    cutoff_frequency: Scalar = param(default=0.25, unit="Hz", min=1e-6, doc="corner of the low-pass")

    frame: Frame = port(doc="tower top; x downwind")
    velocity: RealOutput = port(unit="m/s", doc="filtered velocity")

    filtered: Scalar = var(unit="m/s", state="prefer", doc="filtered velocity")

    def equations(self):
        along = velocity_along(self.frame)
        return [
            eq(der(self.filtered), 2 * math.pi * self.cutoff_frequency * (along - self.filtered)),
            eq(self.velocity, self.filtered),
            initial(self.filtered, along),
            [eq(self.frame.f, m.zeros(3)), eq(self.frame.t, m.zeros(3))],
        ]


def velocity_along(frame):
    """Horizontal velocity [m/s] of a frame in the direction of its x axis."""
    n, v = frame.R[:, 0], der(frame.r)
    return (n[0] * v[0] + n[1] * v[1]) / m.sqrt(n[0] ** 2 + n[1] ** 2)
