"""Convert the WAMIT output of the OC3 Hywind spar to our netCDF layout.

    python models/convert/oc3_hywind_hydrodynamics.py FOLDER

FOLDER is the unzipped wheel of fowt-force-gen 0.1.0 (MIT). The numbers are made dimensional with rho = 1025 kg/m^3,
g = 9.80665 m/s^2 and ULEN = 1 m, as in the HydroDyn input file of that package; nothing else is changed.
"""

import sys
from pathlib import Path

from fowtlib.components.hydro.database import HydrodynamicDatabase

TARGET = Path(__file__).parents[1] / "data" / "oc3_hywind" / "hydrodynamics.nc"


def convert(folder: Path, target: Path = TARGET) -> HydrodynamicDatabase:
    """Write `target` from the unzipped wheel in `folder`."""
    database = HydrodynamicDatabase.from_wamit(
        folder / "fowt_force_gen" / "fast_input_files" / "HydroData" / "spar",
        volume=8029.21,  # PtfmVol0 of OC3Hywind_HydroDyn_template.dat
        centre_of_buoyancy=(0.0, 0.0, -62.0657),  # two cylinders and a cone: 6.5 m, 9.4 m, taper 4 m to 12 m
        rho=1025.0,
        g=9.80665,
        water_depth=320.0,
        source="OC3 Hywind, WAMIT output in fowt-force-gen 0.1.0 (MIT)",
    )
    target.parent.mkdir(parents=True, exist_ok=True)
    database.write(target)
    return database


if __name__ == "__main__":
    print(convert(Path(sys.argv[1])))
