"""Hydrodynamic coefficients by the boundary element method, with the optional package Capytaine (module panel_solver).

From members (`compute`) or from any mesh of a hull (`solve_hull`) to the database that LinearPotentialFlow reads. Lids
on the water inside of the columns remove the irregular frequencies; symmetry is found in the mesh and used. A and B are
made symmetric, as reciprocity demands; a mesh that misses this by more than 5 % is refused. Each frequency is kept as
soon as it is solved: a computation that was stopped goes on from there, one with more frequencies computes only these.
"""

from __future__ import annotations

import contextlib
import math
import tempfile
import warnings
from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from fowtlib.components.hydro.conventions import check_conventions
from fowtlib.components.hydro.database import HydrodynamicDatabase
from fowtlib.components.hydro.deformation import Deformation, shape_stiffness
from fowtlib.components.hydro.errors import HydrodynamicDataError
from fowtlib.components.hydro.hull_mesh import HullMesh
from fowtlib.components.hydro.modal_database import ModalDatabase
from fowtlib.components.hydro.panel_limits import warnings_of
from fowtlib.components.hydro.panel_mesh import Column, Pontoon, members_mesh
from fowtlib.components.hydro.panel_solver import PanelSolver
from fowtlib.language.errors import ModelError

Progress = Callable[[float, float], None]

_Database = TypeVar("_Database", HydrodynamicDatabase, ModalDatabase)
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
    progress: Progress | None = None,
) -> HydrodynamicDatabase:
    """Mesh the floater with panels of `panel_size` [m] and do what `solve_hull` does.

    Raises ParameterError for a floater that cannot be meshed, or whose mesh has another volume than its members.
    """
    hull = members_mesh(list(columns), list(pontoons), panel_size)
    return solve_hull(hull, omega=omega, headings=headings, water_depth=water_depth, rho=rho, g=g, source=source,
                      path=path, progress=progress)  # fmt: skip


def solve_hull(
    hull: HullMesh,
    *,
    omega: Iterable[float],
    headings: Iterable[float],
    water_depth: float = math.inf,
    rho: float = 1025.0,
    g: float = 9.80665,
    source: str = "",
    path: str | Path | None = None,
    progress: Progress | None = None,
) -> HydrodynamicDatabase:
    """Solve radiation and diffraction of a hull; the database about (0, 0, 0) on the water level.

    omega [rad/s], headings [rad], water_depth [m, inf: deep]. A_inf is solved at infinite frequency, A_zero at the
    lowest frequency that the method takes (wave number times depth 0.25; zero in deep water). Time and memory grow with
    the square of the number of panels, divided by the fold of the symmetry (one column of 2700 panels: about 1 s a
    frequency).

    path: the netCDF file that the database is written to; it is made sure first that it can be. progress is called with
    the number of frequencies that are done, and of all. Nothing is lost when the computation is stopped, or when the
    checks at its end refuse the result: what was solved is kept (`fowt cache`), and the same call takes it up.

    Raises MissingExtraError without Capytaine, HydrodynamicDataError for frequencies out of range; warns, with the
    frequency, of panels that are wide for their waves, and of irregular frequencies of a hull without a lid.
    """
    solver, found = _solved(hull, omega, headings, water_depth, rho, g, path, progress, None)
    with _kept_when_refused():
        database = HydrodynamicDatabase(  # its checks come first: they refuse what is far from symmetric
            **found, **_of_hull(hull, water_depth, rho, g), source=source or solver.about
        )
        database = _made_symmetric(database)
        check_conventions(database)
    if path is not None:
        database.write(path)
    return database


def solve_shapes(
    hull: HullMesh,
    deformation: Deformation,
    nodes: np.ndarray,
    shapes: np.ndarray,
    at_rest: np.ndarray | None = None,
    *,
    omega: Iterable[float],
    headings: Iterable[float],
    water_depth: float = math.inf,
    rho: float = 1025.0,
    g: float = 9.80665,
    source: str = "",
    path: str | Path | None = None,
    progress: Progress | None = None,
) -> ModalDatabase:
    """The same of a hull that deforms as `deformation` says, besides its rigid motions.

    nodes (p, 3) [m] and shapes (k, p, 6): what of the structure moves with each shape, for who reads the database;
    at_rest (p, 6) [N, N m]: what the water at rest does to each node, zero without.
    """
    solver, found = _solved(hull, omega, headings, water_depth, rho, g, path, progress, deformation)
    stiffness = shape_stiffness(hull.panels, deformation)
    with _kept_when_refused():
        database = ModalDatabase(
            **found, **_of_hull(hull, water_depth, rho, g), among=rho * g * (stiffness.among + stiffness.among.T) / 2,
            with_rigid=rho * g * stiffness.with_rigid, nodes=nodes, shapes=shapes,
            at_rest=np.zeros((len(nodes), 6)) if at_rest is None else at_rest, source=source or solver.about,
        )  # fmt: skip
        database = _made_symmetric(database)
        check_conventions(database.rigid)
    if path is not None:
        database.write(path)
    return database


