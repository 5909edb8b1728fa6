"""Support structures: towers, arms for several rotors, and the stresses by which they are sized."""

from fowtlib.components.support.arm import Arm, ArmLoads
from fowtlib.components.support.sizing import TubeStress, WireStress
from fowtlib.components.support.tower import FlexibleTower, RigidTower, Tower

__all__ = ["Arm", "ArmLoads", "FlexibleTower", "RigidTower", "Tower", "TubeStress", "WireStress"]
