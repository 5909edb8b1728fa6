"""The structure of a hull of members as a space frame: beams along their axes, rigid where one lies in another.

A member that runs into a larger one is a beam as far as it lies outside of it; from there a rigid arm leads to the axis
of the larger one. Walls, bulkheads, point masses and ballast are those of the hull, so that the frame weighs what the
hull does. Ballast moves with its member and does not stiffen it.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fowtlib.components.hydro.deformation import Field
from fowtlib.components.platform.convex import TOUCH
from fowtlib.components.platform.hull import Hull
from fowtlib.components.platform.members import MemberShape
from fowtlib.components.platform.solids import MassProperties, point, together
from fowtlib.components.platform.space_frame import Beam, NodeMass, Section, SpaceFrame
from fowtlib.language.errors import ParameterError

Floats = NDArray[np.float64]
Place = tuple[int, int]  # number of a member, and of a place along it
_NEAR = 1e-3  # m; closer than this two places on an axis are one
_MEET = 0.05  # of the radius: so far off a surface an end still meets it
FAR = 1.5  # radii off the axis: further out a point belongs to no member


@dataclass(frozen=True)
class _Piece:
    """A beam of the frame: part of the axis of a member."""

    member: int
    low: float
    high: float


class MemberFrame:
    """The beams of a hull. frame: SpaceFrame; longest [m]: no beam is longer; moduli [Pa] of all walls.

    Raises ParameterError for members without walls, and such as meet no other.
    """

    def __init__(self, hull: Hull, longest: float, young_modulus: float = 210e9, shear_modulus: float = 80.8e9):
        self.hull, self.longest = hull, longest
        self._moduli = young_modulus, shear_modulus
        self._stretches = [_stretches(spans) for spans in hull.spans]
        self._places, self._joined = self._divided(self._joints())
        self._nodes, self._points = self._numbered()
        self.pieces, self._beams = self._divided_beams()
        self.frame = SpaceFrame(self._points, self._beams, self._masses())

    def field(self, points: ArrayLike, shapes: ArrayLike) -> Field:
        """How points (k, 3) of the hull move with displacements of the nodes, of several shapes (m, n, 6).

        A section of a member carries them: those of its surface, and inside. Raises ParameterError for a point further
        off than one and a half radii.
        """
        places, given = np.asarray(points, dtype=float).reshape(-1, 3), np.asarray(shapes, dtype=float)
        moved, turn = np.zeros((2, len(given), len(places), 3))
        arms = np.zeros((len(places), 3))
        gradient = np.zeros((len(given), len(places), 3, 3))
        for k, place in enumerate(places):
            piece, share = self.carrier(place)
            axis, motion, slope = self.frame.section_motion(piece, share, given)
            along, arm = self.frame.direction(piece), place - axis
            turn[:, k], arms[k] = motion[:, 3:], arm
            moved[:, k] = motion[:, :3] + np.cross(motion[:, 3:], arm)
            stretch = slope[:, :3] + np.cross(slope[:, 3:], arm) - np.cross(motion[:, 3:], along)
            gradient[:, k] = stretch[:, :, None] * along + _turning(motion[:, 3:])
        return Field(moved, gradient, turn, arms)

    def turn(self, points: ArrayLike, shapes: ArrayLike) -> Floats:
        """Small turns (m, k, 3) [rad] of the sections that carry points (k, 3), for displacements (m, n, 6)."""
        carried = (self.carrier(place) for place in np.asarray(points, dtype=float).reshape(-1, 3))
        given = np.asarray(shapes, dtype=float)
        return np.stack([self.frame.section_motion(*where, given)[1][:, 3:] for where in carried], axis=1)

    def node_at(self, point: ArrayLike) -> int:
        """The node of the frame nearest to a point [m]."""
        return int(np.argmin(np.linalg.norm(self.frame.nodes - np.asarray(point, dtype=float), axis=1)))

    # --- where beams begin and end ---------------------------------------------------------------------------------

    def _joints(self) -> list[tuple[tuple[int, float], tuple[int, float]]]:
        """Places (member, s) that are rigidly joined: the end of a stretch, and where on the axis of another."""
        found = []
        for k, stretches in enumerate(self._stretches):
            for s in (end for stretch in stretches for end in stretch):
                host = self._host(k, self.hull.members[k].at(s))
                if host is not None:
                    found.append(((k, s), host))
        return found

    def _host(self, own: int, point: Floats) -> tuple[int, float] | None:
        """The largest member that reaches to a point, and the place on its axis."""
        best, widest = None, 0.0
        for k, member in enumerate(self.hull.members):
            for low, high in self._stretches[k] if k != own else ():
                s = float(np.clip((point - member.start) @ member.axes[:, 2], low, high))
                radius = float(np.max(member.size_at(s))) / 2
                apart = _off(member, s, point)
                if apart <= radius * (1 + _MEET) + TOUCH and radius > widest:
                    best, widest = (k, s), radius
        return best

    def _divided(
        self, joints: list[tuple[tuple[int, float], tuple[int, float]]]
    ) -> tuple[list[list[float]], list[tuple[Place, Place]]]:
        """Places along each member between which it is a beam, and the joints by number of place."""
        wanted: list[list[float]] = [[end for stretch in stretches for end in stretch] for stretches in self._stretches]
        for one, other in joints:
            wanted[one[0]].append(one[1])
            wanted[other[0]].append(other[1])
        found = []
        for member, places, stretches in zip(self.hull.members, wanted, self._stretches, strict=True):
            inside = [s for s in member.stations if any(low < s < high for low, high in stretches)]
            found.append(_merged([*places, *inside]))
        fine = [self._refined(places, stretches) for places, stretches in zip(found, self._stretches, strict=True)]
        return fine, [((a, _nearest(fine[a], s)), (b, _nearest(fine[b], t))) for (a, s), (b, t) in joints]

    def _refined(self, places: list[float], stretches: list[tuple[float, float]]) -> list[float]:
        more = list(places)
        for a, b in zip(places[:-1], places[1:], strict=True):
            if any(low - _NEAR <= a and b <= high + _NEAR for low, high in stretches):
                count = math.ceil((b - a) / self.longest)
                more += [a + (b - a) * i / count for i in range(1, count)]
        return sorted(more)

    def _numbered(self) -> tuple[dict[Place, int], Floats]:
        """The node of each place, and the points of the nodes: those of the wider members."""
        above: dict[Place, Place] = {}

        def top(place: Place) -> Place:
            while place in above:
                place = above[place]
            return place

        for one, other in self._joined:
            a, b = top(one), top(other)
            if a != b:
                wide, narrow = (a, b) if self._width(a) > self._width(b) else (b, a)
                above[narrow] = wide
        nodes: dict[Place, int] = {}
        points: list[Floats] = []
        for k, places in enumerate(self._places):
            for i in range(len(places)):
                if not self._used((k, i)):
                    continue
                root = top((k, i))
                if root not in nodes:
                    nodes[root] = len(points)
                    points.append(self._point(root))
                nodes[k, i] = nodes[root]
        return nodes, np.array(points)

    def _used(self, place: Place) -> bool:
        s = self._places[place[0]][place[1]]
        return any(low - _NEAR <= s <= high + _NEAR for low, high in self._stretches[place[0]])

    def _point(self, place: Place) -> Floats:
        return self.hull.members[place[0]].at(self._places[place[0]][place[1]])

    def _width(self, place: Place) -> float:
        return float(np.max(self.hull.members[place[0]].size_at(self._places[place[0]][place[1]])))

    # --- beams and masses ------------------------------------------------------------------------------------------

    def _divided_beams(self) -> tuple[list[_Piece], list[Beam]]:
        pieces, beams = [], []
        for k, (member, places) in enumerate(zip(self.hull.members, self._places, strict=True)):
            for i, (a, b) in enumerate(zip(places[:-1], places[1:], strict=True)):
                if not any(low - _NEAR <= a and b <= high + _NEAR for low, high in self._stretches[k]):
                    continue
                start, end = self._nodes[k, i], self._nodes[k, i + 1]
                arms = [_point(member.at(s) - self._points[n]) for s, n in ((a, start), (b, end))]
                pieces.append(_Piece(k, a, b))
                beams.append(Beam(start, end, self._section(k, a, b), _point(member.axes[:, 0]), *arms))
        return pieces, beams

    def _section(self, number: int, a: float, b: float) -> Section:
        """The section in the middle of a piece, with the mass of its walls."""
        member, middle = self.hull.members[number], (a + b) / 2
        wall, sizes = member.wall_at(middle), member.size_at(middle)
        if wall <= 0:
            raise ParameterError(f"{member.name} has no wall; an elastic hull needs its wall_thickness.")
        spans = _within(self.hull.spans[number], a, b)
        outer, inner = (together(member.solid(*span[:2], inner=within).times(span[2]) for span in spans)
                        for within in (False, True))  # fmt: skip
        make = (Section.tube, float(sizes[0])) if member.is_round else (Section.box, (float(sizes[0]), float(sizes[1])))
        section = make[0](make[1], wall, 1.0, *self._moduli)
        density = member.density * (outer.mass - inner.mass) / ((b - a) * section.area)
        return make[0](make[1], wall, density, *self._moduli)

    def _masses(self) -> list[NodeMass]:
        """What the hull weighs beyond its walls: each bulkhead and ballast at both ends of a piece, lumps at a node."""
        found = []
        for piece, beam in zip(self.pieces, self._beams, strict=True):
            member = self.hull.members[piece.member]
            spans = _within(self.hull.spans[piece.member], piece.low, piece.high)
            bare = replace(member, density=0.0, lumps=())
            for part in [*bare.structure(spans), *(member.ballast(fill, spans) for fill in member.fills)]:
                if part.mass:
                    found += self._at_both_ends((beam.start, beam.end), part)
        for k, member in enumerate(self.hull.members):
            nodes = [node for (one, _), node in self._nodes.items() if one == k]
            found += [self._at_a_node(nodes, point(lump.mass, lump.place)) for lump in member.lumps]
        return found

    def _at_both_ends(self, ends: tuple[int, int], part: MassProperties) -> list[NodeMass]:
        """A part of a piece, shared between its ends as their distance says: each share stays at its own centre."""
        one, other = (self._points[n] for n in ends)
        along = other - one
        second = float(np.clip((part.centre - one) @ along / max(float(along @ along), _NEAR**2), 0.0, 1.0))
        return [NodeMass(n, share * part.mass, _point(part.centre - self._points[n]), share * part.inertia)
                for n, share in zip(ends, (1 - second, second), strict=True) if share]  # fmt: skip

    def _at_a_node(self, nodes: Iterable[int], part: MassProperties) -> NodeMass:
        node = min(nodes, key=lambda n: float(np.linalg.norm(self._points[n] - part.centre)))
        return NodeMass(node, part.mass, _point(part.centre - self._points[node]), part.inertia)

    # --- between nodes ---------------------------------------------------------------------------------------------

    @cached_property
    def _segments(self) -> tuple[Floats, Floats, Floats, Floats]:
        """Of each piece its start, its direction, its length, and the largest radius that it has."""
        members = [self.hull.members[piece.member] for piece in self.pieces]
        starts = np.array([member.at(piece.low) for member, piece in zip(members, self.pieces, strict=True)])
        lengths = np.array([piece.high - piece.low for piece in self.pieces])
        radii = [max(float(np.max(member.size_at(s, after=after))) / 2 for s, after in _sizes(member, piece))
                 for member, piece in zip(members, self.pieces, strict=True)]  # fmt: skip
        return starts, np.array([member.axes[:, 2] for member in members]), lengths, np.array(radii)

    def carrier(self, place: Floats) -> tuple[int, float]:
        """The piece whose section carries a point, and the share of its length where that is."""
        off, piece, share = self._nearest_piece(place)
        if off > FAR:
            x, y, z = place
            raise ParameterError(f"the point ({x:g}, {y:g}, {z:g}) m is off the hull, so that no member carries it.")
        return piece, share

    def nearest(self, place: Floats) -> tuple[float, str]:
        """How many radii a point is off the axis of the nearest member, and the name of that."""
        off, piece, _ = self._nearest_piece(place)
        return off, self.hull.members[self.pieces[piece].member].name

    def _nearest_piece(self, place: Floats) -> tuple[float, int, float]:
        """Radii off the axis of the nearest piece, that piece, and the share of its length where that is."""
        starts, along, lengths, radii = self._segments
        shares = np.clip(np.einsum("ki,ki->k", place - starts, along), 0.0, lengths)
        near = np.linalg.norm(place - starts - shares[:, None] * along, axis=1) / radii  # at most what it is
        best, where = math.inf, (0, 0.0)
        for k in np.argsort(near, kind="stable").tolist():
            if near[k] >= best:
                break
            piece = self.pieces[k]
            member = self.hull.members[piece.member]
            s = piece.low + float(shares[k])
            off = _off(member, s, place) / (float(np.max(member.size_at(s))) / 2)
            if off < best:
                best, where = off, (k, (s - piece.low) / (piece.high - piece.low))
        return best, *where


def _sizes(member: MemberShape, piece: _Piece) -> list[tuple[float, bool]]:
    """The places of a piece that have its extreme sizes: its ends, and stations between them from both sides."""
    inside = [s for s in member.stations if piece.low <= s <= piece.high]
    return [(s, after) for s in (piece.low, piece.high, *inside) for after in (True, False)]


def _turning(angles: Floats) -> Floats:
    """Gradients (m, 3, 3) of small turns (m, 3)."""
    matrix = np.zeros((len(angles), 3, 3))
    for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        matrix[:, j, i], matrix[:, i, j] = angles[:, k], -angles[:, k]
    return matrix


def _point(values: Floats) -> tuple[float, float, float]:
    x, y, z = (float(value) for value in values)
    return x, y, z


def _off(member: MemberShape, s: float, place: Floats) -> float:
    return float(np.linalg.norm(place - member.at(s)))


def _within(spans: list[tuple[float, float, float]], a: float, b: float) -> list[tuple[float, float, float]]:
    """The parts of spans between a and b."""
    clipped = ((max(low, a), min(high, b), share) for low, high, share in spans)
    return [(low, high, share) for low, high, share in clipped if high > low]


def _stretches(spans: list[tuple[float, float, float]]) -> list[tuple[float, float]]:
    """The parts of an axis that lie in no larger member, adjacent ones as one."""
    found: list[tuple[float, float]] = []
    for low, high, share in sorted(spans):
        if share <= 0 or high - low <= _NEAR:
            continue
        if found and low - found[-1][1] <= _NEAR:
            found[-1] = found[-1][0], high
        else:
            found.append((low, high))
    return found


def _merged(places: list[float]) -> list[float]:
    """Sorted, those that are near to each other as one."""
    found: list[float] = []
    for s in sorted(places):
        if not found or s - found[-1] > _NEAR:
            found.append(s)
    return found


def _nearest(places: list[float], s: float) -> int:
    return int(np.argmin(np.abs(np.array(places) - s)))
