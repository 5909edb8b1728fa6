"""Morison's loads on the strips of a member that moves in the waves, anywhere in space.

Drag: 1/2 rho C_d D ds |u_n| u_n across the axis, with the velocity u of the water against the strip and its part u_n
across; where the two directions of a section differ, each has its own C_d D. Along the axis 1/2 rho C_e A |u_a| u_a on
ends.

Inertia, for members that are slender against the waves and in no potential flow: the pressure of the wave as if the
member were not there, rho dV a, with the whole acceleration a of the water; and the added mass, rho C_a dV a_n across,
with the acceleration of the water against the strip. The pressure on a closed surface is rho dV a by Gauss' theorem;
a member that reaches the water level has no lid there, and rho g elevation S upwards makes up for it.
Source: J.R. Morison et al., Petroleum Transactions 189 (1950) 149-154; O.M. Faltinsen, Sea Loads on Ships and Offshore
Structures (1990), ch. 3 and 7.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import casadi as ca

from fowtlib.language import der, quadratic
from fowtlib.language import math as m

STILL = 1e-3  # m/s; the speed in |u| u is sqrt(u^2 + STILL^2), smooth where the relative velocity passes zero


@dataclass(frozen=True, eq=False)
class Strip:
    """What a strip resists with, in numbers or symbols; vectors are resolved in the frame that carries it.

    place (3,), axis (3,). across [kg/m]: 1/2 rho C_d D ds; of a section with two directions a pair of them, for flows
    along `side` (3,) and along the third direction. along [kg/m]: 1/2 rho C_e A.
    volume_mass [kg]: rho dV. added_mass [kg]: rho C_a dV across, one or a pair. added_along [kg]: of an end.
    shapes (3, k): displacement per coordinate of the k shapes into which what carries it deforms; None: it is rigid.
    """

    place: Any
    axis: Any
    across: Any
    along: Any = 0.0
    side: Any = None
    volume_mass: Any = 0.0
    added_mass: Any = None
    added_along: Any = 0.0
    shapes: Any = None


def drag_loads(frame: Any, velocity: Any, strips: Sequence[Strip]) -> tuple[Any, Any]:
    """Force and moment about the frame (world) of the drag; velocity (k, 3) of the water at the strips, world."""
    return deforming_drag_loads(frame, velocity, strips, None)[:2]


def inertia_loads(frame: Any, acceleration: Any, strips: Sequence[Strip]) -> tuple[Any, Any]:
    """Force and moment about the frame (world) of the inertia of the water; its acceleration (k, 3), world."""
    return deforming_inertia_loads(frame, acceleration, strips, None)[:2]


def deforming_drag_loads(frame: Any, velocity: Any, strips: Sequence[Strip], q: Any) -> tuple[Any, Any, Any]:
    """As drag_loads of strips that move with shapes of coordinates q (k,); third the load on these: the same work."""

    def load(k: int, strip: Strip, arm: Any, axes: Any) -> Any:
        u = velocity[k, :].T - der(frame.r) - m.cross(frame.w, arm) - _bending(frame, strip, q, 1)
        along = m.dot(u, axes[0])
        if not isinstance(strip.across, tuple) and ca.SX(strip.across).is_zero():
            return strip.along * quadratic(along, STILL, "end drag") * axes[0]
        normal = quadratic(u - axes[0] * along, STILL)
        side = [m.dot(normal, axis) for axis in axes[1:]]
        across = _across(strip.across, normal, axes, 0, side)
        if ca.SX(strip.along).is_zero():
            return across
        return across + strip.along * quadratic(along, STILL, "end drag") * axes[0]

    return _summed(frame, strips, load, q)


def deforming_inertia_loads(frame: Any, acceleration: Any, strips: Sequence[Strip], q: Any) -> tuple[Any, Any, Any]:
    """As inertia_loads of strips that move with shapes of coordinates q (k,); third the load on these.

    Without the accelerations by both the turning of the frame and bending at once.
    """
    linear, angular = der(der(frame.r)), der(frame.w)

    def load(k: int, strip: Strip, arm: Any, axes: Any) -> Any:
        water = acceleration[k, :].T
        own = linear + m.cross(angular, arm) + m.cross(frame.w, m.cross(frame.w, arm)) + _bending(frame, strip, q, 2)
        a = water - own
        along, *across = _split(a, axes)
        added = _across(strip.added_mass, a, axes, along, across) + strip.added_along * along * axes[0]
        return strip.volume_mass * water + added

    return _summed(frame, strips, load, q)


def _bending(frame: Any, strip: Strip, q: Any, order: int) -> Any:
    """Velocity (order 1) or acceleration (2) of a strip by its shapes, world."""
    if strip.shapes is None:
        return m.zeros(3)
    rate = der(q) if order == 1 else der(der(q))
    return m.mtimes(frame.R, m.mtimes(strip.shapes, rate))


def _split(u: Any, axes: list[Any]) -> list[Any]:
    return [m.dot(u, axis) for axis in axes]


def _across(amount: Any, u: Any, axes: list[Any], along: Any, across: list[Any]) -> Any:
    """The part of u across the axis, each direction times its amount."""
    if not isinstance(amount, tuple):
        return amount * (u - axes[0] * along)
    return amount[0] * across[0] * axes[1] + amount[1] * (u - axes[0] * along - axes[1] * across[0])


def _summed(frame: Any, strips: Sequence[Strip], load: Any, q: Any) -> tuple[Any, Any, Any]:
    force, moment, R = m.zeros(3), m.zeros(3), frame.R
    on_shapes = m.zeros(0 if q is None else q.shape[0])
    for k, strip in enumerate(strips):
        place = strip.place if strip.shapes is None else strip.place + m.mtimes(strip.shapes, q)
        arm = m.mtimes(R, place)
        axes = [m.mtimes(R, strip.axis)] + ([] if strip.side is None else [m.mtimes(R, strip.side)])
        given = load(k, strip, arm, axes)
        force, moment = force + given, moment + m.cross(arm, given)
        if strip.shapes is not None:
            on_shapes = on_shapes + m.mtimes(strip.shapes.T, m.mtimes(R.T, given))
    return force, moment, on_shapes
