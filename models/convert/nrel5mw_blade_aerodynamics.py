"""Convert the aerodynamic blade and the airfoils of the NREL 5 MW turbine to two CSV tables.

    python models/convert/nrel5mw_blade_aerodynamics.py FOLDER

FOLDER is the unzipped wheel of rosco 2.10.6 (Apache-2.0). The AeroDyn file has 19 nodes; the first (blade root) and the
last (tip) carry no length and are left out. The 17 others are the middles of elements that fill the blade from 0 to
61.5 m; the lengths of the elements follow from that (checked here against 61.5 m). The digits are kept.
"""

import re
import sys
from pathlib import Path

TARGET = Path(__file__).parents[1] / "data" / "nrel5mw"
SOURCE = Path("Examples") / "Test_Cases" / "NREL-5MW"
AIRFOILS = ("Cylinder1", "Cylinder2", "DU40_A17", "DU35_A17", "DU30_A17", "DU25_A17", "DU21_A17", "NACA64_A17")
LENGTH = 61.5
BLADE_HEAD = """\
# NREL 5 MW blade, aerodynamic elements. span: of the middle of the element, from the blade root along the pitch axis.
# curve, sweep: place of the aerodynamic centre, downwind and towards the trailing edge of the unpitched blade.
# Source: rosco 2.10.6 (Apache-2.0), NRELOffshrBsline5MW_AeroDyn_blade.dat, see SOURCES.md.
span_m,length_m,chord_m,twist_deg,curve_m,sweep_m,airfoil
"""
AIRFOILS_HEAD = """\
# NREL 5 MW airfoils: lift, drag and pitching moment (about the quarter chord, nose up) over the angle of attack.
# Source: rosco 2.10.6 (Apache-2.0), Airfoils/*.dat, see SOURCES.md. With rotational stall delay.
airfoil,angle_of_attack_deg,lift_coefficient,drag_coefficient,moment_coefficient
"""


def blade(path: Path) -> str:
    """The lines of the blade's table."""
    lines = path.read_text().splitlines()
    start = next(i for i, line in enumerate(lines) if line.split()[:1] == ["BlSpn"]) + 2
    rows = [line.split() for line in lines[start + 1 : start + 18]]
    text, edge = "", 0.0
    for row in rows:
        span, curve, sweep, twist, chord = (float(row[k]) for k in (0, 1, 2, 4, 5))
        length = 2 * (span - edge)
        edge += length
        text += f"{span:g},{length:.4f},{chord:g},{twist:g},{curve:.9g},{sweep:.9g},{AIRFOILS[int(row[6]) - 1]}\n"
    print(f"{len(rows)} elements end at {edge:.4f} m of {LENGTH} m")
    return text


def airfoil(name: str, path: Path) -> str:
    """The lines of one airfoil's table."""
    lines = path.read_text().splitlines()
    start, count = next((i, int(line.split()[0])) for i, line in enumerate(lines) if re.search(r"\bNumAlf\b", line))
    numbers = [line for line in lines[start + 1 :] if line.strip() and line.lstrip()[0] != "!"][:count]
    return "".join(name + "," + ",".join(f"{float(x):g}" for x in line.split()) + "\n" for line in numbers)


def convert(folder: Path, target: Path = TARGET) -> None:
    """Write blade_aerodynamics.csv and airfoils.csv into `target` from the unzipped wheel in `folder`."""
    source = folder / SOURCE
    target.mkdir(parents=True, exist_ok=True)
    (target / "blade_aerodynamics.csv").write_text(BLADE_HEAD + blade(source / "NRELOffshrBsline5MW_AeroDyn_blade.dat"))
    polars = [airfoil(name, source / "Airfoils" / f"{name}.dat") for name in AIRFOILS]
    (target / "airfoils.csv").write_text(AIRFOILS_HEAD + "".join(polars))


if __name__ == "__main__":
    convert(Path(sys.argv[1]))
