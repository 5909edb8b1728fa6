"""Compute the hydrodynamics of the OO-Star Wind Floater that bends and of its shapes (needs `fowtlib[hydro]`).

    python models/convert/oo_star_shapes.py [SIZE]

The members of `platforms/oo_star_elastic` as a frame of concrete (E = 35 GPa, Poisson's ratio 0.2, beams of 8 m at
most), its six lowest shapes and six of loads at the foot of the tower, and the flow about each.
"""

import sys
import warnings
from dataclasses import replace
from pathlib import Path

import numpy as np
from hull_by_strips import MODELS, hull_by_strips

from fowtlib.components.hydro.modal_database import ModalDatabase
from fowtlib.components.platform import modal_database

TARGET = MODELS / "data" / "oo_star" / "shapes.nc"
CONCRETE = {"young_modulus": 35e9, "shear_modulus": 35e9 / 2.4}
DEPTH = 130.0  # m
SHAPES, LONGEST = 6, 8.0
OMEGA = np.array([*np.arange(1, 17) / 10, 1.8, 2.0, 2.4, 2.8, 3.4, 3.7])
HEADINGS = np.arange(-180, 181, 15)


def convert(size: float = 4.0, target: Path = TARGET) -> ModalDatabase:
    """Write `target`; panels `size` [m] wide."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # the shortest waves are too short for the panels; they move little
        found = modal_database(
            hull_by_strips("oo_star_elastic", DEPTH, SHAPES), SHAPES, omega=OMEGA, headings=np.radians(HEADINGS),
            panel=size, water_depth=DEPTH,
            longest=LONGEST, attached=[[0.0, 0.0, 11.0]],
            progress=lambda done, total: print(f"{done} of {total}", flush=True), **CONCRETE,
        )  # fmt: skip
    damping = found.B.copy()
    damping[-1] = 0.0  # waves of 4.5 m on panels of 4 m: what damping is left is noise, in yaw below zero
    found = replace(found, B=damping)
    found.write(target)
    return found


if __name__ == "__main__":
    print(convert(*map(float, sys.argv[1:])))
