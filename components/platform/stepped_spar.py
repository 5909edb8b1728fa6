"""A spar of concrete in steps, with a shaft for its tower: equations between its sizes and what it does at rest."""

from __future__ import annotations

from typing import Any

from fowtlib.components.environment.world import World
from fowtlib.components.platform.layers import (
    Layer,
    Moments,
    diameter_at,
    disc_added_inertia,
    frustum,
    plate_added_mass,
    stack,
    thinner,
    up_to,
    whole,
)
from fowtlib.language import Component, Scalar, assert_, eq, outer, param, var
from fowtlib.language import math as m


class SteppedHull(Component):
    """Partial: sizes of the hull, from the keel up: heave plate, base, cone, column; in it a shaft from plate to top.

    The plate is solid, the rest has one wall thickness, measured level. Solid ballast and, on it, water fill the ring
    between shaft and wall from the plate up. `internals` are stiffener walls and slabs, a share of the walls.
    """

    plate_diameter: Scalar = param(default=40.0, unit="m", min=0.1, doc="heave plate: diameter")
    plate_height: Scalar = param(default=2.0, unit="m", min=1e-3, doc="heave plate: thickness")
    base_diameter: Scalar = param(default=30.0, unit="m", min=0.1, doc="base: outer diameter")
    base_height: Scalar = param(default=5.0, unit="m", min=1e-3, doc="base: height")
    cone_height: Scalar = param(default=5.0, unit="m", min=1e-3, doc="height of the cone from base to column")
    column_diameter: Scalar = param(default=15.0, unit="m", min=0.1, doc="column: outer diameter")
    column_height: Scalar = param(default=70.0, unit="m", min=1e-3, doc="column: height")
    shaft_diameter: Scalar = param(default=7.0, unit="m", min=0, doc="inner diameter of the shaft")
    wall: Scalar = param(default=0.35, unit="m", min=0, doc="thickness of the walls of hull and shaft")
    concrete_density: Scalar = param(default=2500.0, unit="kg/m^3", min=1, doc="density of the reinforced concrete")
    internals: Scalar = param(default=0.0, min=0, doc="volume of stiffener walls and slabs over that of the walls")
    solid_ballast: Scalar = param(default=4e6, unit="kg", min=0, doc="mass of the solid ballast")
    ballast_density: Scalar = param(default=3000.0, unit="kg/m^3", min=1, doc="density of the solid ballast")
    water_ballast: Scalar = param(default=0.0, unit="kg", min=0, doc="mass of the water in the base")
    free_surface: Scalar = param(default=0.0, min=0, max=1, doc="moment of its surface over that of an open ring")


class RaisableSet(Component):
    """Partial: tower, nacelle and rotor; in the flooded shaft they float on a cylinder at the foot of the tower."""

    set_mass: Scalar = param(default=9.5e5, unit="kg", min=0, doc="tower, nacelle, rotor and flotation cylinder")
    set_centre: Scalar = param(default=58.0, unit="m", doc="their centre of mass above the foot of the cylinder")
    set_radius: Scalar = param(default=37.0, unit="m", min=0, doc="their radius of gyration in pitch about it")
    set_height: Scalar = param(default=52.0, unit="m", doc="foot of the flotation cylinder above the keel")
    flotation_diameter: Scalar = param(default=6.5, unit="m", min=0.1, doc="diameter of the flotation cylinder")
    flotation_height: Scalar = param(default=30.0, unit="m", min=0.1, doc="height of the flotation cylinder")


class AtRest(Component):
    """Partial: what a spar does at rest, upright in still water."""

    draft: Scalar = var(unit="m", start=60.0, min=0, doc="draft")
    displacement: Scalar = var(unit="m^3", doc="displaced volume")
    freeboard: Scalar = var(unit="m", doc="top of the column above the still water level")
    solid_level: Scalar = var(unit="m", start=5.0, doc="surface of the solid ballast above the keel")
    water_level: Scalar = var(unit="m", start=8.0, doc="surface of the water ballast above the keel")
    concrete_volume: Scalar = var(unit="m^3", doc="volume of the concrete")
    mass: Scalar = var(unit="kg", doc="mass of all")
    centre_of_mass: Scalar = var(unit="m", doc="above the keel")
    centre_of_buoyancy: Scalar = var(unit="m", doc="above the keel")
    metacentric_radius: Scalar = var(unit="m", doc="waterplane moment over displacement")
    metacentric_height: Scalar = var(unit="m", doc="GM, less free surfaces")
    pitch_inertia: Scalar = var(unit="kg*m^2", doc="moment of inertia in pitch about the centre of mass")
    heave_added_mass: Scalar = var(unit="kg", doc="added mass in heave")
    heave_stiffness: Scalar = var(unit="N/m", doc="stiffness of the waterplane")
    pitch_stiffness: Scalar = var(unit="N*m/rad", doc="stiffness in pitch, of water, weight and moorings")
    heave_period: Scalar = var(unit="s", doc="natural period in heave")
    pitch_period: Scalar = var(unit="s", doc="natural period in pitch")
    heel: Scalar = var(unit="rad", doc="mean tilt under the thrust, about the fairleads")
    flotation_capacity: Scalar = var(doc="buoyancy of the flotation cylinder over the weight of the set")


