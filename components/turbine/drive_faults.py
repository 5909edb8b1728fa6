"""What can happen to a drive that follows a commanded angle."""

from __future__ import annotations

from fowtlib.components.mechanics import TwoFrames
from fowtlib.language import OfferedEvent, RealInput, Scalar, assign, event, on, param, port, reinit, var
from fowtlib.language import math as m


class FaultyDrive(TwoFrames):
    """Partial: a drive with a command that it leaves when it is stuck or runs away.

    A drive that is stuck stops from any rate at once. One that runs away goes to its new angle as it would follow a
    command that moves there at the rate. A subclass has the states phi and w.
    """

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

    def faults(self, also=()):
        """What the events do; also: actions when it gets stuck."""
        away = self.runaway
        start = [assign(self.faulty, 1), assign(self.fault_angle, self.phi), assign(self.fault_time, self.time)]
        return [
            on(self.stuck, *start, assign(self.fault_way, 0), assign(self.fault_rate, 0), reinit(self.w, 0), *also),
            on(away, *start, assign(self.fault_way, away.to - self.phi), assign(self.fault_rate, away.rate)),
            on(self.released, assign(self.faulty, 0)),
            on(self.step, assign(self.offset, self.offset + self.step.by)),
        ]
