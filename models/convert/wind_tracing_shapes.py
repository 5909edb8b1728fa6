"""Compute the hydrodynamics of the wind-tracing triangle and of its shapes (needs the extra `fowtlib[hydro]`).

    python models/convert/wind_tracing_shapes.py [SIZE]

The members of `wind_tracing_rigid` as a frame of concrete (E = 35 GPa, Poisson's ratio 0.2, beams of 20 m at most), its
twelve lowest shapes, and the flow about each: frequencies, panels and headings are those of the rigid hull.
"""

import sys
import warnings
from pathlib import Path

import numpy as np
from wind_tracing_hydrodynamics import HEADINGS, OMEGA

import fowtlib as fw
from fowtlib.components.hydro.modal_database import ModalDatabase
from fowtlib.components.platform import modal_database

TARGET = Path(__file__).parents[1] / "data" / "wind_tracing" / "shapes.nc"
CONCRETE = {"young_modulus": 35e9, "shear_modulus": 35e9 / 2.4}
SHAPES, LONGEST = 12, 20.0


def convert(size: float = 6.0, target: Path = TARGET) -> ModalDatabase:
    """Write `target`; panels `size` [m] wide."""
    floater = fw.load("wind_tracing_rigid").root.find("platform.hull")
    both_sides = np.concatenate([-HEADINGS[:0:-1], HEADINGS])
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # waves above 1.8 rad/s are too short for the panels; they move nothing
        return modal_database(
            floater, SHAPES, omega=OMEGA, headings=np.radians(both_sides), panel=size, water_depth=200.0,
            longest=LONGEST, path=target, progress=lambda done, total: print(f"{done} of {total}", flush=True),
            **CONCRETE,
        )  # fmt: skip


if __name__ == "__main__":
    size = float(sys.argv[1]) if len(sys.argv) > 1 else 6.0
    print(convert(size))
