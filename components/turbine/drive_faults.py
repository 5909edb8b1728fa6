"""What can happen to a drive that follows a commanded angle."""

from __future__ import annotations

import math

from fowtlib.components.mechanics import TwoFrames
from fowtlib.components.servo.command_faults import CommandFaults
from fowtlib.language import OfferedEvent, RealInput, Scalar, assign, event, on, param, port, reinit, var
from fowtlib.language import math as m


class FaultyDrive(TwoFrames, CommandFaults):
    """Partial: a drive of second order with a command that it leaves when it is stuck or runs away.

    A drive that is stuck stops from any rate at once. One that runs away goes to its new angle as it would follow a
    command that moves there at the rate. One that is slow has another natural frequency and damping ratio, and far
    from its command it comes to a rate and not beyond: frequency^2 acts on a way of at most 2 damping rate / frequency.
    The defaults are a pitch drive with low hydraulic pressure, 3.42 rad/s and 0.9 (P. F. Odgaard, J. Stoustrup and
    M. Kinnaert, IEEE Trans. Control Syst. Technol. 21, 2013, 1168). A subclass has the states phi and w.
    """

    released: OfferedEvent = event(doc="it follows its command again, as fast as ever")
    step: OfferedEvent = event(
        doc="the command is raised", by=param(default="1 deg", unit="rad", doc="what is added to it")
    )
    slow: OfferedEvent = event(
        doc="it has lost its strength, and follows its command more slowly",
        frequency=param(default=3.42 / (2 * math.pi), unit="Hz", min=1e-3, doc="natural frequency from now on"),
        damping=param(default=0.9, min=1e-3, doc="damping ratio from now on"),
        rate=param(default="8 deg/s", unit="rad/s", min=0, doc="rate far from its command"),
    )

    command: RealInput = port(unit="rad", default=0.0, doc="commanded angle")

    offset: Scalar = var(unit="rad", discrete=True, start=0.0, doc="added to the command")
    weak: Scalar = var(discrete=True, start=0.0, doc="1 while it is slow")
    weak_frequency: Scalar = var(unit="Hz", discrete=True, start=1.0, doc="natural frequency while it is slow")
    weak_damping: Scalar = var(discrete=True, start=1.0, doc="damping ratio while it is slow")
    weak_rate: Scalar = var(unit="rad/s", discrete=True, start=0.0, doc="greatest rate while it is slow")

    def commanded(self):
        """The angle that the drive follows: its command, or a fault's."""
        return self.unless_faulty(self.command + self.offset)

    def acceleration(self, w0, damping_ratio):
        """What the drive does on its way to that angle; w0 [rad/s] and damping ratio while it is sound."""
        way, weak = self.commanded() - self.phi, self.weak > 0.5
        slow = 2 * math.pi * self.weak_frequency
        reach = 2 * self.weak_damping * self.weak_rate / slow
        near = m.fmin(m.fmax(way, -reach), reach)
        sound = w0 * (w0 * way - 2 * damping_ratio * self.w)
        return m.if_else(weak, slow * (slow * near - 2 * self.weak_damping * self.w), sound)

    def faults(self, also=()):
        """What the events do; also: actions when it gets stuck."""
        slow = self.slow
        return [
            self.faults_of(self.phi, reinit(self.w, 0), *also),
            on(self.released, assign(self.faulty, 0), assign(self.weak, 0)),
            on(self.step, assign(self.offset, self.offset + self.step.by)),
            on(
                slow, assign(self.weak, 1), assign(self.weak_frequency, slow.frequency),
                assign(self.weak_damping, slow.damping), assign(self.weak_rate, slow.rate),
            ),
        ]  # fmt: skip
