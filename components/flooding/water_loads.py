"""Loads between a tank and its frame: momentum and angular momentum of water whose amount changes."""

from __future__ import annotations

from typing import Any

from fowtlib.components.environment.world import World
from fowtlib.components.flooding import columns, sloshing
from fowtlib.components.flooding.sections import Contents
from fowtlib.components.mechanics.connectors import Frame
from fowtlib.language import Component, Matrix, Scalar, Vector, der, eq, outer, port, var
from fowtlib.language import math as m


class WaterOnFrame(Component):
    """Partial: water that a frame carries, and what its loads are made of."""

    world: World = outer(World)
    frame: Frame = port(doc="frame that carries the tank")

    velocity: Vector = var(unit="m/s", state="avoid", doc="velocity of the frame, world")
    mass: Scalar = var(unit="kg", state="never", doc="mass of the water")
    moments: Vector = var(unit="kg*m", state="never", doc="mass times centre, from the frame, resolved in it")
    centre: Vector = var(unit="m", state="never", doc="centre of the water, from the frame, resolved in it")
    inertia: Matrix = var(unit="kg*m^2", state="never", doc="inertia about the origin of the frame, resolved in it")


def about_frame(tank: Any, rho: Any, held: Contents) -> tuple[Any, Any]:
    """Mass times centre, and inertia about the origin of the frame, of what is in the vessel."""
    b = tank.place
    first = tank.volume * b + held.first
    second = held.second + m.mtimes(b, held.first.T) + m.mtimes(first, b.T)
    trace = second[0, 0] + second[1, 1] + second[2, 2]
    return rho * first, rho * (trace * m.eye(3) - second)


def motion_of(tank: Any) -> tuple[Any, Any, Any]:
    """Acceleration of the origin of the frame less gravity, angular velocity and its rate, in axes of the frame."""
    return columns.apparent(tank.frame, tank.velocity, tank.world.gravity)


def laws(tank: Any, rho: Any, ports: list[Any], modes: tuple[Any, Any] | None) -> list[Any]:
    """What moves the water: force, and moment about the origin of the frame; see Tank. modes: of water that sloshes."""
    frame, R, mass, first = tank.frame, tank.frame.R, tank.mass, tank.moments
    a, w, turning = motion = motion_of(tank)
    flows = [rho * port.volume_flow for port in tank.water]
    inside = der(first) - sum((q * p for q, p in zip(flows, ports, strict=True)), m.zeros(3))
    brought = sum((q * m.cross(p, m.cross(w, p)) for q, p in zip(flows, ports, strict=True)), m.zeros(3))
    force = mass * a + m.cross(turning, first) + m.cross(w, m.cross(w, first)) + 2 * m.cross(w, inside)
    spin = tank.inertia @ turning + m.cross(w, tank.inertia @ w) + der(tank.inertia) @ w - brought
    moment = m.cross(first, a) + spin + m.cross(w, m.cross(tank.centre, inside))
    more = []
    if tank.flow_inertia:
        push, twist = columns.loads(tank, rho, ports)
        force, moment = force + push, moment + twist
    if modes is not None:
        push, twist = sloshing.loads(tank, modes)
        force, moment, more = force + push, moment + twist, sloshing.laws(tank, modes, motion)
    return [eq(frame.f, R @ force), eq(frame.t, R @ moment), *more]
