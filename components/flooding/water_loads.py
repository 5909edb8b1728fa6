"""Loads between a tank and its frame: momentum and angular momentum of water whose amount changes."""

from __future__ import annotations

from typing import Any

from fowtlib.components.flooding import sloshing
from fowtlib.components.flooding.sections import Contents
from fowtlib.language import der, eq
from fowtlib.language import math as m


def about_frame(tank: Any, rho: Any, held: Contents) -> tuple[Any, Any]:
    """Mass times centre, and inertia about the origin of the frame, of what is in the vessel."""
    b = tank.place
    first = held.volume * b + held.first
    second = held.second + m.mtimes(b, held.first.T) + m.mtimes(first, b.T)
    trace = second[0, 0] + second[1, 1] + second[2, 2]
    return rho * first, rho * (trace * m.eye(3) - second)


def motion_of(tank: Any) -> tuple[Any, Any, Any]:
    """Acceleration of the origin of the frame less gravity, angular velocity and its rate, in axes of the frame."""
    R = tank.frame.R
    a = R.T @ (der(tank.velocity) + m.vertcat(0, 0, tank.world.gravity))
    return a, R.T @ tank.frame.w, R.T @ der(tank.frame.w)


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
    if modes is not None:
        push, twist = sloshing.loads(tank, modes)
        force, moment, more = force + push, moment + twist, sloshing.laws(tank, modes, motion)
    return [eq(frame.f, R @ force), eq(frame.t, R @ moment), *more]
