"""Rotors in the frequency domain by closed formulas: a steady thrust coefficient, no controller, no yawed inflow.

The set of S. Lamei, M. Hayatdavoodi and H.R. Riggs (IWWWFB 2022), equations 2 to 6, beside which the linear model of a
whole turbine stands (`fowtlib.frequency.response`, `fowtlib.linear_rao`). What is doubtful in it:

- its damping of a rotor is printed without the area of the rotor, which its dimension demands; it is here with it,
- rho A C_T V is the slope of the thrust at a fixed C_T. The slope of a rotor whose speed is held and whose C_T falls
  with the wind is smaller; with a controller that holds the power it may be negative,
- the wind load that oscillates with the wave, with a phase from the diffraction about a column (MacCamy and Fuchs,
  1954) of the radius of the tower top, has no cause in the air. It is a function of its own; nothing else uses it.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.special import jvp, yvp

Floats = NDArray[np.float64]
Complexes = NDArray[np.complex128]


def thrust_damping(density: float, area: float, thrust_coefficient: float, speed: float) -> float:
    """Damping rho A C_T V [N s/m] of one rotor against its motion along the wind, in SI units: equation 3."""
    return density * area * thrust_coefficient * speed


def rotor_damping(damping: float, hubs: Sequence[ArrayLike]) -> Floats:
    """Damping (6, 6) of rotors at hubs (3,) [m] from the reference point, SI; the wind blows along x.

    A hub moves along x by surge + z pitch - y yaw. The source has surge and pitch only, with z from the centre of
    gravity; for the reference point of the other matrices it must be from there.
    """
    rows = np.array([[1.0, 0.0, 0.0, 0.0, z, -y] for _, y, z in np.asarray(hubs, dtype=float)])
    return damping * rows.T @ rows


def wave_phase(wave_number: ArrayLike, radius: float) -> Floats:
    """Phase delta = -atan(Y1'(k r) / J1'(k r)) [rad] of the load on a column of this radius [m]: equation 5."""
    kr = np.asarray(wave_number, dtype=float) * radius
    return -np.arctan(yvp(1, kr) / jvp(1, kr))


def wind_at_wave_frequency(
    thrust: float, wave_number: ArrayLike, radius: float, hubs: Sequence[ArrayLike]
) -> Complexes:
    """Load (n, 6) of a thrust [N] of each rotor that oscillates with the wave, for exp(+i omega t): equation 4."""
    rows = np.array([[1.0, 0.0, 0.0, 0.0, z, -y] for _, y, z in np.asarray(hubs, dtype=float)])
    return thrust * np.exp(-1j * wave_phase(wave_number, radius))[:, None] * rows.sum(axis=0)


def motions(
    omega: ArrayLike, mass: ArrayLike, added_mass: ArrayLike, damping: ArrayLike, stiffness: ArrayLike, load: ArrayLike
) -> Complexes:
    """Motions (n, 6) at circular frequencies omega (n,) under loads (n, 6), for exp(+i omega t), SI: equation 6.

    mass, stiffness (6, 6); added_mass, damping (6, 6) or (n, 6, 6), the damping of rotors added to that of the water.
    """
    w = np.asarray(omega, dtype=float)[:, None, None]
    M, A, B, C = (np.asarray(matrix, dtype=float) for matrix in (mass, added_mass, damping, stiffness))
    return np.linalg.solve(-(w**2) * (M + A) + 1j * w * B + C, np.asarray(load)[:, :, None])[:, :, 0]
