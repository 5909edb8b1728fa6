"""The hull that members make together: mass, hydrostatics, what is in the water and what lies in other members, panels.

What members share counts once. The water displaces their union, whose surface is exact for the flat faces that stand
for them (`convex`). Of wall, ballast, drag and inertia of the water, which belong to a member as a whole, the part of
its axis counts that lies in no larger member; where equally large ones cross, each has its share.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from fowtlib.components.hydro import panel_mesh
from fowtlib.components.platform.convex import TOUCH, ConvexBody, as_panels, disc, gap, outside, surface
from fowtlib.components.platform.members import Fill, MemberShape
from fowtlib.components.platform.solids import MassProperties, section, together
from fowtlib.language.errors import ParameterError

Floats = NDArray[np.float64]
Span = tuple[float, float, float]

MEET = 0.05  # m: members nearer than that meet, for plans are rounded to centimetres and circles are polygons here


@dataclass(frozen=True)
class Buoyancy:
    """Displaced volume [m^3], its centre (3,) [m], and the moments of the waterplane about the origin.

    waterplane (6, 6): stiffness of the waterplane over rho g, without the moments of the buoyancy: [2, 2] area,
    [2, 3] first moment by y, [2, 4] less that by x, [3, 3] and [4, 4] second moments by y and by x.
    """

    volume: float
    centre: Floats
    waterplane: Floats

    def stiffness(self, density: float = 1025.0, gravity: float = 9.80665) -> Floats:
        """Hydrostatic stiffness C (6, 6) about the origin without weight, as in a WAMIT .hst file, times rho g."""
        C = self.waterplane.copy()
        C[3, 3] += self.volume * self.centre[2]
        C[4, 4] += self.volume * self.centre[2]
        C[3, 5] -= self.volume * self.centre[0]
        C[4, 5] -= self.volume * self.centre[1]
        return density * gravity * C


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
class Hull:
    """Members in the frame of a floater, the still water at z = 0."""

    members: tuple[MemberShape, ...]
    name: str = "floater"

    def __post_init__(self):
        if not self.members:
            raise ParameterError(
                f"{self.name} has no members; give it parts of class CircularMember or RectangularMember."
            )

    # --- which parts of members count ----------------------------------------------------------------------------

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
            own = self._section(number, (a + b) / 2)
            larger = [self._section_of(other, member.at((a + b) / 2)) / own for other in over]
            if all(ratio <= 1 + 1e-9 for ratio in larger):
                found.append((a, b, 1 / (1 + sum(ratio > 1 - 1e-9 for ratio in larger))))
        return found

    def _section(self, number: int, s: float) -> float:
        member = self.members[number]
        return float(section(member.size_at(s)[None], member.is_round)[0][0])

    def _section_of(self, number: int, place: Floats) -> float:
        """Area of the section of a member nearest to a point."""
        member = self.members[number]
        s = float((place - member.start) @ member.axes[:, 2])
        return self._section(number, min(max(s, TOUCH), member.length - TOUCH))

    # --- mass ----------------------------------------------------------------------------------------------------

    @cached_property
    def structure(self) -> MassProperties:
        """Walls, bulkheads and point masses."""
        return together(part for member, spans in zip(self.members, self.spans, strict=True)
                        for part in member.structure(spans))  # fmt: skip

    @cached_property
    def fills(self) -> dict[str, MassProperties]:
        """Each ballast by name. Raises ParameterError for one that stands above its tank."""
        return {fill.name: member.ballast(fill, spans)
                for member, spans in zip(self.members, self.spans, strict=True) for fill in member.fills}  # fmt: skip

    @cached_property
    def mass(self) -> MassProperties:
        """Structure and ballast."""
        return together([self.structure, *self.fills.values()])

    # --- water ---------------------------------------------------------------------------------------------------

    @cached_property
    def wet(self):
        """The surface of the union under water, in large facets."""
        return surface(self.bodies, below=0.0)

    @property
    def lowest(self) -> float:
        """The z of its lowest point [m]."""
        return min(body.box[0][2] for body in self.bodies)

    @cached_property
    def buoyancy(self) -> Buoyancy:
        """Volume, centre and waterplane of what is under water. Raises ParameterError where that is nothing."""
        if not self.wet:
            raise ParameterError(
                f"{self.name} lies above the water: its lowest point is at z = {self.lowest:g} m; draw it deeper, or "
                "lower it with raised."
            )
        volume, centre, C = panel_mesh.hydrostatics(as_panels([facet.corners for _, facet in self.wet]))
        waterplane = C.copy()
        waterplane[3, 3] -= volume * centre[2]
        waterplane[4, 4] -= volume * centre[2]
        waterplane[3, 5] = waterplane[4, 5] = 0.0
        return Buoyancy(volume, centre, waterplane)

    def metacentric_height(self) -> float:
        """Smallest metacentric height [m] of the hull alone, over all directions in which it may lean."""
        water, mass = self.buoyancy, self.mass
        about_centre = water.waterplane.copy()
        area = max(about_centre[2, 2], 1e-12)
        sx, sy = -about_centre[2, 4] / area, about_centre[2, 3] / area
        second = np.array([[about_centre[3, 3] - area * sy**2, about_centre[3, 4] + area * sx * sy],
                           [about_centre[3, 4] + area * sx * sy, about_centre[4, 4] - area * sx**2]])  # fmt: skip
        return float(np.linalg.eigvalsh(second)[0] / water.volume + water.centre[2] - mass.centre[2])

    def panels(self, size: float) -> Floats:
        """Panels (n, 4, 3) of the union under water, about `size` [m] wide, normals into the water."""
        bodies = self._divided(size)
        return as_panels([facet.corners for _, facet in surface(bodies, below=0.0)])

    def lids(self, size: float) -> Floats:
        """Panels (n, 4, 3) of the water level inside of the members that reach it, normals downwards."""
        bodies = [member.body(a, b, k, size, divided=False)
                  for k, member in enumerate(self.members) for a, b in member.pieces()]  # fmt: skip
        rings = [(body, ring) for body in bodies if len(ring := _cut(body))]
        found = []
        for body, ring in rings:
            polygons = disc(ring[::-1], max(1, math.ceil(np.ptp(ring, axis=0).max() / 2 / size)))
            for other, _ in rings:
                if other.number < body.number:
                    polygons = [rest for polygon in polygons for rest in outside(polygon, other, False)]
            found += polygons
        return as_panels(found)

    def _divided(self, size: float) -> list[ConvexBody]:
        """The bodies with facets for a panel method; upright members are parted at the water level."""
        bodies = []
        for k, member in enumerate(self.members):
            for a, b in member.pieces():
                z = member.at(a)[2], member.at(b)[2]
                upright = abs(member.axes[2, 2]) > 1 - 1e-12 and min(z) < -TOUCH and max(z) > TOUCH
                cuts = [a, a + (b - a) * z[0] / (z[0] - z[1]), b] if upright else [a, b]
                bodies += [member.body(*pair, k, size) for pair in zip(cuts[:-1], cuts[1:], strict=True)]
        return bodies

    # --- strips --------------------------------------------------------------------------------------------------

    def wet_spans(self, number: int) -> list[Span]:
        """The parts of the axis of a member that count and lie under water."""
        member = self.members[number]
        z, slope = member.start[2], member.axes[2, 2]
        level = -z / slope if abs(slope) > 1e-12 else (math.inf if z <= 0 else -math.inf)
        cut = [(a, min(b, level), share) if slope > -1e-12 else (max(a, level), b, share)
               for a, b, share in self.spans[number]]  # fmt: skip
        if abs(slope) <= 1e-12:
            cut = self.spans[number] if z <= 0 else []
        return [(a, b, share) for a, b, share in cut if b - a > TOUCH]

    def strips(self, number: int, count: int) -> Strips:
        """`count` strips of a member, at Gauss points of its wet parts, and its ends; those that it lacks are empty."""
        member, spans = self.members[number], self.wet_spans(number)
        axes = member.axes
        rows = []  # s, length
        for (a, b, share), points in zip(spans, _portions([b - a for a, b, _ in spans], count), strict=True):
            if not points:
                raise ParameterError(
                    f"{member.name}.sections = {count} are too few: {len(spans)} parts of the member are in the water."
                )
            nodes, weights = np.polynomial.legendre.leggauss(points)
            rows += [
                ((a + b) / 2 + (b - a) / 2 * x, (b - a) / 2 * w * share) for x, w in zip(nodes, weights, strict=True)
            ]
        rows += [(0.0, 0.0)] * (count - len(rows)) + [(0.0, 0.0), (member.length, 0.0)]
        sizes = np.array([member.size_at(s, after=s < member.length) for s, _ in rows])
        lengths = np.array([length for _, length in rows])
        area = section(sizes, member.is_round)[0]
        ends, volumes = np.zeros(len(rows)), np.zeros(len(rows))
        ends[-2:] = self._wet_end(number, "start"), self._wet_end(number, "end")
        volumes[-2:] = 2 / 3 * math.pi * (area[-2:] / math.pi) ** 1.5 * (ends[-2:] > 0.01 * area[-2:])
        line, place = self._waterline(number)
        return Strips(
            np.array([member.at(s) for s, _ in rows]), np.tile(axes.T.reshape(1, 9), (len(rows), 1)),
            lengths * sizes[:, 1], lengths * sizes[:, 0], lengths * area, ends, volumes, line, place,
        )  # fmt: skip

    def _wet_end(self, number: int, where: str) -> float:
        """Area of an end of a member that is on the surface of the hull, under water."""
        member = self.members[number]
        plane, sign = (member.start, -1) if where == "start" else (member.end, 1)
        outward = sign * member.axes[:, 2]
        return sum(
            float(np.linalg.norm(facet.area_vector)) for body, facet in self.wet
            if body.number == number and facet.where == where
            and abs((facet.corners[0] - plane) @ outward) < TOUCH
        )  # fmt: skip

    def _waterline(self, number: int) -> tuple[float, Floats]:
        """Horizontal section of a member at the water level, as far as it counts, and its place."""
        member = self.members[number]
        slope = member.axes[2, 2]
        if abs(slope) > 1e-3:
            s = -member.start[2] / slope
            for a, b, share in self.spans[number]:
                if a < s <= b:
                    return share * self._section(number, s) / abs(slope), member.at(s)
        return 0.0, np.array([*np.asarray(member.start)[:2], 0.0])

    # --- balance -------------------------------------------------------------------------------------------------

    def raised(self, by: float) -> Hull:
        """The same hull with everything in it this much higher [m]."""

        def moved(place):
            return (place[0], place[1], place[2] + by)

        return replace(self, members=tuple(
            replace(member, start=moved(member.start), end=moved(member.end),
                    fills=tuple(replace(fill, level=fill.level + by) for fill in member.fills),
                    lumps=tuple(replace(lump, place=moved(lump.place)) for lump in member.lumps))
            for member in self.members))  # fmt: skip

    def with_level(self, names: list[str], level: float) -> Hull:
        """The same hull with the surface of some of its ballast at another height."""

        def filled(fill: Fill) -> Fill:
            return replace(fill, level=level) if fill.name in names else fill

        return replace(self, members=tuple(replace(member, fills=tuple(filled(fill) for fill in member.fills))
                                           for member in self.members))  # fmt: skip

    def ballast_level(self, names: list[str], load: float, density: float = 1025.0) -> float:
        """The height z [m] of the surface of the ballast of these names, with which the hull floats as it is drawn.

        load [kg]: mass that it carries besides, with the vertical pull of moorings over gravity.
        Raises ParameterError where empty tanks are too heavy, or full ones too light.
        """
        from scipy.optimize import brentq  # slow to import

        tanks = [(member, fill) for member in self.members for fill in member.fills if fill.name in names]
        if len(tanks) != len(names) or not names:
            known = ", ".join(fill.name for member in self.members for fill in member.fills) or "none"
            raise ParameterError(f"{self.name}: there is no ballast '{', '.join(names)}'; there is {known}.")
        ranges = [member.heights(fill.low, fill.high) for member, fill in tanks]
        low, high = max(a for a, _ in ranges), min(b for _, b in ranges)
        wanted = density * self.buoyancy.volume - load

        spans = {fill.name: spans for member, spans in zip(self.members, self.spans, strict=True)
                 for fill in member.fills}  # fmt: skip
        rest = self.mass.mass - sum(self.fills[name].mass for name in names)

        def excess(level: float) -> float:
            filled = (member.ballast(replace(fill, level=level), spans[fill.name]).mass for member, fill in tanks)
            return rest + sum(filled) - wanted

        if excess(low) > 0 or excess(high) < 0:
            what = "too heavy with empty tanks" if excess(low) > 0 else "too light with full tanks"
            by = excess(low) if excess(low) > 0 else -excess(high)
            raise ParameterError(
                f"{self.name} is {what} for this draft, by {by:.6g} kg: it displaces "
                f"{density * self.buoyancy.volume:.6g} kg and carries {load:.6g} kg."
            )
        return float(brentq(excess, low, high, xtol=1e-9))

    def rise(self, load: float, density: float = 1025.0) -> float:
        """How much higher [m] the hull floats upright with its ballast than it is drawn; load as in `ballast_level`.

        Raises ParameterError where it sinks, or floats on top of the water.
        """
        wanted = (self.mass.mass + load) / density
        bottom = min(body.box[0][2] for body in self.bodies)
        top = max(body.box[1][2] for body in self.bodies)
        whole = self.raised(-top).buoyancy.volume
        if wanted >= whole:
            raise ParameterError(
                f"{self.name} sinks: it and its load weigh {wanted * density:.6g} kg, and all of it "
                f"displaces {whole * density:.6g} kg; take ballast out, or make it larger."
            )
        low, high, by = -top, -bottom - 1e-6, 0.0
        for _ in range(60):  # Newton's steps, halved where they leave the range
            water = self.raised(by).buoyancy
            low, high = (by, high) if water.volume > wanted else (low, by)
            step = (water.volume - wanted) / max(water.waterplane[2, 2], 1e-9)
            if abs(step) < 1e-9:
                break
            by = by + step if low < by + step < high else (low + high) / 2
        return by

    # --- checks --------------------------------------------------------------------------------------------------

    def check_joined(self) -> None:
        """Raises ParameterError where members do not meet: the hull falls to pieces."""
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
        apart = [(d, a, b) for d, a, b in nearest if root(a) != root(b)]
        if apart:
            distance, a, b = min(apart)
            raise ParameterError(
                f"{self.members[a].name} and {self.members[b].name} do not meet, nor do the members that hang on them: "
                f"the gap is {distance:.2g} m. Let one end in the other, or join them by a member."
            )

    def check_upright(self) -> None:
        """Raises ParameterError where the hull alone turns over: its metacentric height is below zero."""
        height = self.metacentric_height()
        if height < 0:
            raise ParameterError(
                f"{self.name} cannot float upright: the metacentric height of the hull alone is {height:.3g} m (its "
                f"centre of mass lies at z = {self.mass.centre[2]:.4g} m, that of buoyancy at "
                f"{self.buoyancy.centre[2]:.4g} m). Put ballast lower, or widen the waterplane; where moorings hold "
                "it, say held_upright."
            )


def _cut(body: ConvexBody) -> Floats:
    """The section (k, 3) of a body at the water level, counter-clockwise from above; empty where there is none.

    Of a body that ends at the water level, that end, if the body lies below it.
    """
    low, high = body.box
    if low[2] > -TOUCH or high[2] < -TOUCH:
        return np.zeros((0, 3))
    rim = []
    for facet in body.facets:
        z = facet.corners[:, 2]
        for k, corner in enumerate(facet.corners):
            if abs(z[k]) <= TOUCH:
                rim.append(corner)
            elif z[k] * z[k - 1] < 0 and abs(z[k - 1]) > TOUCH:
                rim.append(corner + z[k] / (z[k] - z[k - 1]) * (facet.corners[k - 1] - corner))
    corners = np.array(rim).reshape(-1, 3)
    if len(corners) < 3:
        return np.zeros((0, 3))
    corners = corners[np.unique(np.round(corners / (10 * TOUCH)), axis=0, return_index=True)[1]] * [1, 1, 0]
    middle = (corners.min(axis=0) + corners.max(axis=0)) / 2
    return corners[np.argsort(np.arctan2(corners[:, 1] - middle[1], corners[:, 0] - middle[0]))]


def _box_gap(a: ConvexBody, b: ConvexBody) -> float:
    """Distance of the boxes about two bodies; zero where they overlap."""
    (low_a, high_a), (low_b, high_b) = a.box, b.box
    return float(np.linalg.norm(np.maximum(0.0, np.maximum(low_a - high_b, low_b - high_a))))


def _portions(lengths: list[float], count: int) -> list[int]:
    """Gauss points for parts of these lengths, `count` together: one each at least, the rest by roots of lengths."""
    if not lengths:
        return []
    roots = np.sqrt(lengths)
    shares = np.ones(len(lengths), dtype=int) if count >= len(lengths) else np.zeros(len(lengths), dtype=int)
    for _ in range(count - int(shares.sum()) if shares.any() else 0):
        shares[int(np.argmax(roots / shares))] += 1
    return [int(share) for share in shares]
