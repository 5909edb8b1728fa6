"""Rigid bodies and rigid, massless links."""

from __future__ import annotations

import numpy as np

from fowtlib.components.environment.world import World
from fowtlib.components.mechanics.connectors import Frame
from fowtlib.components.mechanics.interfaces import TwoFrames
from fowtlib.components.mechanics.rotations import axis_rotation, yaw_pitch_roll
from fowtlib.language import (
    Component,
    Matrix,
    Number,
    Scalar,
    Vector,
    der,
    eq,
    facts,
    fix_orientation,
    outer,
    param,
    port,
    rotation,
    shapes,
    var,
)
from fowtlib.language import math as m


class Fixed(Component):
    """A frame welded to the world at a given place and attitude, R = Rz(yaw) Ry(pitch) Rx(roll).

    Reference: Modelica.Mechanics.MultiBody.Parts.Fixed.
    """

    r: Vector = param(default=(0, 0, 0), unit="m", doc="position of the frame, world")
    angles: Vector = param(default=(0, 0, 0), unit="rad", doc="roll, pitch, yaw of the frame")

    frame: Frame = port(doc="the fixed frame")

    def fixed_rotation(self):
        return yaw_pitch_roll(*map(float, self.parameter_value("angles")))

    def start_place(self):
        return self.parameter_value("r")

    def equations(self):
        R = yaw_pitch_roll(self.angles[0], self.angles[1], self.angles[2])
        return [eq(self.frame.r, self.r), fix_orientation(self.frame, R, m.zeros(3))]


class FixedTranslation(TwoFrames):
    """Rigid massless link: frame_b lies at r from frame_a and is parallel to it.

    Reference: Modelica.Mechanics.MultiBody.Parts.FixedTranslation.
    """

    r: Vector = param(unit="m", doc="from frame_a to frame_b, resolved in frame_a")
    diameter: Number = param(default=None, unit="m", min=0, doc="diameter of the rod in pictures; 0 hides it")

    def start_rotation(self, command):
        return np.eye(3)

    def start_translation(self):
        return self.parameter_value("r")

    def equations(self):
        a, b = self.frame_a, self.frame_b
        arm = a.R @ self.r
        return [eq(b.r, a.r + arm), rotation(a, b, m.eye(3), m.zeros(3)), self.transmit(arm)]

    def drawing(self) -> shapes.Drawing:
        return shapes.rod(self.frame_a, self.parameter_value("r"), self.diameter)


class FixedRotation(TwoFrames):
    """Rigid massless link: frame_b lies at r from frame_a and is turned by `angle` about the axis n.

    Reference: Modelica.Mechanics.MultiBody.Parts.FixedRotation.
    """

    n: Vector = param(
        default=(0, 0, 1),
        structural="its zeros drop out of the equations",
        doc="axis of rotation, resolved in frame_a (any length)",
    )
    angle: Scalar = param(unit="rad", doc="angle from frame_a to frame_b")
    r: Vector = param(default=(0, 0, 0), unit="m", doc="from frame_a to frame_b, resolved in frame_a")
    diameter: Number = param(default=None, unit="m", min=0, doc="diameter of the rod in pictures; 0 hides it")

    def start_rotation(self, command):
        return axis_rotation(self.n, float(self.parameter_value("angle")))

    def start_translation(self):
        return self.parameter_value("r")

    def equations(self):
        a, b = self.frame_a, self.frame_b
        arm = a.R @ self.r
        return [eq(b.r, a.r + arm), rotation(a, b, axis_rotation(self.n, self.angle), m.zeros(3)), self.transmit(arm)]

    def drawing(self) -> shapes.Drawing:
        return shapes.rod(self.frame_a, self.parameter_value("r"), self.diameter)


class RigidBody(Component):
    """A rigid body under gravity: Newton for its centre of mass, Euler about it.

    f = m (dv/dt - g); t = R (I dw_a/dt + w_a x I w_a) + (R r_cm) x f, where w_a = R.T w is resolved in frame_a.
    Reference: H. Goldstein, Classical Mechanics, ch. 5; Modelica.Mechanics.MultiBody.Parts.Body.
    """

    mass: Scalar = param(unit="kg", min=0, doc="mass")
    inertia: Matrix = param(
        unit="kg*m^2", form="inertia", doc="inertia tensor about the centre of mass, resolved in frame_a"
    )
    r_cm: Vector = param(default=(0, 0, 0), unit="m", doc="centre of mass, from frame_a, resolved in frame_a")

    world: World = outer(World)
    frame_a: Frame = port(doc="frame fixed to the body")

    v: Vector = var(unit="m/s", state="avoid", doc="velocity of the centre of mass, world")

    def equations(self):
        a, R = self.frame_a, self.frame_a.R
        arm, w_a = R @ self.r_cm, R.T @ a.w
        gravity = m.vertcat(0, 0, -self.world.gravity)
        rate_of_spin = self.inertia @ (R.T @ der(a.w)) + m.cross(w_a, self.inertia @ w_a)
        return [
            eq(self.v, der(a.r) + m.cross(a.w, arm)),
            eq(a.f, self.mass * (der(self.v) - gravity)),
            eq(a.t, R @ rate_of_spin + m.cross(arm, a.f)),
        ]

    def drawing(self) -> shapes.Drawing:
        return [shapes.Ball(self.frame_a, self.parameter_value("r_cm"), material="body")]

    def facts(self) -> list[facts.Fact]:
        mass, centre, inertia = (self.parameter_value(name) for name in ("mass", "r_cm", "inertia"))
        return [facts.Mass(self.frame_a, mass, centre, inertia)]


class PointMass(Component):
    """A mass without extension at the origin of its frame, under gravity: f = m (dv/dt - g), t = 0.

    Reference: Modelica.Mechanics.MultiBody.Parts.PointMass (which has no orientation; this one rides on a frame).
    """

    mass: Scalar = param(unit="kg", min=0, doc="mass")

    world: World = outer(World)
    frame_a: Frame = port(doc="frame at the mass")

    v: Vector = var(unit="m/s", state="avoid", doc="velocity, world")

    def equations(self):
        a = self.frame_a
        return [
            eq(self.v, der(a.r)),
            eq(a.f, self.mass * (der(self.v) - m.vertcat(0, 0, -self.world.gravity))),
            eq(a.t, m.zeros(3)),
        ]

    def drawing(self) -> shapes.Drawing:
        return [shapes.Ball(self.frame_a, material="body")]

    def facts(self) -> list[facts.Fact]:
        return [facts.Mass(self.frame_a, self.parameter_value("mass"))]
