"""Standard deviations of `fw.response` beside those of runs: `python benchmarks/response_against_runs.py MODEL [...]`.

One seed of wind and waves is one run of `--time` seconds, of which the first 300 s are left out.
"""

from __future__ import annotations

import argparse
import warnings

import numpy as np

import fowtlib as fw

DISCARD = 300.0


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("model")
    parser.add_argument("--wind", default="turbulence", choices=("turbulence", "kaimal"))
    parser.add_argument("--speed", type=float, default=18.0)
    parser.add_argument("--height", type=float, default=3.6)
    parser.add_argument("--period", type=float, default=10.0)
    parser.add_argument("--seeds", type=int, default=2)
    parser.add_argument("--time", type=float, default=1300.0)
    parser.add_argument("--outputs", default="surge,pitch,yaw,rotor_speed,blade_pitch,thrust")
    given = parser.parse_args()
    warnings.simplefilter("ignore")
    plant = fw.load(given.model).compile()
    weather = {
        "wind.kind": given.wind, "wind.mean_speed": given.speed, "wind.repetition_period": given.time,
        "sea.significant_wave_height": given.height, "sea.peak_period": given.period,
        "sea.repetition_period": given.time,
    }  # fmt: skip
    names, runs = given.outputs.split(","), []
    for seed in range(1, given.seeds + 1):
        seeds = {"wind.seed": seed, "sea.seed": seed + 50}
        run = plant.simulate(given.time, 0.1, parameters={**weather, **seeds}, solver="fixed", start="turning")
        runs.append([float(np.std(run[name].values[run.time >= DISCARD])) for name in names])
    found = fw.response(plant, outputs=names, parameters=weather)
    for name, ofruns in zip(names, np.transpose(runs), strict=True):
        share = found.std(name) / ofruns.mean()
        print(f"{name:32}{found.std(name):12.4g}   runs {np.array2string(ofruns, precision=4)}   ratio {share:.3f}")


if __name__ == "__main__":
    main()
