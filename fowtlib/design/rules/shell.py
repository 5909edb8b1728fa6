"""Buckling of a cylindrical shell between its ring frames, DNV-RP-C202 (2013), sections 2.2, 3.1, 3.2 and 3.4.

Stresses are positive in tension. Pressure is positive from outside. The radius is that of the middle of the wall.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import pi
from typing import Any

from fowtlib.design.rules.either import choose, cos, demand, exp, larger, of_arrays, sin, smaller, sqrt
from fowtlib.design.rules.steel import STEEL, Steel


@of_arrays
def cylinder_stress(
    radius: Any, thickness: Any, axial_force: Any = 0.0, bending_moment: Any = 0.0, shear_force: Any = 0.0,
    torsion: Any = 0.0,
) -> tuple[Any, Any, Any]:  # fmt: skip
    """Membrane stresses (axial, bending, shear) [Pa] of a thin tube.

    N/(2 pi r t), M/(pi r^2 t), T/(2 pi r^2 t) + Q/(pi r t). axial_force [N], positive in tension; bending_moment [N m],
    of the sign that its stress shall have; shear_force [N],
    torsion [N m]: their greatest shears are added, which is on the safe side. Source: RP-C202, 2.2.2 to 2.2.4.
    """
    demand("a tube", 0.0, radius=radius, thickness=thickness, radius_inside=radius - thickness / 2)
    wall = pi * radius * thickness
    shear = torsion / (2 * wall * radius) + shear_force / wall
    return axial_force / (2 * wall), bending_moment / (wall * radius), shear


@dataclass(frozen=True)
class HoopStress:
    """Hoop stress between rings and at the flange of a ring [Pa]; effective width of shell at a ring l_eo [m]."""

    between: Any
    at_ring: Any
    effective_width: Any


@of_arrays
def hoop_stress(
    external_pressure: Any, longitudinal_stress: Any, radius: Any, thickness: Any, spacing: Any, ring_area: Any,
    flange_radius: Any, steel: Steel = STEEL,
) -> HoopStress:  # fmt: skip
    """Hoop stress of a shell with rings under pressure; source: RP-C202, 2.2.6 to 2.2.8.

    With q = -p r/t and alpha = A_R/(l_eo t): between rings q - alpha zeta/(1 + alpha) (q - nu sigma_x), at the flange
    of a ring (q - nu sigma_x)/(1 + alpha) r/r_f. zeta, of beta = l/(1.56 sqrt(r t)), is not below 0 (a kink near beta =
    3 pi/4). external_pressure [Pa]; longitudinal_stress [Pa]; spacing l of the rings, flange_radius r_f [m];
    ring_area A_R [m^2] without shell.
    """
    demand("hoop stress", 0.0, radius=radius, thickness=thickness, spacing=spacing, flange_radius=flange_radius)
    beta = spacing / (1.56 * sqrt(radius * thickness))
    e = exp(-2 * beta)  # hyperbolic functions over exp(2 beta), which do not overflow for rings far apart
    below = 1 - e**2 + 2 * e * sin(2 * beta)
    zeta = larger(2 * exp(-beta) * (cos(beta) + sin(beta) + e * (sin(beta) - cos(beta))) / below, 0.0)
    width = spacing / beta * (1 + e**2 - 2 * e * cos(2 * beta)) / below
    alpha = ring_area / (width * thickness)
    q = -external_pressure * radius / thickness
    held = (q - steel.poissons_ratio * longitudinal_stress) / (1 + alpha)
    return HoopStress(q - alpha * zeta * held, held * radius / flange_radius, width)


@dataclass(frozen=True)
class ElasticStrength:
    """Elastic buckling strengths [Pa] of a shell: axial, bending, shear, hoop."""

    axial: Any
    bending: Any
    shear: Any
    hoop: Any


@of_arrays
def elastic_strengths(
    radius: Any, thickness: Any, spacing: Any, steel: Steel = STEEL, end_pressure: bool = False
) -> ElasticStrength:
    """Elastic buckling strengths f_E = C pi^2 E/(12 (1 - nu^2)) (t/l)^2, C = psi sqrt(1 + (rho xi/psi)^2); 3.4.2.

    xi and rho of table 3-2, of Z = l^2/(r t) sqrt(1 - nu^2). Long shells have the greater strengths that the standard
    gives them, from l/r = 3.85 sqrt(r/t) (shear) and 2.25 sqrt(r/t) (pressure) on: steps of 9 and 2 % upward.
    end_pressure: the pressure acts on the ends too, and its axial stress is not in that of the load.
    """
    demand("shell buckling", 0.0, radius=radius, thickness=thickness, spacing=spacing,
           radius_inside=radius - thickness / 2)  # fmt: skip
    E, nu = steel.youngs_modulus, steel.poissons_ratio
    Z, slim = spacing**2 / (radius * thickness) * sqrt(1 - nu**2), radius / thickness
    plate = pi**2 * E / (12 * (1 - nu**2)) * (thickness / spacing) ** 2

    def strength(psi: float, xi: Any, rho: Any) -> Any:
        return plate * psi * sqrt(1 + (rho * xi / psi) ** 2)

    shear = strength(5.34, 0.856 * sqrt(sqrt(Z)) * sqrt(Z), 0.6)
    hoop = strength(2.0 if end_pressure else 4.0, 1.04 * sqrt(Z), 0.6)
    length = spacing / radius / sqrt(slim)
    return ElasticStrength(
        strength(1.0, 0.702 * Z, 0.5 / sqrt(1 + slim / 150)),
        strength(1.0, 0.702 * Z, 0.5 / sqrt(1 + slim / 300)),
        choose(length > 3.85, 0.25 * E / (slim * sqrt(slim)), shear),
        choose(length > 2.25, 0.25 * E / slim**2, hoop),
    )


@dataclass(frozen=True)
class ShellBuckling:
    """Utilisation [-], reduced slenderness [-], material factor [-], von Mises stress and strength f_ks [Pa], f_E."""

    utilisation: Any
    slenderness: Any
    material_factor: Any
    stress: Any
    strength: Any
    elastic: ElasticStrength


@of_arrays
def shell_buckling(
    axial_stress: Any, bending_stress: Any, radius: Any, thickness: Any, spacing: Any, *, hoop_stress: Any = 0.0,
    shear_stress: Any = 0.0, steel: Steel = STEEL, least_factor: Any = 1.15, end_pressure: bool = False,
) -> ShellBuckling:  # fmt: skip
    """Shell buckling between ring frames: gamma_M sigma_j / f_ks.

    f_ks = f_y/sqrt(1 + lambda^4), lambda^2 = f_y/sigma_j (sigma_a0/f_Ea + sigma_m0/f_Em + sigma_h0/f_Eh + tau/f_Etau),
    of the compressive parts; sigma_j the von Mises stress. gamma_M rises from `least_factor` below lambda = 0.5 by 0.3
    to lambda = 1 (3.1; kinks there): 1.15 in RP-C202, 1.10 for floating wind turbines in DNVGL-ST-0119.
    All stresses [Pa] are those of the design loads; of the bending stress the compressed side (negative) is to be
    checked, and the other one too where the hoop is compressed. spacing [m]: of the rings. Derivatives by a stress
    do not exist where it changes its sign. Validity: tubes with D/t above 60; thicker ones are no shells.
    """
    demand("shell buckling", 0.0, least_factor=least_factor)
    elastic = elastic_strengths(radius, thickness, spacing, steel, end_pressure)
    x, h, tau = axial_stress + bending_stress, hoop_stress, shear_stress
    square = x**2 - x * h + h**2 + 3 * tau**2

    def pressed(stress: Any) -> Any:
        return larger(-stress, 0.0)

    shear = sqrt(tau**2 + (1e-9 * steel.yield_stress) ** 2)  # |tau| with a derivative
    share = pressed(axial_stress) / elastic.axial + pressed(bending_stress) / elastic.bending
    share = share + pressed(h) / elastic.hoop + shear / elastic.shear
    fy = steel.yield_stress
    stress = sqrt(square + (1e-9 * fy) ** 2)
    slenderness = sqrt(fy * share / stress + 1e-12)
    factor = least_factor + 0.6 * smaller(larger(slenderness - 0.5, 0.0), 0.5)
    utilisation = factor * sqrt(square / fy**2 + share**2 + 1e-18)  # sigma_j/f_ks without a division by sigma_j
    return ShellBuckling(utilisation, slenderness, factor, stress, fy / sqrt(1 + slenderness**4), elastic)
