"""A body whose water changes obeys momentum and angular momentum, and the frame of a tank does not matter."""

from __future__ import annotations

import math

import numpy as np
import pytest

import fowtlib as fw
from fowtlib.components.blocks import Constant
from fowtlib.components.environment import World
from fowtlib.components.flooding import BoxTank, Pump, RoundTank
from fowtlib.components.mechanics import (
    Fixed,
    FixedRotation,
    FixedTranslation,
    Prismatic,
    Revolute,
    RigidBody,
    WorldForce,
)
from tests.flooding.floating import floating_box

RHO = 1025.0
UNIT = ((1.0, 0, 0), (0, 1.0, 0), (0, 0, 1.0))


@pytest.mark.parametrize("solver", ["idas", "fixed"])
def test_a_tank_that_is_filled_while_its_body_moves(solver):
    """What comes in has the velocity of its port: (M + rho V) dv/dt = F, v = v_0 + F / (rho Q) ln(m / m_0)."""
    F, Q, M, start = 4e3, 0.2, 1e4, 5.0
    model = fw.Assembly("barge under way")
    model.world = World()
    model.slide = Prismatic(n=(1, 0, 0), v_start=3.0)
    model.body = RigidBody(mass=M, inertia=UNIT)
    model.shore = RoundTank(diameter=10, height=5, volume_start=60)
    model.tank = BoxTank(length=3, width=2, height=4, volume_start=start, place=(0.4, 0.2, 1))
    model.pump = Pump(mode="flow", rated_flow=Q)
    model.tug = Constant(value=(F, 0, 0))
    model.pull = WorldForce()
    model.connect(model.world.frame, model.slide.frame_a)
    model.connect(model.world.frame, model.shore.frame)
    for frame in (model.body.frame_a, model.tank.frame, model.pull.frame):
        model.connect(model.slide.frame_b, frame)
    model.connect(model.tug.y, model.pull.force)
    model.connect(model.shore.water[0], model.pump.water_a)
    model.connect(model.pump.water_b, model.tank.water[0])
    more = {"step": 0.02} if solver == "fixed" else {"tolerance": 1e-9}
    result = fw.load(model).compile().simulate(40, 0.5, solver=solver, **more)
    m0 = M + RHO * start
    expected = 3.0 + F / (RHO * Q) * np.log((m0 + RHO * Q * result.time) / m0)
    assert np.max(np.abs(result["slide.v"].values - expected)) < 1e-7
    assert expected[-1] > 10


def turntable() -> fw.Assembly:
    """A table that turns about z with a tank on its axis and one at 4 m, their ports beside each other at 1.5 m."""
    model = fw.Assembly("turntable")
    model.world = World()
    model.hinge = Revolute(n=(0, 0, 1), w_start=0.5)
    model.body = RigidBody(mass=100, inertia=((1e3, 0, 0), (0, 1e3, 0), (0, 0, 2e3)))
    model.inner = RoundTank(diameter=3, height=4, volume_start=20, places=((1.5, 0, 0),))
    model.outer = BoxTank(length=3, width=2, height=4, volume_start=4, place=(4, 0, 0), places=((-2.5, 0, 0),))
    model.pump = Pump(mode="flow", rated_flow=0.1)
    model.connect(model.world.frame, model.hinge.frame_a)
    for frame in (model.body.frame_a, model.inner.frame, model.outer.frame):
        model.connect(model.hinge.frame_b, frame)
    model.connect(model.inner.water[0], model.pump.water_a)
    model.connect(model.pump.water_b, model.outer.water[0])
    return model


def test_water_that_is_pumped_outwards_slows_a_turntable():
    """No moment about its axis: I(t) omega is constant, the water being a rigid body in each tank."""
    result = fw.load(turntable()).compile().simulate(100, 1, tolerance=1e-9)
    inner, outer = (RHO * result[f"{name}.volume"].values for name in ("inner", "outer"))
    inertia = 2e3 + inner * 9 / 8 + outer * (16 + (9 + 4) / 12)
    assert inertia[-1] > 2 * inertia[0]
    momentum = inertia * result["hinge.w"].values
    assert np.max(np.abs(momentum / momentum[0] - 1)) < 1e-7


