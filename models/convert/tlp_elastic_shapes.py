"""Compute the hydrodynamics of the tension leg platform that bends and of its shapes (needs `fowtlib[hydro]`).

    python models/convert/tlp_elastic_shapes.py [SIZE]

The members of `platforms/tlp_elastic` as a frame of steel (E = 210 GPa, Poisson's ratio 0.3, beams of 4 m at
most), its six lowest shapes and six of loads at the foot of the tower and at each tendon, and the flow about each.
"""

import sys
import warnings
from pathlib import Path

import numpy as np
from hull_by_strips import MODELS, hull_by_strips

from fowtlib.components.hydro.modal_database import ModalDatabase
from fowtlib.components.platform import modal_database

TARGET = MODELS / "data" / "tlp_elastic" / "shapes.nc"
STEEL = {"young_modulus": 210e9, "shear_modulus": 210e9 / 2.6}
DEPTH = 150.0  # m
SHAPES, LONGEST = 6, 4.0
OMEGA = np.array([*np.arange(1, 17) / 10, 1.8, 2.0, 2.4, 2.8, 3.4])
HEADINGS = np.arange(-180, 181, 15)


def convert(size: float = 2.5, target: Path = TARGET) -> ModalDatabase:
    """Write `target`; panels `size` [m] wide."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # the shortest waves are too short for the panels; they move little
        return modal_database(
            hull_by_strips("tlp_elastic", DEPTH, SHAPES), SHAPES, omega=OMEGA, headings=np.radians(HEADINGS),
            panel=size, water_depth=DEPTH,
            longest=LONGEST, attached=[[0.0, 0.0, 10.0]], path=target,
            progress=lambda done, total: print(f"{done} of {total}", flush=True), **STEEL,
        )  # fmt: skip


if __name__ == "__main__":
    print(convert(*map(float, sys.argv[1:])))
