"""The mechanical connectors: `Frame` (3-D), `Flange`, `TranslationalFlange` (1-D), `ModalCoordinates` (of shapes)."""

from __future__ import annotations

from fowtlib.language import Connector, flow, orientation, potential


class Frame(Connector):
    """A coordinate system fixed to a body, where 3-D mechanical parts are joined.

    Everything is resolved in the world (x downwind, y to port, z up): sea, wind and mooring loads stay readable.
    The orientation R maps components in this frame to components in the world: v = R @ v_frame; R' = skew(w) @ R.
    Loads are positive into the component that owns the port; the moment is taken about the origin of the frame.

    Vocabulary: Modelica.Mechanics.MultiBody.Interfaces.Frame (whose R is the transpose and whose loads are local).
    """

    r = potential(shape=(3,), unit="m", doc="position of the origin, world")
    R = orientation(angular_velocity="w", doc="rotation matrix, world from frame")
    w = potential(shape=(3,), unit="rad/s", doc="angular velocity, world")
    f = flow(shape=(3,), unit="N", doc="force into the component, world")
    t = flow(shape=(3,), unit="N*m", doc="moment into the component about the origin of the frame, world")


class Flange(Connector):
    """A shaft end of the 1-D rotational parts: angle and torque.

    The torque is positive into the component that owns the port: it turns that component forward.
    Vocabulary: Modelica.Mechanics.Rotational.Interfaces.Flange.
    """

    phi = potential(unit="rad", doc="angle of the shaft end")
    tau = flow(unit="N*m", doc="torque into the component")


class TranslationalFlange(Connector):
    """A sliding end of the 1-D translational parts: position along an axis, and force.

    The force is positive into the component that owns the port: it pushes that component towards +s. On the axis of a
    `Prismatic` its reaction acts on the carrier of the slide.
    Vocabulary: Modelica.Mechanics.Translational.Interfaces.Flange.
    """

    s = potential(unit="m", doc="position of the sliding end")
    f = flow(unit="N", doc="force into the component")


class ModalCoordinates(Connector):
    """The coordinates of the shapes into which a body deforms, as many as the port says, and the loads on them.

    A shape is a field of displacements [m] per coordinate [m]; the load on it is the work of all forces per coordinate.
    """

    q = potential(shape="port", unit="m", doc="coordinates of the shapes")
    f = flow(shape="port", unit="N", doc="loads on the shapes, into the component")
