"""The IEA 15-MW turbine on the VolturnUS-S against published numbers: what docs/verification.md and the tests share.

[D] C. Allen et al., NREL/TP-5000-76773 (2020), definition of the VolturnUS-S. [R] RAFT 2.0, values of its tests, rigid.
[O] OpenFAST of 2021: operating points in the 240 linearisations in rosco 2.10.6 (`IEA-15-240-RWT-UMaineSemi/
linearizations`), means over 12 azimuths; rigid blades, surge, heave, pitch, tower bending fore-aft and generator, an
earlier version of the turbine, peak shaving. [T] tabulated power and thrust of the definition, as in floris 4.7
(`turbine_library/iea_15MW.yaml`). [B] pyBmodes 1.19.1, sample `09_iea15_umainesemi`, its own readme.
"""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import numpy as np
import verification_cases as cases

import fowtlib as fw
from fowtlib.components.blocks import Constant
from fowtlib.components.environment import World
from fowtlib.components.mechanics import Beam, FixedRotation, Revolute, SpeedSource
from fowtlib.components.mechanics.beam_properties import read_beam
from fowtlib.components.turbine.operating_point import SteadyTurbine
from fowtlib.modelfile import data_path

EFFICIENCY = 0.95756
RATED = 7.56  # rpm
# wind [m/s]: rotor speed [rpm], pitch [deg], force of the air along the shaft [kN], surge, heave [m], pitch [rad]
OPENFAST = {
    7.0: (4.5455, 0.0, 962.2, 11.34, -0.0517, 0.02139), 8.0: (5.2473, 0.0, 1265.0, 14.10, -0.0768, 0.03611),
    9.0: (5.9597, 0.0, 1610.0, 16.89, -0.1082, 0.05279), 13.0: (7.5554, 8.0145, 1495.0, 16.36, -0.0973, 0.04970),
    14.0: (7.5583, 9.797, 1350.0, 15.35, -0.0840, 0.04353), 15.0: (7.5650, 11.35, 1240.0, 14.59, -0.0752, 0.03897),
    16.0: (7.5650, 12.77, 1152.0, 13.98, -0.0669, 0.03548), 18.0: (7.5554, 15.31, 1018.0, 13.14, -0.0590, 0.03060),
    20.0: (7.5544, 17.60, 921.7, 12.66, -0.0495, 0.02754), 22.0: (7.5678, 19.71, 848.7, 12.44, -0.0448, 0.02568),
    24.0: (7.5640, 21.70, 791.9, 12.39, -0.0407, 0.02469),
}  # fmt: skip
# wind [m/s]: electrical power, without losses in the source, times EFFICIENCY below rated [kW]; thrust [kN]
TABULATED = {
    5.0: (1396.0, 556.1), 6.0: (2609.0, 803.0), 7.0: (4244.4, 1085.2), 8.0: (6388.6, 1406.1), 9.0: (9089.1, 1779.5),
    10.0: (12424.8, 2197.0), 12.0: (15000.0, 1721.5), 13.0: (15000.0, 1516.6), 14.0: (15000.0, 1373.6),
    15.0: (15000.0, 1265.4), 16.0: (15000.0, 1176.8), 18.0: (15000.0, 1042.3), 20.0: (15000.0, 941.4),
    22.0: (15000.0, 867.6), 24.0: (15000.0, 807.9), 25.0: (15000.0, 782.2),
}  # fmt: skip
# Hz: [D], [R]
FREQUENCIES = {"surge": (0.007, 0.00782), "sway": (0.007, 0.00780), "heave": (0.049, 0.06074), "roll": (0.036, 0.03829),
               "pitch": (0.036, 0.03823), "yaw": (0.011, 0.01239)}  # fmt: skip
TOWER = {"tower fore-aft 1": 0.5256}  # [B], rigid rotor and nacelle
RIGID_BLADES = {"turbine.assembly.blade_hinges": 0, "turbine.assembly.blade_torsion": False,
                "turbine.aerodynamics.airfoil_model": "steady"}  # fmt: skip


@lru_cache(maxsize=1)
def steady() -> SteadyTurbine:
    """Rotor and controller, rigid blades, with the tilt of the shaft."""
    turbine: SteadyTurbine = fw.load("volturnus_iea15_rigid").root.turbine.steady_turbine()
    return turbine


def tower_frequencies() -> dict[str, float]:
    """Bending of the tower on the platform, with rigid blades, at rest [Hz]."""
    plant = fw.load("volturnus_iea15", set={**cases.CALM, **RIGID_BLADES}).compile()
    modes = plant.linearize(plant.equilibrium(), outputs=[]).modes()
    found: dict[str, float] = {}
    for mode in modes:
        for axis, name in (("x", "fore-aft"), ("y", "side-side")):
            if mode.label.startswith("tower.beam") and mode.label.endswith(f"_{axis}") and mode.frequency_hz > 0.1:
                count = sum(key.startswith(f"tower {name}") for key in found)
                found[f"tower {name} {count + 1}"] = mode.frequency_hz
    return found


def blade_frequencies(rpm: float, hinges: int = 10, **changes: Any) -> list[tuple[str, float]]:
    """Bending and torsion of one blade on a shaft that turns at a given speed, without weight and air [Hz]."""
    model = fw.Assembly("turning blade")
    model.world, model.shaft, model.drive = World(gravity=0.0), Revolute(n=(0, 0, 1)), SpeedSource()
    model.speed = Constant(value=0.0)
    model.turn = FixedRotation(n=(0, 1, 0), angle=np.pi / 2, r=(3.97, 0, 0))
    table = read_beam(data_path("iea15/blade_structure.csv"))
    model.beam = Beam(**{"table": table, "hinges": hinges, "quadrature": "free_tip", "torsion": True, **changes})
    model.connect(model.world.frame, model.shaft.frame_a)
    model.connect(model.shaft.frame_b, model.turn.frame_a)
    model.connect(model.turn.frame_b, model.beam.frame_a)
    model.connect(model.drive.flange, model.shaft.flange)
    model.connect(model.speed.y, model.drive.w)
    plant = fw.load(model).compile()
    modes = plant.linearize(plant.initial_state(parameters={"speed.value": rpm * np.pi / 30})).modes()
    names = {"_x": "flap", "_y": "edge"}
    return [(names.get(mode.label[-2:], "torsion"), mode.frequency_hz) for mode in modes if mode.frequency_hz > 0.1]
