"""A compartment that floods through a hole to a new equilibrium: volumes, lost buoyancy, energy."""

from __future__ import annotations

import math

import numpy as np
import pytest

import fowtlib as fw
from fowtlib.analysis.afloat import Afloat
from fowtlib.analysis.afloat_models import afloat
from fowtlib.analysis.tank_water import inside_of
from fowtlib.components.environment import World
from fowtlib.components.flooding import BoxTank, RoundTank, SeaOpening
from fowtlib.components.hydro.linear_loads import LinearDamping
from fowtlib.components.mechanics import FreeMotion, Prismatic, RigidBody
from fowtlib.components.platform import CircularMember, Floater, MemberHydrostatics, RectangularMember

RHO, G = 1025.0, 9.80665
LENGTH, WIDTH, HEIGHT, DRAFT = 60.0, 14.0, 9.0, 4.0


def barge(room=10.0, hole=0.5):
    """A box with an empty compartment over its whole section at one end, x from 30 - room to 30 m, and a hole in it."""
    model = fw.Assembly("barge")
    model.world = World(gravity=G, water_density=RHO, water_depth=100.0)
    model.motion, model.floater = FreeMotion(), Floater()
    low = HEIGHT / 2 - DRAFT
    model.floater.box = RectangularMember(
        start=(-LENGTH / 2, 0, low), end=(LENGTH / 2, 0, low), widths=WIDTH, heights=HEIGHT, wall_thickness=0.0,
        density=0.0,
    )  # fmt: skip
    model.floater.hydrostatics = MemberHydrostatics()
    mass = RHO * LENGTH * WIDTH * DRAFT
    inertia = mass / 12 * np.array([WIDTH**2 + HEIGHT**2, LENGTH**2 + HEIGHT**2, LENGTH**2 + WIDTH**2])
    model.body = RigidBody(mass=mass, r_cm=(0, 0, 0.5), inertia=np.diag(inertia).tolist())
    model.room = BoxTank(place=(LENGTH / 2 - room / 2, 0, -DRAFT), length=room, width=WIDTH, height=HEIGHT,
                         volume_start=0.0)  # fmt: skip
    model.hole = SeaOpening(place=(LENGTH / 2, 0, -DRAFT + 1.0), area=hole)
    model.damping = LinearDamping(translation=(1e5, 1e5, 4e6), rotation=(1e8, 2e9, 1e8))
    model.connect(model.world.frame, model.motion.frame_a)
    for frame in (model.floater.frame, model.body.frame_a, model.room.frame, model.hole.frame, model.damping.frame):
        model.connect(model.motion.frame_b, frame)
    model.connect(model.hole.water, model.room.water[0])
    return model


PATHS = (
    "motion.pitch", "motion.roll", "motion.heave", "motion.velocity", "motion.angle_rates", "room.volume",
    "room.surface", "room.mass", "room.centre", "hole.volume_flow", "floater.hydrostatics.volume",
    "floater.hydrostatics.energy", "body.frame_a.R", "body.frame_a.r",
)  # fmt: skip


@pytest.fixture(scope="module")
def flooded():
    """The model, and its run until nothing moves."""
    model = fw.load(barge())
    result = model.compile().simulate(1500.0, 0.5, outputs=PATHS)
    return model, {path: np.asarray(result[path], dtype=float) for path in PATHS}, np.asarray(result.time)


def test_a_damaged_compartment_comes_to_where_lost_buoyancy_says(flooded):
    """Sinkage and trim: the compartment flooded in the run, against one that displaces nothing."""
    model, found, _ = flooded
    hull = afloat(model)
    damaged = Afloat(hull.surface, hull.mass, hull.centre, RHO, G).with_flooded(inside_of(model.root.room)).at_rest()
    assert found["motion.pitch"][-1] == pytest.approx(math.atan2(-damaged.normal[0], damaged.normal[2]), rel=1e-5)
    assert damaged.heel > math.radians(1) and found["motion.roll"][-1] == pytest.approx(0, abs=1e-6)
    assert found["motion.heave"][-1] == pytest.approx(damaged.height, abs=1e-5)
    assert found["room.surface"][-1] == pytest.approx(0, abs=1e-3)  # inside as outside


