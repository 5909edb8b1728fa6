"""Hydrodynamic coefficients by the boundary element method, with the optional package Capytaine.

Needs the extra: pip install "fowtlib[hydro]". Capytaine is imported when `compute` is called, never before.

The linear potential-flow problem is solved with the direct formulation (potentials as unknowns, as WAMIT does), which
for slender spars is far closer than the source formulation with the same panels. A single column is solved as a body of
revolution: surge, heave and pitch in waves along x; sway, roll and all headings follow from the symmetry. Lids on the
water inside of the columns remove the irregular frequencies. A and B are made symmetric, as reciprocity demands;
a mesh that misses this by more than 5 % is refused. Capytaine uses exp(-i omega t); its loads are conjugated
to our exp(+i omega t).

Source: Ancellin and Dias, Capytaine: a Python-based linear potential flow solver, JOSS 4 (2019) 1341.
"""

from __future__ import annotations

import contextlib
import logging
import math
import warnings
from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path

import numpy as np

from fowtlib.components.hydro import panel_mesh
from fowtlib.components.hydro.conventions import check_conventions
from fowtlib.components.hydro.database import HydrodynamicDatabase
from fowtlib.components.hydro.errors import HydrodynamicDataError, MissingExtraError
from fowtlib.components.hydro.panel_mesh import Column, Pontoon
from fowtlib.components.hydro.panel_store import Store
from fowtlib.language.errors import ModelError

_DOFS = ("Surge", "Sway", "Heave", "Roll", "Pitch", "Yaw")
_SHALLOWEST = 0.25  # smallest wave number times depth that Capytaine's finite-depth function takes, with a margin
_NOISE = 1e-7  # of the largest load: what symmetry makes zero


def compute(
    columns: Iterable[Column],
    pontoons: Iterable[Pontoon] = (),
    *,
    omega: Iterable[float],
    headings: Iterable[float],
    water_depth: float = math.inf,
    rho: float = 1025.0,
    g: float = 9.80665,
    panel_size: float = 2.0,
    source: str = "",
    path: str | Path | None = None,
) -> HydrodynamicDatabase:
    """Mesh the floater, solve radiation and diffraction, and return the database about (0, 0, 0) on the water level.

    omega [rad/s], headings [rad], water_depth [m, inf: deep], panel_size [m]. A_inf is solved at infinite frequency,
    A_zero at the lowest frequency that the method takes (wave number times depth 0.25; zero in deep water).
    Time and memory grow with the square of the number of panels (one column of 2700 panels: about 1 s a frequency).

    path: the netCDF file that the database is written to. It is made sure first that it can be written; each frequency
    is kept beside it, in `<path>.partial.npz`, as soon as it is solved, and the same call takes up what it finds there.
    So nothing is lost when the computation is stopped, or when the checks at its end refuse the result.

    Raises MissingExtraError without Capytaine, ParameterError for a floater that cannot be meshed,
    HydrodynamicDataError for frequencies out of range; warns of panels wider than a quarter of the shortest wave.
    """
    cpt = _capytaine()
    columns, pontoons = list(columns), list(pontoons)
    omega = np.unique(np.asarray(list(omega), dtype=float))
    headings = np.asarray(list(headings), dtype=float)
    asked = (columns, pontoons, omega.tolist(), headings.tolist(), water_depth, rho, g, panel_size, cpt.__version__)
    store = Store(path, asked)
    deep = math.isinf(water_depth)
    lowest = 0.0 if deep else math.sqrt(g / water_depth * _SHALLOWEST * math.tanh(_SHALLOWEST))
    if omega.size == 0 or omega[0] <= 0 or omega[0] < lowest or not np.isfinite(omega).all():
        raise HydrodynamicDataError(f"panel method: the frequencies must be finite and at least {lowest:.3g} rad/s at "
                                    f"the depth {water_depth:g} m")
    if panel_size > (shortest := 2 * math.pi * g / omega[-1] ** 2) / 4:
        limit = math.sqrt(math.pi * g / 2 / panel_size)
        warnings.warn(f"panels of {panel_size:g} m are wide for the shortest waves of {shortest:.2g} m: expect "
                      f"errors of the small loads above {limit:.2g} rad/s", stacklevel=2)
    panels = panel_mesh.floater_mesh(columns, pontoons, panel_size)
    volume, buoyancy, C = panel_mesh.hydrostatics(panels)
    round_body = len(columns) == 1 and not pontoons and columns[0].x == columns[0].y == 0
    lid = panel_mesh.lid_panels(columns, pontoons, panel_size)
    body = _round_body(cpt, columns[0], panel_size) if round_body else _body(cpt, panels, lid)
    solver = cpt.BEMSolver(method="direct")
    flow = {"body": body, "water_depth": water_depth, "rho": rho, "g": g}

    def radiation(frequency):
        A, B = np.zeros((6, 6)), np.zeros((6, 6))
        problems = [cpt.RadiationProblem(omega=frequency, radiating_dof=dof, **flow) for dof in body.dofs]
        for result in solver.solve_all(problems, progress_bar=False):
            column = _DOFS.index(result.radiating_dof)
            for dof in body.dofs:
                A[_DOFS.index(dof), column] = result.added_masses[dof]
                B[_DOFS.index(dof), column] = result.radiation_dampings[dof]
        return (_turned(A), _turned(B)) if round_body else (A, B)

    def excitation(frequency):
        waves = [0.0] if round_body else list(headings)
        problems = [cpt.DiffractionProblem(omega=frequency, wave_direction=wave, **flow) for wave in waves]
        X = np.zeros((len(waves), 6), dtype=complex)
        for k, result in enumerate(solver.solve_all(problems, progress_bar=False)):
            krylov = cpt.bem.airy_waves.froude_krylov_force(result.problem)
            for dof in body.dofs:
                X[k, _DOFS.index(dof)] = np.conj(result.forces[dof] + krylov[dof])
        return _all_headings(X[0], headings) if round_body else X

    with _quiet("capytaine"):
        A_inf, A_zero = (store.once(f"A_{w:.17g}", lambda w=w: np.array(radiation(w)))[0] for w in (np.inf, lowest))
        solved = [store.once(f"A_{w:.17g}", lambda w=w: np.array(radiation(w))) for w in omega]
        A, B = (np.array(m) for m in zip(*solved, strict=True))
        X = np.array([store.once(f"X_{w:.17g}", lambda w=w: excitation(w)) for w in omega])
    for part in (X.real, X.imag):
        part[np.abs(part) < _NOISE * np.abs(X).max(axis=(0, 1))] = 0.0
    try:
        database = HydrodynamicDatabase(  # its checks come first: they refuse what is far from symmetric
            omega=omega, heading=headings, A=A, B=B, A_inf=A_inf, A_zero=A_zero, X=X, C=rho * g * C,
            volume=volume, centre_of_buoyancy=buoyancy, rho=rho, g=g, water_depth=water_depth,
            source=source or f"Capytaine {cpt.__version__}, {len(panels)} panels",
        )
        database = replace(database, **{name: (M + np.swapaxes(M, -1, -2)) / 2 for name, M in
                                        (("A", A), ("B", B), ("A_inf", A_inf), ("A_zero", A_zero))})
        check_conventions(database)
    except ModelError as error:
        if store.path is not None:
            kept = f"What was solved is kept in {store.path} (arrays by NumPy's load)."
            error.message = f"{error.message.rstrip('.')}. {kept}"
        raise
    if path is not None:
        database.write(path)
        store.finish()
    return database


