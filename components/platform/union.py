"""What members are together from outside, whatever they are made of and filled with: their union.

What of each axis lies in no larger member, the surface under water, strips, and whether all of them meet.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache

import numpy as np
from numpy.typing import NDArray

from fowtlib.components.platform.convex import TOUCH, ConvexBody, Facet, gap, surface
from fowtlib.components.platform.members import MemberShape
from fowtlib.components.platform.solids import section
from fowtlib.language.errors import ParameterError

Floats = NDArray[np.float64]
Span = tuple[float, float, float]

MEET = 0.05  # m: members nearer than that meet, for plans are rounded to centimetres and circles are polygons here


@dataclass(frozen=True)
class Strips:
    """Sections of one member in the water: places (k, 3), directions (k, 3) of the section and axis, and their sizes.

    across_1, across_2 [m^2]: length times the size that a flow along the first or second direction meets. volume [m^3]
    of the strip. ends [m^2], end_volumes [m^3]: wet area of an end and the half ball over it; zero but for the last two
    strips, which are the start and the end. waterline: horizontal section [m^2] at the water level, and its place.
    """

    places: Floats
    directions: Floats
    across_1: Floats
    across_2: Floats
    volume: Floats
    ends: Floats
    end_volumes: Floats
    waterline: float
    waterline_place: Floats


@dataclass(frozen=True)
class Union:
    """The outsides of members in the frame of a floater, the still water at z = 0."""

    members: tuple[MemberShape, ...]

    @cached_property
    def bodies(self) -> list[ConvexBody]:
        """The members as convex bodies; the number of a body is that of its member."""
        return [body for k, member in enumerate(self.members) for body in member.bodies(k)]

    @cached_property
    def spans(self) -> list[list[Span]]:
        """For each member the parts of its axis (from, to [m], share) that lie in no larger member."""
        return [self._spans(k) for k in range(len(self.members))]

    def _spans(self, number: int) -> list[Span]:
        member = self.members[number]
        line = np.array([member.start, member.end])
        low, high = line.min(axis=0) - TOUCH, line.max(axis=0) + TOUCH
        covers = []
        for other in {
            body.number for body in self.bodies if (low <= body.box[1]).all() and (body.box[0] <= high).all()
        }:
            if other != number:
                covers += [(a, b, other) for a, b in self.members[other].covers(line)]
        ends = {end for a, b, _ in covers for end in (a, b)}
        cuts = sorted(ends | {0.0, member.length} | set(member.stations))
        found: list[Span] = []
        for a, b in zip(cuts[:-1], cuts[1:], strict=True):
            if b - a <= TOUCH:
                continue
            over = [other for low, high, other in covers if low < (a + b) / 2 < high]
            own = self.section(number, (a + b) / 2)
            larger = [self._section_of(other, member.at((a + b) / 2)) / own for other in over]
            if all(ratio <= 1 + 1e-9 for ratio in larger):
                found.append((a, b, 1 / (1 + sum(ratio > 1 - 1e-9 for ratio in larger))))
        return found

    def section(self, number: int, s: float) -> float:
        """Area [m^2] of the section of a member at a distance from its start."""
        member = self.members[number]
        return float(section(member.size_at(s)[None], member.is_round)[0][0])

    def _section_of(self, number: int, place: Floats) -> float:
        """Area of the section of a member nearest to a point."""
        member = self.members[number]
        s = float((place - member.start) @ member.axes[:, 2])
        return self.section(number, min(max(s, TOUCH), member.length - TOUCH))

    @cached_property
    def wet(self) -> list[tuple[ConvexBody, Facet]]:
        """The surface of the union under water, in large facets."""
        return surface(self.bodies, below=0.0)

    def triangles(self, sides: int | None = None) -> Floats:
        """The whole surface (n, 3, 3), above the water too; sides: of the polygon of a circle, FINE where not given."""
        bodies = self.bodies if sides is None else [
            member.body(a, b, k, _width(member, a, b) * math.pi / (sides - 0.5) if member.is_round else None,
                        divided=False)
            for k, member in enumerate(self.members) for a, b in member.pieces()
        ]  # fmt: skip
        return as_triangles([facet.corners for _, facet in surface(bodies)])

    def wet_spans(self, number: int) -> list[Span]:
        """The parts of the axis of a member that count and lie under water."""
        member = self.members[number]
        z, slope = member.start[2], member.axes[2, 2]
        if abs(slope) <= 1e-12:
            low, high = 0.0, member.length if z <= 0 else 0.0
        else:
            low, high = (0.0, -z / slope) if slope > 0 else (-z / slope, member.length)
        cut = [(max(a, low), min(b, high), share) for a, b, share in self.spans[number]]
        return [(a, b, share) for a, b, share in cut if b - a > TOUCH]

    def strips(self, number: int, count: int) -> Strips:
        """`count` strips of a member, at Gauss points of its wet parts, and its ends; those that it lacks are empty."""
        return _strips(self, number, count)

    def wet_end(self, number: int, where: str) -> float:
        """Area of an end of a member that is on the surface of the hull, under water."""
        member = self.members[number]
        plane, sign = (member.start, -1) if where == "start" else (member.end, 1)
        outward = sign * member.axes[:, 2]
        return sum(
            float(np.linalg.norm(facet.area_vector)) for body, facet in self.wet
            if body.number == number and facet.where == where
            and abs((facet.corners[0] - plane) @ outward) < TOUCH
        )  # fmt: skip

    def waterline(self, number: int) -> tuple[float, Floats]:
        """Horizontal section of a member at the water level, as far as it counts, and its place."""
        member = self.members[number]
        slope = member.axes[2, 2]
        if abs(slope) > 1e-3:
            s = -member.start[2] / slope
            for a, b, share in self.spans[number]:
                if a < s <= b:
                    return share * self.section(number, s) / abs(slope), member.at(s)
        return 0.0, np.array([*np.asarray(member.start)[:2], 0.0])

    @cached_property
    def apart(self) -> tuple[float, int, int] | None:
        """The smallest gap [m] between members that do not hang together, and their numbers; None where all do."""
        group = list(range(len(self.members)))

        def root(k: int) -> int:
            while group[k] != k:
                k = group[k]
            return k

        pairs = sorted((_box_gap(a, b), i, j) for i, a in enumerate(self.bodies) for j, b in enumerate(self.bodies[:i]))
        nearest = []
        for distance, i, j in pairs:
            a, b = self.bodies[i], self.bodies[j]
            if root(a.number) == root(b.number):
                continue
            if distance > MEET:
                nearest.append((distance, a.number, b.number))
                continue
            between = gap(a, b)
            if between <= MEET:
                group[root(a.number)] = root(b.number)
            else:
                nearest.append((between, a.number, b.number))
        return min(((d, a, b) for d, a, b in nearest if root(a) != root(b)), default=None)


def as_triangles(polygons: list[Floats]) -> Floats:
    """Triangles (n, 3, 3) that fill convex polygons, fans about their first corners."""
    triangles = [polygon[[0, k, k + 1]] for polygon in polygons for k in range(1, len(polygon) - 1)]
    return np.array(triangles).reshape(-1, 3, 3)


def _width(member: MemberShape, a: float, b: float) -> float:
    return float(max(member.size_at(a)[0], member.size_at(b, after=False)[0]))


@lru_cache(maxsize=16)
def _kept(members: tuple[MemberShape, ...]) -> Union:
    return Union(members)


def union(members: tuple[MemberShape, ...]) -> Union:
    """The union of members; the same object while they differ in what they are made of and filled with alone."""
    return _kept(tuple(replace(member, walls=(), density=0.0, fills=(), plates=(), lumps=()) for member in members))


@lru_cache(maxsize=512)
def _strips(whole: Union, number: int, count: int) -> Strips:
    member, spans = whole.members[number], whole.wet_spans(number)
    axes = member.axes
    rows = []  # s, length
    for (a, b, share), points in zip(spans, _portions([b - a for a, b, _ in spans], count), strict=True):
        if not points:
            raise ParameterError(
                f"{member.name}.sections = {count} are too few: {len(spans)} parts of the member are in the water."
            )
        nodes, weights = np.polynomial.legendre.leggauss(points)
        rows += [((a + b) / 2 + (b - a) / 2 * x, (b - a) / 2 * w * share) for x, w in zip(nodes, weights, strict=True)]
    rows += [(0.0, 0.0)] * (count - len(rows)) + [(0.0, 0.0), (member.length, 0.0)]
    sizes = np.array([member.size_at(s, after=s < member.length) for s, _ in rows])
    lengths = np.array([length for _, length in rows])
    area = section(sizes, member.is_round)[0]
    ends, volumes = np.zeros(len(rows)), np.zeros(len(rows))
    ends[-2:] = whole.wet_end(number, "start"), whole.wet_end(number, "end")
    volumes[-2:] = 2 / 3 * math.pi * (area[-2:] / math.pi) ** 1.5 * (ends[-2:] > 0.01 * area[-2:])
    line, place = whole.waterline(number)
    return Strips(
        np.array([member.at(s) for s, _ in rows]), np.tile(axes.T.reshape(1, 9), (len(rows), 1)),
        lengths * sizes[:, 1], lengths * sizes[:, 0], lengths * area, ends, volumes, line, place,
    )  # fmt: skip


def _portions(lengths: list[float], count: int) -> list[int]:
    """Gauss points for parts of these lengths, `count` together: one each at least, the rest by roots of lengths."""
    if not lengths:
        return []
    roots = np.sqrt(lengths)
    shares = np.ones(len(lengths), dtype=int) if count >= len(lengths) else np.zeros(len(lengths), dtype=int)
    for _ in range(count - int(shares.sum()) if shares.any() else 0):
        shares[int(np.argmax(roots / shares))] += 1
    return [int(share) for share in shares]


def _box_gap(a: ConvexBody, b: ConvexBody) -> float:
    """Distance of the boxes about two bodies; zero where they overlap."""
    (low_a, high_a), (low_b, high_b) = a.box, b.box
    return float(np.linalg.norm(np.maximum(0.0, np.maximum(low_a - high_b, low_b - high_a))))
