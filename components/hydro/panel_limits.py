"""Up to which frequency a mesh is good: panels against the length of the waves, irregular frequencies without a lid.

Source: C.H. Lee and P.D. Sclavounos, Removing the irregular frequencies from integral equations in wave-body
interactions, J. Fluid Mech. 207 (1989) 393-418; for a box of length L, width B and draft T the lowest one is
omega^2 = g k coth(k T) with k = pi sqrt(1 / L^2 + 1 / B^2).
"""

from __future__ import annotations

import math

import numpy as np

from fowtlib.components.environment.waves import wave_number
from fowtlib.components.hydro.hull_mesh import HullMesh, waterlines, widths_of

_PER_WAVE = 4  # panels a wave must have along its length
_LEVEL = 0.7  # of the normal upright: 45 degrees
_REACH = 0.5  # wave lengths below the surface at which a wave has died out (exp(-pi) = 0.04)


def irregular_frequency(hull: HullMesh, g: float) -> float:
    """A lower bound of the lowest irregular frequency [rad/s], were there no lid; inf for a hull under water.

    By the formula for a box, for the box around each waterline and down to the keel: the water inside of a hull that
    fills its box less than wholly is stiffer.
    """
    lowest = math.inf
    for line in waterlines(hull.panels):
        length, width = np.ptp(line[:, :2], axis=0)
        k = math.pi * math.hypot(1 / length, 1 / width)
        lowest = min(lowest, math.sqrt(g * k / math.tanh(k * hull.draft)))
    return lowest


def good_up_to(hull: HullMesh, water_depth: float, g: float) -> float:
    """The highest frequency [rad/s], to 1 %, below which every wave has four panels on its length."""
    omega = np.geomspace(0.05, 20.0, 603)
    coarse = coarse_from(hull, omega, water_depth, g)
    return math.inf if coarse is None else coarse[0] / 1.01


def coarse_from(
    hull: HullMesh, omega: np.ndarray, water_depth: float, g: float
) -> tuple[float, float, np.ndarray] | None:
    """The first frequency [rad/s] whose waves are short against panels they reach; wave length [m]; one such panel.

    The panel by the place of its centre and its width (x, y, z, width) [m].

    None if every wave has four panels on its length, down to half of it.
    """
    panels = np.concatenate([hull.panels, hull.lid])
    width = widths_of(panels)
    depth = -panels[:, :, 2].max(axis=1)
    for frequency in omega:
        length = 2 * math.pi / float(wave_number(float(frequency), water_depth, g))
        wide = (_PER_WAVE * width > length * (1 + 1e-9)) & (depth < _REACH * length)
        if wide.any():
            worst = int(np.where(wide, width, 0).argmax())
            return float(frequency), length, np.append(panels[worst].mean(axis=0), width[worst])
    return None


def is_thin(panels: np.ndarray) -> bool:
    """Whether panels (n, 4, 3) that lie level are nearer to their image than they are wide, as in a thin plate afloat.

    The part of the flow by the water level then varies over a panel as the logarithm of the distance from its image.
    """
    normal = np.cross(panels[:, 2] - panels[:, 0], panels[:, 3] - panels[:, 1])
    level = np.abs(normal[:, 2]) > _LEVEL * np.linalg.norm(normal, axis=1)
    return bool((level & (widths_of(panels) > -2 * panels[:, :, 2].mean(axis=1))).any())


def warnings_of(hull: HullMesh, omega: np.ndarray, water_depth: float, g: float) -> list[str]:
    """Sentences about what is doubtful in a computation of these frequencies, with the frequency; none is good."""
    found = []
    if coarse := coarse_from(hull, omega, water_depth, g):
        frequency, length, (x, y, z, width) = coarse
        found.append(
            f"{hull.name}: from {frequency:.4g} rad/s on the panels are wide for the waves: {width:.3g} m at "
            f"({x:.4g}, {y:.4g}, {z:.4g}), the wave is {length:.3g} m long; expect errors of the small loads. Take "
            "smaller panels, or lower frequencies"
        )
    if not len(hull.lid) and (lowest := irregular_frequency(hull, g)) <= omega[-1]:
        beyond = omega[omega >= lowest]
        found.append(
            f"{hull.name}: without a lid there can be irregular frequencies from {lowest:.3g} rad/s on, where added "
            f"mass and damping jump; {beyond.size} of {omega.size} frequencies lie there, {beyond[0]:.4g} to "
            f"{beyond[-1]:.4g} rad/s. Give the hull a lid"
        )
    return found
