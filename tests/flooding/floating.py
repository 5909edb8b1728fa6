"""A floating box with tanks, for several tests: a box of 30 m x 12 m at a draft of 3 m."""

from __future__ import annotations

import numpy as np

import fowtlib as fw
from fowtlib.components.environment import World
from fowtlib.components.hydro.linear_loads import Hydrostatics
from fowtlib.components.mechanics import FreeMotion, RigidBody

GRAVITY, RHO = 9.80665, 1025.0
LENGTH, WIDTH, DRAFT, KG = 30.0, 12.0, 3.0, -1.0  # KG: height of the mass centre over the still water level
VOLUME = LENGTH * WIDTH * DRAFT


def floating_box(*tanks: tuple[str, object], water: float = 0.0, lift: float = 0.0) -> fw.Assembly:
    """The box afloat; water: m^3 of sea water in its tanks, which its own mass makes room for."""
    model = fw.Assembly("floating box")
    model.world = World(gravity=GRAVITY, water_density=RHO)
    model.motion = FreeMotion()
    mass = RHO * (VOLUME - water)
    inertia = mass / 12 * np.array([WIDTH**2 + 16, LENGTH**2 + 16, LENGTH**2 + WIDTH**2])
    model.body = RigidBody(mass=mass, inertia=np.diag(inertia).tolist(), r_cm=(0, 0, KG))
    C = np.zeros((6, 6))
    C[2, 2] = RHO * GRAVITY * LENGTH * WIDTH
    C[3, 3], C[4, 4] = (RHO * GRAVITY * a * b**3 / 12 for a, b in ((LENGTH, WIDTH), (WIDTH, LENGTH)))
    model.buoyancy = Hydrostatics(volume=VOLUME, centre_of_buoyancy=(0, 0, -DRAFT / 2), stiffness=C.tolist())
    model.connect(model.world.frame, model.motion.frame_a)
    model.connect(model.motion.frame_b, model.body.frame_a)
    model.connect(model.motion.frame_b, model.buoyancy.frame)
    for name, tank in tanks:
        model.add(name, tank)
        model.connect(model.motion.frame_b, tank.frame)
    return model
