"""What a safety system acts by: measured speed, pitch, generator and brake, each as it is asked for until an event."""

from __future__ import annotations

from fowtlib.language import (
    Component,
    OfferedEvent,
    RealInput,
    RealOutput,
    Scalar,
    assign,
    eq,
    event,
    on,
    param,
    port,
    var,
)
from fowtlib.language import math as m

NEVER = -1e3
"""A pitch [rad] and a speed [rad/s] that nothing goes below."""
FADE = 0.05
"""Share of the cut-out speed within which the generator torque goes to zero above it."""
SLOW = 1.0
"""Generator speed [rad/s] around standstill within which the torque of a brake changes its sign."""


class SpeedMeasurement(Component):
    """The speed as it is, or as it was when the sensor got stuck."""

    stuck: OfferedEvent = event(doc="what is measured stays as it is")
    restored: OfferedEvent = event(doc="the sensor measures again")

    speed: RealInput = port(unit="rad/s", doc="speed")
    measured: RealOutput = port(unit="rad/s", doc="speed that is measured")

    faulty: Scalar = var(discrete=True, start=0.0, doc="1 while it is stuck")
    held: Scalar = var(unit="rad/s", discrete=True, start=0.0, doc="speed at which it is stuck")

    def equations(self):
        return [
            eq(self.measured, m.if_else(self.faulty > 0.5, self.held, self.speed)),
            on(self.stuck, assign(self.faulty, 1), assign(self.held, self.measured)),
            on(self.restored, assign(self.faulty, 0)),
        ]


class PitchRamp(Component):
    """The larger one of a demand and of a ramp in time, which ends at a highest pitch; at first there is no ramp."""

    highest: Scalar = param(default="90 deg", unit="rad", doc="pitch at which a ramp ends")
    feathered: Scalar = param(default=0.0, min=0, max=1, doc="1: it starts at the highest pitch; 0: at the demand")

    step: OfferedEvent = event(
        doc="the demand is raised", by=param(default="1 deg", unit="rad", doc="what is added to it")
    )

    demand: RealInput = port(unit="rad", doc="blade pitch that is asked for")
    output: RealOutput = port(unit="rad", doc="blade pitch")

    origin: Scalar = var(
        unit="rad", discrete=True, start=lambda self: self.feathered * self.highest + (1 - self.feathered) * NEVER,
        doc="pitch at which the ramp begins",
    )  # fmt: skip
    rate: Scalar = var(unit="rad/s", discrete=True, start=0.0, doc="rate of the ramp")
    since: Scalar = var(unit="s", discrete=True, start=0.0, doc="time at which the ramp begins")
    offset: Scalar = var(unit="rad", discrete=True, start=0.0, doc="added to the demand")

    def equations(self):
        ramp = self.origin + self.rate * (self.time - self.since)
        return [
            eq(self.output, m.fmax(self.demand + self.offset, m.fmin(ramp, self.highest))),
            on(self.step, assign(self.offset, self.offset + self.step.by)),
        ]

    def ramp_at(self, rate, delay=0.0):
        """Actions: from now on a ramp at a rate, which is at the present pitch after a delay; at rate 0 none."""
        there = m.if_else(m.abs(rate) > 0, self.output, NEVER)
        return [assign(self.origin, there), assign(self.rate, rate), assign(self.since, self.time + delay)]


class GeneratorSwitch(Component):
    """The torque that is asked for while the generator is connected, faded out above a cut-out speed, else none."""

    open: Scalar = param(default=0.0, min=0, max=1, doc="1: not connected at the start")

    step: OfferedEvent = event(
        doc="the demand is raised", by=param(default="1 kN*m", unit="N*m", doc="what is added to it")
    )

    speed: RealInput = port(unit="rad/s", doc="generator speed")
    demand: RealInput = port(unit="N*m", doc="generator torque that is asked for")
    output: RealOutput = port(unit="N*m", doc="generator torque")

    connected: Scalar = var(discrete=True, start=lambda self: 1 - self.open, doc="1 with grid and generator, else 0")
    cut_out_speed: Scalar = var(unit="rad/s", discrete=True, start=NEVER, doc="speed below which there is no torque")
    offset: Scalar = var(unit="N*m", discrete=True, start=0.0, doc="added to the demand")

    def equations(self):
        cut_out = self.cut_out_speed
        turning = _inside((self.speed - cut_out) / (FADE * m.fmax(cut_out, SLOW)))
        return [
            eq(self.output, self.connected * turning * (self.demand + self.offset)),
            on(self.step, assign(self.offset, self.offset + self.step.by)),
        ]


class ShaftBrake(Component):
    """A torque against the motion of a shaft, which comes up linearly; around standstill it is viscous."""

    rise_time: Scalar = param(default=0.6, unit="s", min=1e-3, doc="time in which the torque comes up")

    speed: RealInput = port(unit="rad/s", doc="speed of the shaft")
    torque: RealOutput = port(unit="N*m", doc="torque against the motion")

    applied: Scalar = var(unit="N*m", discrete=True, start=0.0, doc="torque when it is up; 0: the brake is off")
    since: Scalar = var(unit="s", discrete=True, start=0.0, doc="time at which the brake comes on")

    def equations(self):
        up = _inside((self.time - self.since) / self.rise_time)
        return [eq(self.torque, self.applied * up * self.speed / m.sqrt(self.speed**2 + SLOW**2))]


def _inside(share):
    """Between 0 and 1."""
    return m.fmin(m.fmax(share, 0), 1)
