"""The skin of blades, for pictures. NumPy.

Axes of a blade: z from the root to the tip, x downwind, y to the trailing edge at zero twist (to the leading edge for a
rotor that turns counter-clockwise, rotation = -1).
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from fowtlib.language import shapes
from fowtlib.language.declarations import join

POINTS = 18  # of a section
PITCH_AXIS = 0.3  # of the chord, from the leading edge


def blade_sections(axis: ArrayLike, chord: ArrayLike, thickness: ArrayLike, twist: ArrayLike, rotation: int = 1) -> Any:
    """Sections (n, POINTS, 3) around points of the pitch axis (n, 3), from chord and thickness [m], twist [rad].

    A section as thick as long is a circle; thin ones are drop-shaped. Positive twist turns the leading edge upwind.
    """
    axis, chord, thickness, twist = (np.asarray(item, dtype=float) for item in (axis, chord, thickness, twist))
    angle = np.linspace(0, 2 * np.pi, POINTS, endpoint=False)
    along = (1 - np.cos(angle)) / 2  # from the leading edge, on one side there and on the other back
    drop = 2.6 * np.sqrt(along) * (1 - along) * np.sign(np.sin(angle))
    ratio = np.clip(thickness / chord, 0, 1)[:, None]
    round_part = np.clip((ratio - 0.45) / 0.5, 0, 1)
    side = ratio * (round_part * np.sin(angle) + (1 - round_part) * drop) / 2
    back = along - (round_part * 0.5 + (1 - round_part) * PITCH_AXIS)
    x, y = side * chord[:, None], rotation * back * chord[:, None]
    c, s = np.cos(rotation * twist)[:, None], np.sin(rotation * twist)[:, None]
    turned = np.stack([c * x + s * y, c * y - s * x, np.zeros_like(x)], axis=-1)
    return axis[:, None, :] + turned


def typical_blade(root: float, tip: float, rotation: int = 1) -> np.ndarray:
    """Sections of a blade between two radii [m], where nothing but its length is known: the form of large turbines."""
    s = np.array([0, 0.03, 0.08, 0.14, 0.2, 0.3, 0.45, 0.6, 0.75, 0.88, 0.96, 0.99, 1.0])
    chord = np.interp(s, [0, 0.03, 0.2, 0.9, 0.97, 1], np.array([5.3, 5.3, 7.4, 3.3, 2.3, 0.5]) / 100) * tip
    ratio = np.interp(s, [0, 0.03, 0.2, 0.45, 1], [1, 1, 0.42, 0.24, 0.17])
    twist = np.radians(np.interp(s, [0, 0.2, 0.5, 1], [13, 11, 4, 0]))
    axis = np.zeros((len(s), 3))
    axis[:, 2] = root + s * (tip - root)
    return blade_sections(axis, chord, ratio * chord, twist, rotation)


def typical_rotor(rotor: Any, radius: float, tilt: float, precone: float, blades: int = 3) -> list[shapes.Drawn]:
    """Blades that turn and pitch with a rotor that is a disk to the physics: frame, phi, blade_pitch, rotation."""
    upright = _rotation(1, tilt)
    spin = shapes.Turned(rotor.frame, tuple(upright[:, 0]), join(rotor.path, "phi"), rotor.rotation)
    drawn: list[shapes.Drawn] = [shapes.Ball(spin, diameter=0.055 * radius, material="nacelle")]
    sections = typical_blade(0.02 * radius, radius, rotor.rotation)
    for k in range(blades):
        blade = upright @ _rotation(0, rotor.rotation * 2 * np.pi * k / blades) @ _rotation(1, -precone)
        pitched = shapes.Turned(spin, tuple(blade[:, 2]), join(rotor.path, "blade_pitch"), -rotor.rotation)
        drawn.append(shapes.Loft(pitched, sections @ blade.T, material="blade"))
    return drawn


def still_rotor(frame: Any, radius: float, tilt: float, precone: float, blades: int = 3) -> list[shapes.Drawn]:
    """Blades that neither turn nor pitch, on a hub."""
    drawn: list[shapes.Drawn] = [shapes.Ball(frame, diameter=0.055 * radius, material="nacelle")]
    sections = typical_blade(0.02 * radius, radius)
    for k in range(blades):
        blade = _rotation(1, tilt) @ _rotation(0, 2 * np.pi * k / blades) @ _rotation(1, -precone)
        drawn.append(shapes.Loft(frame, sections @ blade.T, material="blade"))
    return drawn


def housing(frame: Any, rotor: Any) -> list[shapes.Drawn]:
    """A box from the hub over the tower, in proportion to the radius of the rotor; nothing for a rotor without one."""
    if "radius" not in rotor.parameters:
        return []
    centre, size = np.array([0.14 * rotor.side, 0, 0]), np.array([0.22, 0.085, 0.085])
    radius = rotor.parameter_value("radius")
    return [shapes.Box(frame, centre * radius, size * radius, material="nacelle")]


def _rotation(axis: int, angle: float) -> np.ndarray:
    """Rotation matrix about the axis 0, 1 or 2."""
    c, s = np.cos(angle), np.sin(angle)
    i, j = (axis + 1) % 3, (axis + 2) % 3
    matrix = np.eye(3)
    matrix[i, i], matrix[i, j], matrix[j, i], matrix[j, j] = c, -s, s, c
    return matrix
