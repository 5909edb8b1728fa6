"""Yaw of the nacelle into the wind, with a deadband."""

from __future__ import annotations

from fowtlib.components.environment.wind import Wind
from fowtlib.components.mechanics.connectors import Frame
from fowtlib.language import (
    Component,
    RealInput,
    RealOutput,
    Scalar,
    assign,
    der,
    eq,
    initial,
    outer,
    param,
    port,
    reinit,
    var,
    when,
)
from fowtlib.language import math as m


class YawController(Component):
    """The nacelle yaws at a constant rate from where its mean error leaves the deadband until the error is gone.

    The error is the direction in which the wind blows less that of the nacelle, on a tower top whose x axis points
    along `frame` (its other rotations are small). Two low-passes of first order: that of averaging_time starts the
    yawing, that of stop_time ends it, and the first goes on from the second then. `command` is for the yaw drive.
    Rate of the NREL 5 MW: NREL/TP-500-38060, section 7; a deadband of 8 deg as in many machines.
    """

    memory = "yaw controller"

    deadband: Scalar = param(default="8 deg", unit="rad", min=1e-6, doc="mean error at which it begins to yaw")
    rate: Scalar = param(default="0.3 deg/s", unit="rad/s", min=1e-9, doc="yaw rate")
    averaging_time: Scalar = param(default=60.0, unit="s", min=1e-3, doc="time constant of the mean error")
    stop_time: Scalar = param(default=5.0, unit="s", min=1e-3, doc="time constant of the error that ends the yawing")
    command_start: Scalar = param(default=0.0, unit="rad", doc="yaw angle of the nacelle at the start")

    wind: Wind = outer(Wind)
    frame: Frame = port(doc="tower top; x along the shaft at yaw angle 0")
    enabled: RealInput = port(default=1.0, doc="0 while it may not yaw")
    command: RealOutput = port(unit="rad", doc="yaw angle of the nacelle, about z of the tower top")

    error: Scalar = var(unit="rad", doc="direction of the wind seen from the nacelle, within half a turn")
    mean_error: Scalar = var(unit="rad", state="prefer", doc="mean of the error")
    short_error: Scalar = var(unit="rad", state="prefer", doc="the error without its fast part")
    way: Scalar = var(discrete=True, start=0.0, doc="1 or -1 while it yaws, else 0")
    origin: Scalar = var(unit="rad", discrete=True, start=command_start, doc="yaw angle at which that began")
    since: Scalar = var(unit="s", discrete=True, start=0.0, doc="time at which that began")

    def equations(self):
        R, rest = self.frame.R, m.abs(self.way) < 0.5
        off = self.wind.bearing - m.atan2(R[1, 0], R[0, 0]) - self.command
        held = [assign(self.origin, self.command), assign(self.since, self.time)]
        done = m.fmin(m.if_else(rest, -1, 1), m.fmax(-self.way * self.short_error, 0.5 - self.enabled))
        return [
            eq(self.error, m.atan2(m.sin(off), m.cos(off))),
            eq(self.averaging_time * der(self.mean_error), self.error - self.mean_error),
            eq(self.stop_time * der(self.short_error), self.error - self.short_error),
            eq(self.command, self.origin + self.way * self.rate * (self.time - self.since)),
            [initial(self.mean_error, 0), initial(self.short_error, self.error)],
            [self._begin(sign, rest, held) for sign in (1, -1)],
            when(done > 0, assign(self.way, 0), *held, reinit(self.mean_error, self.short_error)),
            [eq(self.frame.f, m.zeros(3)), eq(self.frame.t, m.zeros(3))],
        ]

    def _begin(self, sign, rest, held):
        """To one side, where it is at rest and may yaw."""
        margin = m.fmin(m.if_else(rest, 1, -1), m.fmin(self.enabled - 0.5, sign * self.mean_error - self.deadband))
        return when(margin > 0, assign(self.way, sign), *held)
