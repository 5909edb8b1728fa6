"""Where a model is cut in two that are simulated side by side: a point is moved by one and held by the other."""

from __future__ import annotations

from fowtlib.components.mechanics.connectors import Frame
from fowtlib.language import (
    Component,
    RealInput,
    RealOutput,
    Vector,
    assert_,
    der,
    eq,
    fix_orientation,
    input_rate,
    param,
    port,
)
from fowtlib.language import math as m


class ForceToPositionAdaptor(Component):
    """A point of a body, cut off what holds it: takes the force of the missing part, gives its position and velocity.

    It stands in the model that has the mass; in the other one stands a PositionToForceAdaptor. No moment passes.
    Reference: Modelica.Mechanics.Translational.Components.GeneralForceToPositionAdaptor, here in space.
    """

    frame: Frame = port(doc="the point, on the body")
    force: RealInput = port(
        unit="N", shape=(3,), default=(0, 0, 0), doc="force of the missing part on the body, world; else zero"
    )
    position: RealOutput = port(unit="m", shape=(3,), doc="position of the point, world")
    velocity: RealOutput = port(unit="m/s", shape=(3,), doc="velocity of the point, world")

    def equations(self):
        frame = self.frame
        return [
            [eq(frame.f, -self.force), eq(frame.t, m.zeros(3))],
            [eq(self.position, frame.r), eq(self.velocity, der(frame.r))],
        ]


class _HeldPoint(Component):
    """Partial: a point that a missing body carries along; its axes stay those of the world."""

    position_start: Vector = param(default=(0, 0, 0), unit="m", structural=True, doc="position unless given, world")

    frame: Frame = port(doc="the point, on what is held by the missing body")
    position: RealInput = port(unit="m", shape=(3,), default=position_start, doc="position of the point, world")
    velocity: RealInput = port(unit="m/s", shape=(3,), default=(0, 0, 0), doc="velocity of the point, world")
    force: RealOutput = port(unit="N", shape=(3,), doc="force of the parts here on the missing body, world")

    def held(self):
        """The frame, where the missing body has it, and the force."""
        frame = self.frame
        input_rate(self.position, self.velocity)
        return [
            eq(frame.r, self.position),
            fix_orientation(frame, m.eye(3), m.zeros(3)),
            eq(self.force, frame.f),
        ]


class PositionToForceAdaptor(_HeldPoint):
    """The other side of a ForceToPositionAdaptor: takes position and velocity of the point, gives the force on it.

    The position is held from one exchange to the next; parts that need the velocity of the point, such as dampers, see
    the input `velocity`, which is zero where nobody gives it. The axes of the frame stay those of the world, and no
    moment may act on it.
    Reference: Modelica.Mechanics.Translational.Components.GeneralPositionToForceAdaptor, here in space.
    """

    def equations(self):
        moment = self.frame.t
        return [self.held(), assert_(m.dot(moment, moment) < 1, "a moment acts on the point where the model is cut")]


class PositionToLoadAdaptor(_HeldPoint):
    """A point that a missing body carries along without turning it: takes its motion, gives force and moment on it.

    As in a PositionToForceAdaptor, for what may bear on the point with a moment as well, such as a turbine on a hull
    that is in another program or in a basin. The point has no acceleration: masses here add their weight to the load,
    and no inertia.
    """

    moment: RealOutput = port(unit="N*m", shape=(3,), doc="moment of the parts here on the missing body, world")

    def equations(self):
        return [self.held(), eq(self.moment, self.frame.t)]
