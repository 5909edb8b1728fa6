"""Weighted deviation of rotor speed and actuator duty cycle of the DTU 10-MW turbine on land, by `fw.response`.

    python benchmarks/dtu10mw_land.py [--wind disc point] [--gains land slower floating] [--states 15]

Printed for its land-based design by J. M. Hegseth (thesis NTNU 2020:356, papers 3 and 4): 0.043 rad/s, of which paper 4
has 4.22e-2, and 5.10e-3. The states are the winds 1, 3, ... 29 m/s (15) or 1, 2, ... 30 m/s (30), normal turbulence
of class B, weighted by the density of the wind of J. Johannessen et al. (2002): Weibull, shape 1.708 and scale 8.426
m/s at 10 m, shear exponent 0.14. Below 4 m/s and above 25 m/s the rotor is parked and counts as zero. Duty cycle: mean
of the pitch rate's size over 10 deg/s, sqrt(2/pi) of its deviation (paper 4, eq. 11).

`disc`: rigid blades by elements in a field of turbulence through which they turn. `point`: rotor coefficients with the
wind of the hub on the whole disc.

`slower`: the gains on land with 0.7 times the natural frequency of the speed loop and its damping, proportional gain
times 0.7 and integral gain times 0.7^2. With them both printed numbers are met, see docs/dtu10mw.md.
"""

from __future__ import annotations

import argparse
import warnings

import numpy as np

import fowtlib as fw

RIGID = {"turbine.assembly.blade_hinges": 0, "turbine.assembly.blade_torsion": False,
         "turbine.aerodynamics.airfoil_model": "steady", "tower_flow.active": False}  # fmt: skip
WINDS = {
    "disc": ("dtu10mw_land", {"wind.kind": "turbulence", **RIGID}),
    "point": ("dtu10mw_land_rigid", {"wind.kind": "kaimal", "turbine.rotor.filtered": False}),
}
FLOATING = {
    "turbine.control.proportional_gain": 0.003588, "turbine.control.integral_gain": 0.00033,
    "turbine.control.filter_frequency": 1.25, "turbine.control.region_3": "constant_torque",
    "turbine.control.pitch.doubling_pitch": 2.0597, "turbine.control.pitch.schedule_curvature": 16.8919,
}  # fmt: skip
SLOWER = {
    "turbine.control.proportional_gain": 0.7 * 0.0213426, "turbine.control.integral_gain": 0.7**2 * 0.0048489,
}  # fmt: skip
GAINS = {"land": {}, "slower": SLOWER, "floating": FLOATING}
OPERATION = (4.0, 25.0)
GREATEST_RATE = np.radians(10.0)


def weights(winds: np.ndarray) -> np.ndarray:
    """Probabilities of the winds at the hub, with the sum 1."""
    shape, scale = 1.708, 8.426
    at_10_m = winds * (10 / 119) ** 0.14 / scale
    density = at_10_m ** (shape - 1) * np.exp(-(at_10_m**shape))
    return density / density.sum()


def state(plant: fw.Plant, wind: float) -> tuple[float, float]:
    """Deviation of the rotor speed [rad/s] and duty cycle in one state."""
    found = fw.response(plant, outputs=["rotor_speed", "blade_pitch"], parameters={"wind.mean_speed": wind})
    pitch = found.spectrum("blade_pitch")
    rate = np.trapezoid((2 * np.pi * pitch.frequency) ** 2 * pitch.density, pitch.frequency) ** 0.5
    return found.std("rotor_speed") * np.pi / 30, np.sqrt(2 / np.pi) * np.radians(rate) / GREATEST_RATE


def main() -> None:
    """Print a table for each wind and each set of gains."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--wind", nargs="+", default=list(WINDS), choices=list(WINDS))
    parser.add_argument("--gains", nargs="+", default=["land", "floating"], choices=list(GAINS))
    parser.add_argument("--states", type=int, default=15, choices=(15, 30))
    given = parser.parse_args()
    warnings.simplefilter("ignore")
    winds = np.arange(1.0, 31.0, 30 // given.states)
    share = weights(winds)
    for kind in given.wind:
        for gains in given.gains:
            model, conditions = WINDS[kind]
            plant = fw.load(model, set={**conditions, **GAINS[gains]}).compile()
            total = np.zeros(2)
            for wind, weight in zip(winds, share, strict=True):
                if not OPERATION[0] <= wind <= OPERATION[1]:
                    continue
                row = state(plant, float(wind))
                total += weight * np.array(row)
                print(f"{kind} {gains} {wind:4.0f} m/s ({weight:.4f}): {row[0]:.4f} rad/s, {row[1]:.3e}", flush=True)
            print(f"{kind}, gains {gains}: {total[0]:.4f} rad/s, duty cycle {total[1]:.3e}", flush=True)


if __name__ == "__main__":
    main()
