"""Support structures: towers, arms for several rotors, foundations, and the stresses by which they are sized."""

from fowtlib.components.support.arm import Arm, ArmLoads
from fowtlib.components.support.foundation import CoupledSpring, Foundation
from fowtlib.components.support.pile import Pile, PileInClay, PileInLinearSoil, PileInSand
from fowtlib.components.support.sizing import TubeStress, WireStress
from fowtlib.components.support.soil_springs import ClaySpring, LinearSoilSpring, SandSpring, SoilSpring
from fowtlib.components.support.tower import FlexibleTower, RigidTower, Tower

__all__ = [
    "Arm",
    "ArmLoads",
    "ClaySpring",
    "CoupledSpring",
    "FlexibleTower",
    "Foundation",
    "LinearSoilSpring",
    "Pile",
    "PileInClay",
    "PileInLinearSoil",
    "PileInSand",
    "RigidTower",
    "SandSpring",
    "SoilSpring",
    "Tower",
    "TubeStress",
    "WireStress",
]
