"""A point in the water where lines meet: the node of a crow-foot, a buoy, a clump weight, the free end of a line."""

from __future__ import annotations

from fowtlib.components.environment.current import Current
from fowtlib.components.environment.world import World
from fowtlib.components.mechanics.connectors import Frame
from fowtlib.components.mooring.lumped_mass import STILL
from fowtlib.language import (
    Component,
    Scalar,
    Vector,
    assert_,
    der,
    eq,
    fix_orientation,
    outer,
    param,
    port,
    quadratic,
    shapes,
    var,
)
from fowtlib.language import math as m


class LineJoint(Component):
    """A small body without attitude, held by the DynamicLines that end at its frame; it keeps the axes of the world.

    Its mass and volume may be zero: the ends of the lines have inertia. Weight less buoyancy, drag 1/2 rho C_d A |u| u
    against the current and added mass C_a rho V, the same in all directions; waves do not reach it. `position` is where
    a run starts; `equilibrium` finds where it rests. Surface and seabed do not hold it: it warns above the one, and is
    refused below the other.
    """

    mode_names = {"*": "{part} motion"}

    position: Vector = param(unit="m", doc="where it is when a run starts, world")
    mass: Scalar = param(default=0.0, unit="kg", min=0, doc="mass")
    volume: Scalar = param(default=0.0, unit="m^3", min=0, doc="displaced volume of water")
    drag_area: Scalar = param(default=0.0, unit="m^2", min=0, doc="C_d A")
    added_mass_coefficient: Scalar = param(default=0.5, min=0, doc="added mass over the displaced water; 0.5: a ball")

    world: World = outer(World)
    sea_current: Current = outer(Current, optional=True)
    frame: Frame = port(doc="where lines end")

    r: Vector = var(unit="m", start=position, state="prefer", doc="its place, world")
    v: Vector = var(unit="m/s", start=0.0, state="prefer", doc="its velocity, world", hint="do lines end at it?")

    def start_place(self):
        return self.parameter_value("position")

    def fixed_rotation(self):
        return m.eye(3)

    def equations(self):
        water, world = m.zeros(3), self.world
        if self.sea_current is not None:
            water = self.sea_current.velocities(self.r[2])[:, 0]
        displaced = world.water_density * self.volume
        inertia = self.mass + self.added_mass_coefficient * displaced
        drag = world.water_density / 2 * self.drag_area * quadratic(water - self.v, STILL)
        weight = m.vertcat(0, 0, (displaced - self.mass) * world.gravity)
        return [
            eq(der(self.r), self.v),
            eq(self.frame.r, self.r),
            fix_orientation(self.frame, m.eye(3), m.zeros(3)),
            eq(self.frame.f, inertia * der(self.v) - drag - weight),
            assert_(self.r[2] <= 0, "the joint comes out of the water, to z = {z} m", "warning", z=self.r[2]),
            assert_(self.r[2] >= -world.water_depth, "the joint is at z = {z} m, below the seabed", z=self.r[2]),
        ]

    def drawing(self) -> shapes.Drawing:
        return [shapes.Ball(self.frame, (0, 0, 0), material="line")]
