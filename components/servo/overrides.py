"""What a safety system acts by: pitch, generator and brake, each as it is asked for until an event."""

from __future__ import annotations

from fowtlib.components.servo.command_faults import CommandFaults
from fowtlib.language import (
    Component,
    OfferedEvent,
    RealInput,
    RealOutput,
    Scalar,
    assert_,
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


class PitchRamp(CommandFaults):
    """The larger one of a demand and of a ramp in time, which ends at a highest pitch; at first there is no ramp.

    Faults are those of all blades together, which then heed neither controller nor shutdown.
    """

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
            eq(self.output, self.unless_faulty(m.fmax(self.demand + self.offset, m.fmin(ramp, self.highest)))),
            on(self.step, assign(self.offset, self.offset + self.step.by)),
            self.faults_of(self.output),
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
    trip: OfferedEvent = event(doc="its breaker opens: no torque from now on, and nothing else happens by itself")

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
            on(self.trip, assign(self.connected, 0)),
        ]


class ShaftBrake(Component):
    """A torque against the motion of a shaft, which comes up linearly; around standstill it is viscous."""

    rise_time: Scalar = param(default=0.6, unit="s", min=1e-3, doc="time in which the torque comes up")
    rated_torque: Scalar = param(default=0.0, unit="N*m", min=0, doc="torque of an event that does not say it")
    on: Scalar = param(default=0.0, min=0, max=1, doc="1: it is on at the start, with rated_torque; 0: off")

    apply: OfferedEvent = event(
        doc="the brake comes on, and nothing else happens",
        torque=param(default=rated_torque, unit="N*m", min=0, doc="torque when it is up"),
        delay=param(default=0.0, unit="s", min=0, doc="time until it comes on"),
    )  # fmt: skip
    release: OfferedEvent = event(doc="the brake is off")
    failure: OfferedEvent = event(doc="what is left of its torque from now on, whenever it is on",
                                  left=param(default=0.0, min=0, max=1, doc="share that is left"))  # fmt: skip

    speed: RealInput = port(unit="rad/s", doc="speed of the shaft")
    torque: RealOutput = port(unit="N*m", doc="torque against the motion")

    applied: Scalar = var(
        unit="N*m", discrete=True, start=lambda self: self.on * self.rated_torque,
        doc="torque when it is up; 0: the brake is off",
    )  # fmt: skip
    since: Scalar = var(unit="s", discrete=True, start=0.0, doc="time at which the brake comes on")
    held: Scalar = var(discrete=True, start=lambda self: self.on, doc="1: it has been up from the start on")
    share: Scalar = var(discrete=True, start=1.0, doc="of its torque that it still has")

    def equations(self):
        up = self.share * (self.held + (1 - self.held) * _inside((self.time - self.since) / self.rise_time))
        return [
            assert_(
                m.if_else(self.on > 0, self.rated_torque, 1.0) > 0,
                "the brake is on at the start, and its torque is 0; give one",
            ),
            eq(self.torque, self.applied * up * self.speed / m.sqrt(self.speed**2 + SLOW**2)),
            on(self.apply, *self.on_at(self.apply.torque, self.apply.delay)),
            on(self.release, *self.off()),
            on(self.failure, assign(self.share, self.failure.left)),
        ]

    def on_at(self, torque, delay=0.0):
        """Actions: the brake comes on after a delay."""
        return [assign(self.applied, torque), assign(self.since, self.time + delay)]

    def off(self):
        """Actions: the brake is off."""
        return [assign(self.applied, 0), assign(self.held, 0)]


def _inside(share):
    """Between 0 and 1."""
    return m.fmin(m.fmax(share, 0), 1)
