"""Joints between two frames, and the constraint that closes a planar loop."""

from __future__ import annotations

import numpy as np

from fowtlib.components.mechanics.connectors import Flange, TranslationalFlange
from fowtlib.components.mechanics.interfaces import TwoFrames
from fowtlib.components.mechanics.rotations import (
    axis_rotation,
    perpendicular_axes,
    unit_axis,
    yaw_pitch_roll,
    yaw_pitch_roll_velocity,
)
from fowtlib.language import (
    RealInput,
    Scalar,
    Vector,
    assert_,
    der,
    eq,
    param,
    port,
    rotation,
    shapes,
    var,
)
from fowtlib.language import math as m


class FreeMotion(TwoFrames):
    """Six free degrees of freedom of frame_b against frame_a; no load passes: it gives a floating body its states.

    surge, sway, heave: position of frame_b in frame_a [m]. roll, pitch, yaw [rad]: R_b = R_a Rz(yaw) Ry(pitch)
    Rx(roll), the intrinsic sequence yaw, pitch, roll. At pitch = +-90 deg the axes of roll and yaw coincide: the run
    stops near it.
    Reference: Modelica.Mechanics.MultiBody.Joints.FreeMotion; H. Goldstein, Classical Mechanics, appendix A (xyz).
    """

    mode_names = {
        **{name: f"{{parent}} {name}" for name in ("surge", "sway", "heave", "roll", "pitch", "yaw")},
        **{f"velocity.{i}": f"{{parent}} {name}" for i, name in enumerate(("surge", "sway", "heave"))},
        **{f"angle_rates.{i}": f"{{parent}} {name}" for i, name in enumerate(("roll", "pitch", "yaw"))},
    }

    surge_start: Scalar = param(default=0.0, unit="m", doc="initial surge")
    sway_start: Scalar = param(default=0.0, unit="m", doc="initial sway")
    heave_start: Scalar = param(default=0.0, unit="m", doc="initial heave")
    roll_start: Scalar = param(default=0.0, unit="rad", doc="initial roll")
    pitch_start: Scalar = param(default=0.0, unit="rad", doc="initial pitch")
    yaw_start: Scalar = param(default=0.0, unit="rad", doc="initial yaw")
    velocity_start: Vector = param(default=(0, 0, 0), unit="m/s", doc="initial rates of surge, sway, heave")
    angle_rates_start: Vector = param(default=(0, 0, 0), unit="rad/s", doc="initial rates of roll, pitch, yaw")

    surge: Scalar = var(unit="m", start=surge_start, state="prefer", doc="position of frame_b along x of frame_a")
    sway: Scalar = var(unit="m", start=sway_start, state="prefer", doc="position of frame_b along y of frame_a")
    heave: Scalar = var(unit="m", start=heave_start, state="prefer", doc="position of frame_b along z of frame_a")
    roll: Scalar = var(unit="rad", start=roll_start, state="prefer", doc="third turn, about the new x axis")
    pitch: Scalar = var(unit="rad", start=pitch_start, state="prefer", doc="second turn, about the new y axis")
    yaw: Scalar = var(unit="rad", start=yaw_start, state="prefer", doc="first turn, about z of frame_a")
    velocity: Vector = var(
        unit="m/s", start=velocity_start, state="prefer", doc="rates of surge, sway, heave", hint="has the body a mass?"
    )
    angle_rates: Vector = var(
        unit="rad/s", start=angle_rates_start, state="prefer", doc="rates of roll, pitch, yaw", hint="has it inertia?"
    )
    acceleration: Vector = var(unit="m/s^2", doc="second derivatives of surge, sway, heave")
    angle_accelerations: Vector = var(unit="rad/s^2", doc="second derivatives of roll, pitch, yaw")

    def start_rotation(self, command):
        return yaw_pitch_roll(*(float(self.parameter_value(f"{name}_start")) for name in ("roll", "pitch", "yaw")))

    def start_translation(self):
        return [self.parameter_value(f"{name}_start") for name in ("surge", "sway", "heave")]

    def equations(self):
        a, b = self.frame_a, self.frame_b
        position = m.vertcat(self.surge, self.sway, self.heave)
        zero = m.zeros(3)
        return [
            eq(der(position), self.velocity),
            eq(der(m.vertcat(self.roll, self.pitch, self.yaw)), self.angle_rates),
            eq(der(self.velocity), self.acceleration),
            eq(der(self.angle_rates), self.angle_accelerations),
            eq(b.r, a.r + a.R @ position),
            rotation(
                a,
                b,
                yaw_pitch_roll(self.roll, self.pitch, self.yaw),
                yaw_pitch_roll_velocity(self.pitch, self.yaw, self.angle_rates),
            ),
            [eq(load, zero) for load in (a.f, a.t, b.f, b.t)],
            assert_(
                m.cos(self.pitch) > 0.02,
                "pitch is within about 1 deg of +-90 deg, where roll and yaw cannot be told apart: "
                "turn frame_a or frame_b (FixedRotation) so that the body works around another attitude",
            ),
        ]


