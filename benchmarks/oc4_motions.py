"""Motions of the OC4 semisubmersible in waves by a second formulation: six equations in plain numpy.

(-omega^2 (M + A) + i omega B + C) xi = X with the WAMIT output of the report (A, B, X, hydrostatics: .1, .3 and .hst
files), the masses that are printed, and elastic catenaries of its own. Nothing of fowtlib's equations is in it.

Masses: A. Robertson et al., NREL/TP-5000-60601 (2014), platform with ballast; ElastoDyn file of OC4, tower; rotor and
nacelle from NREL/TP-500-38060. Lines: MoorDyn file of OC4.
"""

from __future__ import annotations

from collections.abc import Sequence
from importlib.resources import files

import numpy as np
import xarray
from scipy.optimize import fsolve

G, DENSITY = 9.80665, 1025.0
# kg, centre [m], inertia about it (xx, yy, zz) [kg m^2]: platform, tower, rotor and nacelle
PLATFORM = (1.3473e7, (0.0, 0.0, -13.46), (6.827e9, 6.827e9, 1.226e10))
BODIES = (
    PLATFORM,
    (249718.0, (0.0, 0.0, 43.348), (1.20252e8, 1.20252e8, 1.81846e6)),
    (350000.0, (-0.413771, 0.0, 89.567), (4.37e7, 2.33e7, 2.5e7)),
)
OF_MEMBERS = (1.3486e7, (0.0, 0.0, -13.43), (6.563e9, 6.563e9, 1.1727e10))  # what the members have, docs/floaters.md
BODIES_OF_MEMBERS = (OF_MEMBERS, *BODIES[1:])
FAIRLEAD, ANCHOR = (40.868, -14.0), (837.6, -200.0)  # radius, z [m]
LENGTH, MASS, DIAMETER, STIFFNESS = 835.35, 113.35, 0.0766, 753.6e6
HEADINGS = np.radians([60.0, 180.0, 300.0])


def mass_matrix(bodies: Sequence = BODIES) -> np.ndarray:
    """Of all bodies (mass, centre, inertia about it) about the origin, (6, 6)."""
    total = np.zeros((6, 6))
    for mass, centre, inertia in bodies:
        x, y, z = centre
        cross = np.array([[0, z, -y], [-z, 0, x], [y, -x, 0]])  # v = omega x r
        total[:3, :3] += mass * np.eye(3)
        total[:3, 3:] += mass * cross
        total[3:, :3] += mass * cross.T
        total[3:, 3:] += np.diag(inertia) + mass * cross.T @ cross
    return total


def weight_stiffness(bodies: Sequence = BODIES) -> np.ndarray:
    """What the weight adds to the hydrostatic stiffness, (6, 6)."""
    C = np.zeros((6, 6))
    for mass, (x, y, z), _ in bodies:
        C[3, 3] -= mass * G * z
        C[4, 4] -= mass * G * z
        C[3, 5] += mass * G * x
        C[4, 5] += mass * G * y
    return C


def line_pull(across: float, up: float) -> tuple[float, float]:
    """Horizontal and vertical force [N] of a line at its fairlead: elastic catenary, its end on the seabed."""
    w = (MASS - DENSITY * np.pi / 4 * DIAMETER**2) * G

    def residual(forces: np.ndarray) -> list[float]:
        H, V = np.exp(forces)
        span = LENGTH - V / w + H / w * np.arcsinh(V / H) + H * LENGTH / STIFFNESS
        rise = H / w * (np.sqrt(1 + (V / H) ** 2) - 1) + V**2 / (2 * w * STIFFNESS)
        return [span - across, rise - up]

    H, V = np.exp(fsolve(residual, np.log([9e5, 6e5]), xtol=1e-12))
    return float(H), float(V)


def line_loads(motion: np.ndarray) -> np.ndarray:
    """Force and moment (6,) of the three lines on the platform, about the origin that moves with it."""
    rx, ry, rz = motion[3:]
    R = (
        np.array([[np.cos(rz), -np.sin(rz), 0], [np.sin(rz), np.cos(rz), 0], [0, 0, 1]])
        @ np.array([[np.cos(ry), 0, np.sin(ry)], [0, 1, 0], [-np.sin(ry), 0, np.cos(ry)]])
        @ np.array([[1, 0, 0], [0, np.cos(rx), -np.sin(rx)], [0, np.sin(rx), np.cos(rx)]])
    )
    total = np.zeros(6)
    for angle in HEADINGS:
        out = np.array([np.cos(angle), np.sin(angle), 0])
        arm = R @ (FAIRLEAD[0] * out + [0, 0, FAIRLEAD[1]])
        way = ANCHOR[0] * out + [0, 0, ANCHOR[1]] - motion[:3] - arm
        across = float(np.hypot(*way[:2]))
        H, V = line_pull(across, -float(way[2]))
        force = np.array([*(H * way[:2] / across), -V])
        total += np.concatenate([force, np.cross(arm, force)])
    return total


def line_stiffness() -> np.ndarray:
    """Of the three lines where the platform is drawn, (6, 6)."""
    steps = np.array([1e-2, 1e-2, 1e-2, 1e-4, 1e-4, 1e-4])
    columns = [(line_loads(step) - line_loads(-step)) / (2 * step.sum()) for step in np.diag(steps)]
    return -np.array(columns).T


def _wamit() -> xarray.Dataset:
    return xarray.open_dataset(files("fowtlib.models") / "data" / "oc4_semi" / "hydrodynamics.nc")


def motions(frequencies: Sequence[float], bodies: Sequence = BODIES) -> np.ndarray:
    """Complex motions per metre of a wave of heading 0, (n, 6), m/m and rad/m, at frequencies [Hz]."""
    data = _wamit()
    omega = 2 * np.pi * np.asarray(frequencies)
    at = data.interp(omega=omega).sel(heading=0.0, method="nearest")
    A, B = (at[name].transpose("omega", "row", "column").values for name in ("added_mass", "radiation_damping"))
    X = (at["excitation_real"] + 1j * at["excitation_imaginary"]).transpose("omega", "mode").values
    C = data["hydrostatic_stiffness"].values + weight_stiffness(bodies) + line_stiffness()
    M = mass_matrix(bodies)
    w = omega[:, None, None]
    return np.linalg.solve(-(w**2) * (M + A) + 1j * w * B + C, X[..., None])[..., 0]


def natural_frequencies(bodies: Sequence = BODIES) -> np.ndarray:
    """Undamped, with the added mass at their own frequencies, [Hz], ascending."""
    data = _wamit()
    C = data["hydrostatic_stiffness"].values + weight_stiffness(bodies) + line_stiffness()
    M, found = mass_matrix(bodies), []
    for k in range(6):
        omega = 0.1
        for _ in range(30):
            A = data["added_mass"].interp(omega=max(omega, 0.02)).values
            squares = np.sort(np.linalg.eigvals(np.linalg.solve(M + A, C)).real)
            omega = float(np.sqrt(squares[k]))
        found.append(omega / (2 * np.pi))
    return np.array(found)
