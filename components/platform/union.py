"""What members are together from outside, whatever they are made of and filled with: their union.

What of each axis lies in no larger member, the surface under water, and whether all of them meet.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property, lru_cache

import numpy as np
from numpy.typing import NDArray

from fowtlib.components.platform.convex import TOUCH, ConvexBody, Facet, gap, surface
from fowtlib.components.platform.members import MemberShape
from fowtlib.components.platform.solids import section

Floats = NDArray[np.float64]
Span = tuple[float, float, float]

MEET = 0.05  # m: members nearer than that meet, for plans are rounded to centimetres and circles are polygons here


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


@lru_cache(maxsize=16)
def _kept(members: tuple[MemberShape, ...]) -> Union:
    return Union(members)


def union(members: tuple[MemberShape, ...]) -> Union:
    """The union of members; the same object while they differ in what they are made of and filled with alone."""
    return _kept(tuple(replace(member, walls=(), density=0.0, fills=(), plates=(), lumps=()) for member in members))


def _box_gap(a: ConvexBody, b: ConvexBody) -> float:
    """Distance of the boxes about two bodies; zero where they overlap."""
    (low_a, high_a), (low_b, high_b) = a.box, b.box
    return float(np.linalg.norm(np.maximum(0.0, np.maximum(low_a - high_b, low_b - high_a))))
