"""Tension of the upwind line in fatigue: lines in balance, of one degree of freedom, and of point masses.

    python benchmarks/line_fatigue.py [oc3_spar_rigid volturnus_iea15_rigid] [--elements 20] [--duration 1800]

Prints the deviation of the tension and its damage-equivalent range at 1 Hz for a slope of 3 (chain), over the last part
of each run, and how many times faster than the clock the run was. See docs/mooring.md, Fatigue.
"""

from __future__ import annotations

import argparse
import time

import numpy as np

import fowtlib as fw
from fowtlib.analysis.fatigue import rainflow_cycles

STATES = ((8.0, 2.0, 8.0), (12.0, 3.5, 9.5), (18.0, 6.0, 11.5))
"""Mean wind [m/s], significant wave height [m], peak period [s]."""
KINDS = {"in balance": "none", "one degree of freedom": "coupled", "point masses": "lumped"}
AXIAL = {"oc3_spar_rigid": 0.1, "volturnus_iea15_rigid": 1.15 * 0.185 / (np.pi * 0.333)}
"""Axial drag on pi times the diameter; of studless chain 1.15 on its bar (DNV-OS-E301)."""
SETTLING = 300.0


def tension(
    plant: fw.Plant, state: tuple[float, float, float], duration: float
) -> tuple[np.ndarray, np.ndarray, float]:
    """Times [s] after the settling, tension [N] of the upwind line, and seconds simulated per second."""
    wind, height, period = state
    given = {"wind.mean_speed": wind, "sea.significant_wave_height": height, "sea.peak_period": period}
    began = time.perf_counter()
    result = plant.simulate(duration + SETTLING, 0.1, parameters=given, solver="fixed", step=0.0125)
    speed = (duration + SETTLING) / (time.perf_counter() - began)
    name = "platform.mooring.line_2.tension"
    kept = result.time >= SETTLING
    return result.time[kept], np.asarray(result[name])[kept], speed


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("models", nargs="*", default=list(AXIAL))
    parser.add_argument("--elements", type=int, default=20)
    parser.add_argument("--duration", type=float, default=1800.0)
    given = parser.parse_args()
    for model in given.models:
        for told, kind in KINDS.items():
            more = {"platform.mooring.elements": given.elements,
                    "platform.mooring.axial_drag_coefficient": AXIAL[model]} if kind == "lumped" else {}  # fmt: skip
            plant = fw.load(model, set={"platform.mooring.dynamics": kind, **more}).compile()
            for state in STATES:
                times, series, speed = tension(plant, state, given.duration)
                equivalent = rainflow_cycles((times, series)).power_mean(3.0, given.duration)
                print(f"{model} {told:22} U {state[0]:4.0f} Hs {state[1]:3.1f} Tp {state[2]:4.1f}: mean "
                      f"{series.mean() / 1e3:7.1f} std {series.std() / 1e3:6.1f} equivalent {equivalent / 1e3:7.1f}, "
                      f"least {series.min() / 1e3:7.1f} largest {series.max() / 1e3:7.1f} kN, {speed:5.0f} times real "
                      "time", flush=True)  # fmt: skip


if __name__ == "__main__":
    main()
