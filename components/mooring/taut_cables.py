"""Three taut cables that hold a point below a platform."""

from __future__ import annotations

import numpy as np

from fowtlib.components.mechanics.connectors import Frame
from fowtlib.components.mechanics.interfaces import TwoFrames
from fowtlib.language import Array, Number, Vector, assert_, eq, param, port, rotation, shapes, var
from fowtlib.language import math as m
from fowtlib.language.errors import ParameterError

FLAT = 1e-3  # volume of the three unit vectors along the cables, below which they lie in a plane


class TautCables(TwoFrames):
    """Three taut cables without stretch or mass, from points of a platform to one point, frame_b, that hangs on them.

    The three lengths, from `ends_at` to `place`, say where frame_b is once the ends are somewhere else, as those of a
    platform that bends; on a rigid one it lies at `place`. It has the axes of frame_a, which takes the moments: cables
    that meet in a point take none. Tensions balance the force at frame_b. A cable that would have to push is told.
    Raises ParameterError for a point that lies in the plane of the ends, or nearly so, where cables hold nothing.
    """

    place: Vector = param(unit="m", doc="frame_b at rest, resolved in frame_a")
    ends_at: Array = param(shape=(3, 3), unit="m", doc="the ends at rest, row by row, resolved in frame_a")

    diameter: Number = param(default=0.5, unit="m", min=0, doc="diameter in pictures")

    ends: Frame = port(size=3, doc="where the cables are fixed to the platform")

    tension: Vector = var(unit="N", doc="tension of each cable")

    def start_translation(self):
        return self.parameter_value("place")

    def equations(self):
        a, b, ends = self.frame_a, self.frame_b, self.ends
        _check_depth(self)
        rest = [self.ends_at[k, :].T - self.place for k in range(3)]
        r = _point_at(*(end.r for end in ends), *(m.sumsqr(row) for row in rest), m.dot(m.cross(*rest[:2]), rest[2]))
        ways = [end.r - b.r for end in ends]
        ways = [way / m.norm(way) for way in ways]
        volume = m.dot(m.cross(ways[0], ways[1]), ways[2])
        sides = [m.cross(ways[1], ways[2]), m.cross(ways[2], ways[0]), m.cross(ways[0], ways[1])]
        return [
            eq(b.r, r),
            rotation(a, b, m.eye(3), m.zeros(3)),
            eq(self.tension, m.vertcat(*(-m.dot(side, b.f) / volume for side in sides))),
            [eq(end.f, self.tension[k] * way) for k, (end, way) in enumerate(zip(ends, ways, strict=True))],
            [eq(end.t, m.zeros(3)) for end in ends],
            [eq(a.f, m.zeros(3)), eq(a.t, -b.t)],
            [assert_(self.tension[k] > 0, f"cable {k + 1} is not taut but pushes", "warning") for k in range(3)],
        ]

    def drawing(self) -> shapes.Drawing:
        return [shapes.link(end, self.frame_b, self.parameter_value("diameter"), "line") for end in self.ends]


def _check_depth(part: TautCables) -> None:
    ways = np.asarray(part.parameter_value("ends_at"), dtype=float) - np.asarray(part.parameter_value("place"))
    size = np.linalg.norm(ways, axis=1)
    if not size.all() or abs(np.linalg.det(ways / size[:, None])) < FLAT:
        raise ParameterError(
            f"{part.label}: the point at {tuple(map(float, part.parameter_value('place')))} m lies in the plane of the "
            "three ends, or two cables are one; lower the point, or move the ends apart."
        )


def _point_at(p, q, s, from_p, from_q, from_s, side):
    """The point at the given squares of distances from p, q and s, on the side of their plane that `side` has.

    Axes in the plane: along q - p, and across towards s.
    """
    base, third = q - p, s - p
    d = m.norm(base)
    along = base / d
    i = m.dot(along, third)
    across = third - i * along
    j = m.norm(across)
    across = across / j
    x = (from_p - from_q + d**2) / (2 * d)
    y = (from_p - from_s + i**2 + j**2 - 2 * i * x) / (2 * j)
    z = m.sqrt(from_p - x**2 - y**2)
    return p + x * along + y * across - m.sign(side) * z * m.cross(along, across)
