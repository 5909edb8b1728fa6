"""The panel method on the published mesh of the VolturnUS-S, against the published output of WAMIT for it.

    python benchmarks/panel_volturnus.py FOLDER [OMEGA ...]

FOLDER is the unzipped wheel of rosco 2.10.6 (Apache-2.0). Prints a table of docs/hydrodynamics.md; half a minute of one
core for each frequency [rad/s].
"""

from __future__ import annotations

import sys
import time
import warnings
from pathlib import Path

import numpy as np

from fowtlib.components.hydro import HydrodynamicDatabase
from fowtlib.components.hydro.gdf_files import read_gdf
from fowtlib.components.hydro.panel import solve_hull

HYDRO = "Examples/Test_Cases/IEA-15-240-RWT/IEA-15-240-RWT-UMaineSemi/HydroData"
DEPTH, RHO, G = 200.0, 1025.0, 9.80665
LOADS = [("A11", "A", 0, 0), ("A33", "A", 2, 2), ("A55", "A", 4, 4), ("A66", "A", 5, 5), ("A15", "A", 0, 4),
         ("B11", "B", 0, 0), ("B33", "B", 2, 2), ("B55", "B", 4, 4)]  # fmt: skip


def main(folder: Path, omega: list[float]) -> None:
    warnings.simplefilter("ignore")
    hull = read_gdf(folder / HYDRO / "wamit_inputs_1stOrder" / "IEA-15-240-RWT.gdf", leaky=True)
    wamit = HydrodynamicDatabase.from_wamit(
        folder / HYDRO / "IEA-15-240-RWT-UMaineSemi", volume=hull.volume, centre_of_buoyancy=hull.centre_of_buoyancy,
        rho=RHO, g=G, water_depth=DEPTH,
    )  # fmt: skip
    rows = [int(np.argmin(np.abs(wamit.omega - w))) for w in omega]
    started = time.process_time()
    panel = solve_hull(hull, omega=wamit.omega[rows], headings=[0.0], water_depth=DEPTH, rho=RHO, g=G)
    print(f"{len(hull.panels)} panels, {hull.symmetry}; {time.process_time() - started:.0f} s of processor time")
    print("| |", " | ".join(f"{w:.2g} rad/s" for w in wamit.omega[rows]), "|")
    heading = int(np.argmin(np.abs(wamit.heading)))
    for name, matrix, i, j in LOADS:
        own, other = getattr(panel, matrix)[:, i, j], getattr(wamit, matrix)[rows, i, j]
        print("|", name, "|", " | ".join(f"{a:.4g} ({a / b - 1:+.1%})" for a, b in zip(own, other, strict=True)), "|")
    for name, mode in (("X1", 0), ("X3", 2), ("X5", 4)):
        own, other = panel.X[:, 0, mode], wamit.X[rows, heading, mode]
        far = np.abs(own - other) / np.abs(other)
        print("|", name, "|", " | ".join(f"{abs(a):.4g} ({d:.1%})" for a, d in zip(own, far, strict=True)), "|")
    for name, mode in (("C33", 2), ("C44", 3), ("C55", 4)):
        print(name, panel.C[mode, mode], f"{panel.C[mode, mode] / wamit.C[mode, mode] - 1:+.2%}")
    for name, i, j in (("A_inf 11", 0, 0), ("A_inf 33", 2, 2), ("A_inf 55", 4, 4)):
        print(name, panel.A_inf[i, j], f"{panel.A_inf[i, j] / wamit.A_inf[i, j] - 1:+.2%}")


if __name__ == "__main__":
    main(Path(sys.argv[1]), [float(word) for word in sys.argv[2:]] or [0.2, 0.4, 0.7, 1.0, 1.5])
