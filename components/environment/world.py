"""The world: gravity, the fluids, and the frame that everything is measured from."""

from __future__ import annotations

from fowtlib.components.mechanics.connectors import Frame
from fowtlib.language import Component, Number, Scalar, eq, fix_orientation, param, port
from fowtlib.language import math as m


class World(Component):
    """Gravity, water and air, and the inertial frame at the still water level: x downwind, y to port, z up.

    Declared once at the top of a model; parts find it by `world: World = outer(World)`. Gravity and water depth are
    structural, because the numbers of the waves are computed from them when the model is built; the densities may be
    changed in a built model.
    """

    gravity: Number = param(default=9.80665, unit="m/s^2", min=0, doc="gravity, along -z")
    water_depth: Number = param(default=320.0, unit="m", min=0, doc="depth of the water below z = 0")
    water_density: Scalar = param(default=1025.0, unit="kg/m^3", min=0, doc="density of the water")
    air_density: Scalar = param(default=1.225, unit="kg/m^3", min=0, doc="density of the air")

    frame: Frame = port(optional=True, doc="fixed frame at the still water level; it carries any load")

    def fixed_rotation(self):
        return m.eye(3)

    def start_place(self):
        return (0.0, 0.0, 0.0)

    def equations(self):
        return [eq(self.frame.r, m.zeros(3)), fix_orientation(self.frame, m.eye(3), m.zeros(3))]