def _solved(
    hull: HullMesh, omega: Iterable[float], headings: Iterable[float], water_depth: float, rho: float, g: float,
    path: str | Path | None, progress: Progress | None, deformation: Deformation | None,
) -> tuple[PanelSolver, dict[str, np.ndarray]]:  # fmt: skip
    """What the solver finds at all frequencies, by the names of a database."""
    omega = np.unique(np.asarray(list(omega), dtype=float))
    headings = np.unique(np.asarray(list(headings), dtype=float))
    lowest = _check(omega, headings, water_depth, g)
    if path is not None:
        _check_target(Path(path))
    for sentence in warnings_of(hull, omega, water_depth, g):
        warnings.warn(f"{sentence}.", stacklevel=3)
    solver = PanelSolver(hull, water_depth, g, deformation)
    flows = []
    for k, frequency in enumerate(frequencies := [math.inf, lowest, *omega.tolist()]):
        flows.append(solver.solve(frequency, headings if k > 1 else np.zeros(0)))
        if progress:
            progress(k + 1, len(frequencies))
    A, B = (rho * np.array([getattr(flow, name) for flow in flows]) for name in "AB")
    X = rho * np.array([flow.X for flow in flows[2:]])
    for part in (X.real, X.imag):
        part[np.abs(part) < _NOISE * np.abs(X).max(axis=(0, 1))] = 0.0
    return solver, {"omega": omega, "heading": headings, "A": A[2:], "B": B[2:], "A_inf": A[0], "A_zero": A[1], "X": X}


def _of_hull(hull: HullMesh, water_depth: float, rho: float, g: float) -> dict[str, Any]:
    return {"C": rho * g * hull.stiffness, "volume": hull.volume, "centre_of_buoyancy": hull.centre_of_buoyancy,
            "rho": rho, "g": g, "water_depth": water_depth}  # fmt: skip


def _made_symmetric(database: _Database) -> _Database:
    return replace(database, **{name: _symmetric(getattr(database, name)) for name in ("A", "B", "A_inf", "A_zero")})


@contextlib.contextmanager
def _kept_when_refused():
    try:
        yield
    except ModelError as error:
        error.message = (f"{error.message.rstrip('.')}. If it is the mesh, take smaller panels. What was solved is "
                         "kept (`fowt cache`), no frequency is lost")
        raise


@dataclass(frozen=True)
class MeshStudy:
    """One row of a study of the mesh size: panels about `size` [m] wide, and the database that they give."""

    size: float
    hull: HullMesh
    database: HydrodynamicDatabase


def mesh_study(
    mesh: Callable[[float], HullMesh], sizes: Iterable[float], *, progress: Progress | None = None, **options
) -> list[MeshStudy]:
    """Databases for several panel sizes [m], from the coarsest to the finest; options: those of `solve_hull`.

    mesh makes the hull of a size, for example `lambda size: members_mesh(columns, pontoons, size)`.
    """
    sizes = sorted(set(map(float, sizes)), reverse=True)
    rows = []
    for k, size in enumerate(sizes):
        def report(done: float, total: float, k: int = k) -> None:
            if progress:
                progress(k + done / total, len(sizes))

        hull = mesh(size)
        rows.append(MeshStudy(size, hull, solve_hull(hull, progress=report, **options)))
    return rows


def _check(omega: np.ndarray, headings: np.ndarray, water_depth: float, g: float) -> float:
    """The lowest frequency that the method takes [rad/s]; refuse those below it."""
    if not (water_depth > 0 and g > 0):
        raise HydrodynamicDataError(f"panel method: depth and gravity must be positive, found {water_depth:g} m and "
                                    f"{g:g} m/s^2")
    deep = math.isinf(water_depth)
    lowest = 0.0 if deep else math.sqrt(g / water_depth * _SHALLOWEST * math.tanh(_SHALLOWEST))
    if omega.size < 2 or omega[0] <= 0 or omega[0] < lowest or not np.isfinite(omega).all():
        raise HydrodynamicDataError("panel method: two frequencies or more are needed, finite and at least "
                                    f"{lowest:.3g} rad/s at the depth {water_depth:g} m; found "
                                    f"{', '.join(f'{value:g}' for value in omega[:3])}{' ...' * (omega.size > 3)}")
    if not headings.size or not np.isfinite(headings).all():
        raise HydrodynamicDataError("panel method: one heading or more is needed, all finite")
    return lowest


def _symmetric(M: np.ndarray) -> np.ndarray:
    return (M + np.swapaxes(M, -1, -2)) / 2


def _check_target(target: Path) -> None:
    if not target.parent.is_dir():
        raise ModelError(f"{target}: the folder {target.parent} does not exist; make it first, or choose another one.")
    try:
        with tempfile.TemporaryFile(dir=target.parent):
            pass
        if target.exists():
            with target.open("ab"):
                pass
    except OSError as error:
        raise ModelError(f"{target}: cannot be written: {error.strerror or error}.") from None