class Revolute(TwoFrames):
    """Hinge: frame_b turns by phi about the axis n, which is fixed in frame_a; both frames keep the same origin.

    A positive torque of the flange turns frame_b forward; its reaction acts on frame_a.
    Reference: Modelica.Mechanics.MultiBody.Joints.Revolute.
    """

    n: Vector = param(
        default=(0, 0, 1),
        structural="its zeros drop out of the equations",
        doc="axis of rotation, resolved in frame_a (any length)",
    )
    phi_start: Scalar = param(default=0.0, unit="rad", doc="initial angle")
    w_start: Scalar = param(default=0.0, unit="rad/s", doc="initial angular velocity")

    flange: Flange = port(optional=True, doc="drive of the hinge; free when unconnected")

    phi: Scalar = var(unit="rad", start=phi_start, state="prefer", doc="angle", hint="is there inertia on both sides?")
    w: Scalar = var(unit="rad/s", start=w_start, state="prefer", doc="angular velocity")
    a: Scalar = var(unit="rad/s^2", doc="angular acceleration")

    def start_rotation(self, command):
        return axis_rotation(self.n, float(self.parameter_value("phi_start")))

    def equations(self):
        a, b, n = self.frame_a, self.frame_b, unit_axis(self.n)
        return [
            eq(der(self.phi), self.w),
            eq(der(self.w), self.a),
            eq(b.r, a.r),
            rotation(a, b, axis_rotation(n, self.phi), n * self.w),
            eq(self.flange.phi, self.phi),
            eq(self.flange.tau, -m.dot(a.R @ n, b.t)),
            self.transmit(),
        ]


class Crank(Revolute):
    """A hinge whose angle describes a closed loop: its angle and speed are the states, and the other hinges follow.

    Of a loop any hinge may be the state, but one that only swings (a rocker) has dead points, where its angle does not
    tell how the loop moves on. Use a Crank where the loop has a hinge that turns fully; elsewhere a Revolute will do.
    """

    phi: Scalar = var(unit="rad", start=Revolute.phi_start, state="always", doc="angle")
    w: Scalar = var(unit="rad/s", start=Revolute.w_start, state="always", doc="angular velocity")


class Prismatic(TwoFrames):
    """Slide: frame_b moves by s along the axis n, which is fixed in frame_a, without turning.

    A positive drive force pushes frame_b along +n; its reaction acts on frame_a.
    Reference: Modelica.Mechanics.MultiBody.Joints.Prismatic.
    """

    n: Vector = param(
        default=(1, 0, 0),
        structural="its zeros drop out of the equations",
        doc="axis of motion, resolved in frame_a (any length)",
    )
    s_start: Scalar = param(default=0.0, unit="m", doc="initial position")
    v_start: Scalar = param(default=0.0, unit="m/s", doc="initial velocity")

    force: RealInput = port(unit="N", default=0.0, doc="drive force along n; zero when unconnected")
    axis: TranslationalFlange = port(optional=True, doc="what drives or holds the slide; free when unconnected")

    s: Scalar = var(unit="m", start=s_start, state="prefer", doc="position", hint="is there mass on both sides?")
    v: Scalar = var(unit="m/s", start=v_start, state="prefer", doc="velocity")
    a: Scalar = var(unit="m/s^2", doc="acceleration")

    def start_rotation(self, command):
        return np.eye(3)

    def start_translation(self):
        return np.ravel(unit_axis(self.n)) * float(self.parameter_value("s_start"))

    def equations(self):
        a, b = self.frame_a, self.frame_b
        axis = a.R @ unit_axis(self.n)
        return [
            eq(der(self.s), self.v),
            eq(der(self.v), self.a),
            eq(b.r, a.r + axis * self.s),
            rotation(a, b, m.eye(3), m.zeros(3)),
            eq(self.axis.s, self.s),
            eq(self.force + self.axis.f, -m.dot(axis, b.f)),
            self.transmit(axis * self.s),
        ]

    def drawing(self) -> shapes.Drawing:
        return [shapes.link(self.frame_a, self.frame_b)]


