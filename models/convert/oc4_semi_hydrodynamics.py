"""Convert the WAMIT output of the OC4 DeepCwind semisubmersible to our netCDF layout.

    python models/convert/oc4_semi_hydrodynamics.py FOLDER

FOLDER is the unzipped wheel of fowt-force-gen 0.1.0 (MIT). The numbers are made dimensional with rho = 1025 kg/m^3,
g = 9.80665 m/s^2 and ULEN = 1 m, as in the HydroDyn input file of that package; of the 498 frequencies,
0.01 rad/s apart, every second one is kept up to 2 rad/s and every fifth one above.
"""

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np

from fowtlib.components.hydro.database import HydrodynamicDatabase

TARGET = Path(__file__).parents[1] / "data" / "oc4_semi" / "hydrodynamics.nc"


def convert(folder: Path, target: Path = TARGET) -> HydrodynamicDatabase:
    """Write `target` from the unzipped wheel in `folder`."""
    database = HydrodynamicDatabase.from_wamit(
        folder / "fowt_force_gen" / "fast_input_files" / "HydroData" / "marin_semi",
        volume=13917.0,  # PtfmVol0 of OC4Semi_HydroDyn_template.dat
        centre_of_buoyancy=(0.0, 0.0, -13.15),  # NREL/TP-5000-60601, table 4-1
        rho=1025.0,
        g=9.80665,
        water_depth=200.0,
        source="OC4 DeepCwind, WAMIT output in fowt-force-gen 0.1.0 (MIT)",
    )
    number = np.rint(database.omega / 0.01).astype(int)
    keep = np.where(number <= 200, number % 2 == 0, number % 5 == 0)
    database = replace(database, **{name: getattr(database, name)[keep] for name in ("omega", "A", "B", "X")})
    target.parent.mkdir(parents=True, exist_ok=True)
    database.write(target)
    return database


if __name__ == "__main__":
    print(convert(Path(sys.argv[1])))
