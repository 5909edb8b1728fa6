"""Cost of tubes of steel by material and working time, and of mooring lines by mass.

J. Farkas and K. Jarmai, Optimum Design of Steel Structures (2013): a cost per kilogram, and one per minute of work.
Their correlations take millimetres; the arguments here are in metres. All times are in minutes. That of forming is for
shells of up to 3 m of diameter; for hulls and towers it is extrapolated, as is usual (J.M. Hegseth et al., Marine
Structures 72, 2020, 102771). Forming is 2 % of the cost of a hull.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import pi
from typing import Any

from fowtlib.design.rules.either import between, demand, demand_nodes, exp, of_arrays, sqrt, total
from fowtlib.design.rules.ring import Ring

COMPLEXITY = 3.0
"""Difficulty factor Theta of the source, for curved shells."""
WELD = 10.0
"""Size of the welds [mm]."""
BUTT, FILLET = 0.1346e-3, 0.2349e-3
"""Minutes per mm of length and mm^2 of weld, submerged arc welding."""
FURTHER = 1.3
"""Times of electrodes, slag and chipping, as a factor."""


@dataclass(frozen=True)
class TubeSections:
    """Sections of a tube between nodes: length, mean outer diameter, mean thickness [m]; steel volume [m^3]; seams.

    seams: outer diameters of the nodes between sections [m].
    """

    length: Any
    diameter: Any
    thickness: Any
    volume: Any
    seams: Any


@of_arrays
def tube_sections(elevation: Any, diameter: Any, thickness: Any) -> TubeSections:
    """Sections of a tube from elevations (rising), outer diameters and thicknesses at n nodes [m], linear in between.

    A section counts as the cylinder of its mean diameter and thickness (its volume differs by 0.1 % from that of cones
    of hulls and towers).
    """
    demand_nodes("a tube", elevation=elevation, diameter=diameter, thickness=thickness)
    (below, above), (D0, D1), (t0, t1) = between(elevation), between(diameter), between(thickness)
    length, D, t = above - below, (D0 + D1) / 2, (t0 + t1) / 2
    demand("a tube", 0.0, length_of_a_section=length, diameter=D, thickness=t)
    return TubeSections(length, D, t, pi * (D - t) * t * length, D0[1:])


@of_arrays
def fabrication_times(sections: TubeSections, density: Any = 7850.0, plates: int = 3) -> dict[str, Any]:
    """Minutes of work for the shell: forming, welding of plates to sections, of sections to the tube, painting outside.

    forming: Theta exp(6.8582513 - 4.52721/sqrt(t) + 0.009531996 sqrt(D)) for each section, mm. Welding of k pieces of
    the mass m: Theta sqrt(k m) + 1.3 C a^2 L_weld. Painting: 2 (3 + 4.15) 1e-6 per mm^2. density [kg/m^3].
    """
    D, t, length = 1e3 * sections.diameter, 1e3 * sections.thickness, 1e3 * sections.length
    mass = density * sections.volume
    forming = COMPLEXITY * exp(6.8582513 - 4.52721 / sqrt(t) + 0.009531996 * sqrt(D))
    # the source takes the whole circle of the diameter for the mass of the plates
    rolled = density * pi * sections.diameter * sections.thickness * sections.length
    plate = COMPLEXITY * sqrt(plates * rolled) + FURTHER * BUTT * WELD**2 * plates * length
    seams = FURTHER * BUTT * WELD**2 * pi * 1e3 * total(sections.seams)
    return {
        "forming": total(forming),
        "sections": total(plate),
        "tube": COMPLEXITY * sqrt(sections_of(sections) * total(mass)) + seams,
        "painting": 2 * (3 + 4.15) * 1e-6 * pi * total(D * length),
    }


def sections_of(sections: TubeSections) -> int:
    """How many sections there are."""
    shape = getattr(sections.length, "shape", ())
    return int(shape[0]) if shape else 1


@of_arrays
def ring_fabrication_times(sections: TubeSections, ring: Ring, density: Any = 7850.0) -> dict[str, Any]:
    """Minutes of work for ring frames inside the sections: web to flange, rings to the shell, two fillet welds each.

    The number of rings of a section is its length over their spacing, not rounded, so that costs stay smooth.
    """
    radius = (sections.diameter - sections.thickness) / 2
    ring.demand_in(radius, sections.thickness)
    inner, count = ring.flange_radius(radius, sections.thickness), sections.length / ring.spacing
    mass = density * 2 * pi * ring.centroid_radius(radius, sections.thickness) * ring.area
    seam = FURTHER * FILLET * WELD**2 * 4 * pi * 1e3
    joint = inner + ring.flange_thickness
    webs = count * (COMPLEXITY * sqrt(2 * mass) + seam * joint)
    shell = density * sections.volume
    fitted = COMPLEXITY * sqrt(count * (count * mass + shell)) + seam * count * (joint + ring.web_height)
    return {"rings": total(webs), "rings to shell": total(fitted), "mass of rings [kg]": total(count * mass)}


@dataclass(frozen=True)
class SteelCost:
    """Cost, that of the material and that of the work in it, mass [kg], minutes of work."""

    cost: Any
    material: Any
    work: Any
    mass: Any
    minutes: dict[str, Any]


@of_arrays
def steel_cost(
    sections: TubeSections, ring: Ring | None = None, *, density: Any = 7850.0, per_kilogram: Any = 2.7,
    per_minute: Any = 2.7,
) -> SteelCost:  # fmt: skip
    """Cost of a tube with or without ring frames, per_kilogram k_m mass + per_minute k_f minutes, EUR.

    Ballast, secondary steel and outfitting are not in it; a density above that of steel stands for the latter.
    """
    minutes, mass = fabrication_times(sections, density), density * total(sections.volume)
    if ring is not None:
        more = ring_fabrication_times(sections, ring, density)
        mass = mass + more.pop("mass of rings [kg]")
        minutes = {**minutes, **more}
    work = per_minute * sum(minutes.values())
    return SteelCost(per_kilogram * mass + work, per_kilogram * mass, work, mass, minutes)


@of_arrays
def mooring_cost(mass_per_length: Any, length: Any, lines: Any = 1, per_kilogram: Any = 3.5) -> Any:
    """Cost of chain by its mass, EUR; 3.5 EUR/kg for grade R4 (3 to 4.5 are quoted).

    mass_per_length [kg/m]: in air, unless the price is one for the weight in water.
    """
    demand("mooring cost", 0.0, mass_per_length=mass_per_length, length=length)
    return per_kilogram * lines * mass_per_length * length
