"""Buckling of a tower under axial force and bending, EN 1993-1-6 (2007), section 8.5 and annex D.1.2."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from fowtlib.design.rules.either import choose, demand, demand_within, larger, of_arrays, smaller, sqrt
from fowtlib.design.rules.steel import STEEL, Steel
from fowtlib.language.errors import ModelError

QUALITY = {"A": 40.0, "B": 25.0, "C": 16.0}
"""Fabrication quality parameter Q of the tolerance classes: A excellent, B high, C normal (table D.2)."""


@dataclass(frozen=True)
class TowerBuckling:
    """Utilisation [-], relative slenderness [-], reduction chi [-], critical stress [Pa], imperfection factor [-]."""

    utilisation: Any
    slenderness: Any
    reduction: Any
    critical_stress: Any
    imperfection: Any


@of_arrays
def tower_buckling(
    meridional_stress: Any, radius: Any, thickness: Any, length: Any, *, steel: Steel = STEEL, quality: str = "B",
    material_factor: Any = 1.1, fixity: float = 6.0,
) -> TowerBuckling:  # fmt: skip
    """Meridional buckling of a cylinder between two stiffened edges: sigma_x gamma_M1/(chi f_y).

    omega = l/sqrt(r t); sigma_Rcr = 0.605 E C_x t/r, C_x = 1.36 - 1.83/omega + 2.07/omega^2 (short, omega <= 1.7), 1,
    or max(0.6, 1 + 0.2/C_xb (1 - 2 omega t/r)) (long, omega > r/(2 t)); imperfection alpha = 0.62/(1 + 1.91
    (sqrt(r/t)/Q)^1.44); chi of lambda = sqrt(f_y/sigma_Rcr): 1 up to 0.2, then 1 - 0.6 (lambda - 0.2)/(lambda_p - 0.2),
    from lambda_p = sqrt(alpha/0.4) on alpha/lambda^2. Branches with kinks at 0.2 and lambda_p; C_x has a step of 0.02 %
    at 1.7. meridional_stress [Pa], of the design loads, positive in tension; a tensile one has utilisation 0. length
    [m]: of the section between stiffened edges. quality: tolerance class; fixity C_xb: 6 both ends clamped, 3 one, 1
    none. A conical section counts as a cylinder of its mean radius. Validity: r/t from 20 to 5000.
    """
    if quality not in QUALITY:
        raise ModelError(f"tower buckling: quality '{quality}' is no tolerance class; there are A, B and C.")
    demand("tower buckling", 0.0, radius=radius, thickness=thickness, length=length)
    demand_within("tower buckling", 20, 5000, "EN 1993-1-6", radius_over_thickness=radius / thickness)
    slim, omega = radius / thickness, length / sqrt(radius * thickness)
    short = 1.36 - 1.83 / omega + 2.07 / omega**2
    long = larger(1 + 0.2 / fixity * (1 - 2 * omega / slim), 0.6)
    C = choose(omega <= 1.7, short, choose(omega > slim / 2, long, 1.0))
    critical = 0.605 * steel.youngs_modulus * C / slim
    slenderness = sqrt(steel.yield_stress / critical)
    imperfection = 0.62 / (1 + 1.91 * (sqrt(slim) / QUALITY[quality]) ** 1.44)
    squat, plastic = 0.2, sqrt(imperfection / 0.4)
    plain = 1 - 0.6 * smaller(larger((slenderness - squat) / (plastic - squat), 0.0), 1.0)
    reduction = choose(slenderness < plastic, plain, imperfection / slenderness**2)
    pressed = larger(-meridional_stress, 0.0)
    return TowerBuckling(material_factor * pressed / (reduction * steel.yield_stress), slenderness, reduction, critical,
                         imperfection)  # fmt: skip
