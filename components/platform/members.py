"""A member of a floater as numbers: a straight tube or box between two points, what it is made of and filled with.

Coordinates are those of the frame of the floater: x, y, z from the reference point on the still water level, z up.
Along a member s is the distance from its start. The first direction of a box, that of its width, is horizontal and the
second one, that of its height, upright as far as it can be; of a vertical one they are x and y, or -y where it runs
downwards. Swapping the ends turns both of them by 180 deg or not at all, which changes no box.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fowtlib.components.hydro.panel_mesh import round_factor
from fowtlib.components.platform.convex import TOUCH, ConvexBody, between_rings, inside, split
from fowtlib.components.platform.solids import NOTHING, MassProperties, piece, point, together
from fowtlib.language.errors import ParameterError

Floats = NDArray[np.float64]
Point = tuple[float, float, float]

FINE = 32  # sides of the polygon that stands for a circle, of the same area; its second moments are 8e-6 too large


@dataclass(frozen=True)
class Fill:
    """Ballast in a member, between s = low and s = high [m], up to the height `level` (z) of its upright surface."""

    name: str
    density: float
    level: float
    low: float
    high: float


@dataclass(frozen=True)
class Plate:
    """A bulkhead: a plate that fills the inside of a member at s = place."""

    name: str
    place: float
    thickness: float
    density: float


@dataclass(frozen=True)
class Lump:
    """A mass without extension at a point."""

    name: str
    mass: float
    place: Point


@dataclass(frozen=True)
class MemberShape:
    """One member: sizes and walls at its stations, linear between them; two stations at one place make a step.

    stations [m]: distances from the start, from 0 to the length. sizes: two diameters, or width and height, at each.
    walls [m] at each; density of the wall. turn [rad]: of the section of a box about the direction from start to end.
    """

    name: str
    start: Point
    end: Point
    stations: tuple[float, ...]
    sizes: tuple[tuple[float, float], ...]
    is_round: bool = True
    walls: tuple[float, ...] = ()
    density: float = 0.0
    turn: float = 0.0
    fills: tuple[Fill, ...] = ()
    plates: tuple[Plate, ...] = ()
    lumps: tuple[Lump, ...] = ()

    def __post_init__(self):
        if self.length < TOUCH:
            raise ParameterError(
                f"{self.name}: its start and its end are the same point, {self.start}; let it end at another joint."
            )
        stations = np.array(self.stations)
        if len(stations) < 2 or (np.diff(stations) < 0).any() or abs(stations[0]) > TOUCH or (
            abs(stations[-1] - self.length) > TOUCH
        ):  # fmt: skip
            raise ParameterError(
                f"{self.name}: its stations must go from 0 to its length, {self.length:g} m, and up; "
                f"they are {', '.join(f'{s:g}' for s in stations)} m."
            )
        if (least := min(map(min, self.sizes))) <= 0:
            raise ParameterError(
                f"{self.name}: a diameter, width or height of {least:g} m is not above zero; give it more."
            )
        for wall, sizes in zip(self.walls, self.sizes, strict=False):
            if wall > min(sizes) / 2 + 1e-12:
                raise ParameterError(
                    f"{self.name}: its wall of {wall:g} m is thicker than half of its {min(sizes):g} m. A number "
                    "without a unit is in m; write, for example, 40 mm."
                )
        for plate in self.plates:
            if not -TOUCH <= plate.place <= self.length + TOUCH:
                raise ParameterError(
                    f"{plate.name} at {plate.place:g} m is off its member, which is {self.length:g} m "
                    "long; the place is the distance from the start of the member."
                )

    @property
    def length(self) -> float:
        """Length [m]."""
        return math.dist(self.start, self.end)

    @property
    def axes(self) -> Floats:
        """The columns are the two directions of the section, and the direction from start to end."""
        along = np.subtract(self.end, self.start) / self.length
        level = math.hypot(along[0], along[1])
        one = np.array([-along[1], along[0], 0.0]) / level if level > 1e-9 else np.array([1.0, 0.0, 0.0])
        two = np.cross(along, one)
        cos, sin = math.cos(self.turn), math.sin(self.turn)
        return np.stack([cos * one + sin * two, cos * two - sin * one, along], axis=1)

    def at(self, s: float) -> Floats:
        """The point (3,) of the axis at a distance from the start."""
        return np.asarray(self.start) + s / self.length * np.subtract(self.end, self.start)

    def size_at(self, s: float, after: bool = True) -> Floats:
        """Sizes (2,) at a distance from the start; at a step, those behind it or before it."""
        return _interpolated(self.stations, np.array(self.sizes), s, after)

    def wall_at(self, s: float, after: bool = True) -> float:
        """Thickness of the wall at a distance from the start."""
        return float(_interpolated(self.stations, np.array(self.walls)[:, None], s, after)[0]) if self.walls else 0.0

    def pieces(self, low: float = 0.0, high: float = math.inf) -> list[tuple[float, float]]:
        """The ranges of s between stations, within s = low to high."""
        cuts = [(max(a, low), min(b, high)) for a, b in zip(self.stations[:-1], self.stations[1:], strict=True)]
        return [(a, b) for a, b in cuts if b - a > TOUCH]

    def solid(self, low: float, high: float, inner: bool = False) -> MassProperties:
        """Volume (as mass), centre and inertia of density 1 of what is within s = low to high, or within its walls."""
        parts = []
        for a, b in self.pieces(low, high):
            sizes = [self.size_at(a), self.size_at(b, after=False)]
            if inner:
                sizes = [sizes[0] - 2 * self.wall_at(a), sizes[1] - 2 * self.wall_at(b, after=False)]
            parts.append(piece(self.at(a), self.at(b), self.axes, (sizes[0], sizes[1]), self.is_round))
        return together(parts)

    def bodies(self, number: int, size: float | None = None) -> list[ConvexBody]:
        """The outside as convex bodies, one between two stations each; facets about `size` [m] wide, or large ones."""
        return [self.body(a, b, number, size) for a, b in self.pieces()]

    def body(
        self, a: float, b: float, number: int = 0, size: float | None = None, inner: bool = False, divided: bool = True
    ) -> ConvexBody:
        """What is between s = a and b, without a station between them, as a convex body."""
        sizes = self.size_at(a), self.size_at(b, after=False)
        if inner:
            sizes = sizes[0] - 2 * self.wall_at(a), sizes[1] - 2 * self.wall_at(b, after=False)
        widest = np.maximum(*sizes)
        ring, outline = _round_ring(float(widest[0]), size) if self.is_round else _box_ring(widest, size)
        across = self.axes[:, :2]
        rings = [self.at(s) + (ring * extent) @ across.T for s, extent in zip((a, b), sizes, strict=True)]
        steps = (
            (1, 0)
            if size is None or not divided
            else (math.ceil((b - a) / size), max(1, math.ceil(widest.max() / 2 / size)))
        )
        return between_rings(rings[0], rings[1], outline, steps, number)

    def covers(self, line: Floats) -> list[tuple[float, float]]:
        """The parts of a line between two points (2, 3) that lie in this member: from, to [m] from the first point."""
        length = float(np.linalg.norm(line[1] - line[0]))
        found = [
            self._round_cover(line, a, b) if self.is_round else inside(line, self.body(a, b)) for a, b in self.pieces()
        ]
        return [(part[0] * length, part[1] * length) for part in found if part is not None]

    def _round_cover(self, line: Floats, a: float, b: float) -> tuple[float, float] | None:
        """The range of t in [0, 1] in which a line is in the cone from s = a to b, which is exact as no polygon is."""
        (x, y, s), step = (line[0] - self.start) @ self.axes, (line[1] - line[0]) @ self.axes
        radius = self.size_at(a)[0] / 2
        slope = (self.size_at(b, after=False)[0] / 2 - radius) / (b - a)
        edge, growth = radius + slope * (s - a), slope * step[2]
        square = step[0] ** 2 + step[1] ** 2 - growth**2
        linear, constant = x * step[0] + y * step[1] - edge * growth, x**2 + y**2 - edge**2
        length = float(np.linalg.norm(step))
        if square <= 1e-12 * length**2:  # along the axis, or steeper than the wall
            return inside(line, self.body(a, b))
        root = linear**2 - square * constant
        if root <= 0:
            return None
        low, high = sorted(((-linear - math.sqrt(root)) / square, (-linear + math.sqrt(root)) / square))
        ends = sorted(((a - s) / step[2], (b - s) / step[2])) if abs(step[2]) > 1e-12 * length else None
        if ends is None and not a + TOUCH < s < b - TOUCH:
            return None
        low, high = max(low, 0.0, *(ends or [0.0])[:1]), min(high, 1.0, *(ends or [1.0])[-1:])
        return (low, high) if high - low > TOUCH / length else None

    def structure(self, spans: list[tuple[float, float, float]]) -> list[MassProperties]:
        """Wall, bulkheads and lumps, of the parts (from, to, share) of the axis that count; lumps count always."""
        parts = []
        for low, high, share in spans:
            if self.density and any(self.walls):
                parts.append(self.solid(low, high).times(share * self.density))
                parts.append(self.solid(low, high, inner=True).times(-share * self.density))
            for plate in self.plates:
                if low - TOUCH <= plate.place < high or (plate.place >= high > self.length - TOUCH):
                    parts.append(self._plate(plate).times(share))
        return parts + [point(lump.mass, lump.place) for lump in self.lumps]

    def _plate(self, plate: Plate) -> MassProperties:
        after = plate.place < self.length - TOUCH
        sizes = self.size_at(plate.place, after) - 2 * self.wall_at(plate.place, after)
        half = self.axes[:, 2] * plate.thickness / 2
        middle = self.at(plate.place)
        return piece(middle - half, middle + half, self.axes, (sizes, sizes), self.is_round, plate.density)

    def ballast(self, fill: Fill, spans: list[tuple[float, float, float]]) -> MassProperties:
        """What a fill weighs within the parts of the axis that count.

        Raises ParameterError where the fill does not lie in the member, or stands above its tank.
        """
        if not -TOUCH <= fill.low < fill.high <= self.length + TOUCH:
            raise ParameterError(
                f"{fill.name}: its tank from {fill.low:g} m to {fill.high:g} m is not within its member "
                f"of {self.length:g} m; both are distances from the start of the member."
            )
        bottom, top = self.heights(fill.low, fill.high)
        if not bottom - 1e-6 <= fill.level <= top + 1e-6:
            where = "above" if fill.level > top else "below"
            raise ParameterError(
                f"{fill.name}: its surface at z = {fill.level:g} m is {where} its tank, which goes from z = "
                f"{bottom:g} m to {top:g} m; set its level within, or change the tank (tank_start, tank_end)."
            )
        parts = [self._filled(max(fill.low, low), min(fill.high, high), fill.level).times(fill.density * share)
                 for low, high, share in spans]  # fmt: skip
        return together(parts)

    def heights(self, low: float, high: float) -> tuple[float, float]:
        """Lowest and highest z of the inside between s = low and high."""
        z = [z for a, b in self.pieces(low, high) for s, after in ((a, True), (b, False))
             for z in self._rim(s, after)]  # fmt: skip
        return min(z), max(z)

    def _rim(self, s: float, after: bool) -> tuple[float, float]:
        """Lowest and highest z of the inside of a section."""
        half = (self.size_at(s, after) - 2 * self.wall_at(s, after)) / 2
        reach = half * self.axes[2, :2]
        spread = float(np.hypot(*reach)) if self.is_round else float(np.abs(reach).sum())
        middle = float(self.at(s)[2])
        return middle - spread, middle + spread

    def _filled(self, low: float, high: float, level: float) -> MassProperties:
        """The inside between s = low and high below z = level, of density 1."""
        parts = []
        for a, b in self.pieces(low, high):
            bottom, top = self.heights(a, b)
            if top <= level:
                parts.append(self.solid(a, b, inner=True))
            elif bottom < level:
                if abs(self.axes[2, 2]) > 1 - 1e-12:  # upright: the surface is a section
                    s = (level - self.start[2]) / (self.end[2] - self.start[2]) * self.length
                    parts.append(self.solid(*((a, s) if self.axes[2, 2] > 0 else (s, b)), inner=True))
                else:
                    parts.append(below(self.body(a, b, inner=True), level))
        return together(parts)


def below(body: ConvexBody, level: float) -> MassProperties:
    """What of a convex body lies below z = level: volume (as mass), centre and inertia, from its surface."""
    polygons, rim = [], []
    for facet in body.facets:
        heights = facet.corners[:, 2] - level
        low = split(facet.corners, heights)[1] if heights.max() > TOUCH else facet.corners
        if len(low) > 2:
            polygons.append(low)
            rim += [corner for corner in low if abs(corner[2] - level) < TOUCH]
    if len(rim) > 2:
        corners = np.array(rim)
        middle = corners.mean(axis=0)
        order = np.argsort(np.arctan2(corners[:, 1] - middle[1], corners[:, 0] - middle[0]))
        polygons.append(corners[order])
    return enclosed(polygons)


def enclosed(polygons: list[Floats]) -> MassProperties:
    """Volume (as mass), centre and inertia of density 1 of what closed polygons enclose, normals outwards."""
    triangles = np.array([polygon[[0, k, k + 1]] for polygon in polygons for k in range(1, len(polygon) - 1)])
    if not len(triangles):
        return NOTHING
    origin = triangles.reshape(-1, 3).mean(axis=0)
    a, b, c = np.moveaxis(triangles - origin, 1, 0)
    six = np.einsum("nk,nk->n", a, np.cross(b, c))
    volume = six.sum() / 6
    if volume <= 0:
        return NOTHING
    total = a + b + c
    centre = six @ total / 24 / volume
    second = sum(np.einsum("n,ni,nj->ij", six, p, p) for p in (a, b, c, total)) / 120
    about = np.trace(second) * np.eye(3) - second
    offset = volume * (centre @ centre * np.eye(3) - np.outer(centre, centre))
    return MassProperties(float(volume), origin + centre, about - offset)


def _interpolated(stations: tuple[float, ...], values: Floats, s: float, after: bool) -> Floats:
    known = np.array(stations)
    at = int(np.searchsorted(known, s + TOUCH if after else s - TOUCH, side="left"))
    at = min(max(at, 1), len(known) - 1)
    while known[at] - known[at - 1] <= TOUCH:  # a step: go to the piece that is meant
        at = at + 1 if after and at + 1 < len(known) else at - 1
    share = min(max((s - known[at - 1]) / (known[at] - known[at - 1]), 0.0), 1.0)
    return values[at - 1] + share * (values[at] - values[at - 1])


def _round_ring(diameter: float, size: float | None) -> tuple[Floats, NDArray[np.int64]]:
    """Points (k, 2) about a circle of diameter 1 whose polygon has its area, and the numbers of its corners."""
    count = FINE if size is None else 4 * max(3, math.ceil(math.pi * diameter / size / 4))
    angle = 2 * math.pi / count * np.arange(count)
    return round_factor(count) / 2 * np.stack([np.cos(angle), np.sin(angle)], axis=1), np.arange(count)


def _box_ring(widths: Floats, size: float | None) -> tuple[Floats, NDArray[np.int64]]:
    """Points (k, 2) about a square of width 1, divided as a box of these widths, and the numbers of its corners."""
    counts = [1, 1] if size is None else [max(1, math.ceil(width / size)) for width in widths]
    sides = [np.linspace(-0.5, 0.5, count + 1)[:-1] for count in counts]
    ring = [*((t, -0.5) for t in sides[0]), *((0.5, t) for t in sides[1]), *((-t, 0.5) for t in sides[0]),
            *((-0.5, -t) for t in sides[1])]  # fmt: skip
    return np.array(ring), np.cumsum([0, counts[0], counts[1], counts[0]])
