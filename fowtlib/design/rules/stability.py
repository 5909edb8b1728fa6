"""Stability of a floater upright in still water: righting moment, the areas below its curve, heel, acceleration."""

from __future__ import annotations

from math import pi
from typing import Any

from fowtlib.design.rules.either import cos, demand, demand_not_negative, log, of_arrays, sin, sqrt, tan

LARGEST_HEEL = pi / 3
"""Beyond 60 degrees no hull is wall-sided."""


@of_arrays
def righting_arm(heel: Any, metacentric_height: Any, metacentric_radius: Any) -> Any:
    """GZ = sin(heel) (GM + BM/2 tan^2(heel)) [m] of a hull with walls that are upright about the water; heel [rad].

    Source: J.N. Newman, Marine Hydrodynamics (1977); the wall-sided formula of naval architecture.
    """
    demand_upright(heel)
    return sin(heel) * (metacentric_height + metacentric_radius / 2 * tan(heel) ** 2)


@of_arrays
def stability_area_ratio(
    weight: Any, metacentric_height: Any, metacentric_radius: Any, thrust: Any, lever: Any, until: Any
) -> Any:
    """Area below the righting moment over that below the wind's, from upright to a heel `until` [rad].

    weight [N]: of the displaced water; the moment of the wind is thrust [N] times lever [m] times cos^2. To be 1.30 at
    least, `until` the second intercept of both curves or the angle at which water comes in, whichever is less (IMO MODU
    Code, 3.3.1, for column-stabilised units; of spars it is a designer's choice). Both integrals are exact:
    W (GM (1 - cos) + BM/2 (1/cos + cos - 2)) and F l (until/2 + sin(2 until)/4).
    """
    demand("the area criterion", 0.0, weight=weight, thrust=thrust, lever=lever, until=until)
    demand_upright(until)
    c = cos(until)
    righting = weight * (metacentric_height * (1 - c) + metacentric_radius / 2 * (1 / c + c - 2))
    return righting / (thrust * lever * (until / 2 + sin(2 * until) / 4))


@of_arrays
def static_heel(thrust: Any, lever: Any, weight: Any, metacentric_height: Any, mooring_stiffness: Any = 0.0) -> Any:
    """Mean tilt [rad] = F l/(W GM + C_m), small angles: thrust [N] at a lever [m] above where the mooring holds.

    weight [N]: of the displaced water; mooring_stiffness: in pitch [N m/rad].
    """
    demand("a heel", 0.0, weight=weight)
    stiffness = weight * metacentric_height + mooring_stiffness
    demand("a heel", 0.0, pitch_stiffness=stiffness)
    return thrust * lever / stiffness


@of_arrays
def nacelle_acceleration(
    surge_acceleration: Any, pitch_acceleration: Any, pitch: Any, lever: Any, gravity: Any = 9.80665
) -> Any:
    """Fore-aft acceleration that a nacelle feels [m/s^2]: surge + lever pitch'' + g sin(pitch).

    lever [m]: of the nacelle above where surge is measured. A guideline of many turbines is 0.3 g at most.
    """
    return surge_acceleration + lever * pitch_acceleration + gravity * sin(pitch)


@of_arrays
def highest_wave_ratio(waves: Any) -> Any:
    """H_max over H_s that so many waves have most probably, sqrt(ln(N)/2): 1.86 for the 1000 of three hours.

    Of Rayleigh's distribution (M.S. Longuet-Higgins, J. Mar. Res. 11, 1952). A realisation of three hours whose highest
    wave is less is no sample for extremes.
    """
    demand("a highest wave", 1.0, waves=waves)
    return sqrt(log(waves) / 2)


def demand_upright(heel: Any) -> None:
    """ModelError for a heel below zero, or beyond which the wall-sided formula means nothing."""
    demand_not_negative("a wall-sided hull", heel=heel)
    demand_not_negative("a wall-sided hull", up_to_60_degrees=LARGEST_HEEL - heel)
