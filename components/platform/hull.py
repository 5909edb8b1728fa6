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

from fowtlib.components.hydro.hull_mesh import hydrostatics
from fowtlib.components.hydro.linear_loads import stiffness_with_buoyancy, stiffness_without_buoyancy
from fowtlib.components.platform.convex import TOUCH, ConvexBody, Facet, as_panels, disc, outside, surface
from fowtlib.components.platform.members import Fill, MemberShape
from fowtlib.components.platform.solids import MassProperties, together
from fowtlib.components.platform.union import Span, Strips, Union, union
from fowtlib.language.errors import ParameterError

Floats = NDArray[np.float64]
APART = 0.05  # relative difference of volumes beyond which two hulls are not the same


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
        return density * gravity * stiffness_with_buoyancy(self.waterplane, self.volume, self.centre)


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

    @cached_property
    def union(self) -> Union:
        """The members from outside; hulls that differ in ballast alone have the same."""
        return union(self.members)

    @property
    def spans(self) -> list[list[Span]]:
        """For each member the parts of its axis (from, to [m], share) that lie in no larger member."""
        return self.union.spans

    @property
    def wet(self) -> list[tuple[ConvexBody, Facet]]:
        """The surface of the union under water, in large facets, each with the body that it belongs to."""
        return self.union.wet

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

    @property
    def lowest(self) -> float:
        """The z of its lowest point [m]."""
        return min(body.box[0][2] for body in self.union.bodies)

    @cached_property
    def buoyancy(self) -> Buoyancy:
        """Volume, centre and waterplane of what is under water. Raises ParameterError where that is nothing."""
        if not self.wet:
            raise ParameterError(
                f"{self.name} lies above the water: its lowest point is at z = {self.lowest:g} m; draw it deeper, or "
                "lower it with raised."
            )
        volume, centre, C = hydrostatics(as_panels([facet.corners for _, facet in self.wet]))
        return Buoyancy(volume, centre, stiffness_without_buoyancy(C, volume, centre))

    def metacentric_height(self) -> float:
        """Smallest metacentric height [m] of the hull alone, over all directions in which it may lean."""
        water, mass = self.buoyancy, self.mass
        about_centre = water.waterplane
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
        return self.union.wet_spans(number)

    def strips(self, number: int, count: int) -> Strips:
        """`count` strips of a member, at Gauss points of its wet parts, and its ends; see Union."""
        return self.union.strips(number, count)

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
        bottom = min(body.box[0][2] for body in self.union.bodies)
        top = max(body.box[1][2] for body in self.union.bodies)
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
        if self.union.apart is not None:
            distance, a, b = self.union.apart
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
