"""Support structures: towers, and arms for several rotors."""

from fowtlib.components.support.arm import Arm, ArmLoads
from fowtlib.components.support.tower import FlexibleTower, RigidTower, Tower

__all__ = ["Arm", "ArmLoads", "FlexibleTower", "RigidTower", "Tower"]