def test_loads_of_water_that_flows_in_a_turning_tank():
    """Centrifugal, F_r = -m w^2 r, and Coriolis, F_t = m r w' + 2 w rho Q (r - p); M_z = d(I w)/dt - rho Q w p^2."""
    plant = fw.load(turntable()).compile()
    result = plant.simulate(10, 1, tolerance=1e-9, outputs=["outer.frame.f", "outer.frame.t", "hinge.phi", "hinge.w",
                                                           "hinge.a", "outer.mass"])  # fmt: skip
    phi, w, rate = (result[f"hinge.{name}"].values for name in ("phi", "w", "a"))
    f, t, mass = (result[f"outer.{name}"].values for name in ("frame.f", "frame.t", "mass"))
    radial = f[:, 0] * np.cos(phi) + f[:, 1] * np.sin(phi)
    tangential = -f[:, 0] * np.sin(phi) + f[:, 1] * np.cos(phi)
    flow = RHO * 0.1
    assert radial == pytest.approx(-mass * w**2 * 4, rel=1e-9)
    assert tangential == pytest.approx(mass * rate * 4 + 2 * w * flow * (4 - 1.5), rel=1e-7)
    about = 16 + (9 + 4) / 12
    assert t[:, 2] == pytest.approx(mass * about * rate + flow * w * (about - 1.5**2), rel=1e-7)


def test_the_frame_of_a_tank_does_not_matter():
    """Tanks by place and width, or on frames that are shifted and turned: the same motion while water is pumped."""

    def moved(model: fw.Assembly) -> fw.Result:
        model.pump = Pump(mode="flow", rated_flow=0.3)
        model.connect(model.box.water[0], model.pump.water_a)
        model.connect(model.pump.water_b, model.round.water[0])
        start = {"motion.angle_rates_start": (0.05, 0.02, 0.1), "motion.velocity_start": (0.5, 1.0, -0.2)}
        names = [f"motion.{name}" for name in ("surge", "sway", "heave", "roll", "pitch", "yaw")]
        return fw.load(model).compile().simulate(20, 0.5, tolerance=1e-10, parameters=start, outputs=names)

    here = moved(
        floating_box(
            (
                "box",
                BoxTank(
                    length=8,
                    width=5,
                    height=4,
                    volume_start=80,
                    place=(6, 1, -3),
                    places=((0, 2.5, 1),),
                    walls_wet=True,
                ),
            ),
            ("round", RoundTank(diameter=6, height=4, volume_start=40, place=(-6, -1, -3), places=((3, 0, 0.5),))),
            water=120,
        )
    )
    model = floating_box(water=120)
    model.box = BoxTank(
        length=5, width=8, height=4, volume_start=80, place=(0, 0, 0), places=((2.5, 0, 1),), walls_wet=True
    )
    model.round = RoundTank(
        diameter=6, height=4, volume_start=40, place=(1, 2, 0), places=((3 * math.cos(0.6), -3 * math.sin(0.6), 0.5),)
    )
    model.turn = FixedRotation(n=(0, 0, 1), angle=math.pi / 2, r=(6, 1, -3))
    c, s = math.cos(0.6), math.sin(0.6)
    model.shift = FixedTranslation(r=(-6 - (c * 1 - s * 2), -1 - (s * 1 + c * 2), -3))
    model.turn_2 = FixedRotation(n=(0, 0, 1), angle=0.6)
    for a, b in ((model.motion.frame_b, model.turn.frame_a), (model.turn.frame_b, model.box.frame),
                 (model.motion.frame_b, model.shift.frame_a), (model.shift.frame_b, model.turn_2.frame_a),
                 (model.turn_2.frame_b, model.round.frame)):  # fmt: skip
        model.connect(a, b)
    there = moved(model)
    for name in ("surge", "sway", "heave", "roll", "pitch", "yaw"):
        a, b = (result[f"motion.{name}"].values for result in (here, there))
        assert np.max(np.abs(a - b)) < 1e-6 * np.max(np.abs(a)), name
    assert np.max(np.abs(here["motion.roll"].values)) > 0.02


def test_a_filled_tank_at_rest_weighs_what_it_holds():
    model = fw.Assembly("tank on the ground")
    model.world = World(gravity=9.81)
    model.ground = Fixed(r=(1, 2, 3), angles=(0.1, 0.2, 0.3))
    model.tank = BoxTank(length=3, width=2, height=4, volume_start=12, place=(0.5, -0.5, 1))
    model.connect(model.ground.frame, model.tank.frame)
    state = fw.load(model).compile().initial_state()
    assert np.ravel(state["tank.frame.f"]) == pytest.approx([0, 0, RHO * 12 * 9.81], rel=1e-9, abs=1e-6)
