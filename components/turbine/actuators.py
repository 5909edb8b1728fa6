"""Bearings that a drive turns: blade pitch and nacelle yaw."""

from __future__ import annotations

import math

from fowtlib.components.mechanics.rotations import axis_rotation, unit_axis
from fowtlib.components.turbine.drive_faults import FaultyDrive
from fowtlib.language import (
    Number,
    RealOutput,
    Scalar,
    Vector,
    assign,
    der,
    eq,
    initial,
    param,
    port,
    reinit,
    rotation,
    var,
    when,
)
from fowtlib.language import math as m


class ActuatedBearing(FaultyDrive):
    """frame_b turns about the axis n of frame_a as a drive of second order follows its command.

    angle'' + 2 damping_ratio w0 angle' + w0^2 angle = w0^2 command, w0 = 2 pi natural_frequency. The motion does not
    depend on the load: the drive gives what it takes, `torque`. It starts at rest at the command.
    With a rate_limit the rate stops at the limit and stays there until the equation wants to slow down, exactly: each
    is an event. A command that never asks for more is followed as without limit.
    Blade pitch: 5 Hz, 0.02; yaw: 3 Hz, 0.02 (El Beshbichi 2023, section 3.3). Rates of the NREL 5 MW: 8 deg/s and
    0.3 deg/s (NREL/TP-500-38060, tables 7-2 and 4-1).
    """

    n: Vector = param(
        default=(0, 0, 1),
        structural="its zeros drop out of the equations",
        doc="axis of rotation, resolved in frame_a (any length)",
    )
    natural_frequency: Scalar = param(unit="Hz", min=0, doc="undamped natural frequency of the drive")
    damping_ratio: Scalar = param(default=0.02, min=0, doc="damping ratio of the drive")
    rate_limit: Number = param(default=None, unit="rad/s", min=1e-9, doc="greatest rate; without it there is no limit")

    angle: RealOutput = port(unit="rad", doc="angle")
    torque: RealOutput = port(unit="N*m", doc="torque of the drive on frame_b")

    phi: Scalar = var(unit="rad", state="prefer", doc="angle")
    w: Scalar = var(unit="rad/s", state="prefer", doc="rate")
    limited: Scalar = var(discrete=True, doc="1 or -1 while the rate is at its limit, forward or backward; else 0")

    def limit(self, wanted, scale):
        """Events at the rate limit; wanted is the acceleration without it, scale any positive one.

        Each condition keeps clear of zero while it has no meaning: the first two at the limit, the last one off it. A
        rate that is set free starts a billionth below the limit, so that it does not meet it again at once.
        """
        top, held = self.rate_limit, self.limited**2
        return [
            when((1 - held) * (self.w - top) - held * top > 0, reinit(self.w, top), assign(self.limited, 1)),
            when((1 - held) * (self.w + top) + held * top < 0, reinit(self.w, -top), assign(self.limited, -1)),
            when(
                self.limited * wanted + (1 - held) * scale < 0,
                reinit(self.w, self.limited * (1 - 1e-9) * top), assign(self.limited, 0),
            ),
        ]  # fmt: skip

    def start_rotation(self, command):
        return axis_rotation(self.n, command)

    def equations(self):
        a, b, n = self.frame_a, self.frame_b, unit_axis(self.n)
        w0 = 2 * math.pi * self.natural_frequency
        wanted = self.acceleration(w0, self.damping_ratio)
        return [
            eq(der(self.phi), self.w),
            eq(der(self.w), wanted if self.rate_limit is None else (1 - self.limited**2) * wanted),
            [] if self.rate_limit is None else self.limit(wanted, w0**2),
            self.faults([] if self.rate_limit is None else [assign(self.limited, 0)]),
            [initial(self.phi, self.command), initial(self.w, 0)],
            eq(b.r, a.r),
            rotation(a, b, axis_rotation(n, self.phi), n * self.w),
            self.transmit(),
            eq(self.angle, self.phi),
            eq(self.torque, -m.dot(a.R @ n, b.t)),
        ]
