"""Support structures: towers."""

from fowtlib.components.support.tower import FlexibleTower, RigidTower

__all__ = ["FlexibleTower", "RigidTower"]
