"""Software in the loop, as in a basin: the hull is there, its turbine is a mass and a program that commands winches.

The program is the FMU of the turbine: it takes the motion of the hub, and gives the force that the winches put on it
up to the next exchange. The whole model, which has the turbine in it, is what the basin should show. Three things part
them: the exchange period, the moments of the rotor, which winches at the hub leave out, and that the rotor of the FMU
does not tilt with the hull. In a tank of another scale the hull is a model by Froude's law, and the FMU that of the
prototype: what it is told and gives goes through the same law, and its seconds pass faster than those of the tank.

python fmus/software_in_the_loop.py                        after `make fmus`; pictures come to fmus/built
python fmus/software_in_the_loop.py dtif --scale 45
python fmus/software_in_the_loop.py HULL.yaml --frame tower_to_hub.frame_b --fmu TURBINE.fmu --whole MODEL [--scale 45]

A hull of your own is a model file with the mass of its turbine, whose hub is a port of it (--frame); the FMU is made as
that of fmus/models/turbine_alone.yaml.
"""

from __future__ import annotations

import argparse
import math
from dataclasses import dataclass, field
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import fowtlib as fw
from fowtlib.components.blocks import Demux, Gain, Mux
from fowtlib.components.fmu import FMU
from fowtlib.components.mechanics import PositionSensor, VelocitySensor, WorldForce, WorldTorque

HERE = Path(__file__).parent
STEP = 0.0125  # s of full scale
FRESH = 1000.0  # kg/m^3, of the water in a tank
IGNORED = ["yaw", "control.velocity", "control.set_point_change", "control.pitch.raised", "control.torque.raised"]
SHOWN = {"surge": "surge [m]", "pitch": "pitch [deg]", "thrust": "force at the hub [kN]"}


@dataclass(frozen=True)
class Case:
    """A hull, the port of its hub, the FMU of its turbine, the whole model, and the wind that both have."""

    hull: str
    whole: str
    fmu: str
    frame: str = "tower_to_hub.frame_b"
    wind: dict[str, object] = field(default_factory=dict)


def _wind(speed: float) -> dict[str, object]:
    return {"wind.kind": "kaimal", "wind.mean_speed": speed, "wind.turbulence_class": "B", "wind.seed": 1}


CASES = {
    "oc3": Case(str(HERE / "models" / "spar_hull.yaml"), "oc3_spar_rigid", "turbine_alone.fmu", wind=_wind(14.0)),
    "dtif": Case(str(HERE / "models" / "dtif_hull.yaml"), "dtif_operating", "surrogate_alone.fmu", wind=_wind(12.0)),
}


def in_the_basin(case, archive, period, moments=False, scale=1.0):
    """The model of the hull in a tank, 1 : scale, with the FMU at its hub, exchanged every period [s of full scale]."""
    model = fw.load(case.hull)
    density = 1.0
    if scale != 1.0:
        density = FRESH / float(model.root.world.parameter_value("water_density"))
        model = fw.scaled(model, 1 / scale, density_ratio=density)
    root, hub = model.root, _port(model.root, case.frame)
    root.turbine = FMU(file=str(archive), period=period / math.sqrt(scale), time_factor=math.sqrt(scale),
                       ignore=[f"turbine.{name}" for name in IGNORED])  # fmt: skip
    root.place, root.hub_motion = PositionSensor(), VelocitySensor()
    root.winches, root.torque = WorldForce(), WorldTorque()
    for part in (root.place, root.hub_motion, root.winches, root.torque):
        root.connect(hub, part.frame)
    force = density / scale**3
    exchanged = {
        "hub_position": (root.place.r, scale), "hub_velocity": (root.hub_motion.v, math.sqrt(scale)),
        "force": (root.winches.force, force), "moment": (root.torque.torque, force / scale * moments),
    }  # fmt: skip
    for name, (signal, factor) in exchanged.items():
        told = name.startswith("hub")
        split = root.add(f"{name}_parts", Demux(n=3) if told else Mux(n=3))
        root.connect(*((signal, split.u) if told else (split.y, signal)))
        for i in range(3):
            scaled = root.add(f"{name}_scaled_{i}", Gain(gain=factor))
            port = getattr(root.turbine, f"{name}_{i}")
            one, other = (split.y[i], port) if told else (port, split.u[i])
            root.connect(one, scaled.u)
            root.connect(scaled.y, other)
    return model


def basin(case, archive, period, duration, moments=False, scale=1.0):
    """Times [s], and what is shown, of full scale, of a run in the basin."""
    slow, density = math.sqrt(scale), 1.0
    plant = in_the_basin(case, archive, period, moments, scale).compile()
    if scale != 1.0:
        density = FRESH / float(fw.load(case.hull).root.world.parameter_value("water_density"))
    result = plant.simulate(duration / slow, 0.1 / slow, solver="fixed", step=STEP / slow)
    found = {"surge": result["surge"].values * scale, "pitch": result["pitch"].values}
    found["thrust"] = result["winches.force"].values[:, 0] * scale**3 / density / 1e3
    return result.time * slow, found


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


def _port(root, path):
    """A port of a model by its path."""
    owner, _, name = path.rpartition(".")
    return getattr(root.find(owner), name)


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
