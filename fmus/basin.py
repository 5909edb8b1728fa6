"""A hull in a basin whose turbine is an FMU: the model of it, and a run.

In a tank of another scale the hull is a model by Froude's law, and the FMU that of the prototype: what it is told and
gives goes through the same law, and its seconds pass faster than those of the tank.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import fowtlib as fw
from fowtlib.components.blocks import Demux, Gain, Mux
from fowtlib.components.fmu import FMU
from fowtlib.components.mechanics import PositionSensor, VelocitySensor, WorldForce, WorldTorque

STEP = 0.0125  # s of full scale
FRESH = 1000.0  # kg/m^3, of the water in a tank
IGNORED = ["yaw", "control.velocity", "control.set_point_change", "control.pitch.raised", "control.torque.raised"]


@dataclass(frozen=True)
class Case:
    """A hull, the port of its hub, the FMU of its turbine, the whole model, and the wind that both have."""

    hull: str
    whole: str
    fmu: str
    frame: str = "tower_to_hub.frame_b"
    wind: dict[str, object] = field(default_factory=dict)


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


def _port(root, path):
    """A port of a model by its path."""
    owner, _, name = path.rpartition(".")
    return getattr(root.find(owner), name)
