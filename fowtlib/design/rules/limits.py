"""Limits of motion, periods and shape, and the simple quantities that they are put on."""

from __future__ import annotations

from collections.abc import Sequence
from math import pi
from typing import Any

from fowtlib.design.rules.either import atan, cos, demand, of_arrays, size, sqrt


@of_arrays
def at_most(value: Any, limit: Any) -> Any:
    """|value|/limit: of a tilt, an offset, an acceleration; a kink at 0.

    Usual for floating turbines: tilt 15 degrees in a storm, mean and dynamic; offset a tenth of the water depth.
    """
    demand("a limit", 0.0, limit=limit)
    return size(value) / limit


@of_arrays
def at_least(value: Any, limit: Any) -> Any:
    """limit/value, of what must not be less than a limit, such as a heave period of 25 s; value above 0."""
    demand("a lower limit", 0.0, value=value)
    return limit / value


@of_arrays
def rigid_period(mass: Any, added_mass: Any, stiffness: Any) -> Any:
    """Natural period [s] of one motion alone, 2 pi sqrt((M + A)/C); kg, kg, N/m, or kg m^2, kg m^2, N m/rad."""
    demand("a period", 0.0, mass=mass, stiffness=stiffness)
    return 2 * pi * sqrt((mass + added_mass) / stiffness)


@of_arrays
def heave_period(
    mass: Any, keel_diameter: Any, waterline_diameter: Any, water_density: Any = 1025.0, gravity: Any = 9.80665,
    mooring_stiffness: Any = 0.0,
) -> Any:  # fmt: skip
    """Natural period [s] of a spar in heave: added mass rho D_b^3/3 of its keel disc, stiffness rho g pi D^2/4.

    mass [kg] of what moves, without lines that hang from it; diameters [m]; mooring_stiffness [N/m] of the lines, in
    heave. The disc is that of a body with water on both sides (DNV-RP-C205, appendix D, table D-2).
    """
    added = water_density * keel_diameter**3 / 3
    stiffness = water_density * gravity * pi * waterline_diameter**2 / 4 + mooring_stiffness
    return rigid_period(mass, added, stiffness)


@of_arrays
def period_ratio(
    first: Any, second: Any, apart_from: Sequence[float] = (0.5, 1.0, 1.5, 2.0), margin: float = 0.1
) -> tuple[Any, ...]:
    """Utilisations, one for each of `apart_from`, of two periods whose ratio must stay `margin` away from it.

    Heave over pitch of a spar: near these ratios, waves of the sum of both let pitch grow by itself (Mathieu; H.A.
    Haslum and O.M. Faltinsen, OTC 10953, 1999). 2 - |first/second - ratio|/margin: 1 at the margin, 2 in the middle,
    where it has a kink.
    """
    demand("a ratio of periods", 0.0, first=first, second=second, margin=margin)
    return tuple(2 - size(first / second - ratio) / margin for ratio in apart_from)


@of_arrays
def taper_utilisation(
    lower_diameter: Any, upper_diameter: Any, length: Any, limit: Any = pi / 18
) -> Any:
    """Half angle of a cone [rad], atan(|D_2 - D_1|/(2 L)), over its limit [rad]; a kink at a cylinder."""
    demand("a taper", 0.0, length=length, limit=limit)
    return atan(size(upper_diameter - lower_diameter) / (2 * length)) / limit


@of_arrays
def power_lost_by_tilt(tilt: Any) -> Any:
    """Share of the power that a rotor tilted by so much [rad] does not take, 1 - cos^3."""
    return 1 - cos(tilt) ** 3
