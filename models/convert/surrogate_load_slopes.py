"""The slopes of the 7-MW surrogate's loads by the wind at its elements, over the winds in which it operates.

python models/convert/surrogate_load_slopes.py

Its blades are those of the DTU 10 MW in another size. At the same wind, tip speed and pitch slopes of the thrust go by
the square of the size, those of the moments by the cube; rotor speed and pitch are those of turbines/surrogate_7mw.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from dtu10mw_load_slopes import DATA, HUB_RADIUS, PRECONE, RADIUS
from surrogate_7mw import POWER, SPEEDS
from surrogate_7mw import RADIUS as SMALL

from fowtlib.components.aero import BladeElementRotor, load_slopes, read_blade, read_coefficients, write_load_slopes
from fowtlib.components.servo import TorqueLaw
from fowtlib.components.turbine import SteadyTurbine
from fowtlib.design.rules.turbine import DTU_10MW, NREL_5MW, between

WINDS = [*np.arange(3.0, 10.0), 9.5, 10.0, 10.2, 10.4, 10.6, 10.8, *np.arange(11.0, 15.0, 0.5), *np.arange(15.0, 31.0)]
ABOUT = (
    "Surrogate 7 MW: slopes of the loads of one blade by the wind along the shaft at each element, over the density.",
    "Written by models/convert/surrogate_load_slopes.py (SOURCES.md). Above 25 m/s in operation too, not parked.",
)


def main() -> None:
    """Write load_slopes.csv."""
    sizes = between(NREL_5MW, DTU_10MW, SMALL, POWER, "surrogate 7-MW")
    n, size = sizes.gear_ratio, SMALL / RADIUS
    rated = sizes.rated_speed * n
    law = TorqueLaw(
        **{name: share * rated for name, share in SPEEDS.items()}, rated_speed=rated,
        rated_torque=sizes.rated_torque / n, region_2_constant=sizes.optimal_constant / n**3,
        region_3="constant_torque",
    )  # fmt: skip
    table = read_coefficients(str(DATA / "rotor_coefficients.csv"))
    turbine = SteadyTurbine(table, SMALL, law, n, precone=PRECONE)
    points = [turbine.operating_point(float(wind)) for wind in WINDS]
    blade = read_blade(str(DATA / "blade_aerodynamics.csv"), str(DATA / "airfoils.csv"), HUB_RADIUS, RADIUS)
    speeds, pitches = np.array([p.rotor_speed for p in points]), [p.blade_pitch for p in points]
    large = load_slopes(BladeElementRotor(blade), WINDS, speeds * size, pitches, precone=PRECONE)
    small = replace(
        large, rotor_speed=speeds, radius=large.radius * size, thrust=large.thrust * size**2,
        torque=large.torque * size**3, moment=large.moment * size**3,
    )  # fmt: skip
    write_load_slopes(DATA.parent / "surrogate_7mw" / "load_slopes.csv", small, ABOUT)


if __name__ == "__main__":
    main()