class SteppedSpar(AtRest, RaisableSet, SteppedHull):
    """A spar of steps with a raisable tower, upright in still water: any of its sizes from what it shall do at rest.

    Sizes are tunable, so that `plant.equilibrium(free=["column_diameter", ...], targets={"heave_period": 28.5, ...})`
    solves the same equations for sizes (fowtlib.design.sizing). The draft follows from masses and the vertical pull of
    the moorings. Added mass: level by strips with the coefficients given; heave by `plate_added_mass` with the column
    at the water level, which is a semi-empirical choice for a base between both (see there). Periods are those of the
    rigid body, undamped, pitch about the centre of mass with its coupling to surge.

    Valid for a draft within the column, ballast and water that the hull holds, and a metacentric height above zero:
    without it there is no period in pitch (nan). Draft and levels are checked.
    """

    mooring_pull: Scalar = param(default=0.0, unit="N", doc="vertical pull of the moorings")
    fairlead_height: Scalar = param(default=37.0, unit="m", doc="height of the fairleads above the keel")
    mooring_pitch: Scalar = param(default=0.0, unit="N*m/rad", min=0, doc="pitch stiffness of the moorings")
    thrust: Scalar = param(default=0.0, unit="N", doc="thrust of the rotor")
    hub_height: Scalar = param(default=110.0, unit="m", doc="height of the hub above the still water level")
    side_added_mass: Scalar = param(default=1.0, min=0, doc="added mass of flow across over the displaced water")
    plate_side_added_mass: Scalar = param(default=0.1, min=0, doc="the same of the plate, which is thin")

    world: World = outer(World)

    def equations(self):
        rho, g = self.world.water_density, self.world.gravity
        wet, mass = up_to(hull_layers(self), self.draft), mass_of(self)
        solid, water = fillings(self)
        waterline = diameter_at(hull_layers(self), self.draft)
        loss = self.free_surface * surface_moment(self, self.water_level)
        lever = self.hub_height + self.draft - self.fairlead_height
        capacity = rho * m.pi / 4 * self.flotation_diameter**2 * self.flotation_height
        return [
            eq(rho * self.displacement * g, self.mass * g + self.mooring_pull),
            eq(self.displacement, wet.amount),
            eq(self.freeboard, height_of(self) - self.draft),
            eq(solid.amount, self.solid_ballast / self.ballast_density),
            eq(water.amount, solid.amount + self.water_ballast / rho),
            eq(self.concrete_volume, concrete(self).amount),
            eq(self.mass, mass.amount),
            eq(self.centre_of_mass, mass.first / self.mass),
            eq(self.centre_of_buoyancy, wet.first / self.displacement),
            eq(self.metacentric_radius, m.pi / 64 * waterline**4 / self.displacement),
            eq(self.metacentric_height, self.centre_of_buoyancy + self.metacentric_radius - self.centre_of_mass
               - loss / self.displacement),
            eq(self.pitch_inertia, mass.across - self.mass * self.centre_of_mass**2),
            eq(self.heave_added_mass, plate_added_mass(self.plate_diameter, waterline, rho)),
            eq(self.heave_stiffness, rho * g * m.pi / 4 * waterline**2),
            eq(self.pitch_stiffness, rho * g * self.displacement * self.metacentric_height + self.mooring_pitch),
            eq(self.heave_period, 2 * m.pi * m.sqrt((self.mass + self.heave_added_mass) / self.heave_stiffness)),
            eq(self.pitch_period, 2 * m.pi * m.sqrt(moving_inertia(self) / self.pitch_stiffness)),
            eq(self.heel, self.thrust * lever / self.pitch_stiffness),
            eq(self.flotation_capacity, capacity / m.fmax(self.set_mass, 1.0)),
            *checks_of(self),
        ]  # fmt: skip


