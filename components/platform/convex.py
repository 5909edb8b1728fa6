"""Convex bodies with flat faces, and the surface of what several of them make together. NumPy.

A polygon is cut by a plane into what lies outside and what lies inside. So the part of a face that lies outside of a
convex body is found exactly, and the faces of all bodies, less what lies in others, are the surface of their union: it
has no gaps, whichever way the bodies cross. Faces that touch (the foot of a column on a wider one) are no surface; of
faces that lie on each other and look the same way, one is kept.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from fowtlib.components.hydro.panel_mesh import spacing

Floats = NDArray[np.float64]

TOUCH = 1e-6  # m: nearer than that, things are at the same place


@dataclass(frozen=True, eq=False)
class Facet:
    """A flat convex piece of the surface of a body: corners (k, 3), counter-clockwise seen from outside.

    where: "side", or "start" and "end" of the body.
    """

    corners: Floats
    where: str

    @property
    def area_vector(self) -> Floats:
        """Outward normal times area."""
        return area_vector(self.corners)


@dataclass(frozen=True, eq=False)
class ConvexBody:
    """A body between planes, normals (m, 3) @ x <= offsets (m,), its facets, and its place in a row of bodies."""

    normals: Floats
    offsets: Floats
    facets: list[Facet]
    number: int

    @cached_property
    def box(self) -> tuple[Floats, Floats]:
        """Lowest and highest coordinates (3,)."""
        corners = np.concatenate([facet.corners for facet in self.facets])
        return corners.min(axis=0), corners.max(axis=0)


def area_vector(corners: Floats) -> Floats:
    """Normal times area (3,) of a flat polygon (k, 3)."""
    x, y, z = (corners[1:] - corners[0]).T  # np.cross takes ten times as long
    return (
        np.array([y[:-1] @ z[1:] - z[:-1] @ y[1:], z[:-1] @ x[1:] - x[:-1] @ z[1:], x[:-1] @ y[1:] - y[:-1] @ x[1:]])
        / 2
    )


def between_rings(low: Floats, high: Floats, outline: Floats, steps: tuple[int, int], number: int) -> ConvexBody:
    """The body between two rings (k, 3), which run counter-clockwise about the direction from low to high.

    outline: the numbers of the points of a ring that are corners of the body. steps: divisions of the facets along the
    body and from the middle of its ends outwards; 0 for the latter: one facet for each end.
    """
    along, outwards = steps
    facets = []
    levels = [low + t * (high - low) for t in spacing(along, True, True)]
    for below, above in zip(levels[:-1], levels[1:], strict=True):
        for k in range(len(low)):
            after = (k + 1) % len(low)
            facets.append(Facet(_distinct(np.array([below[k], below[after], above[after], above[k]])), "side"))
    for ring, where in ((low[::-1], "start"), (high, "end")):
        facets += [Facet(corners, where) for corners in disc(ring, outwards)]
    facets = [facet for facet in facets if len(facet.corners) > 2]
    corners = low[outline], high[outline]
    planes = []
    for k in range(len(outline)):
        after = (k + 1) % len(outline)
        side = _distinct(np.array([corners[0][k], corners[0][after], corners[1][after], corners[1][k]]))
        planes.append((area_vector(side), side[0]))
    direction = high.mean(axis=0) - low.mean(axis=0)
    planes += [(-direction, low[0]), (direction, high[0])]
    normals = np.array([normal / np.linalg.norm(normal) for normal, _ in planes])
    return ConvexBody(normals, np.array([n @ p for n, (_, p) in zip(normals, planes, strict=True)]), facets, number)


def disc(ring: Floats, steps: int) -> list[Floats]:
    """Polygons that fill a flat ring (k, 3): rings of quadrilaterals about its middle, or (steps 0) one polygon."""
    if np.ptp(ring, axis=0).max() < TOUCH:
        return []
    if not steps:
        return [ring]
    middle, polygons = ring.mean(axis=0), []
    scale = spacing(steps, False, True)
    for inner, outer in zip(scale[:-1], scale[1:], strict=True):
        a, b = middle + inner * (ring - middle), middle + outer * (ring - middle)
        for k in range(len(ring)):
            after = (k + 1) % len(ring)
            polygons.append(_distinct(np.array([a[k], b[k], b[after], a[after]])))
    return polygons


def _distinct(corners: Floats) -> Floats:
    """Without corners that repeat the one before."""
    keep = np.linalg.norm(corners - np.roll(corners, 1, axis=0), axis=1) > TOUCH
    return corners[keep]


def split(corners: Floats, heights: Floats) -> tuple[Floats, Floats]:
    """The parts of a convex polygon above and below a plane, from the heights (k,) of its corners over it."""
    above: list[list[float]] = []
    below: list[list[float]] = []
    points, levels = corners.tolist(), heights.tolist()  # for so few numbers arrays take longer
    q, g = points[-1], levels[-1]
    for p, h in zip(points, levels, strict=True):
        if (h > TOUCH and g < -TOUCH) or (h < -TOUCH and g > TOUCH):
            share = g / (g - h)
            crossing = [a + share * (b - a) for a, b in zip(q, p, strict=True)]
            above.append(crossing)
            below.append(crossing)
        if h >= -TOUCH:
            above.append(p)
        if h <= TOUCH:
            below.append(p)
        q, g = p, h
    return np.array(above), np.array(below)


def _flat(corners: Floats) -> bool:
    """Whether no element of the normal times area comes to 1e-9 m^2."""
    if len(corners) < 3:
        return True
    (x0, y0, z0), (x, y, z), *others = corners.tolist()
    x, y, z = x - x0, y - y0, z - z0
    a = b = c = 0.0
    for x1, y1, z1 in others:
        u, v, w = x1 - x0, y1 - y0, z1 - z0
        a, b, c = a + y * w - z * v, b + z * u - x * w, c + x * v - y * u
        x, y, z = u, v, w
    return max(abs(a), abs(b), abs(c)) / 2 < 1e-9


def outside(corners: Floats, body: ConvexBody, keep_equal: bool) -> list[Floats]:
    """The parts of a polygon that do not lie in a body, nor on its surface with the opposite normal.

    keep_equal: whether to keep what lies on its surface with the same normal.
    """
    heights = corners @ body.normals.T - body.offsets
    highest, lowest = heights.max(axis=0), heights.min(axis=0)
    on = (highest < TOUCH) & (lowest > -TOUCH)  # the plane of a face of the body
    if on.any() and keep_equal and (body.normals[on] @ area_vector(corners) > 0).any():
        return [corners]
    if (lowest[~on] > -TOUCH).any():
        return [corners]
    parts, rest = [], corners
    for plane in np.flatnonzero(highest > TOUCH):
        out, rest = split(rest, rest @ body.normals[plane] - body.offsets[plane])
        if not _flat(out):
            parts.append(out)
        if _flat(rest):
            return [corners]  # nothing of it lies inside: it stays in one piece
    return parts


def surface(bodies: list[ConvexBody], below: float | None = None) -> list[tuple[ConvexBody, Facet]]:
    """The surface of the union of the bodies: each facet with the body that it belongs to.

    below: of what lies below this height [m] alone; it stays open there.
    """
    boxes = [body.box for body in bodies]
    found = []
    for body, (low, high) in zip(bodies, boxes, strict=True):
        near = [other for other, (low_2, high_2) in zip(bodies, boxes, strict=True)
                if other is not body and (low <= high_2 + TOUCH).all() and (low_2 <= high + TOUCH).all()]  # fmt: skip
        pieces = [_below(facet.corners, below) for facet in body.facets]
        for other in near:
            owners = [k for k, parts in enumerate(pieces) for _ in parts]
            polygons = [part for parts in pieces for part in parts]
            left: list[list[Floats]] = [[] for _ in pieces]
            for k, part, there in zip(owners, polygons, _reached(polygons, other), strict=True):
                left[k] += outside(part, other, body.number < other.number) if there else [part]
            pieces = left
        found += [(body, Facet(part, facet.where)) for facet, parts in zip(body.facets, pieces, strict=True)
                  for part in parts]  # fmt: skip
    return found


def _below(corners: Floats, level: float | None) -> list[Floats]:
    """What of a polygon lies below a level [m], if there is one: one polygon, or none."""
    if level is None:
        return [corners]
    heights = corners[:, 2] - level
    if heights.min() > -TOUCH:
        return []
    return [split(corners, heights)[1]] if heights.max() > TOUCH else [corners]


def _reached(polygons: list[Floats], body: ConvexBody) -> NDArray[np.bool_]:
    """Which polygons may have a part in a body: those that lie on the far side of none of its planes."""
    if not polygons:
        return np.zeros(0, dtype=bool)
    first = np.cumsum([0, *(len(corners) for corners in polygons[:-1])])
    heights = np.concatenate(polygons) @ body.normals.T - body.offsets
    lowest, highest = np.minimum.reduceat(heights, first, axis=0), np.maximum.reduceat(heights, first, axis=0)
    return ~((lowest > -TOUCH) & (highest >= TOUCH)).any(axis=1)


def as_panels(polygons: list[Floats]) -> Floats:
    """Quadrilaterals (n, 4, 3) that fill convex polygons; triangles repeat a corner."""
    panels = [np.zeros((0, 4, 3))]
    for corners in polygons:
        for k in range(1, len(corners) - 1, 2):
            panels.append(corners[[0, k, k + 1, min(k + 2, len(corners) - 1)]][None])
    return np.concatenate(panels)


def inside(points: Floats, body: ConvexBody) -> tuple[float, float] | None:
    """The range of t in [0, 1] in which the line between two points (2, 3) lies in a body; None where it does not."""
    start, step = points[0], points[1] - points[0]
    rate, room = body.normals @ step, body.offsets - body.normals @ start
    length = float(np.linalg.norm(step))
    along = np.abs(rate) <= 1e-12 * length
    if (room[along] < TOUCH).any():  # beside the body, or on its face
        return None
    low = float(np.max((room / np.where(along, 1, rate))[~along & (rate < 0)], initial=0.0))
    high = float(np.min((room / np.where(along, 1, rate))[~along & (rate > 0)], initial=1.0))
    return (low, high) if high - low > TOUCH / length else None


def gap(a: ConvexBody, b: ConvexBody) -> float:
    """How far two bodies are from touching [m]; negative where they overlap. By linear programming.

    Each of them grown by half of it would touch; between faces that look at each other it is their distance.
    """
    from scipy.optimize import linprog  # slow to import

    normals = np.concatenate([a.normals, b.normals])
    left = np.hstack([normals, -np.ones((len(normals), 1))])
    result = linprog([0, 0, 0, 1], left, np.concatenate([a.offsets, b.offsets]), bounds=(None, None), method="highs")
    return 2 * float(result.x[3])
