"""Water between the ports of a tank and its surface, which the acceleration of the body and its own inertia move.

The way goes straight from a port p to the surface on the axis of the tank, x_s. Along it, in axes of the frame, with a
the acceleration of its origin less gravity, w its angular velocity and A the section of the tank, the equation of
Bernoulli in a moving frame gives

    (p_port - p_air) / rho = a.(x_s - p) + w'.(p x x_s) - (|w x x_s|^2 - |w x p|^2) / 2 + h / A d(sum Q)/dt,

h being the level: the column over the floor moves as a whole. What the flow gives to the body is rho Q' (x_s - p) and
its moment, rho Q' p x x_s, of water that comes in with the velocity of the column. Along a Duct all is the same, so
that the way from surface to surface is the anti-roll tank of A. R. J. M. Lloyd, Seakeeping: Ship Behaviour in Rough
Weather (1989), ch. 20, for any motion.
"""

from __future__ import annotations

from typing import Any

from fowtlib.components.flooding.sections import Box, Disc, Wedge
from fowtlib.language import Component, der, param
from fowtlib.language import math as m
from fowtlib.language.errors import ParameterError


class MovingColumns(Component):
    """Partial: what a tank says of the water between its ports and its surface."""

    flow_inertia: bool = param(
        default=False, doc="accelerations of the body and of the water act on the heads at its ports: anti-roll tanks"
    )


def apparent(frame: Any, velocity: Any, gravity: Any) -> tuple[Any, Any, Any]:
    """Acceleration of the origin of a frame less gravity, angular velocity and its rate, in axes of the frame."""
    R = frame.R
    return R.T @ (der(velocity) + m.vertcat(0, 0, gravity)), R.T @ frame.w, R.T @ der(frame.w)


def potential_along(motion: tuple[Any, Any, Any], start: Any, end: Any) -> Any:
    """Integral of the apparent acceleration along a straight way [m^2/s^2], gravity in it; motion: see apparent."""
    a, w, turning = motion
    ends = [m.cross(w, end), m.cross(w, start)]
    swung = (m.dot(ends[0], ends[0]) - m.dot(ends[1], ends[1])) / 2
    return m.dot(a, end - start) + m.dot(turning, m.cross(start, end)) - swung


def check(tank: Any) -> None:
    """A column has one section."""
    if not isinstance(tank.vessel(), Box | Disc | Wedge):
        raise ParameterError(
            f"{tank.label}.flow_inertia needs a tank of one section from floor to roof, and a {type(tank).__name__} "
            "is none; take a BoxTank, RoundTank or PrismaticTank."
        )
    if tank.sloshing:
        raise ParameterError(
            f"{tank.label}.flow_inertia and sloshing are of the same water, which swings from tank to tank or within "
            "one; leave one of them out."
        )


def surface_place(tank: Any) -> Any:
    """The surface on the axis of the tank, from its frame."""
    return tank.place + m.vertcat(0, 0, tank.level)


def head(tank: Any, motion: tuple[Any, Any, Any], place: Any, up: Any) -> Any:
    """What accelerations add to the head at a port [m], over the height of the surface."""
    end, gravity = surface_place(tank), tank.world.gravity
    moved = potential_along(motion, place, end) / gravity - m.dot(up, end - place)
    return moved + tank.level / (gravity * tank.vessel().area) * der(_inflow(tank))


def loads(tank: Any, rho: Any, ports: list[Any]) -> tuple[Any, Any]:
    """Force and moment (3,) about the frame, in its axes, that speed the water up relative to the tank."""
    force, moment, end = m.zeros(3), m.zeros(3), surface_place(tank)
    for water, place in zip(tank.water, ports, strict=True):
        rate = rho * der(water.volume_flow)
        force, moment = force + rate * (end - place), moment + rate * m.cross(place, end)
    return force, moment


def _inflow(tank: Any) -> Any:
    return sum((w.volume_flow for w in tank.water), 0.0)
