"""What stands between a controller and the machine: shutdowns, loss of the grid, faults of sensors and commands."""

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
"""A speed [rad/s] and a pitch [rad] that are never gone below."""
FADE = 0.05
"""Share of the cut-out speed within which the generator torque goes to zero above it."""
SLOW = 1.0
"""Generator speed [rad/s] around standstill within which the brake torque changes its sign."""


class SafetySystem(Component):
    """Passes on speed, pitch and torque unchanged until an event; then it acts over the head of the controller.

    blade_pitch is the larger one of what the controller asks for and a ramp: in a shutdown from the pitch at that
    moment up to feather_pitch, in a start-up down from it, so that the controller takes over where they meet. The
    controller goes on by itself and is not told; an external library cannot know of the event but by its measurements.
    generator_torque is none without grid, and in a shutdown fades out above cut_out_speed. The brake on the high speed
    shaft comes up linearly within brake_time; around standstill it is viscous. Events of one turbine may follow each
    other; the later one counts. Reference: IEC 61400-1, 2019, 7.4 and 8 (protection functions).
    """

    feather_pitch: Scalar = param(default="90 deg", unit="rad", doc="pitch at which the turbine is shut down")
    greatest_rate: Scalar = param(default="8 deg/s", unit="rad/s", min=0, doc="pitch rate of an emergency shutdown")
    brake_torque: Scalar = param(default=0.0, unit="N*m", min=0, doc="greatest torque of the brake, high speed side")
    brake_time: Scalar = param(default=0.6, unit="s", min=1e-3, doc="time in which the brake comes up")
    idling: Scalar = param(default=0.0, min=0, max=1, doc="1: shut down at the start, at feather_pitch; 0: in operation")

    normal_shutdown: OfferedEvent = event(
        doc="the blades pitch to feather; the generator brakes on down to a speed",
        rate=param(default="2 deg/s", unit="rad/s", min=0, doc="pitch rate"),
        cut_out_speed=param(default=0.0, unit="rad/s", min=0, doc="generator speed below which there is no torque"),
    )  # fmt: skip
    emergency_shutdown: OfferedEvent = event(
        doc="the blades pitch to feather at the greatest rate, the generator is off, and the brake comes on",
        rate=param(default=greatest_rate, unit="rad/s", min=0, doc="pitch rate"),
        brake_torque=param(default=brake_torque, unit="N*m", min=0, doc="torque of the brake, high speed side"),
        brake_delay=param(default=0.0, unit="s", min=0, doc="time until the brake comes on"),
        generator=param(default=0.0, min=0, max=1, doc="1: the generator brakes on; 0: it is off at once"),
    )  # fmt: skip
    grid_loss: OfferedEvent = event(
        doc="the generator torque is gone at once; after a delay the blades pitch to feather",
        delay=param(default=0.2, unit="s", min=0, doc="time until the blades begin to pitch"),
        rate=param(default=greatest_rate, unit="rad/s", min=0, doc="pitch rate; 0: no shutdown follows"),
    )  # fmt: skip
    start_up: OfferedEvent = event(
        doc="the blades pitch towards operation, grid and generator are there, the brake is off",
        rate=param(default="2 deg/s", unit="rad/s", min=0, doc="pitch rate, until the controller takes over"),
    )  # fmt: skip
    sensor_stuck: OfferedEvent = event(doc="the generator speed that the controller measures stays as it is")
    sensor_restored: OfferedEvent = event(doc="the controller measures the generator speed again")
    pitch_step: OfferedEvent = event(
        doc="the pitch command is raised", by=param(default="1 deg", unit="rad", doc="what is added to it")
    )  # fmt: skip
    torque_step: OfferedEvent = event(
        doc="the torque command is raised", by=param(default="1 kN*m", unit="N*m", doc="what is added to it")
    )  # fmt: skip

    generator_speed: RealInput = port(unit="rad/s", doc="generator speed")
    pitch_demand: RealInput = port(unit="rad", doc="blade pitch that the controller asks for")
    torque_demand: RealInput = port(unit="N*m", doc="generator torque that the controller asks for")
    measured_speed: RealOutput = port(unit="rad/s", doc="generator speed that the controller gets")
    blade_pitch: RealOutput = port(unit="rad", doc="blade pitch")
    generator_torque: RealOutput = port(unit="N*m", doc="generator torque")
    brake: RealOutput = port(unit="N*m", doc="torque of the brake on the high speed shaft, against its motion")

    pitch_from: Scalar = var(
        unit="rad", discrete=True, doc="pitch at which the ramp begins",
        start=lambda self: self.idling * self.feather_pitch + (1 - self.idling) * NEVER,
    )  # fmt: skip
    pitch_rate: Scalar = var(unit="rad/s", discrete=True, start=0.0, doc="rate of the ramp")
    pitch_time: Scalar = var(unit="s", discrete=True, start=0.0, doc="time at which the ramp begins")
    connected: Scalar = var(discrete=True, start=lambda self: 1 - self.idling, doc="1 with grid and generator, else 0")
    cut_out_speed: Scalar = var(unit="rad/s", discrete=True, start=NEVER, doc="speed below which there is no torque")
    braking: Scalar = var(unit="N*m", discrete=True, start=0.0, doc="torque of the brake when it is up")
    brake_since: Scalar = var(unit="s", discrete=True, start=0.0, doc="time at which the brake comes on")
    stuck: Scalar = var(discrete=True, start=0.0, doc="1 while the measured speed is stuck")
    stuck_at: Scalar = var(unit="rad/s", discrete=True, start=0.0, doc="speed at which it is stuck")
    pitch_offset: Scalar = var(unit="rad", discrete=True, start=0.0, doc="added to the pitch command")
    torque_offset: Scalar = var(unit="N*m", discrete=True, start=0.0, doc="added to the torque command")

    def equations(self):
        ramp = self.pitch_from + self.pitch_rate * (self.time - self.pitch_time)
        speed, cut_out = self.generator_speed, self.cut_out_speed
        turning = _inside((speed - cut_out) / (FADE * m.fmax(cut_out, SLOW)))
        up = _inside((self.time - self.brake_since) / self.brake_time)
        return [
            eq(self.measured_speed, m.if_else(self.stuck > 0.5, self.stuck_at, speed)),
            eq(self.blade_pitch, m.fmax(self.pitch_demand + self.pitch_offset, m.fmin(ramp, self.feather_pitch))),
            eq(self.generator_torque, self.connected * turning * (self.torque_demand + self.torque_offset)),
            eq(self.brake, self.braking * up * speed / m.sqrt(speed**2 + SLOW**2)),
            *self.shutdowns(),
            on(self.sensor_stuck, assign(self.stuck, 1), assign(self.stuck_at, self.measured_speed)),
            on(self.sensor_restored, assign(self.stuck, 0)),
            on(self.pitch_step, assign(self.pitch_offset, self.pitch_offset + self.pitch_step.by)),
            on(self.torque_step, assign(self.torque_offset, self.torque_offset + self.torque_step.by)),
        ]

    def shutdowns(self):
        """What starts and stops the turbine."""
        normal, emergency, grid = self.normal_shutdown, self.emergency_shutdown, self.grid_loss
        return [
            on(normal, *self.pitch_at(normal.rate), assign(self.cut_out_speed, normal.cut_out_speed)),
            on(
                emergency, *self.pitch_at(emergency.rate),
                assign(self.connected, self.connected * emergency.generator),
                assign(self.braking, emergency.brake_torque),
                assign(self.brake_since, self.time + emergency.brake_delay),
            ),
            on(grid, *self.pitch_at(grid.rate, grid.delay), assign(self.connected, 0)),
            on(
                self.start_up, *self.pitch_at(-self.start_up.rate), assign(self.connected, 1),
                assign(self.cut_out_speed, NEVER), assign(self.braking, 0),
            ),
        ]  # fmt: skip

    def pitch_at(self, rate, delay=0.0):
        """The ramp goes at a rate through the present pitch, after a delay; at rate 0 there is none."""
        there = m.if_else(m.abs(rate) > 0, self.blade_pitch, NEVER)
        return [
            assign(self.pitch_from, there), assign(self.pitch_rate, rate), assign(self.pitch_time, self.time + delay),
        ]  # fmt: skip


def _inside(share):
    """Between 0 and 1."""
    return m.fmin(m.fmax(share, 0), 1)
