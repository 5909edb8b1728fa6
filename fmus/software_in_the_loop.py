"""Software in the loop, as in a basin: the hull is there, its turbine is a mass and a program that commands winches.

The program is the FMU of the turbine: it takes the motion of the hub, and gives the force that the winches put on it
up to the next exchange. The whole model, which has the turbine in it, is what the basin should show. Three things part
them: the exchange period, the moments of the rotor, which winches at the hub leave out, and that the rotor of the FMU
does not tilt with the hull. The tank may have another scale (basin.py).

python fmus/software_in_the_loop.py                        after `make fmus`; pictures come to fmus/built
python fmus/software_in_the_loop.py dtif --scale 45
python fmus/software_in_the_loop.py HULL.yaml --frame tower_to_hub.frame_b --fmu TURBINE.fmu --whole MODEL [--scale 45]

A hull of your own is a model file with the mass of its turbine, whose hub is a port of it (--frame); the FMU is made as
that of fmus/models/turbine_alone.yaml.
"""

import argparse
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from basin import STEP, Case, basin

import fowtlib as fw

HERE = Path(__file__).parent
SHOWN = {"surge": "surge [m]", "pitch": "pitch [deg]", "thrust": "force at the hub [kN]"}
WIND = {"wind.kind": "kaimal", "wind.turbulence_class": "B", "wind.seed": 1}
CASES = {
    name: Case(str(HERE / "models" / hull), whole, fmu, wind=WIND | {"wind.mean_speed": speed})
    for name, hull, whole, fmu, speed in (
        ("oc3", "spar_hull.yaml", "oc3_spar_rigid", "turbine_alone.fmu", 14.0),
        ("dtif", "dtif_hull.yaml", "dtif_operating", "surrogate_alone.fmu", 12.0),
    )
}


def main(folder=HERE / "built", duration=300.0, periods=(0.2, 0.1, 0.05, 0.0125), case=CASES["oc3"], scale=1.0,
         picture="software_in_the_loop.png"):  # fmt: skip
    """Standard deviation of what surge, pitch and force are off over their own; by (period [s], moments)."""
    run = fw.load(case.whole, set=case.wind).compile().simulate(duration, 0.1, solver="fixed", step=STEP)
    whole = {name: run[name].values for name in SHOWN}
    figure, axes = plt.subplots(len(SHOWN), 1, figsize=(9, 7), sharex=True, layout="constrained")
    found = {}
    for period, moments in [*((period, False) for period in periods), (min(periods), True)]:
        time, shown = basin(case, folder / case.fmu, period, duration, moments, scale)
        there = {name: np.interp(run.time, time, shown[name]) for name in SHOWN}
        off = {name: np.std(there[name] - whole[name]) / np.std(whole[name]) for name in SHOWN}
        found[period, moments] = tuple(off.values())
        label = f"{1000 * period:g} ms" + (", with moments" if moments else "")
        print(f"exchange every {label:22}: surge off by {off['surge']:.4f}, pitch by {off['pitch']:.4f}, "
              f"force by {off['thrust']:.4f} of its standard deviation")  # fmt: skip
        if period in (max(periods), min(periods)):
            for name, axis in zip(SHOWN, axes, strict=True):
                axis.plot(time, shown[name], lw=0.8, label=f"in the basin, {label}")
    for (name, label), axis in zip(SHOWN.items(), axes, strict=True):
        axis.plot(run.time, whole[name], "k--", lw=0.8, label="whole model")
        axis.set_ylabel(label)
    axes[0].legend()
    axes[-1].set_xlabel("time [s]")
    figure.savefig(folder / picture, dpi=100)
    return found


def _arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("case", nargs="?", default="oc3", help="oc3, dtif, or the file of a hull")
    parser.add_argument("--frame", default="tower_to_hub.frame_b", help="port at the hub, of a hull of your own")
    parser.add_argument("--fmu", help="FMU of the turbine, of a hull of your own")
    parser.add_argument("--whole", help="model with its turbine to compare with, of a hull of your own")
    parser.add_argument("--scale", type=float, default=1.0, help="of the tank, 45 for 1:45")
    parser.add_argument("--time", type=float, default=300.0, help="seconds of full scale")
    return parser, parser.parse_args()


if __name__ == "__main__":
    parser, given = _arguments()
    if given.case not in CASES and not (given.fmu and given.whole):
        parser.error("a hull of your own needs --fmu and --whole")
    chosen = CASES.get(given.case) or Case(given.case, given.whole, str(Path(given.fmu).resolve()), given.frame)
    if not (HERE / "built" / chosen.fmu).is_file():
        raise SystemExit(f"There is no {chosen.fmu} yet; make it: make fmus")
    shown = Path(given.case).stem + (f"_1_{given.scale:g}" if given.scale != 1 else "")
    main(duration=given.time, case=chosen, scale=given.scale, picture=f"software_in_the_loop_{shown}.png")
