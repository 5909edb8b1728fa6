"""Properties of mooring chain by the diameter of its bar: numbers, arrays and expressions alike, SI units.

Sources: weight and stiffness as in J.M. Hegseth et al., Marine Structures 72 (2020) 102771, eq. 46-47, near those of
stud link chain; strength of DNV-OS-E302, as a function of the diameter.
"""

from __future__ import annotations

import math
from typing import Any

from fowtlib.components.mooring.mooring_system import MooringSystem
from fowtlib.language import Array, Scalar, like, param
from fowtlib.language.errors import ParameterError

WEIGHT, STIFFNESS = 187.5e3, 90e9
"""Weight in water [N/m] and axial stiffness [N] over the square of the diameter [m^2]."""
GRADES = {"R3": 22.3, "R3S": 24.9, "R4": 27.4, "R4S": 30.4, "R5": 32.0}
"""Strength factor c by grade, for N and mm."""
STEEL, SEA, GRAVITY = 7850.0, 1025.0, 9.80665
LARGEST = 0.22
"""Diameter [m] up to which there is chain; the formula of the strength turns down at 0.37 m."""


def weight_in_water(diameter: Any, factor: Any = WEIGHT) -> Any:
    """Weight in sea water per length [N/m], factor D^2; of stud link chain 0.1875 N/m by the square of millimetres."""
    return factor * diameter**2


def mass(diameter: Any, factor: Any = WEIGHT) -> Any:
    """Mass in air per length [kg/m] of steel with this weight in sea water."""
    return weight_in_water(diameter, factor) / (GRAVITY * (1 - SEA / STEEL))


def bar_diameter(diameter: Any, factor: Any = WEIGHT) -> Any:
    """Diameter [m] of a bar that displaces the same water, in proportion to that of the chain."""
    return diameter * (mass(1.0, factor) * 4 / (math.pi * STEEL)) ** 0.5


def axial_stiffness(diameter: Any, factor: Any = STIFFNESS) -> Any:
    """Axial stiffness EA [N], factor D^2."""
    return factor * diameter**2


def breaking_load(diameter: Any, grade: str = "R4") -> Any:
    """Minimum breaking load [N], c D^2 (44 - 0.08 D) with D in millimetres, of a new chain."""
    if grade not in GRADES:
        raise ParameterError(f"grade '{grade}' of chain: there are {', '.join(GRADES)}.")
    thick = 1e3 * diameter
    return GRADES[grade] * thick**2 * (44 - 0.08 * thick)


class ChainMooring(MooringSystem):
    """Mooring of chain: the lines of a MooringSystem with the properties of a chain by its diameter and grade.

    Mass, stiffness, displacement and breaking load follow from chain_diameter, also where that is changed between runs
    or differentiated by; one that is given takes its place. Formulas: fowtlib.components.mooring.chain.
    """

    chain_diameter: Scalar = param(unit="m", min=0.01, max=LARGEST, doc="diameter of the bar of the chain")
    grade: str = param(default="R4", choices=tuple(GRADES), doc="grade of its steel")
    weight_factor: Scalar = param(default=WEIGHT, unit="N/m^3", min=0, doc="weight in water over diameter squared")
    stiffness_factor: Scalar = param(default=STIFFNESS, unit="N/m^2", min=0, doc="EA over diameter squared")

    axial_stiffness: Array = like(
        MooringSystem.axial_stiffness, default=lambda self: axial_stiffness(self.chain_diameter, self.stiffness_factor)
    )
    mass_per_length: Array = like(
        MooringSystem.mass_per_length, default=lambda self: mass(self.chain_diameter, self.weight_factor)
    )
    diameter: Array = like(
        MooringSystem.diameter, default=lambda self: bar_diameter(self.chain_diameter, self.weight_factor)
    )
    breaking_load: Array = like(
        MooringSystem.breaking_load, default=lambda self: breaking_load(self.chain_diameter, self.grade)
    )
