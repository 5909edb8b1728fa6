"""The slopes of the DTU 10 MW rotor's loads by the wind at its elements, over the winds in which it operates.

python models/convert/dtu10mw_load_slopes.py

Rotor speed and pitch are those of turbines/dtu10mw_rigid in steady operation, the slopes those of its blade elements.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from fowtlib.components.aero import BladeElementRotor, load_slopes, read_blade, read_coefficients, write_load_slopes
from fowtlib.components.servo import TorqueLaw
from fowtlib.components.turbine import SteadyTurbine

DATA = Path(__file__).parent.parent / "data" / "dtu10mw"
HUB_RADIUS, RADIUS, PRECONE, RATIO = 2.8, 89.1655, np.radians(2.5), 50.0
WINDS = [*np.arange(3.0, 11.0), 10.5, 11.0, 11.2, 11.4, 11.6, 11.8, *np.arange(12.0, 16.0, 0.5), *np.arange(16.0, 31.0)]
LAW = TorqueLaw(
    cut_in_speed=280 * np.pi / 30, region_2_speed=320 * np.pi / 30, region_3_speed=475 * np.pi / 30,
    rated_speed=480 * np.pi / 30, rated_torque=198943.7, region_2_constant=100.461, region_3="constant_torque",
)  # fmt: skip
ABOUT = (
    "DTU 10 MW: slopes of the loads of one blade by the wind along the shaft at each element, over the air density.",
    "Written by models/convert/dtu10mw_load_slopes.py (SOURCES.md). Above 25 m/s in operation too, not parked.",
)


def main() -> None:
    """Write load_slopes.csv."""
    table = read_coefficients(str(DATA / "rotor_coefficients.csv"))
    turbine = SteadyTurbine(table, RADIUS, LAW, RATIO, precone=PRECONE)
    points = [turbine.operating_point(float(wind)) for wind in WINDS]
    blade = read_blade(str(DATA / "blade_aerodynamics.csv"), str(DATA / "airfoils.csv"), HUB_RADIUS, RADIUS)
    speeds, pitches = [p.rotor_speed for p in points], [p.blade_pitch for p in points]
    slopes = load_slopes(BladeElementRotor(blade), WINDS, speeds, pitches, precone=PRECONE)
    write_load_slopes(DATA / "load_slopes.csv", slopes, ABOUT)


if __name__ == "__main__":
    main()
