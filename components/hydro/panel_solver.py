"""One frequency of the linear potential flow about a hull, by Capytaine; what was solved is kept.

Needs the extra: pip install "fowtlib[hydro]". Capytaine is imported when something is solved, never before.

The direct formulation (potentials as unknowns, as WAMIT does) is for slender spars far closer than the source
formulation with the same panels. Radiation and diffraction of a frequency are solved together, with one matrix. Of a
symmetric hull only a part is meshed (hull_mesh.Symmetry), which saves time and memory by nearly its fold; a body of
revolution is solved for surge, heave and pitch in waves along x, from which sway, roll and all headings follow.
Capytaine uses exp(-i omega t); its loads are conjugated to our exp(+i omega t).

The part of the flow by the water level is taken at one point of each panel; at four where level panels are wider than
twice their depth (panel_limits.is_thin), without which the damping of a thin plate errs by a tenth or more.

Shapes into which the hull deforms (hydro.deformation) are further motions behind the six rigid ones. They are given by
their displacements at the middles of the panels of the whole hull; symmetry of the hull still divides the matrix.

The results of a frequency lie in the folder of what is kept (`fowt cache`), under a digest of all that they follow
from: panels, lid, frequency, headings, depth, gravity, version of Capytaine, text of this module. They are per unit of
density.

Source: Ancellin and Dias, Capytaine: a Python-based linear potential flow solver, JOSS 4 (2019) 1341.
"""

from __future__ import annotations

import contextlib
import logging
from dataclasses import dataclass
from typing import Any

import numpy as np

from fowtlib.components.hydro.deformation import Deformation
from fowtlib.components.hydro.errors import MissingExtraError
from fowtlib.components.hydro.hull_mesh import HullMesh, Symmetry
from fowtlib.components.hydro.panel_limits import is_thin
from fowtlib.language.cache import cached, sources

_DOFS = ("Surge", "Sway", "Heave", "Roll", "Pitch", "Yaw")
_ROUND_DOFS = ("Surge", "Heave", "Pitch")


@dataclass(frozen=True, eq=False)
class Flow:
    """Added mass A and damping B (m, m) and wave load X (nh, m) per amplitude, all divided by the density.

    m: six rigid motions, then the shapes.
    """

    A: np.ndarray
    B: np.ndarray
    X: np.ndarray


