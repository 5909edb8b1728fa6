"""The air that the sections of a blade take along when they accelerate."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import casadi as ca
import numpy as np

from fowtlib.components.mechanics import Frame
from fowtlib.language import der
from fowtlib.language import math as m

if TYPE_CHECKING:
    from fowtlib.components.aero.blade_element_aerodynamics import BladeElementAerodynamics


def added_mass_loads(air: BladeElementAerodynamics) -> Any:
    """Force and moment of each node of a rotor (6n), world; see section_added_mass."""
    chords, sections = ca.vertsplit(air.chord), zip(air.nodes, air.section_axes(air.nodes), air.turning(), strict=True)
    loads = []
    for i, (node, axes, turn) in enumerate(sections):
        k = i % len(chords)
        density = air.world.air_density * float(air.rotor.lengths[k])
        loads += section_added_mass(node, axes, turn, chords[k], air.rotation, density)
    return m.vertcat(*loads)


def section_added_mass(node: Frame, axes: Any, turn: Any, chord: Any, rotation: int, density: Any) -> tuple[Any, Any]:
    """Force and moment about a node (world) of the air that accelerates with a flat plate of the section's chord c.

    Theodorsen (1935, NACA report 496), the terms with accelerations: at the middle of the chord -pi/4 rho c^2 dv/dt
    along the normal n of the chord, and the moment -pi/128 rho c^4 dw/dt about it. dv/dt is the rate of the velocity
    v = (velocity of the middle of the chord) . n, so that a rotor in steady operation has none of it; without what the
    turning w of the section makes of its velocity along the chord, because the airfoil models with a shed wake have
    that (pi T w in their lift). The air itself is not taken to accelerate.

    axes: of the section, columns normal to the chord, y = z x x, and along the blade; turn [rad/s]: w about the
    latter, without the turning of the rotor; rotation: 1 if y is to the trailing edge, -1 if to the nose; density
    [kg/m]: of the air times the length of the section.
    """
    normal, chordwise, span = axes[:, 0], axes[:, 1], axes[:, 2]
    velocity, back, angular = der(node.r), rotation * chord / 4, der(turn)
    rate = m.dot(der(velocity), normal) + m.dot(velocity, m.cross(node.w, normal)) - turn * m.dot(velocity, chordwise)
    force = -np.pi / 4 * density * chord**2 * (rate - back * angular)
    return force * normal, (-back * force - np.pi / 128 * density * chord**4 * angular) * span
