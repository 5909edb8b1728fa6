"""Compute the hydrodynamics of the two-rotor spar with the panel method (needs the extra `fowtlib[hydro]`).

    python models/convert/two_rotor_spar_hydrodynamics.py

Takes about ten minutes on one core. The spar: draft 140 m, diameter 7.6 m down to 4 m depth, tapered to 10.5 m at 12 m
depth (taper as the OC3 Hywind spar), water depth 320 m.
"""

from pathlib import Path

import numpy as np

from fowtlib.components.hydro.database import HydrodynamicDatabase
from fowtlib.components.hydro.panel import Column, compute

TARGET = Path(__file__).parents[1] / "data" / "two_rotor_spar" / "hydrodynamics.nc"
SPAR = Column(((-140.0, 10.5), (-12.0, 10.5), (-4.0, 7.6), (10.0, 7.6)))


def convert(target: Path = TARGET) -> HydrodynamicDatabase:
    """Write `target`."""
    target.parent.mkdir(parents=True, exist_ok=True)
    return compute(
        [SPAR],
        omega=np.round(np.arange(0.05, 4.001, 0.05), 2),
        headings=np.radians(np.arange(-180, 181, 15)),
        water_depth=320.0,
        rho=1025.0,
        g=9.80665,
        panel_size=1.0,
        path=target,
    )


if __name__ == "__main__":
    print(convert())
