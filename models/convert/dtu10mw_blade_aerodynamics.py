"""Convert the aerodynamic blade and the airfoils of the DTU 10-MW turbine to two CSV tables.

    python models/convert/dtu10mw_blade_aerodynamics.py FOLDER

FOLDER is the unzipped wheel of lacbox 0.4.0 (MIT). The files of HAWC2 have chord and relative thickness along the blade
(ae), polars by relative thickness (pc), and the line of the half chords with the twist (c2_def in the htc). The blade
becomes ELEMENTS elements, which are shorter at the root and at the tip. Every one has the values at its middle, linear
between the stations; its polar is linear between the two polars of the next thicknesses, as in HAWC2. The aerodynamic
centre is a quarter of the chord in front of the half chord. The polars reach round the whole circle already.
"""

import sys
from pathlib import Path

import numpy as np

TARGET = Path(__file__).parents[1] / "data" / "dtu10mw"
SOURCE = Path("lacbox") / "test" / "_data" / "dtu_10_mw"
ELEMENTS = 26
BLADE_HEAD = """\
# DTU 10-MW blade, aerodynamic elements. span: of the middle of the element, from the blade root along the pitch axis.
# curve, sweep: place of the aerodynamic centre, downwind and towards the trailing edge of the unpitched blade.
# Source: lacbox 0.4.0 (MIT), DTU_10MW_RWT_ae.dat and DTU_10MW_RWT.htc, see SOURCES.md.
span_m,length_m,chord_m,twist_deg,curve_m,sweep_m,airfoil
"""
AIRFOILS_HEAD = """\
# DTU 10-MW airfoils, FFA-W3 by relative thickness (T241: 24.1 %): lift, drag and pitching moment (about the quarter
# chord, nose up) over the angle of attack.
# Source: lacbox 0.4.0 (MIT), DTU_10MW_RWT_pc.dat, see SOURCES.md.
airfoil,angle_of_attack_deg,lift_coefficient,drag_coefficient,moment_coefficient
"""


def half_chords(folder: Path) -> np.ndarray:
    """Places x (leading edge), y (downwind), z (tip) [m] and twist [deg] of blade1 in the htc file, (n, 4)."""
    lines = (folder / SOURCE / "DTU_10MW_RWT.htc").read_text().splitlines()
    start = next(i for i, line in enumerate(lines) if line.split()[:2] == ["name", "blade1"])
    rows = []
    for line in lines[start:]:
        words = line.replace(";", " ").split()
        if words[:2] == ["end", "c2_def"]:
            break
        if words[:1] == ["sec"]:
            rows.append([float(word) for word in words[2:6]])
    found = np.array(rows)
    found[:, 3] *= -1  # positive with the leading edge upwind
    return found


def along(line: np.ndarray) -> np.ndarray:
    """Length of the line of the half chords from its root to each point [m], (n,)."""
    return np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(line[:, :3], axis=0), axis=1))])


def planform(folder: Path) -> np.ndarray:
    """Distance along the blade, chord [m] and relative thickness [%] of the ae file (n, 3)."""
    lines = (folder / SOURCE / "data" / "DTU_10MW_RWT_ae.dat").read_text().splitlines()
    count = int(lines[1].split()[1])
    return np.array([line.split()[:3] for line in lines[2 : 2 + count]], dtype=float)


def polars(folder: Path) -> dict[float, np.ndarray]:
    """Angle [deg], lift, drag and moment (n, 4) by relative thickness [%], of the pc file."""
    lines = (folder / SOURCE / "data" / "DTU_10MW_RWT_pc.dat").read_text().splitlines()
    sets, at = {}, 2
    for _ in range(int(lines[1].split()[0])):
        _, count, thickness = lines[at].split()[:3]
        rows = lines[at + 1 : at + 1 + int(count)]
        sets[float(thickness)] = np.array([row.split() for row in rows], dtype=float)
        at += 1 + int(count)
    return sets


def of_thickness(given: dict[float, np.ndarray], thickness: float) -> np.ndarray:
    """The polar of a relative thickness, linear between the next ones, at the angles of both."""
    known = sorted(given)
    i = int(np.clip(np.searchsorted(known, thickness), 1, len(known) - 1))
    thin, thick = given[known[i - 1]], given[known[i]]
    share = np.clip((thickness - known[i - 1]) / (known[i] - known[i - 1]), 0, 1)
    if share in (0, 1):
        return thick if share else thin
    angles = np.union1d(thin[:, 0], thick[:, 0])
    pair = [np.column_stack([np.interp(angles, one[:, 0], one[:, k]) for k in (1, 2, 3)]) for one in (thin, thick)]
    return np.column_stack([angles, (1 - share) * pair[0] + share * pair[1]])


def tables(folder: Path, elements: int = ELEMENTS) -> tuple[str, str]:
    """The lines of the tables of the blade and of its airfoils."""
    line, plan, given = half_chords(folder), planform(folder), polars(folder)
    tip, length = line[-1, 2], along(line)
    borders = tip * (1 - np.cos(np.pi * np.linspace(0, 1, elements + 1))) / 2
    middles = (borders[1:] + borders[:-1]) / 2
    x, y, twist = (np.interp(middles, line[:, 2], line[:, k]) for k in (0, 1, 3))
    s = np.interp(middles, line[:, 2], length) * plan[-1, 0] / length[-1]  # the files count to the same end
    chord, thickness = (np.interp(s, plan[:, 0], plan[:, k]) for k in (1, 2))
    curve = y - chord / 4 * np.sin(np.radians(twist))
    sweep = -x - chord / 4 * np.cos(np.radians(twist))
    names = [f"T{10 * value:.0f}" for value in thickness]
    rows = zip(middles, np.diff(borders), chord, twist, curve, sweep, names, strict=True)
    blade = "".join(",".join(f"{value:.7g}" for value in row[:-1]) + f",{row[-1]}\n" for row in rows)
    airfoils = ""
    for name, value in dict(zip(names, thickness, strict=True)).items():
        polar = of_thickness(given, value)
        airfoils += "".join(f"{name}," + ",".join(f"{number:.6g}" for number in row) + "\n" for row in polar)
    return blade, airfoils


def convert(folder: Path, target: Path = TARGET) -> None:
    """Write blade_aerodynamics.csv and airfoils.csv into `target` from the unzipped wheel in `folder`."""
    target.mkdir(parents=True, exist_ok=True)
    blade, airfoils = tables(folder)
    (target / "blade_aerodynamics.csv").write_text(BLADE_HEAD + blade)
    (target / "airfoils.csv").write_text(AIRFOILS_HEAD + airfoils)


if __name__ == "__main__":
    convert(Path(sys.argv[1]))
