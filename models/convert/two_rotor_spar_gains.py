"""Gains of the two-rotor spar over the wind, data/two_rotor_spar/gains.json: linear-quadratic, from the model itself.

The weights are those of O. El Beshbichi, thesis, Univ. of Stavanger (2023), tables 5.5 and 5.6: below rated wind yaw,
above it also the speeds of the rotors and the integrals of their errors. Below rated the plant is linearised at a pitch
of 0.052 rad, as there, where a rotor answers to pitch; the trim is that of the controller. There the integrals have a
small weight, not in the source, with which they come back to zero in weak wind.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

import fowtlib as fw
from fowtlib.control import OperatingPoints, gain_table, lqi, reduced

SIDES = ("left", "right")
SPEEDS = [f"turbine_{side}.rotor.w" for side in SIDES]
YAW = ["platform.motion.yaw", "platform.motion.angle_rates[2]"]
STATES = [*SPEEDS, "platform.motion.pitch", "platform.motion.angle_rates[1]", *YAW]
RATED = 12.1 * np.pi / 30
# wind: weights of yaw, yaw rate, speeds, integrals; of the pitches
WEIGHTS = {10.5: ((500, 1, 0, 1e-4), 100), 12.5: ((2500, 2500, 500, 0.01), 200), 99: ((5000, 5000, 5, 1.0), 100)}
PITCHED = 0.052
DATA = Path(__file__).parent.parent / "data"
WINDS = (4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16, 17, 18, 19, 20, 21, 22, 23, 24, 25)


def write_gains(name: str, weights: dict[float, tuple[tuple[float, ...], float]], path: Path) -> None:
    """Design the regulators of a rigid model with two turbines and write the table."""
    power = {f"turbine_{side}.control.region_3": "constant_power" for side in SIDES}
    inputs = {side: f"turbine_{side}.rotor.blade_pitch" for side in SIDES}
    plant = OperatingPoints(fw.load(name).with_parameters(power), inputs, SPEEDS)
    points, regulators = [], []
    for wind in WINDS:
        at = plant.at(wind)
        held = dict.fromkeys(SIDES, PITCHED)
        where = plant.at(wind, held) if at["left"] < PITCHED else at
        others = [name for name in at.linear.states if name.startswith("platform") and name not in STATES]
        (yaw, rate, speed, integral), R = next(value for limit, value in weights.items() if wind < limit)
        by_state = dict(zip([*YAW, *SPEEDS], [yaw, rate, speed, speed], strict=True))
        small = reduced(where.linear, STATES, others)
        regulators.append(lqi(small, by_state, dict.fromkeys(SIDES, R), dict.fromkeys(SPEEDS, integral)))
        # what the rounded corner of the lower limit leaves is no trim
        points.append(replace(at, inputs={side: at[side] if at[side] > 2e-3 else 0.0 for side in SIDES}))
    table = gain_table(points, regulators)
    table.set_points[:, :2] = RATED
    table.save(path)


if __name__ == "__main__":
    write_gains("two_rotor_spar_rigid", WEIGHTS, DATA / "two_rotor_spar" / "gains.json")
