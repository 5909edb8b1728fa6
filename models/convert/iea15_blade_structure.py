"""Convert the structure of the IEA 15-MW blade to CSV and print its mass and moments.

    python models/convert/iea15_blade_structure.py FOLDER

FOLDER is the unzipped wheel of rosco 2.10.6 (Apache-2.0). The BeamDyn files have matrices (6, 6) of stiffness and mass
of 26 sections, about the reference axis, in axes turned by the twist. A beam with one axis and principal stiffnesses:

- its axis is the line of the shear centres, so that a load beside it twists the blade as it should;
- bending stiffnesses about the elastic centre (where an axial force does not bend), in their principal axes, which are
  turned a little further than the sections;
- torsional stiffness about the shear centre; the flexibility of shear is left out;
- the centre of mass beside the axis, and rotary inertias about the centre of mass, in the same principal axes.

Where the section is nearly round (the root) its principal axes are any; those within 45 deg of the section's are taken.
"""

import sys
from pathlib import Path

import numpy as np

TARGET = Path(__file__).parents[1] / "data" / "iea15" / "blade_structure.csv"
SOURCE = Path("Examples") / "Test_Cases" / "IEA-15-240-RWT" / "IEA-15-240-RWT"
LENGTH, STATIONS, KEY_POINTS = 117.0, 26, 50
HEAD = """\
# IEA 15-MW blade, structural properties. z: distance from the blade root (3.97 m off the rotor axis).
# Linear between the stations; twist: leading edge upwind positive. The axis is the line of the shear centres; centres
# of mass are off that, along the principal axes.
# Source: rosco 2.10.6 (Apache-2.0), IEA-15-240-RWT_BeamDyn{,_blade}.dat, see SOURCES.md.
"""
COLUMNS = (
    "z_m,mass_per_length_kg_per_m,bending_stiffness_flapwise_N_m2,bending_stiffness_edgewise_N_m2,"
    "torsional_stiffness_N_m2,axial_stiffness_N,structural_twist_deg,rotary_inertia_flapwise_kg_m,"
    "rotary_inertia_edgewise_kg_m,reference_x_m,reference_y_m,centre_of_mass_x_m,centre_of_mass_y_m"
)


def section(stiffness: np.ndarray, mass: np.ndarray) -> dict[str, float]:
    """Numbers of one section from its matrices (6, 6): shear x, y, axial, bending about x, y, torsion.

    Centres are in the axes of the section, `turn` [rad] is about +z from them to the principal axes.
    """
    axial = stiffness[2, 2]
    centre = np.array([-stiffness[2, 4], stiffness[2, 3]]) / axial  # elastic centre: N = EA (e + y k_x - x k_y)
    bending = stiffness[3:5, 3:5] - axial * np.outer([centre[1], -centre[0]], [centre[1], -centre[0]])
    arm = np.linalg.solve(stiffness[:2, :2], stiffness[:2, 5])  # (-y, x) of the shear centre
    torsion = stiffness[5, 5] - stiffness[:2, 5] @ arm
    difference, product = bending[0, 0] - bending[1, 1], bending[0, 1]
    turn = 0.5 * np.arctan2(2 * product, difference)
    turn -= np.pi / 2 * np.rint(turn / (np.pi / 2))
    c, s = np.cos(turn), np.sin(turn)
    axes = np.array([[c, -s], [s, c]])  # columns: principal axes
    bending = axes.T @ bending @ axes
    per_length = mass[0, 0]
    gravity = np.array([mass[1, 5], -mass[0, 5]]) / per_length
    rotary = mass[3:5, 3:5] - per_length * np.outer([gravity[1], -gravity[0]], [gravity[1], -gravity[0]])
    rotary = axes.T @ rotary @ axes
    shear = np.array([arm[1], -arm[0]])
    return {"mass": per_length, "edge": bending[0, 0], "flap": bending[1, 1], "torsion": torsion, "axial": axial,
            "turn": turn, "rotary_edge": rotary[0, 0], "rotary_flap": rotary[1, 1],
            "shear": shear, "gravity": axes.T @ (gravity - shear)}  # fmt: skip


def sections(path: Path) -> tuple[np.ndarray, list[dict[str, float]]]:
    """Relative span (n,) and the numbers of each section of a BeamDyn blade file."""
    lines = path.read_text().splitlines()
    start = next(i for i, line in enumerate(lines) if "DISTRIBUTED PROPERTIES" in line) + 1
    numbers = np.array(" ".join(lines[start:]).split()[: STATIONS * 73], dtype=float).reshape(STATIONS, 73)
    matrices = numbers[:, 1:].reshape(STATIONS, 2, 6, 6)
    return numbers[:, 0], [section(*pair) for pair in matrices]


def key_points(path: Path) -> np.ndarray:
    """x, y, z [m] and twist [deg] along the reference axis of a BeamDyn file (n, 4)."""
    lines = path.read_text().splitlines()
    start = next(i for i, line in enumerate(lines) if line.split()[:1] == ["kp_xr"]) + 2
    return np.array([line.split() for line in lines[start : start + KEY_POINTS]], dtype=float)


def convert(folder: Path, target: Path = TARGET) -> None:
    """Write `target` from the unzipped wheel in `folder`."""
    source = folder / SOURCE
    span, found = sections(source / "IEA-15-240-RWT_BeamDyn_blade.dat")
    x, y, along, twist = key_points(source / "IEA-15-240-RWT_BeamDyn.dat").T
    z = span * LENGTH
    rows = []
    for s, one in zip(z, found, strict=True):
        turned = np.radians(np.interp(s, along, twist))  # about -z
        axes = np.array([[np.cos(turned), np.sin(turned)], [-np.sin(turned), np.cos(turned)]])
        place = np.array([np.interp(s, along, x), np.interp(s, along, y)]) + axes @ one["shear"]
        rows.append(
            [
                s,
                one["mass"],
                one["flap"],
                one["edge"],
                one["torsion"],
                one["axial"],
                np.degrees(turned - one["turn"]),
                one["rotary_flap"],
                one["rotary_edge"],
                *place,
                *one["gravity"],
            ]
        )
    target.parent.mkdir(parents=True, exist_ok=True)
    target.write_text(HEAD + COLUMNS + "\n" + "".join(",".join(f"{v:.7g}" for v in row) + "\n" for row in rows))
    s = np.linspace(0, LENGTH, 200001)
    mu = np.interp(s, z, [one["mass"] for one in found])
    print(f"mass {np.trapezoid(mu, s):.6g} kg, first moment {np.trapezoid(mu * s, s):.7g} kg m, "
          f"inertia about the root {np.trapezoid(mu * s**2, s):.8g} kg m^2")  # fmt: skip


if __name__ == "__main__":
    convert(Path(sys.argv[1]))
