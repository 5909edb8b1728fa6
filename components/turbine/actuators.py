"""Bearings that a drive turns: blade pitch and nacelle yaw."""

from __future__ import annotations

import math

from fowtlib.components.mechanics import TwoFrames
from fowtlib.components.mechanics.rotations import axis_rotation, unit_axis
from fowtlib.language import RealInput, RealOutput, Scalar, Vector, der, eq, initial, param, port, rotation, var
from fowtlib.language import math as m


class ActuatedBearing(TwoFrames):
    """frame_b turns about the axis n of frame_a as a drive of second order follows its command.

    angle'' + 2 damping_ratio w0 angle' + w0^2 angle = w0^2 command, w0 = 2 pi natural_frequency. The motion does not
    depend on the load: the drive gives what it takes, `torque`. It starts at rest at the command.
    Blade pitch: 5 Hz, 0.02; yaw: 3 Hz, 0.02 (El Beshbichi 2023, section 3.3).
    """

    n: Vector = param(default=(0, 0, 1), structural=True, doc="axis of rotation, resolved in frame_a (any length)")
    natural_frequency: Scalar = param(unit="Hz", min=0, doc="undamped natural frequency of the drive")
    damping_ratio: Scalar = param(default=0.02, min=0, doc="damping ratio of the drive")

    command: RealInput = port(unit="rad", default=0.0, doc="commanded angle")
    angle: RealOutput = port(unit="rad", doc="angle")
    torque: RealOutput = port(unit="N*m", doc="torque of the drive on frame_b")

    phi: Scalar = var(unit="rad", state="prefer", doc="angle")
    w: Scalar = var(unit="rad/s", state="prefer", doc="rate")

    def equations(self):
        a, b, n = self.frame_a, self.frame_b, unit_axis(self.n)
        w0 = 2 * math.pi * self.natural_frequency
        return [
            eq(der(self.phi), self.w),
            eq(der(self.w), w0 * (w0 * (self.command - self.phi) - 2 * self.damping_ratio * self.w)),
            [initial(self.phi, self.command), initial(self.w, 0)],
            eq(b.r, a.r),
            rotation(a, b, axis_rotation(n, self.phi), n * self.w),
            self.transmit(),
            eq(self.angle, self.phi),
            eq(self.torque, -m.dot(a.R @ n, b.t)),
        ]
