"""A foundation as one matrix of stiffness and damping at the mudline."""

from __future__ import annotations

from fowtlib.components.mechanics import FreeMotion, TwoFrames
from fowtlib.language import Matrix, Scalar, Vector, assert_, der, eq, param, part, shapes, var
from fowtlib.language import math as m
from fowtlib.language.similarity import six_by_six

_LARGEST_ANGLE = 0.1  # rad; the rotation vector of CoupledSpring is exact to (angle^2) / 6 there, 0.2 %


class CoupledSpring(TwoFrames):
    """Linear spring and damper between two frames in all six directions, coupled by a matrix.

    load = stiffness (d, theta) + damping d(d, theta)/dt, the force and moment that bring frame_b back to frame_a, at
    the origin of frame_b and in the axes of frame_a: d = r_b - r_a, theta the rotation vector, taken as that of a small
    turn. Entries in N/m, N/rad, N*m/m and N*m/rad; a force along x with the moment about y that holds the head of a
    pile upright has stiffness[0][4] < 0. Errors: a matrix that is not symmetric, or would release energy; an angle
    beyond 0.1 rad.
    """

    units_within = {"stiffness": six_by_six("N/m")}

    stiffness: Matrix = param(
        shape=(6, 6), form="stiffness", doc="stiffness, SI units, symmetric: three forces, then three moments"
    )
    damping_time: Scalar = param(default=0.0, unit="s", min=0, doc="damping over stiffness")

    displacement: Vector = var(unit="m", doc="of frame_b against frame_a, in the axes of frame_a")
    angle: Vector = var(unit="rad", doc="rotation vector of frame_b against frame_a, in the axes of frame_a")

    def equations(self):
        a, b = self.frame_a, self.frame_b
        turn, spin = a.R.T @ b.R, a.R.T @ (b.w - a.w)
        moved, rate = m.vertcat(self.displacement, self.angle), m.vertcat(der(self.displacement), spin)
        load = self.stiffness @ (moved + self.damping_time * rate)
        twice = m.vertcat(turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1])
        return [
            eq(self.displacement, a.R.T @ (b.r - a.r)),
            eq(self.angle, twice / 2),
            [eq(b.f, a.R @ load[:3]), eq(b.t, a.R @ load[3:])],
            self.transmit(b.r - a.r),
            assert_(
                m.sumsqr(self.angle) < _LARGEST_ANGLE**2,
                "the foundation turns by more than 0.1 rad, beyond the small angles of its matrix; check its loads",
            ),
        ]


class Foundation(TwoFrames):
    """A foundation as one matrix of stiffness at the mudline, and the mass that moves with it: frame_b stands on it.

    Its six motions are states, so that something with a mass has to stand on it. See CoupledSpring for the matrix.
    """

    units_within = {"stiffness": six_by_six("N/m")}

    stiffness: Matrix = param(
        shape=(6, 6), form="stiffness", doc="stiffness, SI units: three forces, then three moments, at frame_b"
    )
    damping_time: Scalar = param(default=0.0, unit="s", min=0, doc="damping over stiffness")

    motion: FreeMotion = part(FreeMotion)
    spring: CoupledSpring = part(CoupledSpring, stiffness=stiffness, damping_time=damping_time)

    def build(self):
        for one in (self.motion, self.spring):
            self.connect(self.frame_a, one.frame_a)
            self.connect(one.frame_b, self.frame_b)

    def drawing(self) -> shapes.Drawing:
        return [shapes.link(self.frame_a, self.frame_b)]