def hull_layers(hull: SteppedHull) -> list[Layer]:
    """Outer shape of the hull: plate, base, cone, column."""
    sides = [(size, size) for size in (hull.plate_diameter, hull.base_diameter, hull.column_diameter)]
    cone = (hull.base_diameter, hull.column_diameter)
    heights = [hull.plate_height, hull.base_height, hull.cone_height, hull.column_height]
    return stack(heights, [*sides[:2], cone, sides[2]])


def height_of(hull: SteppedHull) -> Any:
    """From keel to top [m]."""
    return hull.plate_height + hull.base_height + hull.cone_height + hull.column_height


def shaft_layer(hull: SteppedHull, walls: int) -> Layer:
    """The shaft above the plate, with its wall or (walls=0) without."""
    size = hull.shaft_diameter + 2 * walls * hull.wall
    return Layer(hull.plate_height, height_of(hull) - hull.plate_height, size, size)


def concrete(hull: SteppedHull) -> Moments:
    """The plate, and the walls of hull and shaft with their internals."""
    plate, *above = hull_layers(hull)
    walls = whole(above) - whole(thinner(above, hull.wall))
    walls = walls + frustum(*shaft_layer(hull, 1)) - frustum(*shaft_layer(hull, 0))
    return frustum(*plate) + walls.times(1 + hull.internals)


def room(hull: SteppedHull, level: Any) -> Moments:
    """The ring between shaft and wall, above the plate and below a level [m]."""
    _, *above = hull_layers(hull)
    return up_to(thinner(above, hull.wall), level) - up_to([shaft_layer(hull, 1)], level)


def surface_moment(hull: SteppedHull, level: Any) -> Any:
    """Second moment of area [m^4] of the open ring at a level."""
    _, *above = hull_layers(hull)
    outer, inner = diameter_at(thinner(above, hull.wall), level), hull.shaft_diameter + 2 * hull.wall
    return m.pi / 64 * (outer**4 - inner**4)


def fillings(spar: SteppedSpar) -> tuple[Moments, Moments]:
    """What lies below the surfaces of the solid ballast and of the water."""
    return room(spar, spar.solid_level), room(spar, spar.water_level)


def mass_of(spar: SteppedSpar) -> Moments:
    """Mass moments of concrete, ballast, water and the set."""
    solid, water = fillings(spar)
    z = spar.set_height + spar.set_centre
    parts = Moments(spar.set_mass, spar.set_mass * z, spar.set_mass * (z**2 + spar.set_radius**2), 0)
    return (
        concrete(spar).times(spar.concrete_density) + solid.times(spar.ballast_density)
        + (water - solid).times(spar.world.water_density) + parts
    )  # fmt: skip


def checks_of(spar: SteppedSpar) -> list[Any]:
    """What the equations are valid for."""
    top, foot = height_of(spar), height_of(spar) - spar.column_height
    return [
        assert_(spar.draft >= foot, "the draft of {draft} m ends below the column, which begins {foot} m above the keel"
                "; take more ballast or a smaller base", draft=spar.draft, foot=foot),
        assert_(spar.draft <= top, "it sinks: the draft would be {draft} m and its top is {top} m above the keel; take "
                "less ballast or a larger hull", draft=spar.draft, top=top),
        assert_(spar.water_level <= top, "the ballast would reach {reached} m above the keel and its top is {top} m "
                "above; take less, or a denser one", reached=spar.water_level, top=top),
    ]  # fmt: skip


def moving_inertia(spar: SteppedSpar) -> Any:
    """Moment of inertia in pitch about the centre of mass with added mass by strips, surge free to follow."""
    rho, z, layers = spar.world.water_density, spar.centre_of_mass, hull_layers(spar)
    plate = whole(layers[:1]).times(rho * spar.plate_side_added_mass)
    strips = plate + up_to(layers[1:], spar.draft).times(rho * spar.side_added_mass)
    coupling = strips.first - strips.amount * z
    about = strips.second - 2 * z * strips.first + z**2 * strips.amount
    inertia = spar.pitch_inertia + about + disc_added_inertia(spar.plate_diameter, rho)
    return inertia - coupling**2 / (spar.mass + strips.amount)
