"""Convert the rotor performance tables of the NREL 5 MW turbine to one CSV table.

    python models/convert/nrel5mw_rotor_coefficients.py FOLDER

FOLDER is the unzipped wheel of rosco 2.10.6 (Apache-2.0). The three matrices become one long table, one line for each
pair of tip speed ratio and blade pitch; the digits are kept. With the wind speed U and the shaft speed Omega:

    tip speed ratio = Omega 63 m / U                R = 63 m cos(2.5 deg) = 62.94 m, the radius of the coned rotor
    power  P = C_p rho/2 pi R^2 U^3      thrust T = C_t rho/2 pi R^2 U^2      torque Q = C_q rho/2 pi R^3 U^2

The two radii are not stated in the file; C_p = tip speed ratio * C_q * cos(2.5 deg), which holds throughout (printed
here), shows them. To take R = 63 m instead overestimates the loads by 0.2 %.
"""

import re
import sys
from pathlib import Path

import numpy as np

TARGET = Path(__file__).parents[1] / "data" / "nrel5mw" / "rotor_coefficients.csv"
HEAD = """\
# NREL 5 MW rotor: steady coefficients over tip speed ratio and collective blade pitch, rigid blades.
# Source: rosco 2.10.6 (Apache-2.0), Cp_Ct_Cq.NREL5MW.txt (blade element momentum theory, CCBlade), see SOURCES.md.
# Tip speed ratio with the blade length 63 m; coefficients with the coned radius R = 63 m cos(2.5 deg) = 62.94 m.
# Range: tip speed ratio 2 to 14.5, pitch -5 to 30 deg. No data for start-up from rest, parking and feathering.
"""
COLUMNS = "tip_speed_ratio,blade_pitch_deg,power_coefficient,thrust_coefficient,torque_coefficient"


def read(path: Path) -> tuple[np.ndarray, np.ndarray, dict[str, np.ndarray]]:
    """Tip speed ratios, pitch angles [deg] and the matrices (tip speed ratio, pitch) by name."""
    blocks = re.split(r"^#(.*)$", path.read_text(), flags=re.MULTILINE)
    numbers = {
        title.strip(): np.array(text.split(), dtype=float)
        for title, text in zip(blocks[1::2], blocks[2::2], strict=True)
        if text.strip()
    }

    def find(word):
        return next(value for title, value in numbers.items() if title.startswith(word))

    pitch, ratio = find("Pitch angle vector"), find("TSR vector")
    tables = {
        name: find(f"{name.capitalize()} coefficient").reshape(ratio.size, pitch.size)
        for name in ("power", "thrust", "torque")
    }
    return ratio, pitch, tables


def convert(folder: Path, target: Path = TARGET) -> None:
    """Write `target` from the unzipped wheel in `folder`."""
    ratio, pitch, tables = read(folder / "Examples" / "Test_Cases" / "NREL-5MW" / "Cp_Ct_Cq.NREL5MW.txt")
    mismatch = np.abs(tables["power"] - ratio[:, None] * tables["torque"] * np.cos(np.radians(2.5))).max()
    best = np.unravel_index(tables["power"].argmax(), tables["power"].shape)
    print(
        f"C_p - tip speed ratio * C_q * cos(2.5 deg): at most {mismatch:.1e}; largest C_p "
        f"{tables['power'][best]:.4f} at {ratio[best[0]]:g} and {pitch[best[1]]:g} deg"
    )
    lines = [
        f"{r:g},{p:g}," + ",".join(f"{tables[name][i, j]:.6f}" for name in ("power", "thrust", "torque"))
        for i, r in enumerate(ratio)
        for j, p in enumerate(pitch)
    ]
    target.parent.mkdir(parents=True, exist_ok=True)
    target.write_text(HEAD + COLUMNS + "\n" + "\n".join(lines) + "\n")


if __name__ == "__main__":
    convert(Path(sys.argv[1]))
