"""A foundation as one matrix of stiffness and damping at the mudline."""

from __future__ import annotations

import numpy as np

from fowtlib.components.mechanics import FreeMotion, TwoFrames
from fowtlib.language import Matrix, Scalar, Vector, assert_, der, eq, param, part, shapes, var
from fowtlib.language import math as m
from fowtlib.language.errors import ParameterError
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

    stiffness: Matrix = param(shape=(6, 6), doc="stiffness, SI units, symmetric: three forces, then three moments")
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

    stiffness: Matrix = param(shape=(6, 6), doc="stiffness, SI units: three forces, then three moments, at frame_b")
    damping_time: Scalar = param(default=0.0, unit="s", min=0, doc="damping over stiffness")

    motion: FreeMotion = part(FreeMotion)
    spring: CoupledSpring = part(CoupledSpring, stiffness=stiffness, damping_time=damping_time)

    def build(self):
        check_stiffness(self)
        for one in (self.motion, self.spring):
            self.connect(self.frame_a, one.frame_a)
            self.connect(one.frame_b, self.frame_b)

    def drawing(self) -> shapes.Drawing:
        return [shapes.link(self.frame_a, self.frame_b)]


def check_stiffness(foundation: Foundation) -> None:
    """Raise ParameterError where a matrix of stiffness is not symmetric, or not positive definite."""
    k = np.asarray(foundation.parameter_value("stiffness"), dtype=float)
    scale = np.sqrt(np.outer(np.abs(np.diag(k)), np.abs(np.diag(k)))) + 1e-300
    worst = np.unravel_index(np.argmax(np.abs(k - k.T) / scale), (6, 6))
    if abs(k - k.T)[worst] > 1e-6 * scale[worst]:
        i, j = worst
        raise ParameterError(
            f"{foundation.label}.stiffness: entry ({i + 1}, {j + 1}) is {k[i, j]:g} and ({j + 1}, {i + 1}) is "
            f"{k[j, i]:g}; a stiffness is symmetric."
        )
    lowest = float(np.linalg.eigvalsh(k / scale)[0]) if np.all(np.diag(k) > 0) else -1.0
    if lowest <= 0:
        raise ParameterError(
            f"{foundation.label}.stiffness: it must be positive definite, as a foundation that holds in all six "
            "directions is; check the signs of the entries that couple forces and moments."
        )
