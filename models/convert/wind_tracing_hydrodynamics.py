"""Compute the hydrodynamics of the wind-tracing triangle with the panel method (needs the extra `fowtlib[hydro]`).

    python models/convert/wind_tracing_hydrodynamics.py [SIZE]

The hull: the members of `wind_tracing_rigid`, in panels of 6 m, which are symmetric about y = 0. The hull is some
320 m wide, so that the phase of the waves on it changes much from one heading to the next: they are 5 deg apart. Waves
from one side are computed, and mirrored.
"""

import sys
import warnings
from dataclasses import replace
from pathlib import Path

import numpy as np

import fowtlib as fw
from fowtlib.components.hydro.database import HydrodynamicDatabase
from fowtlib.components.hydro.model_hulls import hulls
from fowtlib.components.hydro.panel import solve_hull

TARGET = Path(__file__).parents[1] / "data" / "wind_tracing" / "hydrodynamics.nc"
HEADINGS = np.arange(0, 181, 5)
OMEGA = np.round([*np.arange(0.1, 1.301, 0.05), 1.4, 1.6, 1.8, 2.0, 2.4, 2.8, 3.2], 2)


def convert(size: float = 6.0, target: Path = TARGET, model: str = "wind_tracing_rigid") -> HydrodynamicDatabase:
    """Write `target`; panels `size` [m] wide."""
    hull = hulls(fw.load(model).root)["platform.hull"].mesh(size)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # waves above 1.8 rad/s are too short for the panels; they move nothing
        database = solve_hull(
            hull,
            omega=OMEGA,
            headings=np.radians(HEADINGS),
            water_depth=200.0,
            rho=1025.0,
            g=9.80665,
            progress=lambda done, total: print(f"{done} of {total}", flush=True),
        )
    target.parent.mkdir(parents=True, exist_ok=True)
    database = mirrored(database)
    database.write(target)
    return database


def mirrored(database: HydrodynamicDatabase) -> HydrodynamicDatabase:
    """With waves from the other side: sway, roll and yaw change their sign."""
    other = database.X[:, :0:-1] * [1, -1, 1, -1, 1, -1]
    return replace(
        database,
        heading=np.concatenate([-database.heading[:0:-1], database.heading]),
        X=np.concatenate([other, database.X], axis=1),
    )


if __name__ == "__main__":
    size = float(sys.argv[1]) if len(sys.argv) > 1 else 6.0
    print(convert(size))
