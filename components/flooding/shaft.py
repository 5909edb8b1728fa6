"""A shaft in which a piston floats: the water that lifts it and runs through the gap, and what both get from it.

Section A_s of the shaft, A_c of the piston, A_a = A_s - A_c of the gap, nu = A_c/A_a. Above the floor: the foot of the
piston at s, the surface at h, the immersion c of the piston. The volume V tells both levels: V = A_s h - A_c c with
c = h - s, so that c = (V - A_s s)/A_a while that is positive, and the piston hangs dry above the water otherwise.

The loads are those of Lagrange's equations. Relative to the shaft the water runs in the gap only, at -nu v when the
piston moves at v = ds/dt; under the piston it moves to the sides, and no mean velocity along the axis is left there.
So T = a v^2/2 with a = rho A_c nu c and, of the centre of the water, dU/ds = -rho g A_c c; a depends on s and V:

    force along the axis = rho A_c c g_n + A_c dp - a dv/dt - (da/ds v/2 + da/dV Q) v
    pressure at the floor = rho g h + dp - rho nu^2 v^2/2

with the acceleration g_n of the shaft against free fall, along the axis, and the loss dp of the gap. A piston that
floats thus has the stiffness rho g A_c A_s/A_a, and the water in the gap the inertia a: its period is 2 pi sqrt(d/g)
for a gap of any width, if A_c is such that it floats at the depth d in a shaft at rest. In the momentum of the water
relative to the shaft, -rho A_c c v, and in T the flow Q of the pump is left out, whose speed is small against nu v.
"""

from __future__ import annotations

from typing import Any, NamedTuple

from fowtlib.language import der, eq, quadratic
from fowtlib.language import math as m

STILL = 1e-3  # m/s; the speed in |u| u of the gap is smooth below it
ENTRY = 0.1  # m; immersion over which the losses and the wall of the gap come in


class Levels(NamedTuple):
    """Lengths [m] of the water of a shaft and its moments; wet: 1 where the piston is in the water, else 0."""

    surface: Any
    immersion: Any
    wet: Any
    volume: Any
    first: Any
    second: Any


def levels(shaft) -> Levels:
    """Levels for the volume and the place of the piston that there are now, moments [m^4], [m^5] above the floor."""
    area, piston, s = shaft.area, shaft.piston_area, shaft.axis.s
    above = shaft.volume - area * s
    immersion = m.fmax(above, 0.0) / (area - piston)
    h = (shaft.volume + piston * immersion) / area
    top = s + immersion
    return Levels(
        h, immersion, m.if_else(above > 0, 1.0, 0.0), shaft.volume,
        area * h**2 / 2 - piston * (top**2 - s**2) / 2, area * h**3 / 3 - piston * (top**3 - s**3) / 3,
    )  # fmt: skip


def surface_moment(shaft, found: Levels):
    """Second moment of area of the free surface [m^4]."""
    return m.pi / 64 * (shaft.diameter**4 - begun(found) * shaft.piston_diameter**4)


def centre(shaft, found: Levels):
    """Centre of the water in the axes of the shaft (3,) [m]; its surface is level, to the first order in the slope."""
    up = shaft.frame_a.R.T @ m.vertcat(0, 0, 1)
    aside = -surface_moment(shaft, found) * up[:2] / up[2]
    return m.vertcat(aside, found.first) / (found.volume + 1e-9 * shaft.area)


def gap_loss(shaft, found: Levels):
    """Pressure [Pa] lost by the flow in the gap, positive for one upwards; zero where the piston is dry."""
    gap = shaft.area - shaft.piston_area
    u = (shaft.water.volume_flow - shaft.piston_area * der(shaft.axis.s)) / gap
    factor = shaft.gap_loss + shaft.gap_friction * found.immersion / (shaft.diameter - shaft.piston_diameter)
    return shaft.density_now() / 2 * factor * quadratic(u, STILL, "gap") * begun(found)


def begun(found: Levels):
    """How much of the gap there is: none of a dry piston, all of one that is in by more than ENTRY."""
    return m.fmin(found.immersion / ENTRY, 1.0)


def on_the_axis(shaft, found: Levels) -> list:
    """Force of the water on the piston, head at the floor, energy and loss."""
    rho, area, piston = shaft.density_now(), shaft.area, shaft.piston_area
    nu, v = piston / (area - piston), der(shaft.axis.s)
    flow, loss, n = shaft.water.volume_flow, shaft.gap_pressure, shaft.frame_a.R[:, 2]
    inertia, per_place = rho * piston * nu * found.immersion, -rho * nu**2 * area * found.wet
    per_volume = -per_place / area
    acceleration = der(shaft.velocity) + m.vertcat(0, 0, shaft.world.gravity)
    along = m.dot(n, acceleration + (found.surface - found.immersion / 2) * shaft.turning())
    moved = inertia * der(v) + (per_place * v / 2 + per_volume * flow) * v
    head = shaft.frame_a.r[2] + n[2] * found.surface
    weight = rho * shaft.world.gravity
    return [
        eq(shaft.gap_pressure, gap_loss(shaft, found)),
        eq(shaft.lift, rho * piston * found.immersion * along + piston * loss - moved),
        eq(shaft.axis.f, -shaft.lift),
        eq(shaft.water.head, head + (loss - per_volume * v**2 / 2) / weight),
        eq(shaft.energy, inertia * v**2 / 2 + weight * found.first),
        eq(shaft.lost_power, loss * (flow - piston * v)),
    ]


def on_the_frames(shaft, found: Levels) -> list:
    """Loads of the water on shaft and piston across the axis, and its weight and inertia."""
    rho, area, piston, s = shaft.density_now(), shaft.area, shaft.piston_area, shaft.axis.s
    a, b, n, v = shaft.frame_a, shaft.frame_b, shaft.frame_a.R[:, 2], der(shaft.axis.s)
    up = der(shaft.velocity) + m.vertcat(0, 0, shaft.world.gravity)  # acceleration against free fall
    turning, middle = shaft.turning(), s + found.immersion / 2
    weight = rho * (up * found.volume + turning * found.first)
    moment = rho * m.cross(n, up * found.first + turning * found.second)
    momentum = -rho * piston * found.immersion * v
    growth = found.wet * (shaft.water.volume_flow - area * v) / (area - piston)
    rate = -rho * piston * (growth * v + found.immersion * der(v))
    coriolis = 2 * momentum * m.cross(a.w, n)
    surface = rho * surface_moment(shaft, found)
    push = rho * piston * found.immersion * (up + middle * turning)
    across = push - n * m.dot(n, push)
    pressed = weight + n * rate + coriolis + across
    level = surface * m.cross(up + found.surface * turning, n)  # at right angles to the acceleration that it feels
    turned = moment + middle * m.cross(n, coriolis + across) - level
    return [
        [eq(a.f, pressed), eq(a.t, turned)],
        [eq(b.f, -across), eq(b.t, -m.cross(n * found.immersion / 2, across))],
    ]
