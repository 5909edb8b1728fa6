"""A tower that is raised and lowered in a shaft by water: its flotation cylinder, and the water that it takes."""

from __future__ import annotations

from math import pi
from typing import Any

from fowtlib.design.rules.either import demand, demand_not_negative, of_arrays, sqrt


@of_arrays
def flotation_diameter(mass: Any, height: Any, water_density: Any = 1025.0) -> Any:
    """Least diameter [m] of a flotation cylinder of a height [m] that bears a mass [kg]: rho pi/4 D^2 h = m."""
    demand("a flotation cylinder", 0.0, mass=mass, height=height, water_density=water_density)
    return sqrt(4 * mass / (pi * water_density * height))


@of_arrays
def flotation_draft(mass: Any, diameter: Any, water_density: Any = 1025.0) -> Any:
    """How deep [m] a cylinder dips that bears a mass; it floats while this is less than its height and the water's."""
    demand("a flotation cylinder", 0.0, mass=mass, diameter=diameter, water_density=water_density)
    return 4 * mass / (pi * water_density * diameter**2)


@of_arrays
def shaft_water(shaft_diameter: Any, cylinder_diameter: Any, draft: Any, stroke: Any) -> Any:
    """Water [m^3] in a shaft that holds its cylinder afloat a stroke [m] above the floor.

    (A_s - A_c) d + A_s S: what the cylinder leaves of the shaft up to its draft d, and the whole shaft below it. A
    metre of stroke takes the area of the shaft, whatever the cylinder; all of it comes from the tanks, so that the hull
    keeps its draft.
    """
    demand("a shaft", 0.0, shaft_diameter=shaft_diameter, cylinder_diameter=cylinder_diameter)
    demand("a shaft", 0.0, gap=shaft_diameter - cylinder_diameter)
    demand_not_negative("a shaft", draft=draft, stroke=stroke)
    return pi / 4 * ((shaft_diameter**2 - cylinder_diameter**2) * draft + shaft_diameter**2 * stroke)


@of_arrays
def shaft_stiffness(
    shaft_diameter: Any, cylinder_diameter: Any, water_density: Any = 1025.0, gravity: Any = 9.80665
) -> Any:
    """Stiffness [N/m] of a cylinder that floats in a shaft with a fixed volume of water: rho g A_c A_s/(A_s - A_c).

    Where it goes down, the water beside it rises: the narrower the gap, the stiffer.
    """
    demand("a shaft", 0.0, cylinder_diameter=cylinder_diameter, gap=shaft_diameter - cylinder_diameter)
    shaft, cylinder = pi / 4 * shaft_diameter**2, pi / 4 * cylinder_diameter**2
    return water_density * gravity * cylinder * shaft / (shaft - cylinder)
