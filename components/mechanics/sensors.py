"""Sensors on frames. They take no load; every output is resolved as its sentence says."""

from __future__ import annotations

import numpy as np

from fowtlib.components.mechanics.connectors import Frame
from fowtlib.components.mechanics.interfaces import TwoFrames
from fowtlib.language import (
    Component,
    RealOutput,
    Scalar,
    assign,
    der,
    eq,
    param,
    port,
    rotation,
    var,
    when,
)
from fowtlib.language import math as m


class _FrameSensor(Component):
    """A sensor on one frame. Partial."""

    frame: Frame = port(doc="frame that is measured")

    def no_load(self):
        return [eq(self.frame.f, m.zeros(3)), eq(self.frame.t, m.zeros(3))]


class PositionSensor(_FrameSensor):
    """Position of a frame's origin, world."""

    r: RealOutput = port(unit="m", shape=(3,), doc="position, world")

    def equations(self):
        return [eq(self.r, self.frame.r), self.no_load()]


class VelocitySensor(_FrameSensor):
    """Velocity of a frame's origin and its angular velocity, resolved in the world or in the frame itself."""

    resolve_in: str = param(default="world", choices=("world", "frame"), doc="axes in which the outputs are resolved")

    v: RealOutput = port(unit="m/s", shape=(3,), doc="velocity of the origin")
    w: RealOutput = port(unit="rad/s", shape=(3,), doc="angular velocity")

    def equations(self):
        frame = self.frame
        axes = m.eye(3) if self.resolve_in == "world" else frame.R.T
        return [eq(self.v, axes @ der(frame.r)), eq(self.w, axes @ frame.w), self.no_load()]


class AccelerationSensor(_FrameSensor):
    """Acceleration of a frame's origin (kinematic: gravity is not included), in the world or in the frame itself."""

    resolve_in: str = param(default="world", choices=("world", "frame"), doc="axes in which the output is resolved")

    a: RealOutput = port(unit="m/s^2", shape=(3,), doc="acceleration of the origin")

    def equations(self):
        axes = m.eye(3) if self.resolve_in == "world" else self.frame.R.T
        return [eq(self.a, axes @ der(der(self.frame.r))), self.no_load()]


class AttitudeSensor(_FrameSensor):
    """Roll, pitch and yaw of a frame in the world: R = Rz(yaw) Ry(pitch) Rx(roll), pitch within +-90 deg.

    With continuous_yaw the yaw angle counts full turns: an event moves its reference angle after every 2 rad. It must
    start within 3 rad of reference_start. Otherwise it stays within +-180 deg of reference_start and jumps there.
    """

    continuous_yaw: bool = param(default=True, doc="count full turns of yaw")
    reference_start: Scalar = param(default=0.0, unit="rad", doc="angle near which yaw starts")

    roll: RealOutput = port(unit="rad", doc="roll angle")
    pitch: RealOutput = port(unit="rad", doc="pitch angle")
    yaw: RealOutput = port(unit="rad", doc="yaw angle")

    reference: Scalar = var(unit="rad", start=reference_start, discrete=True, doc="angle from which yaw is measured")
    turned: Scalar = var(unit="rad", doc="yaw angle from the reference, within +-180 deg")

    def equations(self):
        R, c, s = self.frame.R, m.cos(self.reference), m.sin(self.reference)
        moved = assign(self.reference, self.yaw)
        return [
            eq(self.roll, m.atan2(R[2, 1], R[2, 2])),
            eq(self.pitch, m.atan2(-R[2, 0], m.sqrt(R[2, 1] ** 2 + R[2, 2] ** 2))),
            eq(self.turned, m.atan2(c * R[1, 0] - s * R[0, 0], c * R[0, 0] + s * R[1, 0])),
            eq(self.yaw, self.reference + self.turned),
            [when(sign * self.turned > angle, moved) for sign in (1, -1) for angle in (2, 3) if self.continuous_yaw],
            self.no_load(),
        ]


class RelativeSensor(TwoFrames):
    """Position and velocity of frame_b as seen by an observer who moves and turns with frame_a."""

    r: RealOutput = port(unit="m", shape=(3,), doc="position of frame_b, resolved in frame_a")
    v: RealOutput = port(unit="m/s", shape=(3,), doc="rate of that position, resolved in frame_a")
    w: RealOutput = port(unit="rad/s", shape=(3,), doc="angular velocity of b relative to a, resolved in frame_a")

    def equations(self):
        a, b, zero = self.frame_a, self.frame_b, m.zeros(3)
        gap = b.r - a.r
        return [
            eq(self.r, a.R.T @ gap),
            eq(self.v, a.R.T @ (der(b.r) - der(a.r) - m.cross(a.w, gap))),
            eq(self.w, a.R.T @ (b.w - a.w)),
            [eq(load, zero) for load in (a.f, a.t, b.f, b.t)],
        ]


class LoadSensor(TwoFrames):
    """Force and moment that pass between two frames, which it holds together rigidly.

    Positive: what the side of frame_a exerts on the side of frame_b, about the common origin, resolved in frame_a.
    Reference: Modelica.Mechanics.MultiBody.Sensors.CutForceAndTorque.
    """

    force: RealOutput = port(unit="N", shape=(3,), doc="force of side a on side b, resolved in frame_a")
    torque: RealOutput = port(unit="N*m", shape=(3,), doc="moment of side a on side b, resolved in frame_a")

    def start_rotation(self, command):
        return np.eye(3)

    def equations(self):
        a, b = self.frame_a, self.frame_b
        return [
            eq(b.r, a.r),
            rotation(a, b, m.eye(3), m.zeros(3)),
            self.transmit(),
            eq(self.force, a.R.T @ a.f),
            eq(self.torque, a.R.T @ a.t),
        ]
