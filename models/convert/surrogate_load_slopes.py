"""The slopes of the 7-MW surrogate's loads by the wind at its elements, over the winds in which it operates.

python models/convert/surrogate_load_slopes.py

Its blades are those of the DTU 10 MW in another size. At the same wind, tip speed and pitch slopes of the thrust go by
the square of the size, those of the moments by the cube; rotor speed and pitch are those of turbines/surrogate_7mw.
Above 30 m/s it is parked: its rotor stands, with feathered blades.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from dtu10mw_load_slopes import DATA, HUB_RADIUS, PRECONE, RADIUS
from surrogate_turbines import POWER, SPEEDS
from surrogate_turbines import RADIUS as SMALL

from fowtlib.components.aero import BladeElementRotor, load_slopes, read_blade, read_coefficients, write_load_slopes
from fowtlib.components.servo import TorqueLaw
from fowtlib.components.turbine import SteadyTurbine
from fowtlib.design.rules.turbine import DTU_10MW, NREL_5MW, between

WINDS = [*np.arange(3.0, 10.0), 9.5, 10.0, 10.2, 10.4, 10.6, 10.8, *np.arange(11.0, 15.0, 0.5), *np.arange(15.0, 31.0)]
PARKED, FEATHER = [30.0, 40.0, 50.0, 60.0, 70.0], np.radians(90)
ABOUT = (
    "Surrogate 7 MW: slopes of the loads of one blade by the wind along the shaft at each element, over the density.",
    "Written by models/convert/surrogate_load_slopes.py (SOURCES.md). In operation up to 30 m/s, above it",
    "parked at rest, with feathered blades.",
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
    rotor, still = BladeElementRotor(blade), np.zeros(len(PARKED))
    large = load_slopes(rotor, WINDS, speeds * size, pitches, precone=PRECONE)
    parked = load_slopes(rotor, PARKED, still, [FEATHER] * len(PARKED), precone=PRECONE)

    def both(name: str) -> np.ndarray:
        return np.concatenate([getattr(large, name), getattr(parked, name)])

    small = replace(
        large, wind_speed=both("wind_speed"), rotor_speed=np.append(speeds, still), blade_pitch=both("blade_pitch"),
        radius=large.radius * size, thrust=both("thrust") * size**2, torque=both("torque") * size**3,
        moment=both("moment") * size**3,
    )  # fmt: skip
    write_load_slopes(DATA.parent / "surrogate_7mw" / "load_slopes.csv", small, ABOUT)


if __name__ == "__main__":
    main()
