"""Buckling of a cylinder as a column, DNV-RP-C202 (2013), section 3.8."""

from __future__ import annotations

from dataclasses import dataclass
from math import pi
from typing import Any

from fowtlib.design.rules.either import choose, demand, larger, of_arrays, smaller, sqrt
from fowtlib.design.rules.shell import elastic_strengths
from fowtlib.design.rules.steel import STEEL, Steel


@of_arrays
def column_slenderness(length: Any, radius: Any, steel: Steel = STEEL, effective_length: Any = 1.0) -> Any:
    """(k L/i)^2 over 2.5 E/f_y, i = r/sqrt(2): up to 1 a column needs no check of column buckling (3.8.1).

    length [m], radius of the middle of the wall [m], effective_length k: 1 with pinned ends, 2 with a free one.
    """
    demand("column buckling", 0.0, length=length, radius=radius, effective_length=effective_length)
    return (effective_length * length) ** 2 / (radius**2 / 2) / (2.5 * steel.youngs_modulus / steel.yield_stress)


@dataclass(frozen=True)
class ColumnBuckling:
    """Utilisation [-], slenderness [-], strength of the column f_kc and of its shell f_ak [Pa]; Euler's stress [Pa]."""

    utilisation: Any
    slenderness: Any
    strength: Any
    shell_strength: Any
    euler_stress: Any


@of_arrays
def column_buckling(
    axial_stress: Any, bending_stress: Any, radius: Any, thickness: Any, spacing: Any, length: Any, *,
    hoop_stress: Any = 0.0, steel: Steel = STEEL, effective_length: Any = 1.0, least_factor: Any = 1.15,
) -> ColumnBuckling:  # fmt: skip
    """Column buckling of a shell with rings: sigma_a0/f_kcd + sigma_m/(1 - sigma_a0/f_E)/f_akd (3.8.2).

    f_kc = (1 - 0.28 lambda^2) f_ak up to lambda = 1.34, else 0.9 f_ak/lambda^2, lambda = k L/(pi i) sqrt(f_ak/E);
    f_ak is the axial strength of the shell under its hoop stress. gamma_M goes with lambda as in shell_buckling. The
    stresses [Pa] are positive in tension, of the design loads; what is compressed counts. The branch at lambda = 1.34
    is a step of 0.8 %. Beyond 0.99 of Euler's stress the term of bending stays as it is there. Lengths [m].
    """
    demand("column buckling", 0.0, length=length, effective_length=effective_length, least_factor=least_factor)
    E, fy = steel.youngs_modulus, steel.yield_stress
    elastic = elastic_strengths(radius, thickness, spacing, steel)
    hoop = larger(-hoop_stress, 0.0)
    # the axial strength with a hoop stress: a f^2 + b f + c = 0 of 3.8.2, hoop positive in compression
    a = 1 + (fy / elastic.axial) ** 2
    b = (2 * fy**2 / (elastic.axial * elastic.hoop) - 1) * hoop
    c = hoop**2 * (1 + (fy / elastic.hoop) ** 2) - fy**2
    shell = (-b + sqrt(larger(b**2 - 4 * a * c, 0.0) + 1e-12 * fy**2)) / (2 * a)
    radius_of_gyration = radius / sqrt(2.0)
    slim = effective_length * length / (pi * radius_of_gyration)
    slenderness, euler = slim * sqrt(larger(shell, 1e-6 * fy) / E), E / slim**2
    long = larger(slenderness, 0.1)
    strength = shell * choose(slenderness <= 1.34, 1 - 0.28 * slenderness**2, 0.9 / long**2)
    factor = least_factor + 0.6 * smaller(larger(slenderness - 0.5, 0.0), 0.5)
    pressed = larger(-axial_stress, 0.0)
    left = 1 - smaller(pressed / euler, 0.99)
    bending = larger(-bending_stress, 0.0) / left
    return ColumnBuckling(factor * (pressed / strength + bending / shell), slenderness, strength, shell, euler)
