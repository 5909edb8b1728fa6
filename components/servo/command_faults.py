"""A command that a drive leaves: it is blocked where it is, or runs away."""

from __future__ import annotations

from fowtlib.language import Component, OfferedEvent, Scalar, assign, event, on, param, var
from fowtlib.language import math as m


class CommandFaults(Component):
    """Partial: an angle that stays where it is from an event on, or goes at a rate to another one."""

    stuck: OfferedEvent = event(doc="it stops at once, and stays at its angle")
    runaway: OfferedEvent = event(
        doc="it leaves its command and goes at a rate to another angle", to=param(default=0.0, unit="rad", doc="angle"),
        rate=param(default="8 deg/s", unit="rad/s", min=0, doc="rate"),
    )  # fmt: skip

    faulty: Scalar = var(discrete=True, start=0.0, doc="1 while it is stuck or runs away")
    fault_angle: Scalar = var(unit="rad", discrete=True, start=0.0, doc="angle at which that began")
    fault_way: Scalar = var(unit="rad", discrete=True, start=0.0, doc="way from there until it stops")
    fault_rate: Scalar = var(unit="rad/s", discrete=True, start=0.0, doc="rate on that way")
    fault_time: Scalar = var(unit="s", discrete=True, start=0.0, doc="time at which that began")

    def unless_faulty(self, command):
        """The angle that is gone to: a command, or a fault's."""
        gone = self.fault_rate * (self.time - self.fault_time)
        angle = self.fault_angle + m.fmin(m.fmax(self.fault_way, -gone), gone)
        return m.if_else(self.faulty > 0.5, angle, command)

    def faults_of(self, angle, *when_stuck):
        """What the events do to an angle; further actions when it gets stuck."""
        away = self.runaway
        start = [assign(self.faulty, 1), assign(self.fault_angle, angle), assign(self.fault_time, self.time)]
        return [
            on(self.stuck, *start, assign(self.fault_way, 0), assign(self.fault_rate, 0), *when_stuck),
            on(away, *start, assign(self.fault_way, away.to - angle), assign(self.fault_rate, away.rate)),
        ]
