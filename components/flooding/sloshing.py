"""First mode of the water in a tank, along x and along y of its frame: a mass on a spring.

A box of length a, depth h: k = pi / a, m_1 = rho a^2 b 8 tanh(k h) / pi^3. A round tank of radius R: k = xi / R, xi =
1.84118 the first zero of J_1', m_1 = rho pi R^3 2 tanh(k h) / (xi (xi^2 - 1)). Of both omega^2 = g k tanh(k h), and m_1
sits at h - (2 / k) tanh(k h / 2) above the floor. H. N. Abramson (ed.), The dynamic behavior of liquids in moving
containers, NASA SP-106 (1966), ch. 2 and 6; F. T. Dodge, The new "dynamic behavior of liquids in moving containers",
Southwest Research Institute (2000), ch. 3.

At rest in a tank that leans the mode has the share m_1 g / (omega^2 rho i) of the free surface, 96 / pi^4 = 0.9855 of a
box and 8 / (xi^2 (xi^2 - 1)) = 0.9873 of a round tank, whatever the depth. The surface of the other modes, which are
faster, stays level: their share is all that is left of the quasi-static one, so that nothing counts twice.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from fowtlib.language import Array, assert_, der, eq, var
from fowtlib.language import math as m

XI = 1.8411837813406593  # first zero of the derivative of the Bessel function J_1


@dataclass(frozen=True)
class Mode:
    """Of one direction: mass [kg], height above the floor [m], omega^2 [1/s^2], rise at the wall per displacement."""

    mass: Any
    height: Any
    omega2: Any
    rise: Any


BOX = 96 / math.pi**4  # share of the first mode in the moment of the free surface
ROUND = 8 / (XI**2 * (XI**2 - 1))


def box_mode(length: Any, width: Any, depth: Any, density: Any, gravity: Any) -> Mode:
    """Along `length`."""
    k = math.pi / length
    steep = m.tanh(k * depth)
    mass = density * length**2 * width * 8 * steep / math.pi**3
    return Mode(mass, depth - 2 / k * m.tanh(k * depth / 2), gravity * k * steep, 4 / math.pi * steep)


def round_mode(radius: Any, depth: Any, density: Any, gravity: Any) -> Mode:
    """Along any direction."""
    k = XI / radius
    steep = m.tanh(k * depth)
    mass = density * math.pi * radius**3 * 2 * steep / (XI * (XI**2 - 1))
    return Mode(mass, depth - 2 / k * m.tanh(k * depth / 2), gravity * k * steep, 2 * XI * steep / (XI**2 - 1))


def declare(tank: Any) -> None:
    """The displacement of the mass along x and y of the frame, and its rates."""
    for name, unit, state, doc in (
        ("slosh", "m", "always", "displacement of the first mode along x and y of the frame"),
        ("slosh_velocity", "m/s", "always", "its rate"),
        ("slosh_acceleration", "m/s^2", "never", "second derivative of it"),
    ):
        tank.declare(name, Array, var(unit=unit, shape=(2,), state=state, doc=doc))


def moved(tank: Any, modes: tuple[Mode, Mode]) -> Any:
    """Mass times displacement of both modes (3,)."""
    return m.vertcat(*(mode.mass * tank.slosh[i] for i, mode in enumerate(modes)), 0)


def loads(tank: Any, modes: tuple[Mode, Mode]) -> tuple[Any, Any]:
    """Force and moment (3,) about the frame, in its axes, that speed the modes up relative to the tank."""
    force, moment = m.zeros(3), m.zeros(3)
    for i, mode in enumerate(modes):
        one = mode.mass * tank.slosh_acceleration[i] * _axis(i)
        force, moment = force + one, moment + m.cross(_place(tank, mode, i), one)
    return force, moment


def laws(tank: Any, modes: tuple[Mode, Mode], motion: tuple[Any, Any, Any]) -> list[Any]:
    """Equations of motion; motion: a less gravity, w and w' of the frame, in its axes."""
    a, w, turning = motion
    found = [eq(der(tank.slosh), tank.slosh_velocity), eq(der(tank.slosh_velocity), tank.slosh_acceleration)]
    velocity = m.vertcat(tank.slosh_velocity[0], tank.slosh_velocity[1], 0)
    for i, mode in enumerate(modes):
        place = _place(tank, mode, i)
        felt = a + m.cross(turning, place) + m.cross(w, m.cross(w, place)) + 2 * m.cross(w, velocity)
        braked = 2 * tank.slosh_damping * m.sqrt(mode.omega2 + 1e-12) * tank.slosh_velocity[i]
        found.append(eq(tank.slosh_acceleration[i] + felt[i] + braked + mode.omega2 * tank.slosh[i], 0))
        wave, room = m.abs(mode.rise * tank.slosh[i]), tank.vessel().height - tank.level
        found.append(
            assert_(wave < m.fmin(tank.level, room), f"the water sloshes along {'xy'[i]} by {{wave}} m at the wall, to "
                    "its floor or roof, where its first mode is not linear any more; leave its sloshing out, or damp "
                    "it", wave=wave)
        )  # fmt: skip
    return found


def _axis(i: int) -> Any:
    return m.vertcat(*(1.0 if i == k else 0.0 for k in range(3)))


def _place(tank: Any, mode: Mode, i: int) -> Any:
    """Where the mass is, from the frame."""
    return tank.place + m.vertcat(0, 0, mode.height) + tank.slosh[i] * _axis(i)
