"""A tank on a frame: water with a level surface, whose mass, centre and inertia follow from volume and tilt."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from fowtlib.components.flooding import air_space, columns, sloshing, water_loads
from fowtlib.components.flooding.air_space import TrappedAir
from fowtlib.components.flooding.columns import MovingColumns
from fowtlib.components.flooding.connectors import Water
from fowtlib.components.flooding.sections import Contents, Cornered, Wedge
from fowtlib.components.flooding.sloshing import FirstMode
from fowtlib.components.flooding.water_loads import WaterOnFrame
from fowtlib.language import Array, Scalar, Vector, assert_, der, eq, facts, param, port, var
from fowtlib.language import math as m

STEEPEST = 80.0  # deg, of the axis of a tank against the vertical
MARGIN = 1e-6  # of the height of a tank: what Newton and rounding may leave above its roof, or below its floor
DRY = 2e-3  # m, by which a port may be above the water while water leaves through it
SEEPING = 1e-6  # m/s on the section of the tank: what may leave through a dry port
LEAST = 1e-4  # of the capacity of a tank, to which its level takes it as filled at least, and as empty


class Tank(WaterOnFrame, TrappedAir, FirstMode, MovingColumns):
    """Partial: a tank whose axis is the z axis of its frame, with `place` the middle of its floor.

    State: the volume of water. Its surface is level in the world, whatever the body does, and mass, centre and inertia
    are those of the water below that plane: the loss of stability by a free surface comes out and is no correction.
    Ports lie at `places` on the wall. Head at a port: the surface, or the port itself while it lies above the surface,
    plus the pressure of the air over rho g. Water may come in through a dry port, and none may leave.

    Loads on the frame, in its axes, a: acceleration of its origin less gravity, w: angular velocity, c: centre, J:
    inertia about the origin, p: ports, Q: flows in. The momentum of the water relative to the tank is P = d(m c)/dt -
    rho sum(Q p); force = m a + w' x m c + w x (w x m c) + 2 w x P, moment = m c x a + J w' + w x J w + J' w - rho sum(Q
    p x (w x p)) + w x (c x P). Kept are all terms of a flow that is steady relative to the tank: what comes in has the
    velocity of its port, the Coriolis loads of what flows inside, and the change of inertia. Left out are d(P)/dt in
    the tank (pressures by which the flow itself speeds up, of the order of m dQ/dt / area), jets, and the rotation of
    the water relative to the tank. Pressures at ports are those in the world's gravity, not in that of a tank that
    accelerates, unless it has `flow_inertia`: then both are there, see fowtlib.components.flooding.columns.
    With `sloshing`: see fowtlib.components.flooding.sloshing.
    """

    place: Vector = param(default=(0, 0, 0), unit="m", doc="middle of the floor, resolved in the frame")
    places: Array = param(
        default=((0.0, 0.0, 0.0),), unit="m", doc="ports (n, 3), from the middle of the floor, resolved in the frame"
    )
    volume_start: Scalar = param(unit="m^3", min=0, doc="water at the start")
    density: Scalar = param(default=None, unit="kg/m^3", min=0, doc="density of the water; without: World's")

    water: Water = port(size=lambda self: len(self.parameter_value("places")), optional=True, doc="at each place")

    volume: Scalar = var(unit="m^3", state="always", start=volume_start, doc="volume of the water")
    level: Scalar = var(unit="m", state="never", start=lambda self: self.start_level(), doc="water on the axis")
    surface: Scalar = var(unit="m", state="never", doc="height of the free surface above the still water level")
    air_pressure: Scalar = var(unit="Pa", doc="of the air above the water, above the atmosphere")

    def vessel(self) -> Any:
        """Its shape, with `area`, `height` and `contents(level, slope)`: see fowtlib.components.flooding.sections."""
        raise NotImplementedError

    def start_level(self) -> Any:
        """A first guess of the level at the start."""
        return self.volume_start / self.vessel().area

    def build(self):
        if self.sealed:
            air_space.declare(self)
        else:
            self.refuse_unused(*air_space.PARAMETERS, because="the tank is open to the air (sealed: false)")
        if self.sloshing:
            self.first_mode_share()
            sloshing.declare(self)
        else:
            self.refuse_unused("slosh_damping", because="the surface stays level (sloshing: false)")
        if self.flow_inertia:
            columns.check(self)

    def equations(self):
        vessel, rho, up = self.vessel(), density(self), self.frame.R.T @ m.vertcat(0, 0, 1)
        modes = self.modes(rho) if self.sloshing else None
        level_share = 1 - self.first_mode_share() if self.sloshing else 1  # of the slope, that follows at once
        slope = level_share * up[0] / up[2], level_share * up[1] / up[2]
        held, fill = _filled(self, vessel, slope)
        first, inertia = water_loads.about_frame(self, rho, held)
        first = first + sloshing.moved(self, modes) if self.sloshing else first
        ports = [self.place + self.places[i, :].T for i in range(len(self.water))]
        return [
            eq(der(self.volume), sum((w.volume_flow for w in self.water), 0.0)),
            fill,
            eq(self.surface, self.frame.r[2] + m.dot(up, self.place + m.vertcat(0, 0, self.level))),
            [eq(self.velocity, der(self.frame.r)), eq(self.mass, rho * self.volume), eq(self.moments, first)],
            [eq(self.centre, first / (self.mass + 1e-9 * rho * vessel.capacity)), eq(self.inertia, inertia)],
            [eq(w.head, head) for w, head in zip(self.water, _heads(self, rho, up, ports), strict=True)],
            air_space.laws(self) if self.sealed else eq(self.air_pressure, 0),
            *water_loads.laws(self, rho, ports, modes),
            *_limits(self, vessel, up, ports),
        ]

    def start_height(self) -> float:
        """Height [m] of the centre of the water above the floor at the start, upright."""
        return float(self.volume_start / self.vessel().area) / 2

    def facts(self) -> list[facts.Fact]:
        given = self.parameter_value("density")
        rho = self.world.parameter_value("water_density") if given is None else given
        centre = np.ravel(self.parameter_value("place")) + (0, 0, self.start_height())
        water = facts.Mass(self.frame, float(rho * self.parameter_value("volume_start")), centre)
        return [water, facts.Reading("volume"), facts.Reading("level")]


def density(tank: Tank) -> Any:
    """Density of its water [kg/m^3]."""
    return tank.world.water_density if tank.density is None else tank.density


def _heads(tank: Tank, rho: Any, up: Any, ports: list[Any]) -> list[Any]:
    """Heads at ports: the surface, or their own heights while they are dry, the air on top, and accelerations."""
    motion, found = water_loads.motion_of(tank) if tank.flow_inertia else None, []
    for place in ports:
        own = tank.frame.r[2] + m.dot(up, place)
        moved = columns.head(tank, motion, place, up) if motion else 0.0
        found.append(m.fmax(tank.surface, own) + tank.air_pressure / (rho * tank.world.gravity) + moved)
    return found


def _filled(tank: Tank, vessel: Any, slope: tuple[Any, Any]) -> tuple[Contents, Any]:
    """What is below the level, and the equation that it is the volume.

    A vessel with corners is never filled by less than LEAST of it, nor to less than that below its roof, by which the
    level of an empty and of a full one is smooth in the tilt; V + LEAST^2 / V elsewhere. Moments are those of the
    volume. Beyond floor and roof the section goes on: there is a level for a step of a solver that goes too far.
    """
    held, h, volume = vessel.contents(tank.level, slope), tank.level, tank.volume
    if not isinstance(vessel, Cornered):
        return held, eq(volume, held.volume)
    least, reach = LEAST * vessel.capacity, vessel.lift(slope)
    wet = m.smooth_max(volume, 0, 2 * least)
    filled = vessel.capacity - m.smooth_max(vessel.capacity - wet, 0, 2 * least)
    beyond = vessel.area * (m.fmax(h - vessel.height - reach, 0) + m.fmin(h + reach, 0))
    settled, share = vessel.settled(held, h, volume), volume / filled
    first = share * settled.first * m.vertcat(1, 1, share)  # so that the height of the centre of a column is exact
    outside = m.fmin(volume, 0) + m.fmax(volume - vessel.capacity, 0)
    return Contents(volume, first, share * settled.second), eq(filled + outside, held.volume + beyond)


def _limits(tank: Tank, vessel: Any, up: Any, ports: list[Any]) -> list[Any]:
    """What the equations hold for: neither more than it holds, nor less than nothing, nor air into a pipe."""
    full, found = vessel.capacity, []
    for i, place in enumerate(ports):
        flow, dry = -tank.water[i].volume_flow, tank.frame.r[2] + m.dot(up, place) - tank.surface
        found.append(
            assert_(m.if_else(dry > DRY, flow < SEEPING * vessel.area, 1), f"air comes into its port {i}: it lies "
                    "{dry} m above the water, of which {water} m3 are left, and {flow} m3/s leave through it; stop the "
                    "pump or close the valve before", dry=dry, water=tank.volume, flow=flow)
        )  # fmt: skip
    if isinstance(vessel, Wedge):
        found.append(_wet_walls(tank, vessel, up))
    return [
        *found,
        assert_(tank.volume < (1 + MARGIN) * full, "the tank is overfilled: {water} m3 of water, and it holds {full} m3"
                "; stop its pump before, or join an overflow", water=tank.volume, full=full),
        assert_(tank.volume > -MARGIN * full, "the tank is drained: {water} m3 are left in it; stop its pump before",
                water=tank.volume),
        assert_(up[2] > math.cos(math.radians(STEEPEST)), "the axis of the tank is turned by more than "
                f"{STEEPEST:g} deg against the vertical, where its level is not determined"),
    ]  # fmt: skip


def _wet_walls(tank: Tank, vessel: Wedge, up: Any) -> Any:
    """Of a wedge: it ends at the walls, above the floor and below the roof."""
    wedge = vessel.lift((up[0] / up[2], up[1] / up[2]))
    room = m.fmin(tank.level, vessel.height - tank.level) - MARGIN * vessel.height
    return assert_(wedge <= room, "the surface comes to the floor or the roof: it rises by {wedge} m at the wall, and "
                   "there are {room} m; take a tank that knows its corners (a BoxTank or RoundTank without walls_wet), "
                   "or another amount of water", wedge=wedge, room=room)  # fmt: skip
