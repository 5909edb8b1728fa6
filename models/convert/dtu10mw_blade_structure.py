"""Convert the structure of the DTU 10-MW blade to CSV and print its mass and moments.

    python models/convert/dtu10mw_blade_structure.py FOLDER

FOLDER is the unzipped wheel of lacbox 0.4.0 (MIT). The st file of HAWC2 has the sections along the line of the half
chords (c2_def in the htc), with their centres from the half chord in axes turned by the twist: x towards the leading
edge, y to the suction side. A beam with one axis and principal stiffnesses:

- its axis is the line of the shear centres, so that a load beside it twists the blade as it should;
- bending stiffnesses E I about the elastic centre, in principal axes, which are turned by `pitch` against the twist;
- torsional stiffness G K; the flexibility of shear is left out;
- the centre of mass from the shear centre, and rotary inertias about the centre of mass, in the principal axes.

Where the section is nearly round (the first 9 m) the file turns the axes by 43 deg: they are left as the file has them.
"""

import sys
from pathlib import Path

import numpy as np
from dtu10mw_blade_aerodynamics import SOURCE, along, half_chords

TARGET = Path(__file__).parents[1] / "data" / "dtu10mw" / "blade_structure.csv"
HEAD = """\
# DTU 10-MW blade, structural properties. z: distance from the blade root (2.8 m off the rotor axis).
# Linear between the stations; twist: leading edge upwind positive. The axis is the line of the shear centres; centres
# of mass are off that, along the principal axes.
# Source: lacbox 0.4.0 (MIT), DTU_10MW_RWT_Blade_st.dat and DTU_10MW_RWT.htc, see SOURCES.md.
"""
COLUMNS = (
    "z_m,mass_per_length_kg_per_m,bending_stiffness_flapwise_N_m2,bending_stiffness_edgewise_N_m2,"
    "torsional_stiffness_N_m2,axial_stiffness_N,structural_twist_deg,rotary_inertia_flapwise_kg_m,"
    "rotary_inertia_edgewise_kg_m,reference_x_m,reference_y_m,centre_of_mass_x_m,centre_of_mass_y_m"
)
NAMES = ("r", "m", "x_cg", "y_cg", "ri_x", "ri_y", "x_sh", "y_sh", "E", "G", "I_x", "I_y", "K", "k_x", "k_y", "A",
         "pitch", "x_e", "y_e")  # fmt: skip


def sections(path: Path) -> dict[str, np.ndarray]:
    """Columns of the first set, flexible, of the first part of an st file of HAWC2."""
    lines = path.read_text().splitlines()
    start = next(i for i, line in enumerate(lines) if line.split()[:1] == ["$1"])
    count = int(lines[start].split()[1])
    rows = np.array([line.split() for line in lines[start + 1 : start + 1 + count]], dtype=float)
    return dict(zip(NAMES, rows.T, strict=True))


def convert(folder: Path, target: Path = TARGET) -> None:
    """Write `target` from the unzipped wheel in `folder`."""
    line = half_chords(folder)
    given = sections(folder / SOURCE / "data" / "DTU_10MW_RWT_Blade_st.dat")
    length = along(line)
    s = given["r"] * length[-1] / given["r"][-1]  # HAWC2 lets both end at the tip
    x, y, z, twist = (np.interp(s, length, line[:, k]) for k in range(4))
    c, t = np.cos(np.radians(twist)), np.sin(np.radians(twist))  # axes of the section: leading edge upwind
    shear = np.array([x + c * given["x_sh"] + t * given["y_sh"], y - t * given["x_sh"] + c * given["y_sh"]])
    cp, sp = np.cos(np.radians(given["pitch"])), np.sin(np.radians(given["pitch"]))
    beside = np.array([given["x_cg"] - given["x_sh"], given["y_cg"] - given["y_sh"]])
    centre = np.array([cp * beside[0] + sp * beside[1], -sp * beside[0] + cp * beside[1]])
    E, mu = given["E"], given["m"]
    table = np.column_stack(
        [z, mu, E * given["I_x"], E * given["I_y"], given["G"] * given["K"], E * given["A"], twist - given["pitch"],
         mu * given["ri_x"] ** 2, mu * given["ri_y"] ** 2, shear[1], -shear[0], centre[1], -centre[0]]
    )  # fmt: skip
    target.parent.mkdir(parents=True, exist_ok=True)
    target.write_text(HEAD + COLUMNS + "\n" + "".join(",".join(f"{v:.7g}" for v in row) + "\n" for row in table))
    fine = np.linspace(0, z[-1], 200001)
    per_length = np.interp(fine, z, mu)
    mass, first, second = (np.trapezoid(per_length * fine**k, fine) for k in range(3))
    print(f"mass {mass:.6g} kg, first moment {first:.7g} kg m, inertia about the root {second:.8g} kg m^2")


if __name__ == "__main__":
    convert(Path(sys.argv[1]))
