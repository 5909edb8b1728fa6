"""Bearings that a drive turns: blade pitch and nacelle yaw."""

from __future__ import annotations

import math

from fowtlib.components.mechanics import TwoFrames
from fowtlib.components.mechanics.rotations import axis_rotation, unit_axis
from fowtlib.language import (
    Number,
    OfferedEvent,
    RealInput,
    RealOutput,
    Scalar,
    Vector,
    assign,
    der,
    eq,
    event,
    initial,
    on,
    param,
    port,
    reinit,
    rotation,
    var,
    when,
)
from fowtlib.language import math as m


class ActuatedBearing(TwoFrames):
    """frame_b turns about the axis n of frame_a as a drive of second order follows its command.

    angle'' + 2 damping_ratio w0 angle' + w0^2 angle = w0^2 command, w0 = 2 pi natural_frequency. The motion does not
    depend on the load: the drive gives what it takes, `torque`. It starts at rest at the command.
    With a rate_limit the rate stops at the limit and stays there until the equation wants to slow down, exactly: each
    is an event. A command that never asks for more is followed as without limit.
    A drive that is stuck stops from any rate at once; one that runs away goes there as it would follow a command.
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

    stuck: OfferedEvent = event(doc="it stops at once, and stays at its angle")
    runaway: OfferedEvent = event(
        doc="it leaves its command and goes at a rate to another angle", to=param(default=0.0, unit="rad", doc="angle"),
        rate=param(default="8 deg/s", unit="rad/s", min=0, doc="rate"),
    )  # fmt: skip
    released: OfferedEvent = event(doc="it follows its command again")
    step: OfferedEvent = event(
        doc="the command is raised", by=param(default="1 deg", unit="rad", doc="what is added to it")
    )

    command: RealInput = port(unit="rad", default=0.0, doc="commanded angle")
    angle: RealOutput = port(unit="rad", doc="angle")
    torque: RealOutput = port(unit="N*m", doc="torque of the drive on frame_b")

    phi: Scalar = var(unit="rad", state="prefer", doc="angle")
    w: Scalar = var(unit="rad/s", state="prefer", doc="rate")
    limited: Scalar = var(discrete=True, doc="1 or -1 while the rate is at its limit, forward or backward; else 0")

    faulty: Scalar = var(discrete=True, start=0.0, doc="1 while it is stuck or runs away")
    fault_angle: Scalar = var(unit="rad", discrete=True, start=0.0, doc="angle at which that began")
    fault_way: Scalar = var(unit="rad", discrete=True, start=0.0, doc="way from there until it stops")
    fault_rate: Scalar = var(unit="rad/s", discrete=True, start=0.0, doc="rate on that way")
    fault_time: Scalar = var(unit="s", discrete=True, start=0.0, doc="time at which that began")
    offset: Scalar = var(unit="rad", discrete=True, start=0.0, doc="added to the command")

    def commanded(self):
        """The angle that the drive follows: its command, or a fault's."""
        gone = self.fault_rate * (self.time - self.fault_time)
        faulty = self.fault_angle + m.fmin(m.fmax(self.fault_way, -gone), gone)
        return m.if_else(self.faulty > 0.5, faulty, self.command + self.offset)

    def faults(self):
        """What the events do."""
        away, start = self.runaway, [assign(self.faulty, 1), assign(self.fault_angle, self.phi)]
        start.append(assign(self.fault_time, self.time))
        free = [] if self.rate_limit is None else [assign(self.limited, 0)]
        return [
            on(self.stuck, *start, assign(self.fault_way, 0), assign(self.fault_rate, 0), reinit(self.w, 0), *free),
            on(away, *start, assign(self.fault_way, away.to - self.phi), assign(self.fault_rate, away.rate)),
            on(self.released, assign(self.faulty, 0)),
            on(self.step, assign(self.offset, self.offset + self.step.by)),
        ]

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
        wanted = w0 * (w0 * (self.commanded() - self.phi) - 2 * self.damping_ratio * self.w)
        return [
            eq(der(self.phi), self.w),
            eq(der(self.w), wanted if self.rate_limit is None else (1 - self.limited**2) * wanted),
            [] if self.rate_limit is None else self.limit(wanted, w0**2),
            self.faults(),
            [initial(self.phi, self.command), initial(self.w, 0)],
            eq(b.r, a.r),
            rotation(a, b, axis_rotation(n, self.phi), n * self.w),
            self.transmit(),
            eq(self.angle, self.phi),
            eq(self.torque, -m.dot(a.R @ n, b.t)),
        ]
