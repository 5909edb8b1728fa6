"""Sensitivities of runs in time: what they cost, and how far they go in turbulence; see docs/sensitivities.md.

    python benchmarks/sensitivities.py cost        # one run, and sensitivities to 1, 10 and 30 parameters
    python benchmarks/sensitivities.py turbulence  # against differences of several sizes, in 600 s
    python benchmarks/sensitivities.py seeds       # slopes of statistics of six seeds

Processor time of one thread, the least of three. Each difference of runs takes what a user's takes: the mean and the
data of wind and sea at another parameter.
"""

from __future__ import annotations

import sys
import time
import warnings
from collections.abc import Callable
from typing import Any

import numpy as np

import fowtlib as fw

MODEL = "oc3_spar_rigid"
PARAMETERS = [
    "platform.mooring.length", "turbine.control.proportional_gain", "platform.drag.drag_coefficient",
    "platform.hull.mass", "platform.mooring.mass_per_length", "platform.mooring.fairlead_depth", "world.air_density",
    "tower.mass", "turbine.rotor.inertia", "turbine.control.integral_gain", "platform.mooring.yaw_stiffness",
    "turbine.rotor.radius", "platform.mooring.axial_stiffness", "platform.mooring.anchor_radius",
    "platform.mooring.fairlead_radius", "turbine.control.rated_speed", "turbine.control.filter_frequency",
    "turbine.mass", "turbine.gear_ratio", "turbine.generator_inertia", "turbine.control.torque.rated_torque",
    "turbine.control.pitch.doubling_pitch", "turbine.rotor.cutoff_frequency", "platform.damping.translation[0]",
    "platform.damping.translation[1]", "platform.damping.translation[2]", "platform.damping.rotation[2]",
    "platform.drag.diameters[0]", "platform.drag.diameters[1]", "platform.water.hydrostatics.volume",
]  # fmt: skip
RESULTS = ["surge", "pitch", "rotor_speed", "thrust", "fairlead_tension_2"]
STATES = {8.0: (2.5, 9.0), 12.0: (3.5, 10.0), 18.0: (5.0, 11.0)}


def weather(speed: float, seed: int = 1) -> dict[str, Any]:
    height, period = STATES[speed]
    return {"wind.mean_speed": speed, "sea.significant_wave_height": height, "sea.peak_period": period,
            "wind.seed": seed, "sea.seed": seed}  # fmt: skip


def least(action: Callable[[], object]) -> float:
    """Processor time [s]."""
    taken = []
    for _ in range(3):
        began = time.process_time()
        action()
        taken.append(time.process_time() - began)
    return min(taken)


def cost(plant: fw.Plant) -> None:
    run = {"t_end": 600.0, "output_step": 0.1, "start": "equilibrium", "parameters": weather(18.0)}
    alone = least(lambda: plant.simulate(solver="fixed", outputs=RESULTS, **run))
    print(f"one run of 600 s: {alone:.2f} s, with its mean and data kept")
    value = float(plant.binding(run["parameters"]).values[PARAMETERS[0]])
    shifts = iter(1 + 1e-6 * np.arange(1, 100))

    def another() -> None:
        moved = {**run["parameters"], PARAMETERS[0]: value * next(shifts)}
        plant.simulate(solver="fixed", outputs=RESULTS, **{**run, "parameters": moved})

    each = least(another)
    print(f"a run at another parameter: {each:.2f} s")
    for count in (1, 10, 30):
        taken = least(lambda count=count: fw.sensitivities(plant, PARAMETERS[:count], RESULTS, **run))
        differences = 2 * count * each
        print(f"{count} parameters: {taken:.2f} s, {taken / alone:.1f} runs; central differences {differences:.2f} s")


def turbulence(plant: fw.Plant) -> None:
    for speed in STATES:
        conditions = weather(speed)
        run = {"t_end": 600.0, "output_step": 0.2, "start": "equilibrium"}
        found = fw.sensitivities(plant, PARAMETERS[:3], RESULTS, parameters=conditions, tolerance=1e-10, **run)
        print(f"{speed:g} m/s: growth {found.growth:+.4f} 1/s")
        for parameter in found.parameters:
            value = float(found.at[found.parameters.index(parameter)])
            for part in (1e-4, 1e-3, 1e-2, 5e-2):
                both = [plant.simulate(solver="fixed", outputs=RESULTS, tolerance=1e-10,
                                       parameters={**conditions, parameter: value * (1 + sign * part)}, **run)
                        for sign in (1, -1)]  # fmt: skip
                told = []
                for result in RESULTS:
                    change = (both[0].array(result) - both[1].array(result)) / (2 * part * value)
                    slope = found.array(result, parameter)
                    spans = [slice(0, 500), slice(500, 1500), slice(1500, None)]
                    sizes = [(np.linalg.norm((change - slope)[span]), np.linalg.norm(change[span])) for span in spans]
                    told.append("/".join(f"{rest / size:.1e}" if size else "no change" for rest, size in sizes))
                print(f"  {parameter} {part:.0e}: " + "  ".join(told))
        for result in ("pitch", "fairlead_tension_2"):
            for number in ("mean", "std", "maximum"):
                slopes = getattr(found, number)(result, 100.0)
                told = []
                for k, parameter in enumerate(found.parameters):
                    value = float(found.at[k])
                    both = [plant.simulate(solver="fixed", outputs=[result], tolerance=1e-10,
                                           parameters={**conditions, parameter: value * (1 + sign * 0.01)}, **run)
                            for sign in (1, -1)]  # fmt: skip
                    key = {"maximum": "max"}.get(number, number)
                    high, low = (getattr(one.statistics(discard=100.0)[result], key) for one in both)
                    told.append(f"{slopes.by[k] * value * 0.01:.4g} ({(high - low) / 2:.4g})")
                print(f"  {slopes.name} {slopes.value:.4g}: change for 1 %, and by runs: " + ", ".join(told))


def seeds(plant: fw.Plant) -> None:
    for speed in STATES:
        rows = []
        for seed in range(1, 7):
            found = fw.sensitivities(plant, PARAMETERS[:3], ["pitch", "fairlead_tension_2"], t_end=700.0,
                                     output_step=0.2, start="equilibrium", parameters=weather(speed, seed))  # fmt: skip
            numbers = [getattr(found, number)(result, 100.0) for result in found.results
                       for number in ("mean", "std", "maximum")]  # fmt: skip
            rows.append([number.by * found.at * 0.01 for number in numbers])
        mean, spread = np.mean(rows, axis=0), np.std(rows, axis=0, ddof=1)
        for k, number in enumerate(numbers):
            told = (f"{m:.3g} +- {s:.2g}" for m, s in zip(mean[k], spread[k], strict=True))
            print(f"{speed:g} m/s, {number.name}: change for 1 % of each: {', '.join(told)}")


if __name__ == "__main__":
    warnings.simplefilter("always")
    chosen = sys.argv[1:] or ["cost"]
    compiled = fw.load(MODEL).compile()
    for word in chosen:
        {"cost": cost, "turbulence": turbulence, "seeds": seeds}[word](compiled)
