"""Compute the coefficients of the rigid DTU 10-MW rotor from its blades, also parked, idling and fast.

    python models/convert/dtu10mw_rotor_coefficients.py

All are fowtlib's blade-element momentum theory, from blade_aerodynamics.csv and airfoils.csv: uniform wind along the
shaft, cone 2.5 deg, the prebend of the blades as it is; without induction below a tip speed ratio of 1.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from fowtlib.components.aero import BladeElementRotor, coefficient_table, read_blade
from fowtlib.components.aero.coefficient_table import write_coefficients

DATA = Path(__file__).parent.parent / "data" / "dtu10mw"
PRECONE = np.radians(2.5)
RATIOS = np.concatenate(
    [np.arange(-1, 2, 0.125), np.arange(2, 25, 0.5), np.arange(25, 60, 2.5), np.arange(60, 100, 5.0),
     np.arange(100, 180.1, 10)]
)  # fmt: skip
"""Tip speed ratios to rated speed (89.6 m/s) in the least wind of CoefficientRotor (0.5 m/s)."""
PITCHES = np.radians(np.arange(-5.0, 100.1, 1.0))

ABOUT = (
    "DTU 10-MW rotor: steady coefficients over tip speed ratio and blade pitch, rigid blades, also parked and idling.",
    "fowtlib's blade-element momentum theory with the tables beside this file (SOURCES.md).",
)


def main() -> None:
    """Write rotor_coefficients.csv."""
    blade = read_blade(str(DATA / "blade_aerodynamics.csv"), str(DATA / "airfoils.csv"), 2.8, 89.1655)
    table = coefficient_table(BladeElementRotor(blade), RATIOS, PITCHES, precone=PRECONE)
    write_coefficients(DATA / "rotor_coefficients.csv", table, PRECONE, ABOUT)


if __name__ == "__main__":
    main()
