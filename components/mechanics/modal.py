"""A body that deforms in a few shapes: their inertia and stiffness, and frames that are carried by it.

The shapes are small and are carried along by a frame that moves as far as it likes (a floating frame of reference).
They are those of the free structure, so that they carry no momentum of its own mass; what stands on it does that by the
frames. Left out: forces by the turning of the frame on what is displaced (of the order of displacement over size).
Source: A.A. Shabana, Dynamics of Multibody Systems (2013), ch. 5.
"""

from __future__ import annotations

from fowtlib.components.mechanics.connectors import Frame, ModalCoordinates
from fowtlib.components.mechanics.rotations import yaw_pitch_roll, yaw_pitch_roll_velocity
from fowtlib.language import Array, Component, Scalar, Vector, assert_, der, eq, param, port, rotation, var
from fowtlib.language import math as m

_LARGEST_TURN = 0.2  # rad: of a frame by the shapes, beyond which they are not small


class ElasticBody(Component):
    """Inertia, damping and stiffness of shapes: load + `load` = mass q'' + damping_time stiffness q' + stiffness q."""

    shapes: int = param(min=1, doc="number of shapes")
    mass: Array = param(shape=("shapes", "shapes"), unit="kg", doc="modal mass")
    stiffness: Array = param(shape=("shapes", "shapes"), unit="N/m", doc="modal stiffness")
    damping_time: Scalar = param(default=0.0, unit="s", min=0, doc="damping over stiffness")
    load: Array = param(
        default=lambda self: [0.0] * self.shapes, shape="shapes", unit="N", doc="load on the shapes at rest"
    )

    modes: ModalCoordinates = port(shape="shapes", optional=True, doc="coordinates of the shapes")
    q: Array = var(shape="shapes", unit="m", state="prefer", doc="coordinates of the shapes")
    v: Array = var(shape="shapes", unit="m/s", state="prefer", doc="their rates")

    mode_names = {"q.*": "{parent} bending", "v.*": "{parent} bending"}

    def equations(self):
        elastic = m.mtimes(self.stiffness, self.q + self.damping_time * self.v)
        return [
            eq(self.modes.q, self.q),
            eq(der(self.q), self.v),
            eq(self.modes.f, m.mtimes(self.mass, der(self.v)) + elastic - self.load),
        ]


class ElasticFrame(Component):
    """A frame at a point of a body that deforms: `node` moves with `frame` and with the shapes, without mass.

    It lies at `place` + displacement q in the axes of `frame`, turned by the small angles turn q about them (taken as
    roll, pitch and yaw). The load on the node is a load on the frame and on the shapes, of the same power.
    Errors: an angle by the shapes beyond 0.2 rad.
    """

    shapes: int = param(min=1, doc="number of shapes")
    place: Vector = param(unit="m", doc="the point at rest, in the axes of `frame`")
    displacement: Array = param(shape=(3, "shapes"), doc="displacement of the point per coordinate")
    turn: Array = param(shape=(3, "shapes"), unit="rad/m", doc="turn of its section per coordinate")

    frame: Frame = port(doc="the frame that carries the shapes")
    node: Frame = port(doc="the frame at the point")
    modes: ModalCoordinates = port(shape="shapes", doc="coordinates of the shapes")

    def equations(self):
        a, b, q = self.frame, self.node, self.modes.q
        angles = m.mtimes(self.turn, q)
        arm = a.R @ (self.place + m.mtimes(self.displacement, q))
        velocities = [yaw_pitch_roll_velocity(angles[1], angles[2], m.eye(3)[:, k]) for k in range(3)]
        spin = m.horzcat(*velocities)
        force, moment = a.R.T @ b.f, a.R.T @ b.t
        on_shapes = m.mtimes(self.displacement.T, force) + m.mtimes(self.turn.T, spin.T @ moment)
        return [
            eq(b.r, a.r + arm),
            rotation(a, b, yaw_pitch_roll(angles[0], angles[1], angles[2]), spin @ m.mtimes(self.turn, der(q))),
            [eq(a.f, -b.f), eq(a.t, -b.t - m.cross(arm, b.f))],
            eq(self.modes.f, -on_shapes),
            assert_(
                m.sumsqr(angles) < _LARGEST_TURN**2,
                "the shapes turn this frame by more than 0.2 rad, so that they are not small any more",
            ),
        ]
