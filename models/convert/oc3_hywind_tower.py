"""Convert the distributed properties of the OC3 Hywind tower to CSV and print its mass, centre and inertia.

    python models/convert/oc3_hywind_tower.py FOLDER

FOLDER is the unzipped wheel of fowt-force-gen 0.1.0 (MIT). Heights become metres above the still water level (tower
from 10 m to 87.6 m). That file has no torsional and axial stiffness: they follow from the same thin steel tube, GJ =
2 EI G/E and EA = E m / rho, with E 210 GPa, G 80.8 GPa, rho 8500 kg/m^3 (Jonkman 2010, NREL/TP-500-47535, chapter 2);
outer diameter 6.5 m to 3.87 m and wall 27 mm to 19 mm, both linear, reproduce the columns (checked here).
"""

import sys
from pathlib import Path

import numpy as np

TARGET = Path(__file__).parents[1] / "data" / "oc3_hywind" / "tower.csv"
BASE, TOP = 10.0, 87.6
E, G, DENSITY = 210e9, 80.8e9, 8500.0
HEAD = """\
# OC3 Hywind tower, distributed properties. z: height above the still water level; linear between the stations.
# Source: fowt-force-gen 0.1.0 (MIT), OC3Hywind_ElastoDyn_Tower.dat; Jonkman (2010), NREL/TP-500-47535, chapter 2.
# Torsion and axial stiffness, diameter and wall: from the same tube, see models/convert/oc3_hywind_tower.py.
"""
COLUMNS = (
    "z_m,mass_per_length_kg_per_m,bending_stiffness_fore_aft_N_m2,bending_stiffness_side_side_N_m2,"
    "torsional_stiffness_N_m2,axial_stiffness_N,outer_diameter_m,wall_thickness_m"
)


def convert(folder: Path, target: Path = TARGET) -> None:
    """Write `target` from the unzipped wheel in `folder`."""
    source = folder / "fowt_force_gen" / "fast_input_files" / "OC3Hywind_ElastoDyn_Tower.dat"
    lines = source.read_text().splitlines()
    start = next(i for i, line in enumerate(lines) if line.split()[:1] == ["HtFract"]) + 2
    fraction, mass, fore_aft, side_side = np.array([line.split() for line in lines[start : start + 11]], dtype=float).T
    z = BASE + fraction * (TOP - BASE)
    diameter = 6.5 + fraction * (3.87 - 6.5)
    wall = 0.027 + fraction * (0.019 - 0.027)
    area = np.pi / 4 * (diameter**2 - (diameter - 2 * wall) ** 2)
    inertia = np.pi / 64 * (diameter**4 - (diameter - 2 * wall) ** 4)
    print(
        f"tube against columns: mass {np.abs(DENSITY * area / mass - 1).max():.1e}, "
        f"bending {np.abs(E * inertia / fore_aft - 1).max():.1e}"
    )
    columns = np.c_[z, mass, fore_aft, side_side, 2 * G / E * fore_aft, E * mass / DENSITY, diameter, wall]
    target.parent.mkdir(parents=True, exist_ok=True)
    target.write_text(HEAD + COLUMNS + "\n" + "".join(",".join(f"{v:.6g}" for v in row) + "\n" for row in columns))

    fine = np.linspace(BASE, TOP, 77601)
    m = np.interp(fine, z, mass)
    d, t = np.interp(fine, z, diameter), np.interp(fine, z, wall)
    total = np.trapezoid(m, fine)
    centre = np.trapezoid(m * fine, fine) / total
    radius_squared = (d**2 + (d - 2 * t) ** 2) / 8  # of gyration about the axis
    axial = np.trapezoid(m * radius_squared, fine)
    transverse = np.trapezoid(m * ((fine - centre) ** 2 + radius_squared / 2), fine)
    print(
        f"mass {total:.6g} kg, centre {centre:.5g} m, inertia about the centre {transverse:.6g} (roll, pitch), "
        f"{axial:.6g} kg m^2 (yaw)"
    )


if __name__ == "__main__":
    convert(Path(sys.argv[1]))
