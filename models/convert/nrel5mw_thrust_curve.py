"""The thrust coefficient of the NREL 5 MW in steady operation over the wind, for a rotor that is a thrust.

python models/convert/nrel5mw_thrust_curve.py

From rotor_coefficients_whole.csv and the controller of turbines/nrel5mw_rigid: optimal torque, then constant torque and
pitch. Below 0.5 m/s, where nothing matters, the coefficient stays.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from fowtlib.components.aero import read_coefficients
from fowtlib.components.servo import TorqueLaw
from fowtlib.components.turbine import SteadyTurbine

DATA = Path(__file__).parent.parent / "data" / "nrel5mw"
RADIUS, PRECONE, RATIO = 63.0, np.radians(2.5), 97.0
WINDS = np.unique(np.round(np.concatenate([
    np.arange(0.5, 11, 0.25), np.arange(11, 13, 0.1), np.arange(13, 25, 0.5), np.arange(25, 51, 1.0),
]), 6))  # fmt: skip
ABOUT = (
    "NREL 5 MW: thrust coefficient in steady operation over the wind along the shaft, area pi (63 m cos 2.5 deg)^2.",
    "Written by models/convert/nrel5mw_thrust_curve.py (SOURCES.md). Above 25 m/s in operation too, not parked.",
)


def main() -> None:
    """Write thrust_curve.csv."""
    table = read_coefficients(str(DATA / "rotor_coefficients_whole.csv"))
    turbine = SteadyTurbine(table, RADIUS, TorqueLaw(region_3="constant_torque"), RATIO, precone=PRECONE)
    area = np.pi * (RADIUS * np.cos(PRECONE)) ** 2
    thrusts = [turbine.operating_point(float(wind)).thrust for wind in WINDS]
    coefficients = np.array(thrusts) / (turbine.air_density / 2 * area * WINDS**2)
    rows = [(0.0, coefficients[0]), *zip(WINDS, coefficients, strict=True)]
    lines = [*(f"# {line}" for line in ABOUT), "wind_speed_m_s,thrust_coefficient"]
    lines += [f"{wind:.10g},{coefficient:.6f}" for wind, coefficient in rows]
    (DATA / "thrust_curve.csv").write_text("\n".join(lines) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
