"""Convert the WAMIT output of the VolturnUS-S semisubmersible to our netCDF layout.

    python models/convert/volturnus_hydrodynamics.py FOLDER

FOLDER is the unzipped wheel of rosco 2.10.6 (Apache-2.0). The numbers are made dimensional with rho = 1025 kg/m^3,
g = 9.80665 m/s^2 and ULEN = 1 m, as in the HydroDyn input file of that package. All of the 100 frequencies, 0.05 rad/s
apart, are kept; of the 37 headings, 10 deg apart, every second one, 20 deg apart. The damping of yaw at 4.35 rad/s,
which is negative there (-0.12 % of its maximum), becomes zero.
"""

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np

from fowtlib.components.hydro.database import HydrodynamicDatabase

TARGET = Path(__file__).parents[1] / "data" / "volturnus" / "hydrodynamics.nc"
FOLDER = Path("Examples") / "Test_Cases" / "IEA-15-240-RWT" / "IEA-15-240-RWT-UMaineSemi" / "HydroData"


def convert(folder: Path, target: Path = TARGET) -> HydrodynamicDatabase:
    """Write `target` from the unzipped wheel in `folder`."""
    database = HydrodynamicDatabase.from_wamit(
        folder / FOLDER / "IEA-15-240-RWT-UMaineSemi",
        volume=20206.34889,  # PtfmVol0 of IEA-15-240-RWT-UMaineSemi_HydroDyn.dat
        centre_of_buoyancy=(0.0, 0.0, -13.627908),  # IEA-15-240-RWT-UMaineSemi_1stOrder.out.wamit
        rho=1025.0,
        g=9.80665,
        water_depth=200.0,
        source="VolturnUS-S, WAMIT output in rosco 2.10.6 (Apache-2.0)",
    )
    keep = np.rint(np.degrees(database.heading)).astype(int) % 20 == 0
    damping = database.B.copy()
    damping[:, 5, 5] = np.maximum(damping[:, 5, 5], 0.0)
    database = replace(database, heading=database.heading[keep], X=database.X[:, keep], B=damping)
    target.parent.mkdir(parents=True, exist_ok=True)
    database.write(target)
    return database


if __name__ == "__main__":
    print(convert(Path(sys.argv[1])))
