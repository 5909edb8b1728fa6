"""A steady current: the same at all depths, or by a power of the height above the seabed."""

from __future__ import annotations

from typing import Any

import casadi as ca

from fowtlib.components.environment.world import World
from fowtlib.language import Component, Scalar, assert_, outer, param, shapes
from fowtlib.language import math as m

LEAST = 1e-3
"""Share of the water depth, from the seabed on, below which the current is that at this height."""


class Current(Component):
    """Level, steady flow of the sea, u(z) = speed (1 + z / h)^exponent down to the seabed; at z > 0 that of z = 0.

    An exponent of 0 is a uniform current, 1/7 that of tides (DNV-RP-C205, 2010, 4.1.4.2). Drag finds it
    by `sea_current: Current = outer(Current, optional=True)`: it adds to the velocity of the waves there, in runs, in
    the mean position and, linearised about it, in linear models. A model without one has no terms of it.
    Waves are not changed by it, nor is the potential flow around a hull, whose wave drift would be.
    """

    speed: Scalar = param(default=0.0, unit="m/s", doc="speed at the still water level")
    direction: Scalar = param(default=0.0, unit="rad", doc="direction towards which it flows, from x towards y")
    exponent: Scalar = param(default=0.0, min=0, doc="of the height above the seabed; 0: uniform, 1/7: tides")

    world: World = outer(World)

    def equations(self):
        said = "the current is {speed} m/s; no current of the sea is faster than 10 m/s"
        return [assert_(m.abs(self.speed) <= 10, said, speed=self.speed)]

    def drawing(self) -> shapes.Drawing:
        return []

    def velocities(self, heights: Any) -> Any:
        """Velocities (3, n) [m/s], world, at heights (n,) [m] above the still water level; inside equations()."""
        z = ca.vec(ca.densify(ca.SX(heights))).T
        above = ca.fmax(ca.fmin(1 + z / self.world.water_depth, 1), LEAST)
        size = self.speed * above**self.exponent
        return ca.vertcat(size * m.cos(self.direction), size * m.sin(self.direction), ca.SX.zeros(1, z.shape[1]))


def with_current(water: Any, current: Current | None, heights: Any) -> Any:
    """Velocities (n, 3) of the water in waves at heights (n,), and of the current there, if there is one."""
    return water if current is None else water + current.velocities(heights).T
