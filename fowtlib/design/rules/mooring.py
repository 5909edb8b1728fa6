"""Strength of mooring lines, and the offset at which one would lift its anchor."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from fowtlib.design.rules.either import asinh, choose, demand, of_arrays, sqrt


@dataclass(frozen=True)
class MooringStrength:
    """Utilisation [-], design tension and design strength [N]."""

    utilisation: Any
    tension: Any
    strength: Any


@of_arrays
def mooring_strength(
    mean_tension: Any, dynamic_tension: Any, breaking_strength: Any, *, mean_factor: Any = 1.3,
    dynamic_factor: Any = 1.75, strength_factor: Any = 0.95,
) -> MooringStrength:  # fmt: skip
    """Design tension 1.3 T_mean + 1.75 T_dyn over 0.95 of the breaking strength; DNV-OS-J103, DNVGL-ST-0119.

    mean_tension [N]: characteristic mean; dynamic_tension [N]: characteristic largest less mean; breaking_strength [N]:
    minimum, of the catalogue. The factors are those of the ultimate limit state, consequence class 1; class 2: 1.5
    and 2.2.
    """
    demand("mooring strength", 0.0, breaking_strength=breaking_strength, strength_factor=strength_factor)
    tension = mean_factor * mean_tension + dynamic_factor * dynamic_tension
    strength = strength_factor * breaking_strength
    return MooringStrength(tension / strength, tension, strength)


@dataclass(frozen=True)
class UpliftLimit:
    """The line that just lifts its anchor: offset [m] and horizontal tension [N]; top tension [N]; distance [m]."""

    offset: Any
    horizontal_tension: Any
    top_tension: Any
    distance: Any


@of_arrays
def uplift_limit(
    length: Any, weight: Any, axial_stiffness: Any, height: Any, distance: Any
) -> UpliftLimit:
    """Offset of a fairlead away from its anchor at which the whole line hangs, so that it pulls its anchor up beyond.

    An elastic catenary with its lower end horizontal at the anchor has H = w (L^2 - h^2)/(2 h), h the height less
    w L^2/(2 EA), and reaches H/w asinh(w L/H) + H L/EA. length, unstretched, L [m]; weight in water [N/m];
    axial_stiffness EA [N]; height of the fairlead above the anchor [m]; distance [m]: horizontal, at zero offset.
    A line that hangs as a whole at any tension (h not above 0, or L below h) is refused; as an expression its offset is
    -distance or less.
    """
    demand("uplift", 0.0, length=length, weight=weight, axial_stiffness=axial_stiffness, height=height)
    low = height - weight * length**2 / (2 * axial_stiffness)
    demand("uplift", 0.0, height_less_stretch=low, length_less_height=length - low)
    possible = low > 0
    low = choose(possible, low, height)
    horizontal = weight * (length**2 - low**2) / (2 * low)
    reach = horizontal / weight * asinh(weight * length / horizontal) + horizontal * length / axial_stiffness
    reach = choose(possible, reach, 0.0)
    return UpliftLimit(reach - distance, horizontal, sqrt(horizontal**2 + (weight * length) ** 2), reach)
