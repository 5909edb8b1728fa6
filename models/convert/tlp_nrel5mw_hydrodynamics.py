"""Compute the hydrodynamics of the MIT/NREL TLP with the panel method (needs the extra `fowtlib[hydro]`).

    python models/convert/tlp_nrel5mw_hydrodynamics.py

Takes some minutes on one core. The hull: a column of 18 m diameter and 47.89 m draft, water depth 200 m. The spokes are
left out, as in the WAMIT model of the platform, whose volume is that of the column.
"""

from pathlib import Path

import numpy as np

from fowtlib.components.hydro.database import HydrodynamicDatabase
from fowtlib.components.hydro.panel import Column, compute

TARGET = Path(__file__).parents[1] / "data" / "tlp_nrel5mw" / "hydrodynamics.nc"
HULL = Column(((-47.89, 18.0), (5.0, 18.0)))


def convert(target: Path = TARGET) -> HydrodynamicDatabase:
    """Write `target`."""
    target.parent.mkdir(parents=True, exist_ok=True)
    return compute(
        [HULL],
        omega=np.round(np.concatenate([[0.06], np.arange(0.1, 2.001, 0.05), np.arange(2.1, 4.001, 0.1)]), 2),
        headings=np.radians(np.arange(-180, 181, 15)),
        water_depth=200.0,
        rho=1025.0,
        g=9.80665,
        panel_size=1.0,
        path=target,
    )


if __name__ == "__main__":
    print(convert())