@contextlib.contextmanager
def _quiet(name: str):
    """Keep the logger from warning of every frequency; what matters is checked here."""
    logger = logging.getLogger(name)
    level = logger.level
    logger.setLevel(logging.ERROR)
    try:
        yield
    finally:
        logger.setLevel(level)


def _capytaine():
    try:
        import capytaine
    except ImportError:
        raise MissingExtraError(
            'the panel method needs Capytaine, which is not installed: pip install "fowtlib[hydro]"') from None
    return capytaine


def _round_body(cpt, column: Column, size: float):
    outline = panel_mesh.profile(column, size)
    number = panel_mesh.sides(max(d for _, d in column.wetted()), size)
    factor = panel_mesh.round_factor(number)

    def revolve(r, z):
        points = np.stack([r * factor, np.zeros_like(r), z], axis=1)
        return cpt.RotationSymmetricMesh.from_profile_points(points, n=number)

    lid = None
    radius, top = outline[-1]
    if radius > 0 and top == 0:
        rings = np.linspace(0, radius, max(2, math.ceil(radius / size)) + 1)
        lid = revolve(rings, np.zeros_like(rings))
    dofs = cpt.rigid_body_dofs(only=["Surge", "Heave", "Pitch"], rotation_center=(0, 0, 0))
    return cpt.FloatingBody(mesh=revolve(outline[:, 0], outline[:, 1]), lid_mesh=lid, dofs=dofs, name="column")


def _body(cpt, panels: np.ndarray, lid: np.ndarray):
    def mesh(part, name):
        return cpt.Mesh(vertices=part.reshape(-1, 3), faces=np.arange(4 * len(part)).reshape(-1, 4), name=name)

    dofs = cpt.rigid_body_dofs(rotation_center=(0, 0, 0))
    return cpt.FloatingBody(mesh=mesh(panels, "hull"), lid_mesh=mesh(lid, "lid") if len(lid) else None, dofs=dofs,
                            name="floater")


def _turned(M: np.ndarray) -> np.ndarray:
    """Sway and roll of a body of revolution from its surge and pitch (a quarter turn about z)."""
    full = M.copy()
    full[1, 1], full[3, 3] = M[0, 0], M[4, 4]
    full[1, 3], full[3, 1] = -M[0, 4], -M[4, 0]
    return full


def _all_headings(X: np.ndarray, headings: np.ndarray) -> np.ndarray:
    """Loads (nh, 6) of a body of revolution from those in waves along x: its loads turn with the waves."""
    cos, sin = np.cos(headings), np.sin(headings)
    return np.stack([X[0] * cos, X[0] * sin, X[2] * np.ones_like(cos), -X[4] * sin, X[4] * cos, 0 * cos], axis=1)
