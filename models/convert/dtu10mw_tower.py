"""Convert the tower of the DTU 10-MW turbine on land to CSV and print its mass.

    python models/convert/dtu10mw_tower.py FOLDER

FOLDER is the unzipped wheel of lacbox 0.4.0 (MIT). The st file of HAWC2 has a steel tube of ten sections, each with a
wall of its own. Outer diameter and wall thickness are added: a round tube of the area and the second moment given, and
the script checks that these are 8.3 m to 5.5 m and 38 mm to 20 mm.
"""

import sys
from pathlib import Path

import numpy as np
from dtu10mw_blade_aerodynamics import SOURCE
from dtu10mw_blade_structure import sections

TARGET = Path(__file__).parents[1] / "data" / "dtu10mw" / "tower.csv"
HEAD = """\
# DTU 10-MW turbine, tower on land: a steel tube of ten sections. z: height above the ground; the wall changes within
# 1 mm at the ends of the sections.
# Source: lacbox 0.4.0 (MIT), DTU_10MW_RWT_Tower_st.dat, see SOURCES.md.
"""
COLUMNS = (
    "z_m,mass_per_length_kg_per_m,bending_stiffness_fore_aft_N_m2,bending_stiffness_side_side_N_m2,"
    "torsional_stiffness_N_m2,axial_stiffness_N,outer_diameter_m,wall_thickness_m"
)


def convert(folder: Path, target: Path = TARGET) -> None:
    """Write `target` from the unzipped wheel in `folder`."""
    given = sections(folder / SOURCE / "data" / "DTU_10MW_RWT_Tower_st.dat")
    squares = 4 * given["A"] / np.pi, 16 * given["I_x"] / given["A"]  # of the diameters: difference, sum
    outer = np.sqrt((squares[1] + squares[0]) / 2)
    wall = (outer - np.sqrt((squares[1] - squares[0]) / 2)) / 2
    if np.abs(outer - np.interp(given["r"], [0, 115.63], [8.3, 5.5])).max() > 2e-3:
        raise SystemExit("the tube of the file is not 8.3 m to 5.5 m wide.")
    if np.abs(1e3 * wall - np.repeat(np.arange(38, 19, -2), 2)).max() > 0.05:
        raise SystemExit("the walls of the file are not 38 mm to 20 mm.")
    E, G = given["E"], given["G"]
    table = np.column_stack(
        [given["r"], given["m"], E * given["I_x"], E * given["I_y"], G * given["K"], E * given["A"], outer, wall]
    )
    target.parent.mkdir(parents=True, exist_ok=True)
    target.write_text(HEAD + COLUMNS + "\n" + "".join(",".join(f"{v:.7g}" for v in row) + "\n" for row in table))
    print(f"mass {np.trapezoid(given['m'], given['r']):.6g} kg")


if __name__ == "__main__":
    convert(Path(sys.argv[1]))