def test_what_came_in_is_in_it_and_is_displaced(flooded):
    """The volume of the tank is the integral of the flow; at rest the hull displaces its own mass and the water."""
    _, found, time = flooded
    flow = found["hole.volume_flow"]
    came = np.concatenate([[0], np.cumsum((flow[1:] + flow[:-1]) / 2 * np.diff(time))])
    assert found["room.volume"] == pytest.approx(came, rel=1e-4, abs=0.1)
    dry = LENGTH * WIDTH * DRAFT
    assert found["floater.hydrostatics.volume"][-1] == pytest.approx(dry + found["room.volume"][-1], rel=1e-6)
    assert found["room.volume"][-1] > 10 * WIDTH * DRAFT  # more than at the first draft


def test_energy_goes_into_the_hole_and_the_damping(flooded):
    """Weight of hull and water inside, and buoyancy: what they lose is what the flow loses, with what motion loses.

    Water that comes in brings rho g Q times the head inside; between the heads it is lost in the hole.
    """
    _, found, time = flooded
    mass = RHO * LENGTH * WIDTH * DRAFT
    up = found["body.frame_a.R"][:, 2, :]
    heights = found["body.frame_a.r"][:, 2, None]
    potential = mass * G * (heights[:, 0] + 0.5 * up[:, 2]) + found["floater.hydrostatics.energy"]
    potential += found["room.mass"] * G * (heights[:, 0] + np.einsum("ni,ni->n", up, found["room.centre"]))
    rates, speed = found["motion.angle_rates"], found["motion.velocity"]
    damped = speed**2 @ [1e5, 1e5, 4e6] + rates**2 @ [1e8, 2e9, 1e8]
    brought = RHO * G * found["hole.volume_flow"] * found["room.surface"]
    power = brought - damped
    work = np.concatenate([[0], np.cumsum((power[1:] + power[:-1]) / 2 * np.diff(time))])
    lost = potential[0] - potential[-1]
    assert lost > 1e6
    assert potential - potential[0] == pytest.approx(work, abs=1e-4 * lost)


def test_a_column_that_takes_in_ballast_sinks_to_its_new_draft():
    """A valve to the sea is open for a minute: 15 m of draft become (m + rho V) / (rho A), and stay."""
    model = fw.Assembly("column")
    model.world = World(gravity=G, water_density=RHO, water_depth=100.0)
    model.motion, model.floater = Prismatic(n=(0, 0, 1)), Floater()
    model.floater.column = CircularMember(start=(0, 0, -15), end=(0, 0, 25), diameters=10.0, wall_thickness=0.0)
    model.floater.hydrostatics = MemberHydrostatics()
    area = math.pi * 25
    model.body = RigidBody(mass=RHO * area * 15, r_cm=(0, 0, -10), inertia=np.diag([1e8, 1e8, 1e7]).tolist())
    model.tank = RoundTank(place=(0, 0, -15), diameter=9.0, height=30.0, volume_start=10.0)
    model.valve = SeaOpening(place=(0, 0, -15), area=0.3)
    model.damping = LinearDamping(translation=(0, 0, 4e5))
    model.connect(model.world.frame, model.motion.frame_a)
    for frame in (model.floater.frame, model.body.frame_a, model.tank.frame, model.valve.frame, model.damping.frame):
        model.connect(model.motion.frame_b, frame)
    model.connect(model.valve.water, model.tank.water[0])
    events = [fw.Event("valve.shut", at=60.0)]
    paths = ("tank.volume", "floater.hydrostatics.draft", "valve.volume_flow")
    result = fw.load(model).compile().simulate(300.0, 1.0, events=events, outputs=paths)
    water, draft, flow = (np.asarray(result[path], dtype=float) for path in paths)
    assert flow[30] > 1 and np.abs(flow[70:]).max() < 1e-9 and np.ptp(water[70:]) < 1e-6
    assert water[-1] > 100
    assert 15 + draft[-1] == pytest.approx((15 * area + water[-1]) / area, abs=1e-3)
    assert 15 + draft[45] == pytest.approx((15 * area + water[45]) / area, abs=0.05)  # it follows on the way
