"""Response amplitude operators take the added mass and damping of the data, not those of the states that realise them.

The reference is a 6 x 6 computation in numpy with the matrices of the database, which knows no state space.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import fowtlib as fw
from fowtlib.analysis.rao import linear_rao
from fowtlib.components.environment import Sea, World
from fowtlib.components.hydro import (
    AddedMass,
    HydrodynamicDatabase,
    Hydrostatics,
    Radiation,
    WaveExcitation,
    waterplane_stiffness,
)
from fowtlib.components.hydro.linear_loads import RadiationTransfer
from fowtlib.components.mechanics import FreeMotion, RigidBody
from fowtlib.language import StateSpace

OC3 = str(Path(__file__).parents[2] / "models" / "data" / "oc3_hywind" / "hydrodynamics.nc")
DATA = HydrodynamicDatabase.read(OC3)
G, RHO, DEPTH_OF_MASS = DATA.g, DATA.rho, 78.0
MASS, INERTIA = RHO * DATA.volume, np.diag([1.2e10, 1.2e10, 1.9e8])
MOTIONS = ("surge", "sway", "heave", "roll", "pitch", "yaw")


def spar(order):
    """A free spar in waves, its weight that of the water it displaces."""
    model = fw.Assembly("spar in water")
    model.world, model.sea = World(gravity=G, water_density=RHO), Sea()
    model.motion, model.body = FreeMotion(), RigidBody(mass=MASS, inertia=INERTIA, r_cm=(0, 0, -DEPTH_OF_MASS))
    model.connect(model.world.frame, model.motion.frame_a)
    loads = {
        "statics": Hydrostatics(
            volume=DATA.volume, centre_of_buoyancy=DATA.centre_of_buoyancy, stiffness=waterplane_stiffness(DATA)
        ),
        "mass": AddedMass(matrix=DATA.A_inf),
        "radiation": Radiation(database=OC3, order=order),
        "waves": WaveExcitation(database=OC3),
    }
    for name, load in loads.items():
        model.add(name, load)
    for part in (model.body.frame_a, *(load.frame for load in loads.values())):
        model.connect(model.motion.frame_b, part)
    return fw.load(model)


def reference(i, heading):
    """Motions (6,) per wave amplitude at the i-th frequency of the data: (-w^2 (M + A) + i w B + C) q = X."""
    z, w = -DEPTH_OF_MASS, DATA.omega[i]
    skew = np.array([[0, -z, 0], [z, 0, 0], [0, 0, 0]])
    mass = np.block([[MASS * np.eye(3), -MASS * skew], [MASS * skew, INERTIA - MASS * skew @ skew]])
    stiffness = waterplane_stiffness(DATA)
    arm = RHO * G * DATA.volume * DATA.centre_of_buoyancy[2] - MASS * G * z
    stiffness[3, 3], stiffness[4, 4] = stiffness[3, 3] + arm, stiffness[4, 4] + arm
    system = -(w**2) * (mass + DATA.A[i]) + 1j * w * DATA.B[i] + stiffness
    return np.linalg.solve(system, DATA.excitation_at([w], heading)[0])


@pytest.mark.parametrize("order", [2, 4])
@pytest.mark.parametrize("heading", [0.0, np.radians(40.0)])
def test_the_response_is_that_of_the_data(order, heading):
    """At the frequencies of the data, to the last digits, also where two states per motion are a poor memory."""
    numbers = [i for i, w in enumerate(DATA.omega) if 0.15 < w < 2.5][::4]
    plant = spar(order).compile()
    paths = [f"motion.{name}" for name in MOTIONS]
    frequency = DATA.omega[numbers] / (2 * np.pi)
    rao = linear_rao(plant, frequency, outputs=paths, heading=heading, state=plant.initial_state())
    expected = np.array([reference(i, heading) for i in numbers])
    assert rao.response == pytest.approx(expected, rel=2e-6, abs=1e-9 * np.abs(expected).max())


def test_the_realization_differs():
    """What two states per motion make of the same response: the test above would not pass with it."""
    plant = spar(2).compile()
    state = plant.initial_state()
    linear = plant.linearize(state, ["waves.extra_force"], ["motion.heave", "motion.surge"])
    i = int(np.argmin(np.abs(DATA.omega - 0.8)))
    exact, realized = (
        linear.frequency_response(DATA.omega[i : i + 1], realized=flag)[0, [0, 1], [2, 0]] for flag in (False, True)
    )
    assert 1e-4 < np.max(np.abs(realized / exact - 1)) < 0.2


def test_between_and_outside_of_the_data():
    part = spar(4).root.radiation
    model = part.model()
    realization = StateSpace(model.A, model.B, model.C)
    transfer = RadiationTransfer(DATA, realization)
    at = transfer(DATA.omega)
    assert at.real == pytest.approx(DATA.B, rel=1e-12)
    assert at.imag == pytest.approx(DATA.omega[:, None, None] * (DATA.A - DATA.A_inf), rel=1e-9, abs=1e-3)
    middle = (DATA.omega[10:12].sum() / 2).reshape(1)
    lowest, highest = np.sort(DATA.B[10:12, 0, 0])
    assert lowest <= transfer(middle)[0, 0, 0].real <= highest
    outside = np.array([0.5 * DATA.omega[0], 2 * DATA.omega[-1]])
    assert np.array_equal(transfer(outside), realization.transfer(outside))
