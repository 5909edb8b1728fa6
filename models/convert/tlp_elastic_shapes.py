"""Compute the hydrodynamics of the tension leg platform that bends and of its shapes (needs `fowtlib[hydro]`).

    python models/convert/tlp_elastic_shapes.py [SIZE]

The members of `platforms/tlp_elastic` as a frame of steel (E = 210 GPa, Poisson's ratio 0.3, beams of 4 m at
most), its six lowest shapes and six of loads at the foot of the tower and at each tendon, and the flow about each.
"""

import sys
import tempfile
import warnings
from pathlib import Path

import numpy as np

import fowtlib as fw
from fowtlib.components.hydro.modal_database import ModalDatabase
from fowtlib.components.platform import modal_database

MODELS = Path(__file__).parents[1]
PLATFORM = MODELS / "platforms" / "tlp_elastic.yaml"
TARGET = MODELS / "data" / "tlp_elastic" / "shapes.nc"
STEEL = {"young_modulus": 210e9, "shear_modulus": 210e9 / 2.6}
SHAPES, LONGEST = 6, 4.0
OMEGA = np.array([*np.arange(1, 17) / 10, 1.8, 2.0, 2.4, 2.8, 3.4])
HEADINGS = np.arange(-180, 181, 15)


def floater():
    """The hull of the platform, by strips: before there is a database."""
    text = f"""fowtlib: 1
world: {{class: World, water_depth: 150 m, water_density: 1025 kg/m^3}}
parts: {{platform: {{use: {PLATFORM}, parts: {{hull: {{database: null, shapes: {SHAPES}}}}}}}}}
connect:
  - [world.frame, platform.world]
"""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "hull.yaml"
        path.write_text(text)
        return fw.load(path).root.find("platform.hull")


def convert(size: float = 2.5, target: Path = TARGET) -> ModalDatabase:
    """Write `target`; panels `size` [m] wide."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # the shortest waves are too short for the panels; they move little
        return modal_database(
            floater(), SHAPES, omega=OMEGA, headings=np.radians(HEADINGS), panel=size, water_depth=150.0,
            longest=LONGEST, attached=[[0.0, 0.0, 10.0]], path=target,
            progress=lambda done, total: print(f"{done} of {total}", flush=True), **STEEL,
        )  # fmt: skip


if __name__ == "__main__":
    print(convert(*map(float, sys.argv[1:])))
