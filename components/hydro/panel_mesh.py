"""Panel meshes of the wetted hull of a floater made of vertical columns and straight horizontal pontoons.

Pure geometry (numpy). A mesh is an array (n, 4, 3) of quadrilaterals, corners in order, normal out of the hull into the
water; triangles repeat a corner. Where a pontoon meets a column both meshes share their corners, so that the hull is
closed below the water. Polygons are enlarged until they have the area of the circle that they stand for: a plain
inscribed polygon of 24 sides would lose 1.1 % of the volume.
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass

import numpy as np

from fowtlib.components.hydro.hull_mesh import HullMesh, hydrostatics
from fowtlib.language.errors import ParameterError

__all__ = [
    "Column", "HullMesh", "Pontoon", "floater_mesh", "hydrostatics", "lid_panels", "members_mesh", "members_volume",
    "profile", "round_factor", "sides", "spacing",
]  # fmt: skip

_BOX = 1.3  # a round pontoon is tied to its column within a square patch of this width over its diameter
_TOUCH = 1e-6  # m
_TALL = 1.6  # height over width of the panels of a column: the number of sides matters more for the added mass
_SKIN = 1.5  # depth below the water line, over the panel size, with finer panels


@dataclass(frozen=True)
class Column:
    """Vertical column with circular sections ((z, diameter), ...) from bottom to top, linear between them.

    z is measured upwards from the still water level [m]; two sections with the same z make a step. x, y: position of
    the axis [m].
    """

    sections: tuple[tuple[float, float], ...]
    x: float = 0.0
    y: float = 0.0

    def __post_init__(self):
        z, d = np.array(self.sections, dtype=float).T
        if len(z) < 2 or (np.diff(z) < 0).any() or z[0] >= 0 or z[-1] <= z[0] or (d <= 0).any():
            raise ParameterError("column: sections must be ((z, diameter), ...) from the bottom, which lies below the "
                                 f"water, to the top, with positive diameters; found {self.sections}")

    def wetted(self) -> list[tuple[float, float]]:
        """Sections (z, diameter) up to the water level."""
        z, d = np.array(self.sections, dtype=float).T
        if z[-1] <= 0:
            return [(float(a), float(b)) for a, b in zip(z, d, strict=True)]
        wet = [(float(a), float(b)) for a, b in zip(z, d, strict=True) if a < 0]
        above = int(np.argmax(z >= 0))
        part = -z[above - 1] / (z[above] - z[above - 1])
        return [*wet, (0.0, float(d[above - 1] + part * (d[above] - d[above - 1])))]

    @property
    def waterline_diameter(self) -> float:
        """Diameter at the still water level [m]; zero for a column that ends below it."""
        z, diameter = self.wetted()[-1]
        return diameter if z == 0 else 0.0

    def diameter_between(self, low: float, high: float) -> float | None:
        """The diameter if it is constant from z = low to z = high within the column, else None."""
        z, d = np.array(self.sections, dtype=float).T
        if low < z[0] - _TOUCH or high > min(z[-1], 0.0) + _TOUCH:
            return None
        middle = np.interp((low + high) / 2, z, d)
        inside = (z > low + _TOUCH) & (z < high - _TOUCH)
        ends = [np.interp(low + _TOUCH, z, d), np.interp(high - _TOUCH, z, d), *d[inside]]
        return float(middle) if np.allclose(ends, middle, rtol=1e-6) else None


@dataclass(frozen=True)
class Pontoon:
    """Horizontal pontoon between two points (x, y, z) of its axis [m]; rectangular (width, height) or round (diameter).

    An end that lies on the axis of a column is joined to the column's wall, another end is closed by a flat cap. The
    pontoon must be narrower than the column and, if round, must leave 15 % of its diameter free on each side.
    """

    start: tuple[float, float, float]
    end: tuple[float, float, float]
    width: float = 0.0
    height: float = 0.0
    diameter: float = 0.0

    def __post_init__(self):
        rectangular = self.width > 0 and self.height > 0 and self.diameter == 0
        if not rectangular and not (self.diameter > 0 and self.width == 0 and self.height == 0):
            raise ParameterError("pontoon: give either width and height, or diameter, positive [m]")
        if abs(self.start[2] - self.end[2]) > _TOUCH or math.dist(self.start[:2], self.end[:2]) < _TOUCH:
            raise ParameterError(f"pontoon from {self.start} to {self.end}: it must be horizontal and longer than zero")
        if self.patch[1] >= 0:
            raise ParameterError(f"pontoon from {self.start} to {self.end}: it must lie below the water")

    @property
    def half_width(self) -> float:
        """Half of the width of its patch on the wall of a column [m]."""
        return _BOX * self.diameter / 2 if self.diameter else self.width / 2

    @property
    def patch(self) -> tuple[float, float]:
        """Lowest and highest z of its patch on the wall of a column [m]."""
        half = _BOX * self.diameter / 2 if self.diameter else self.height / 2
        return self.start[2] - half, self.start[2] + half

    @property
    def direction(self) -> np.ndarray:
        """Unit vector from start to end."""
        axis = np.subtract(self.end, self.start)
        return axis / np.linalg.norm(axis)


def profile(column: Column, size: float) -> np.ndarray:
    """Points (n, 2) of radius and z of the wetted outline, from the axis at the bottom to the water line (or the axis).

    Panels are finer at edges and at the water line.
    """
    sections = column.wetted()
    corners = [(0.0, sections[0][0]), *((d / 2, z) for z, d in sections)]
    if sections[-1][0] < 0:
        corners.append((0.0, sections[-1][0]))
    depth = _SKIN * size
    if sections[-1][0] == 0 and -corners[-2][1] > 2 * depth:  # short waves do not reach below a thin skin
        (r, z), top = corners[-2], corners[-1]
        corners.insert(-1, (top[0] + (r - top[0]) * depth / -z, -depth))
    points = [corners[0]]
    for k, (a, b) in enumerate(zip(corners[:-1], corners[1:], strict=True)):
        length = math.dist(a, b)
        if length < _TOUCH:
            continue
        first = k > 0 and _turn(corners[k - 1], a, b)
        last = k + 2 == len(corners) or _turn(a, b, corners[k + 2])
        wanted = length / size / (_TALL if a[1] < b[1] else 1.0)
        number = 5 if b[1] == 0 and length < 2.001 * depth else max(1, math.ceil(wanted))
        for t in spacing(number, bool(first), bool(last))[1:]:
            points.append((a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1])))
    return np.array(points)


def round_factor(sides: int | np.ndarray) -> float:
    """Enlargement of the radius of a polygon (number of sides, or its angles) that has the area of the circle."""
    steps = np.full(sides, 2 * np.pi / sides) if np.isscalar(sides) else np.diff(sides, append=sides[0] + 2 * np.pi)
    return math.sqrt(2 * np.pi / np.sin(steps).sum())


def sides(diameter: float, size: float) -> int:
    """Number of sides of the polygon that stands for a circle, a multiple of four."""
    return 4 * max(4, math.ceil(np.pi * diameter / size / 4))


def floater_mesh(columns: list[Column], pontoons: list[Pontoon], size: float) -> np.ndarray:
    """Panels (n, 4, 3) of the wetted hull, about `size` [m] wide.

    Raises ParameterError if members meet in a way that this mesher does not know.
    """
    levels = _levels(pontoons, size)
    panels = [_pontoon_panels(p, columns, pontoons, levels, size) for p in pontoons]
    panels += [_column_panels(c, pontoons, levels, size) for c in columns]
    return np.concatenate(panels)


def lid_panels(columns: list[Column], pontoons: list[Pontoon], size: float) -> np.ndarray:
    """Panels (n, 4, 3) of the water level inside of the columns that reach it, normal downwards."""
    lids = [np.zeros((0, 4, 3))]
    for column in columns:
        z, diameter = column.wetted()[-1]
        if z == 0:
            angle, _ = _angles(column, [p for p in pontoons if _ends(p, column)], size)
            rim = diameter / 2 * round_factor(angle) * np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1)
            scale = np.linspace(0, 1, max(2, math.ceil(diameter / 2 / size)) + 1)
            lids.append(_loft(np.array([column.x, column.y, 0.0]) + scale[:, None, None] * rim).reshape(-1, 4, 3))
    return np.concatenate(lids)


def members_mesh(columns: list[Column], pontoons: list[Pontoon], size: float, name: str = "hull") -> HullMesh:
    """Hull and lid of the members, with panels about `size` [m] wide.

    Raises ParameterError if members meet in a way that this mesher does not know, and where volume or waterplane are
    not those of the formulas (0.5 %).
    """
    mesh = HullMesh(floater_mesh(columns, pontoons, size), lid_panels(columns, pontoons, size), name)
    mesh.expect(members_volume(columns, pontoons), sum(math.pi / 4 * c.waterline_diameter**2 for c in columns))
    return mesh


def members_volume(columns: list[Column], pontoons: list[Pontoon]) -> float:
    """Displaced volume [m^3] by formulas: truncated cones, and what of the pontoons lies outside of the columns."""
    total = 0.0
    for column in columns:
        for (z, d), (above, e) in itertools.pairwise(column.wetted()):
            total += math.pi / 12 * (above - z) * (d * d + d * e + e * e)
    nodes, weights = np.polynomial.legendre.leggauss(40)
    for pontoon in pontoons:
        radii = [c.diameter_between(*pontoon.patch) / 2 for c in columns for _ in _ends(pontoon, c)]
        half = pontoon.diameter / 2 or pontoon.width / 2
        angle = nodes * np.pi / 2  # across = half sin(angle): smooth where a round section begins
        height = pontoon.diameter * np.cos(angle) if pontoon.diameter else pontoon.height
        length = math.dist(pontoon.start, pontoon.end) - sum(
            np.sqrt(r**2 - (half * np.sin(angle)) ** 2) for r in radii)
        total += float(np.sum(weights * np.pi / 2 * half * np.cos(angle) * height * length))
    return total


def _column_panels(column: Column, pontoons: list[Pontoon], levels: np.ndarray, size: float) -> np.ndarray:
    joined = [p for p in pontoons if _ends(p, column)]
    angle, patches = _angles(column, joined, size)
    factor = round_factor(angle)
    points = profile(column, size)
    if joined:
        points = _with_levels(points, column, joined, levels)
    ring = np.stack([np.cos(angle), np.sin(angle), np.zeros_like(angle)], axis=1)
    rings = np.array([column.x, column.y, 0.0]) + points[:, None, :1] * factor * ring + points[:, None, 1:] * [0, 0, 1]
    panels = _loft(rings)
    free = np.ones(panels.shape[:2], dtype=bool)
    z = (points[:-1, 1] + points[1:, 1]) / 2
    wall = np.abs(points[1:, 1] - points[:-1, 1]) > _TOUCH
    for covered, pontoon in patches:
        low, high = pontoon.patch
        free[np.ix_(wall & (z > low) & (z < high), covered)] = False
    return panels[free]


def _angles(column: Column, joined: list[Pontoon], size: float):
    """Angles of the corners of a column, and (mask of the sides that it covers, pontoon) for each pontoon."""
    largest = max(d for _, d in column.wetted())
    number = sides(largest, size)
    if not joined:
        return np.arange(number) * 2 * np.pi / number, []
    patches: dict[tuple[int, int], list[Pontoon]] = {}
    for pontoon in joined:
        for sign in _ends(pontoon, column):
            heading = math.atan2(*(sign * pontoon.direction)[[1, 0]]) % (2 * np.pi)
            patches.setdefault((round(heading * 1e7), round(pontoon.half_width * 1e7)), []).append(pontoon)
    for group in patches.values():
        for pontoon in group:
            diameter = column.diameter_between(*pontoon.patch)
            if diameter is None or 2 * pontoon.half_width >= 0.98 * diameter:
                raise ParameterError(
                    f"pontoon from {pontoon.start} to {pontoon.end}: the column at ({column.x:g}, {column.y:g}) must "
                    f"be wider than {2 * pontoon.half_width:g} m, with a constant diameter, from z = "
                    f"{pontoon.patch[0]:g} m to {pontoon.patch[1]:g} m")
    factor = 1.0
    for _ in range(8):  # the enlargement depends on the angles and the angles on the enlarged radius
        nodes, masks, end = [], {}, None
        spans = []
        for key in sorted(patches):
            pontoon = patches[key][0]
            radius = factor * column.diameter_between(*pontoon.patch) / 2
            across = np.linspace(-1, 1, _across(pontoon, size) + 1) * pontoon.half_width
            spans.append((key, key[0] / 1e7 + np.arcsin(across / radius)))
        for k, (key, span) in enumerate(spans):
            behind = spans[(k + 1) % len(spans)][1][0] + (2 * np.pi if k + 1 == len(spans) else 0.0)
            gap = behind - span[-1]
            if gap < 1e-3 or (end is not None and span[0] < end):
                raise ParameterError(f"column at ({column.x:g}, {column.y:g}): its pontoons overlap on its wall")
            pieces = 2 * math.ceil(gap * number / (4 * np.pi))  # even: no panel lies across a plane of symmetry
            filling = np.linspace(span[-1], behind, pieces + 1)
            masks[key] = (len(nodes), len(nodes) + len(span) - 1)
            nodes += [*span[:-1], *filling[:-1]]
            end = span[-1]
        angle = np.array(nodes)
        factor = round_factor(angle)
    covered = []
    for key, group in patches.items():
        mask = np.zeros(angle.size, dtype=bool)
        mask[slice(*masks[key])] = True
        covered += [(mask, pontoon) for pontoon in group]
    return angle, covered


def _pontoon_panels(pontoon: Pontoon, columns, pontoons, levels: np.ndarray, size: float) -> np.ndarray:
    box = _box(pontoon, levels, size)
    section = box
    if pontoon.diameter:
        direction = np.arctan2(box[:, 1], box[:, 0])
        factor = round_factor(np.unwrap(direction))
        section = pontoon.diameter / 2 * factor * np.stack([np.cos(direction), np.sin(direction)], axis=1)
    axis = pontoon.direction
    left = np.array([-axis[1], axis[0], 0.0])  # section (t, z): ccw about the axis is left, then up
    panels, ends, caps = [], [], []
    for point, sign in ((pontoon.start, 1.0), (pontoon.end, -1.0)):
        column = next((c for c in columns if sign in _ends(pontoon, c)), None)
        radius = 0.0
        if column:
            angle, _ = _angles(column, [p for p in pontoons if _ends(p, column)], size)
            radius = round_factor(angle) * column.diameter_between(*pontoon.patch) / 2

        def place(at, point=point, sign=sign, radius=radius):
            along = sign * np.sqrt(radius**2 - at[:, 0] ** 2) if radius else np.zeros(len(at))
            return np.array(point) + along[:, None] * axis + at[:, :1] * left + at[:, 1:] * [0.0, 0.0, 1.0]

        ends.append(place(section))
        scale = [] if column else spacing(max(1, math.ceil(np.abs(section).max() / size)), False, True)[:-1]
        caps.append([np.array(point) + t * (place(section) - point) for t in scale])
        if column and pontoon.diameter:
            rings = np.array([place(box + t * (section - box)) for t in (0.0, 0.5, 1.0)])
            panels.append(_loft(rings if sign > 0 else rings[::-1]).reshape(-1, 4, 3))
    length = np.linalg.norm(ends[1] - ends[0], axis=1).mean()
    steps = spacing(2 * max(1, math.ceil(length / size / 2)), bool(caps[0]), bool(caps[1]))
    rings = [*caps[0], *(ends[0] + t * (ends[1] - ends[0]) for t in steps), *caps[1][::-1]]
    return np.concatenate([*panels, _loft(np.array(rings)).reshape(-1, 4, 3)])


def _box(pontoon: Pontoon, levels: np.ndarray, size: float) -> np.ndarray:
    """Corners (n, 2) of the rim of its patch on a wall, (across, z from the axis), counter-clockwise."""
    across = np.linspace(-1, 1, _across(pontoon, size) + 1) * pontoon.half_width
    low, high = pontoon.patch
    z = levels[(levels > low - _TOUCH) & (levels < high + _TOUCH)] - pontoon.start[2]
    rim = [*((t, z[0]) for t in across[:-1]), *((across[-1], v) for v in z[:-1]),
           *((t, z[-1]) for t in across[:0:-1]), *((across[0], v) for v in z[:0:-1])]
    return np.array(rim)


def _levels(pontoons: list[Pontoon], size: float) -> np.ndarray:
    """Heights at which every column that meets a pontoon has corners."""
    every = [np.linspace(*p.patch, max(2, math.ceil((p.patch[1] - p.patch[0]) / size)) + 1) for p in pontoons]
    values = np.sort(np.concatenate([*every, np.zeros(0)]))
    return values[np.concatenate([[True], np.diff(values) > 1e-3 * size])] if values.size else values


def _with_levels(points: np.ndarray, column: Column, joined: list[Pontoon], levels: np.ndarray) -> np.ndarray:
    """The outline of a column with corners at the levels of its pontoons and no others within their patches."""
    for pontoon in joined:
        low, high = pontoon.patch
        corner = [(column.diameter_between(low, high) / 2, v) for v in levels if low - _TOUCH < v < high + _TOUCH]
        on_wall = np.abs(points[:, 0] - corner[0][0]) < _TOUCH
        inside = on_wall & (points[:, 1] > low - _TOUCH) & (points[:, 1] < high + _TOUCH)
        points = points[~inside]
        disk = np.abs(points[:, 1] - points[0, 1]) < _TOUCH  # the bottom, from the axis outwards, comes first
        after = np.flatnonzero(~disk & (points[:, 1] > low))
        at = int(after[0]) if after.size else len(points)
        points = np.concatenate([points[:at], corner, points[at:]])
    return points


def _ends(pontoon: Pontoon, column: Column) -> list[float]:
    """+1 if the pontoon starts, -1 if it ends on the axis of the column (the sign of its outward direction)."""
    return [sign for point, sign in ((pontoon.start, 1.0), (pontoon.end, -1.0))
            if math.dist(point[:2], (column.x, column.y)) < 1e-3]


def _across(pontoon: Pontoon, size: float) -> int:
    return 2 * max(1, math.ceil(pontoon.half_width / size))


def _loft(rings: np.ndarray) -> np.ndarray:
    """Panels (m - 1, n, 4, 3) between closed rings (m, n, 3).

    Normals point outwards if the rings run counter-clockwise about the direction of the loft.
    """
    ahead = np.roll(rings, -1, axis=1)
    return np.stack([rings[:-1], ahead[:-1], ahead[1:], rings[1:]], axis=2)


def spacing(number: int, fine_first: bool, fine_last: bool) -> np.ndarray:
    """Values, one more than number, from 0 to 1, closer at the ends that are asked for."""
    t = np.linspace(0, 1, number + 1)
    if fine_first and fine_last:
        bent = (1 - np.cos(np.pi * t)) / 2
    elif fine_first or fine_last:
        bent = np.sin(np.pi / 2 * t) if fine_last else 1 - np.cos(np.pi / 2 * t)
    else:
        return t
    return 0.4 * t + 0.6 * bent


def _turn(a, b, c) -> bool:
    """Whether the outline has an edge of more than 40 deg at b."""
    u, v = np.subtract(b, a), np.subtract(c, b)
    length = np.linalg.norm(u) * np.linalg.norm(v)
    return bool(length > 0 and u @ v < math.cos(math.radians(40)) * length)
