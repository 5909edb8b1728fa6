"""Strength of mooring lines, and the offset at which one would lift its anchor."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from fowtlib.design.rules.either import (
    asinh,
    choose,
    cosh,
    demand,
    is_expression,
    larger,
    of_arrays,
    sinh,
    smaller,
    sqrt,
)


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


@dataclass(frozen=True)
class HangingLine:
    """A line between its anchor and its fairlead: horizontal and vertical tension at the top [N].

    vertical_stiffness: how the vertical one grows with the height of the fairlead over a fixed anchor [N/m].
    """

    horizontal: Any
    vertical: Any
    vertical_stiffness: Any


NEWTON = 25  # iterations; from a line that is nearly straight they are many


@of_arrays
def hanging_line(length: Any, weight: Any, axial_stiffness: Any, height: Any, distance: Any) -> HangingLine:
    """Tensions at the top of an elastic line that lies on the seabed at its anchor, without friction there.

    With the suspended length l = V/w: height h = H/w (sqrt(1 + (V/H)^2) - 1) + V^2/(2 w EA) and distance X = L - l +
    H/w asinh(V/H) + H L/EA, by Newton's method from a line without stretch. length, unstretched, L [m]; weight in water
    w [N/m]; axial_stiffness EA [N]; height of the fairlead above the anchor, distance [m]. A line that hangs as a whole
    (l > L) is refused; of expressions V is then above w L.
    """
    demand("a line", 0.0, length=length, weight=weight, axial_stiffness=axial_stiffness, height=height)
    demand("a line", 0.0, distance=distance, slack=length - distance + height)
    # without stretch (L - X)/h = (sinh u - u)/(cosh u - 1), u = asinh(V/H), which is nearly u/3
    u = smaller(larger(3 * (length - distance) / height, 0.2), 3.0)
    H = weight * height / (cosh(u) - 1)
    V = H * sinh(u)
    for _ in range(NEWTON):
        root = sqrt(H**2 + V**2)
        f = (root - H) / weight + V**2 / (2 * weight * axial_stiffness) - height
        g = length - V / weight + H / weight * asinh(V / H) + H * length / axial_stiffness - distance
        fH, fV = (H / root - 1) / weight, V / root / weight + V / (weight * axial_stiffness)
        gH = (asinh(V / H) - V / root) / weight + length / axial_stiffness
        gV = (H / root - 1) / weight
        det = fH * gV - fV * gH
        dH, dV = (f * gV - fV * g) / det, (fH * g - gH * f) / det
        H, V = larger(H - dH, H / 3), larger(V - dV, V / 3)
    if not is_expression(V):
        demand("a line on the seabed", 0.0, length_on_the_seabed=length - V / weight)
    return HangingLine(H, V, -gH / det)
