"""Convert the aerodynamic blade and the airfoils of the IEA 15-MW turbine to two CSV tables.

    python models/convert/iea15_blade_aerodynamics.py FOLDER

FOLDER is the unzipped wheel of rosco 2.10.6 (Apache-2.0). The AeroDyn file has 50 nodes at equal distances from root to
tip, each with an airfoil of its own. Every second one of them, from the second on, becomes the middle of an element
that reaches from the node before to the node behind it: 24 elements with the digits of the file. What is left, from the
49th node to the tip, is one element with the mean of both nodes and the airfoil of the 49th. All 50 airfoils are kept.
"""

import re
import sys
from pathlib import Path

import numpy as np

TARGET = Path(__file__).parents[1] / "data" / "iea15"
SOURCE = Path("Examples") / "Test_Cases" / "IEA-15-240-RWT" / "IEA-15-240-RWT"
NODES = 50
BLADE_HEAD = """\
# IEA 15-MW blade, aerodynamic elements. span: of the middle of the element, from the blade root along the pitch axis.
# curve, sweep: place of the aerodynamic centre, downwind and towards the trailing edge of the unpitched blade.
# Source: rosco 2.10.6 (Apache-2.0), IEA-15-240-RWT_AeroDyn15_blade.dat, see SOURCES.md.
span_m,length_m,chord_m,twist_deg,curve_m,sweep_m,airfoil
"""
AIRFOILS_HEAD = """\
# IEA 15-MW airfoils: lift, drag and pitching moment (about the quarter chord, nose up) over the angle of attack.
# Source: rosco 2.10.6 (Apache-2.0), Airfoils/IEA-15-240-RWT_AeroDyn15_Polar_*.dat, see SOURCES.md.
airfoil,angle_of_attack_deg,lift_coefficient,drag_coefficient,moment_coefficient
"""


def nodes(path: Path) -> np.ndarray:
    """Span, curve, sweep [m], twist [deg], chord [m] and number of the airfoil of each node (n, 6)."""
    lines = path.read_text().splitlines()
    start = next(i for i, line in enumerate(lines) if line.split()[:1] == ["BlSpn"]) + 2
    rows = np.array([line.split() for line in lines[start : start + NODES]], dtype=float)
    return rows[:, [0, 1, 2, 4, 5, 6]]


def blade(path: Path) -> str:
    """The lines of the blade's table."""
    given = nodes(path)
    span = given[:, 0]
    middles = [(given[k], span[k + 1] - span[k - 1]) for k in range(1, NODES - 2, 2)]
    tip = given[-2:].mean(axis=0)
    tip[5] = given[-2, 5]
    middles.append((tip, span[-1] - span[-2]))
    print(f"{len(middles)} elements are {sum(length for _, length in middles):.4f} m of {span[-1]:.4f} m long")
    return "".join(
        f"{s:.7g},{length:.7g},{chord:.7g},{twist:.7g},{curve:.7g},{sweep:.7g},AF{int(number) - 1:02d}\n"
        for (s, curve, sweep, twist, chord, number), length in middles
    )


def airfoil(name: str, path: Path) -> str:
    """The lines of one airfoil's table."""
    lines = path.read_text().splitlines()
    start, count = next((i, int(line.split()[0])) for i, line in enumerate(lines) if re.search(r"\bNumAlf\b", line))
    numbers = [line for line in lines[start + 1 :] if line.strip() and line.lstrip()[0] != "!"][:count]
    return "".join(name + "," + ",".join(f"{float(x):.6g}" for x in line.split()) + "\n" for line in numbers)


def convert(folder: Path, target: Path = TARGET) -> None:
    """Write blade_aerodynamics.csv and airfoils.csv into `target` from the unzipped wheel in `folder`."""
    source = folder / SOURCE
    target.mkdir(parents=True, exist_ok=True)
    (target / "blade_aerodynamics.csv").write_text(BLADE_HEAD + blade(source / "IEA-15-240-RWT_AeroDyn15_blade.dat"))
    polars = [airfoil(f"AF{k:02d}", source / "Airfoils" / f"IEA-15-240-RWT_AeroDyn15_Polar_{k:02d}.dat")
              for k in range(NODES)]  # fmt: skip
    (target / "airfoils.csv").write_text(AIRFOILS_HEAD + "".join(polars))


if __name__ == "__main__":
    convert(Path(sys.argv[1]))
