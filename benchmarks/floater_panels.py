"""Convergence in the size of panels: the OC4 semisubmersible by its members, solved by Capytaine, beside WAMIT.

    .venv/bin/python benchmarks/floater_panels.py [SIZE ...]

Needs the extra hydro. One frequency, 0.6 rad/s, in 200 m; two minutes with the sizes of docs/floaters.md.
"""

import logging
import sys
from pathlib import Path

import capytaine as cpt
import numpy as np

import fowtlib as fw
from fowtlib.components.hydro import HydrodynamicDatabase

MODELS = Path(__file__).parents[1] / "models"
ENTRIES = (("Surge", 0), ("Heave", 2), ("Pitch", 4))


def body(hull, size):
    """The wetted hull with its lids as a floating body."""
    meshes = [cpt.Mesh(vertices=part.reshape(-1, 3), faces=np.arange(4 * len(part)).reshape(-1, 4))
              for part in (hull.panels(size), hull.lids(size))]  # fmt: skip
    dofs = cpt.rigid_body_dofs(only=[name for name, _ in ENTRIES], rotation_center=(0, 0, 0))
    return cpt.FloatingBody(mesh=meshes[0], lid_mesh=meshes[1], dofs=dofs, name="floater")


def solved(floating, omega):
    """Added mass and damping of the entries."""
    problems = [cpt.RadiationProblem(body=floating, omega=omega, radiating_dof=name, water_depth=200.0, rho=1025.0,
                                     g=9.80665) for name, _ in ENTRIES]  # fmt: skip
    results = cpt.BEMSolver(method="direct").solve_all(problems, progress_bar=False)
    return [[getattr(r, name)[r.radiating_dof] for r in results] for name in ("added_masses", "radiation_dampings")]


if __name__ == "__main__":
    logging.disable(logging.WARNING)
    known = HydrodynamicDatabase.read(MODELS / "data" / "oc4_semi" / "hydrodynamics.nc")
    row = int(np.argmin(np.abs(known.omega - 0.6)))
    hull = fw.load(MODELS / "platforms" / "oc4_semi_unmoored.yaml").root.hull.hull()
    print("size panels  A11 A33 A55  B11 B33 B55")
    for size in map(float, sys.argv[1:] or ("4", "3", "2.5", "2.1")):
        floating = body(hull, size)
        A, B = solved(floating, float(known.omega[row]))
        print(f"{size:g} m {floating.mesh.nb_faces}", *(f"{value:.4g}" for value in (*A, *B)), flush=True)
    print("WAMIT", *(f"{matrix[row, k, k]:.4g}" for matrix in (known.A, known.B) for _, k in ENTRIES))