class PanelSolver:
    """Solves one frequency after the other for a hull [m] in water of a depth [m, inf: deep] and gravity [m/s^2].

    deformation: the shapes besides the rigid motions. Raises MissingExtraError without Capytaine.
    """

    def __init__(self, hull: HullMesh, water_depth: float, g: float, deformation: Deformation | None = None):
        self.capytaine = _capytaine()
        self.hull, self.water_depth, self.g = hull, water_depth, g
        self.part, self.lid = (hull.part(panels) if len(panels) else panels for panels in (hull.panels, hull.lid))
        self._round = hull.symmetry.round and deformation is None
        self._shapes = self._shapes_of(deformation) if deformation is not None else np.zeros((0, 0, 3))
        self._quadrature = "Gauss-Legendre 2" if is_thin(self.part) else None
        self._dofs = (*_DOFS, *(f"shape {k + 1}" for k in range(len(self._shapes))))
        self._body: Any = None
        self._bem: Any = None

    @property
    def unknowns(self) -> int:
        """Panels of the part that is meshed, with its lid."""
        return len(self.part) + len(self.lid)

    @property
    def about(self) -> str:
        """One line on the origin of what it finds."""
        return f"Capytaine {self.capytaine.__version__}, {len(self.hull.panels)} panels"

    def solve(self, omega: float, headings: np.ndarray) -> Flow:
        """The flow at a frequency [rad/s, also 0 in deep water, and inf] and headings (nh,) [rad]; kept, if it can be.

        Without headings X is (0, m): at zero and infinite frequency there are no waves.
        """
        headings = np.asarray(headings, dtype=float)
        about = f"{omega!r} {self.water_depth!r} {self.g!r} {self.hull.symmetry} {self._quadrature}"
        given = [self.part, self.lid, headings, *([self._shapes] if self._shapes.size else [])]
        found = cached("panels", [about, self.capytaine.__version__, *given, *sources(__name__)],
                       lambda: self._solve(omega, headings))  # fmt: skip
        X = np.array(found["X_real"]) + 1j * np.array(found["X_imaginary"])
        return Flow(np.array(found["A"]), np.array(found["B"]), X.reshape(-1, len(self._dofs)))

    def _solve(self, omega: float, headings: np.ndarray) -> dict[str, np.ndarray]:
        cpt, symmetric, count = self.capytaine, self._round, len(self._dofs)
        if self._body is None:
            with _quiet("capytaine"):
                self._body, self._bem = self._floating_body(), cpt.BEMSolver(method="direct")
        flow = {"body": self._body, "omega": omega, "water_depth": self.water_depth, "rho": 1.0, "g": self.g}
        waves = headings if not symmetric else [0.0] * bool(headings.size)
        problems = [cpt.RadiationProblem(radiating_dof=dof, **flow) for dof in self._body.dofs]
        problems += [cpt.DiffractionProblem(wave_direction=float(wave), **flow) for wave in waves]
        A, B, X = np.zeros((count, count)), np.zeros((count, count)), np.zeros((len(waves), count), dtype=complex)
        _draw_alike()
        with _quiet("capytaine"):
            results = self._bem.solve_all(problems, progress_bar=False, _check_wavelength=False, keep_details=False)
        for k, result in enumerate(results):
            if error := getattr(result, "exception", None):  # Capytaine goes on after a failure
                raise error
            wave = k - len(self._body.dofs)
            for dof in self._body.dofs:
                row = self._dofs.index(dof)
                if wave < 0:
                    A[row, self._dofs.index(result.radiating_dof)] = result.added_masses[dof]
                    B[row, self._dofs.index(result.radiating_dof)] = result.radiation_dampings[dof]
                else:
                    X[wave, row] = np.conj(result.forces[dof])
        for wave, problem in enumerate(problems[len(self._body.dofs) :]):
            for dof, load in cpt.bem.airy_waves.froude_krylov_force(problem).items():
                X[wave, self._dofs.index(dof)] += np.conj(load)
        if symmetric:
            A, B = _turned(A), _turned(B)
            X = _all_headings(X[0], headings) if headings.size else X
        return {"A": A, "B": B, "X_real": X.real, "X_imaginary": X.imag}

    def _floating_body(self) -> Any:
        symmetry = self.hull.symmetry
        lid = _mesh(self.capytaine, self.lid, symmetry, self._quadrature) if len(self.lid) else None
        dofs = self.capytaine.rigid_body_dofs(only=list(_ROUND_DOFS) if self._round else None,
                                              rotation_center=(0, 0, 0))  # fmt: skip
        mesh = _mesh(self.capytaine, self.part, symmetry, self._quadrature)
        body = self.capytaine.FloatingBody(mesh=mesh, lid_mesh=lid, dofs=dofs, name="floater")
        for name, shape in zip(self._dofs[len(_DOFS) :], self._shapes, strict=True):
            body.dofs[name] = shape
        return body

    def _shapes_of(self, deformation: Deformation) -> np.ndarray:
        """Displacements (m, n, 3) at the middles of the panels, in the order that Capytaine has for the whole hull."""
        return deformation(np.asarray(_mesh(self.capytaine, self.part, self.hull.symmetry).faces_centers)).displacement


def _draw_alike() -> None:
    """The same numbers each time: Capytaine fits its waves of finite depth at points that it draws, felt by 4e-5."""
    from capytaine.tools import prony_decomposition

    prony_decomposition.RNG = np.random.default_rng(0)


def _mesh(cpt: Any, part: np.ndarray, symmetry: Symmetry, quadrature: str | None = None) -> Any:
    faces = np.arange(4 * len(part)).reshape(-1, 4)
    mesh = cpt.Mesh(vertices=part.reshape(-1, 3), faces=faces, quadrature_method=quadrature)
    if symmetry.rotation > 1:
        return cpt.RotationSymmetricMesh(mesh, n=symmetry.rotation)
    for plane in symmetry.planes:
        mesh = cpt.ReflectionSymmetricMesh(mesh, plane=plane)
    return mesh


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


def _capytaine() -> Any:
    try:
        import capytaine
    except ImportError:
        raise MissingExtraError(
            'the panel method needs Capytaine, which is not installed: pip install "fowtlib[hydro]"'
        ) from None
    return capytaine


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