class Spherical(TwoFrames):
    """Ball joint: common origin, free rotation; no moment passes. Angles as in FreeMotion, with the same singularity.

    Reference: Modelica.Mechanics.MultiBody.Joints.Spherical (with three angles as states).
    """

    roll_start: Scalar = param(default=0.0, unit="rad", doc="initial roll")
    pitch_start: Scalar = param(default=0.0, unit="rad", doc="initial pitch")
    yaw_start: Scalar = param(default=0.0, unit="rad", doc="initial yaw")
    angle_rates_start: Vector = param(default=(0, 0, 0), unit="rad/s", doc="initial rates of roll, pitch, yaw")

    roll: Scalar = var(unit="rad", start=roll_start, state="prefer", doc="third turn, about the new x axis")
    pitch: Scalar = var(unit="rad", start=pitch_start, state="prefer", doc="second turn, about the new y axis")
    yaw: Scalar = var(unit="rad", start=yaw_start, state="prefer", doc="first turn, about z of frame_a")
    angle_rates: Vector = var(
        unit="rad/s", start=angle_rates_start, state="prefer", doc="rates of roll, pitch, yaw", hint="has it inertia?"
    )
    angle_accelerations: Vector = var(unit="rad/s^2", doc="second derivatives of roll, pitch, yaw")

    def start_rotation(self, command):
        return yaw_pitch_roll(*(float(self.parameter_value(f"{name}_start")) for name in ("roll", "pitch", "yaw")))

    def equations(self):
        a, b = self.frame_a, self.frame_b
        angles = (self.roll, self.pitch, self.yaw)
        return [
            eq(der(m.vertcat(*angles)), self.angle_rates),
            eq(der(self.angle_rates), self.angle_accelerations),
            eq(b.r, a.r),
            rotation(a, b, yaw_pitch_roll(*angles), yaw_pitch_roll_velocity(self.pitch, self.yaw, self.angle_rates)),
            [eq(a.f, -b.f), eq(a.t, m.zeros(3)), eq(b.t, m.zeros(3))],
            assert_(m.cos(self.pitch) > 0.02, "pitch is within about 1 deg of +-90 deg: turn frame_a (FixedRotation)"),
        ]


class PlanarLoopRevolute(TwoFrames):
    """The hinge that closes a planar loop: it holds the two origins together in the plane perpendicular to n, only.

    An ordinary hinge there would repeat three of the loop's other equations (out-of-plane position, two rotations) and
    the loads in those directions would be undetermined. All other hinges of the loop are Revolute, parallel to n.
    Reference: Modelica.Mechanics.MultiBody.Joints.RevolutePlanarLoopConstraint.
    """

    n: Vector = param(
        default=(0, 0, 1),
        structural="its zeros drop out of the equations",
        doc="common axis of the loop's hinges, resolved in frame_a",
    )

    force_1: Scalar = var(unit="N", doc="constraint force along the first direction in the plane, on frame_a")
    force_2: Scalar = var(unit="N", doc="constraint force along the second direction in the plane, on frame_a")

    def equations(self):
        a, b = self.frame_a, self.frame_b
        e, g = (a.R @ axis for axis in perpendicular_axes(self.n))
        gap = b.r - a.r
        return [
            eq(m.dot(e, gap), m.zeros(1)),
            eq(m.dot(g, gap), m.zeros(1)),
            eq(a.f, e * self.force_1 + g * self.force_2),
            eq(b.f, -a.f),
            eq(a.t, m.zeros(3)),
            eq(b.t, m.zeros(3)),
        ]
