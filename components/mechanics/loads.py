"""Loads on frames: given by signals, or by a spring and damper between two frames."""

from __future__ import annotations

from fowtlib.components.mechanics.connectors import Frame
from fowtlib.components.mechanics.interfaces import TwoFrames
from fowtlib.language import Component, RealInput, Scalar, Vector, assert_, der, eq, param, port, shapes, var
from fowtlib.language import math as m


class WorldForce(Component):
    """A force on a frame, given by a signal; it acts at the origin of the frame, on the part joined there.

    Reference: Modelica.Mechanics.MultiBody.Forces.WorldForce.
    """

    resolve_in: str = param(default="world", choices=("world", "frame"), doc="axes in which the signal is resolved")

    frame: Frame = port(doc="where the force acts")
    force: RealInput = port(unit="N", shape=(3,), doc="force on the part joined to the frame")

    def equations(self):
        load = self.force if self.resolve_in == "world" else self.frame.R @ self.force
        return [eq(self.frame.f, -load), eq(self.frame.t, m.zeros(3))]


class ConstantForce(Component):
    """A force on a frame that is the same at all times, resolved in the world; it acts at the origin of the frame."""

    force: Vector = param(default=(0, 0, 0), unit="N", doc="force on the part joined to the frame, world")

    frame: Frame = port(doc="where the force acts")

    def equations(self):
        return [eq(self.frame.f, -self.force), eq(self.frame.t, m.zeros(3))]


class WorldTorque(Component):
    """A moment on a frame, given by a signal; it acts on the part joined there.

    Reference: Modelica.Mechanics.MultiBody.Forces.WorldTorque.
    """

    resolve_in: str = param(default="world", choices=("world", "frame"), doc="axes in which the signal is resolved")

    frame: Frame = port(doc="where the moment acts")
    torque: RealInput = port(unit="N*m", shape=(3,), doc="moment on the part joined to the frame")

    def equations(self):
        load = self.torque if self.resolve_in == "world" else self.frame.R @ self.torque
        return [eq(self.frame.f, m.zeros(3)), eq(self.frame.t, -load)]


class SpringDamper(TwoFrames):
    """Linear spring and damper along the line between two origins; tension is positive and pulls the frames together.

    tension = stiffness (length - natural_length) + damping d(length)/dt. It pushes when shorter than natural_length.
    Reference: Modelica.Mechanics.MultiBody.Forces.SpringDamperParallel.
    """

    stiffness: Scalar = param(unit="N/m", min=0, doc="stiffness")
    damping: Scalar = param(default=0.0, unit="N*s/m", min=0, doc="damping")
    natural_length: Scalar = param(default=0.0, unit="m", min=0, doc="length without load")

    length: Scalar = var(unit="m", state="never", doc="distance of the two origins")
    tension: Scalar = var(unit="N", doc="tension")

    def equations(self):
        a, b = self.frame_a, self.frame_b
        line = b.r - a.r
        direction = line / self.length
        rate = m.dot(direction, der(b.r) - der(a.r))
        return [
            eq(self.length, m.norm(line)),
            eq(self.tension, self.stiffness * (self.length - self.natural_length) + self.damping * rate),
            [eq(a.f, -direction * self.tension), eq(b.f, direction * self.tension)],
            [eq(a.t, m.zeros(3)), eq(b.t, m.zeros(3))],
            assert_(self.length > 1e-9, "the two ends of the spring meet, so its direction is undetermined"),
        ]

    def drawing(self) -> shapes.Drawing:
        return [shapes.link(self.frame_a, self.frame_b)]
