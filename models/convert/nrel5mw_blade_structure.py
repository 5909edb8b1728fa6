"""Convert the structure of the NREL 5 MW blade to CSV and print its mass, moments and the factor of its mass.

    python models/convert/nrel5mw_blade_structure.py FOLDER

FOLDER is the unzipped wheel of rosco 2.10.6 (Apache-2.0). Stations become metres from the blade root. Mass, twist and
bending stiffness are those of the ElastoDyn file; torsional and axial stiffness and the rotary inertias of the sections
are on the diagonals of the BeamDyn file of the same blade. The mass of the definition, 17,740 kg, is that of the table
times a factor (Jonkman et al. 2009, NREL/TP-500-38060, section 2: 1.04536 with the elements of that program). Here the
factor makes the integral of the table, linear between the stations, equal to 17,740 kg.
"""

import sys
from pathlib import Path

import numpy as np

TARGET = Path(__file__).parents[1] / "data" / "nrel5mw" / "blade_structure.csv"
LENGTH, MASS = 61.5, 17740.0
HEAD = """\
# NREL 5 MW blade, structural properties. z: distance from the blade root (1.5 m off the rotor axis).
# Linear between the stations; twist: leading edge upwind positive.
# Source: rosco 2.10.6 (Apache-2.0), NRELOffshrBsline5MW_{Blade,BeamDyn_Blade}.dat;
# Jonkman et al. (2009), NREL/TP-500-38060, table 2-1.
# Mass and rotary inertia include the factor %.6f, which makes the blade weigh 17,740 kg.
"""
COLUMNS = ("z_m,mass_per_length_kg_per_m,bending_stiffness_flapwise_N_m2,bending_stiffness_edgewise_N_m2,"
           "torsional_stiffness_N_m2,axial_stiffness_N,structural_twist_deg,rotary_inertia_flapwise_kg_m,"
           "rotary_inertia_edgewise_kg_m")


def beamdyn(path: Path, stations: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Relative span (n,), diagonals of stiffness and mass (n, 6): two shears, axial, edgewise, flapwise, torsion."""
    lines = path.read_text().splitlines()
    start = next(i for i, line in enumerate(lines) if "Distributed Properties" in line) + 1
    numbers = np.array(" ".join(lines[start:]).split()[: stations * 73], dtype=float).reshape(stations, 73)
    diagonal = np.arange(6) * 7
    return numbers[:, 0], numbers[:, 1 + diagonal], numbers[:, 37 + diagonal]


def convert(folder: Path, target: Path = TARGET) -> None:
    """Write `target` from the unzipped wheel in `folder`."""
    source = folder / "Examples" / "Test_Cases" / "NREL-5MW"
    lines = (source / "NRELOffshrBsline5MW_Blade.dat").read_text().splitlines()
    start = next(i for i, line in enumerate(lines) if line.split()[:1] == ["BlFract"]) + 2
    span, twist, mass, flap, edge = np.array([line.split() for line in lines[start : start + 49]], dtype=float).T
    other_span, stiffness, inertia = beamdyn(source / "NRELOffshrBsline5MW_BeamDyn_Blade.dat", 49)
    pairs = ((span, other_span), (flap, stiffness[:, 4]), (edge, stiffness[:, 3]), (mass, inertia[:, 0]))
    print("largest difference of the two files:", [f"{np.abs(a - b).max():.1e}" for a, b in pairs])
    z = span * LENGTH
    factor = MASS / np.trapezoid(mass, z)
    columns = np.c_[z, factor * mass, flap, edge, stiffness[:, 5], stiffness[:, 2], twist,
                    factor * inertia[:, 4], factor * inertia[:, 3]]
    rows = "".join(",".join(f"{v:.7g}" for v in row) + "\n" for row in columns)
    target.write_text(HEAD % factor + COLUMNS + "\n" + rows)
    s = np.linspace(0, LENGTH, 200001)
    mu = factor * np.interp(s, z, mass)
    print(f"factor {factor:.6f}, mass {np.trapezoid(mu, s):.6g} kg, first moment {np.trapezoid(mu * s, s):.7g} kg m, "
          f"inertia about the root {np.trapezoid(mu * s**2, s):.8g} kg m^2")


if __name__ == "__main__":
    convert(Path(sys.argv[1]))
