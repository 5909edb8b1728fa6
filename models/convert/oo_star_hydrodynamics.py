"""Compute the hydrodynamics of the OO-Star Wind Floater with the panel method (needs the extra `fowtlib[hydro]`).

    python models/convert/oo_star_hydrodynamics.py [SIZE]

Takes about ten minutes on one core. The hull: the members of `oo_star_rigid`, in panels of 3 m. The floater is
three equal parts, but its panels are symmetric about y = 0 only: the results are averaged over the three turns, which
takes away a coupling of sway and yaw that the floater has not.
"""

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np

import fowtlib as fw
from fowtlib.components.hydro.database import HydrodynamicDatabase
from fowtlib.components.hydro.model_hulls import hulls
from fowtlib.components.hydro.panel import solve_hull

TARGET = Path(__file__).parents[1] / "data" / "oo_star" / "hydrodynamics.nc"
HEADINGS = np.arange(-180, 181, 15)
OMEGA = np.round(np.arange(0.1, 4.001, 0.1), 1)


def convert(size: float = 3.0, target: Path = TARGET) -> HydrodynamicDatabase:
    """Write `target`; panels `size` [m] wide."""
    hull = hulls(fw.load("oo_star_rigid").root)["platform.hull"].mesh(size)
    database = in_three_parts(
        solve_hull(
            hull,
            omega=OMEGA,
            headings=np.radians(HEADINGS),
            water_depth=130.0,
            rho=1025.0,
            g=9.80665,
            progress=lambda done, total: print(f"{done} of {total}", flush=True),
        )
    )
    target.parent.mkdir(parents=True, exist_ok=True)
    database.write(target)
    return database


def in_three_parts(database: HydrodynamicDatabase) -> HydrodynamicDatabase:
    """The mean of the database and of itself turned by 120 and 240 deg about z."""
    mean = {name: np.zeros_like(getattr(database, name)) for name in ("A", "B", "X", "A_inf", "A_zero")}
    for k in range(3):
        c, s = np.cos(2 * np.pi * k / 3), np.sin(2 * np.pi * k / 3)
        turn = np.kron(np.eye(2), [[c, -s, 0], [s, c, 0], [0, 0, 1]])
        for name in ("A", "B", "A_inf", "A_zero"):
            mean[name] += turn @ getattr(database, name) @ turn.T / 3
        before = (HEADINGS - 120 * k + 180) % 360 - 180  # the wave that is turned into each heading
        mean["X"] += database.X[:, np.searchsorted(HEADINGS, before)] @ turn.T / 3
    return replace(database, **mean)


if __name__ == "__main__":
    print(convert(*map(float, sys.argv[1:])))
