"""Software in the loop, as in a basin: the hull is there, its turbine is a mass and a program that commands winches.

The program is the FMU of the turbine: it takes the motion of the hub, and gives the force that the winches put on it
up to the next exchange. The whole spar, which has the turbine in it, is what the basin should show. Three things part
them: the exchange period, the moments of the rotor, which winches at the hub leave out, and that the rotor of the FMU
does not tilt with the hull.

python fmus/software_in_the_loop.py      after `make fmus`; the picture is fmus/built/software_in_the_loop.png
"""

from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import fowtlib as fw

HERE = Path(__file__).parent
WIND = {"wind.kind": "kaimal", "wind.mean_speed": 14.0, "wind.turbulence_class": "B", "wind.seed": 1}
SHOWN = {"surge": "surge [m]", "pitch": "pitch [deg]", "thrust": "force at the hub [kN]"}


def basin(archive, period, duration, moments=False):
    """The run of the hull with the FMU of the turbine, exchanged every period [s]; moments: those of the rotor too."""
    settings = {"turbine.file": str(archive), "turbine.period": period}
    settings |= {f"moment_{i}.gain": float(moments) for i in range(3)}
    model = fw.load(HERE / "models" / "spar_in_the_basin.yaml", set=settings, trust=True)
    return model.compile().simulate(duration, 0.1, solver="fixed", step=0.0125)


def main(folder=HERE / "built", duration=300.0, periods=(0.2, 0.1, 0.05, 0.0125), picture="software_in_the_loop.png"):
    """Standard deviation of what surge, pitch and force are off over their own; by (period [s], moments)."""
    whole = fw.load("oc3_spar_rigid", set=WIND).compile().simulate(duration, 0.1, solver="fixed", step=0.0125)
    figure, axes = plt.subplots(len(SHOWN), 1, figsize=(9, 7), sharex=True, layout="constrained")
    found = {}
    for period, moments in [*((period, False) for period in periods), (min(periods), True)]:
        run = basin(folder / "turbine_alone.fmu", period, duration, moments)
        off = {name: np.std(run[name].values - whole[name].values) / np.std(whole[name].values) for name in SHOWN}
        found[period, moments] = tuple(off.values())
        label = f"{1000 * period:g} ms" + (", with moments" if moments else "")
        print(f"exchange every {label:22}: surge off by {off['surge']:.4f}, pitch by {off['pitch']:.4f}, "
              f"force by {off['thrust']:.4f} of its standard deviation")  # fmt: skip
        if period in (max(periods), min(periods)):
            for name, axis in zip(SHOWN, axes, strict=True):
                axis.plot(run.time, run[name].values, lw=0.8, label=f"in the basin, {label}")
    for (name, label), axis in zip(SHOWN.items(), axes, strict=True):
        axis.plot(whole.time, whole[name].values, "k--", lw=0.8, label="whole spar")
        axis.set_ylabel(label)
    axes[0].legend()
    axes[-1].set_xlabel("time [s]")
    figure.savefig(folder / picture, dpi=100)
    return found


if __name__ == "__main__":
    main() if (HERE / "built").is_dir() else exit("There are no archives yet; make them: make fmus")
