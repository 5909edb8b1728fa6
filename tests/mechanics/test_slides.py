"""What stops, holds and rubs a slide: impact, latch, friction, loads of a guide, each against a formula."""

from __future__ import annotations

import math

import numpy as np
import pytest

import fowtlib as fw
from fowtlib.components.blocks import Integrator
from fowtlib.components.mechanics import (
    EndStop,
    FixedRotation,
    FixedTranslation,
    Guide,
    Latch,
    Prismatic,
    RigidBody,
    SlidingFriction,
    World,
)

G = 9.80665
MASS = 1000.0


def slide(gravity=G, joint=None, **start):
    model = fw.Assembly("slide")
    model.world = World(gravity=gravity)
    model.joint = joint or Prismatic(n=(0, 0, 1), **start)
    model.body = RigidBody(mass=MASS, inertia=np.diag([1e3, 1e3, 1e3]))
    model.connect(model.world.frame, model.joint.frame_a)
    model.connect(model.joint.frame_b, model.body.frame_a)
    return model


def on_axis(model, name, part):
    """A part on the axis of the slide, with the integral of the power that it takes out."""
    model.add(name, part)
    model.connect(model.joint.axis, part.axis)
    meter = model.add(f"{name}_loss", Integrator())
    model.connect(part.lost_power, meter.u)


def run(model, t_end, step=0.01, **options):
    return fw.load(model).compile().simulate(t_end, step, **{"tolerance": 1e-10, **options})


# --- end stops ----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("side, speed", [("below", -0.5), ("above", 0.5), ("below", -0.1)])
def test_a_body_comes_back_from_a_stop_slower_by_its_loss(side, speed):
    """Restitution is 1 - alpha v (Hunt and Crossley 1975, eq. 20); the next term is of order (alpha v)^2."""
    model = slide(0.0, s_start=-0.2 * np.sign(speed), v_start=speed)
    on_axis(model, "stop", EndStop(side=side, reference_force=MASS * G, restitution_loss=0.2))
    result = run(model, 0.2 / abs(speed) + 0.5, 0.002)
    back = -np.asarray(result["joint.v"])[-1] / speed
    assert back == pytest.approx(1 - 0.2 * abs(speed), abs=(0.2 * speed) ** 2)
    assert np.asarray(result["stop.impacts"])[-1] == 1
    assert np.asarray(result["stop.impact_speed"])[-1] == pytest.approx(abs(speed), rel=1e-6)
    assert np.min(result["stop.force"]) == 0


def test_the_energy_of_a_body_that_bounces_is_accounted_for():
    """Kinetic, potential and elastic energy, and what stop and friction took, add up to what it had; to 1e-6 of it."""
    model = slide(s_start=0.3)
    on_axis(model, "stop", EndStop(reference_force=MASS * G, restitution_loss=0.2))
    on_axis(model, "rubbing", SlidingFriction(coefficient=0.1, preload=500.0, viscous=20.0))
    result = run(model, 3.0)
    s, v, elastic, *lost = (
        np.asarray(result[path]) for path in ("joint.s", "joint.v", "stop.energy", "stop_loss.y", "rubbing_loss.y")
    )
    total = MASS * v**2 / 2 + MASS * G * s + elastic + sum(lost)
    assert np.abs(total / (MASS * G * 0.3) - 1).max() < 1e-6
    assert np.asarray(result["stop.impacts"])[-1] > 3 and lost[0][-1] > 0.1 * MASS * G * 0.3


def test_a_body_rests_on_a_stop_as_deep_as_its_weight_asks():
    """F = F_ref (d/d_ref)^1.5: a weight of half the reference force lies 0.5^(2/3) of the reference depth deep."""
    model = slide(s_start=0.0)
    on_axis(model, "stop", EndStop(reference_force=2 * MASS * G, restitution_loss=1.0))
    on_axis(model, "rubbing", SlidingFriction(viscous=2e4))
    depth = np.asarray(run(model, 10.0, 0.1)["stop.depth"])[-1]
    assert depth == pytest.approx(0.01 * 0.5 ** (2 / 3), rel=1e-5)


# --- latch --------------------------------------------------------------------------------------------------------


def held(**latch):
    model = slide(0.0, s_start=0.0, v_start=0.1)
    on_axis(model, "latch", Latch(place=0.5, stiffness=1e7, damping=2e4, **latch))
    return model


def test_a_latch_catches_the_slide_when_it_comes_and_lets_it_go():
    events = ["latch.close at 1 s", "latch.open at 7 s"]
    result = run(held(), 8.0, events=events)
    t, s = result.time, np.asarray(result["joint.s"])
    assert np.allclose(s[t < 4.4], 0.1 * t[t < 4.4], atol=1e-8)
    caught = np.asarray(result["latch.held"])[-1]
    assert caught == pytest.approx(0.45, abs=1e-6)
    assert np.abs(s[(t > 6.0) & (t < 7.0)] - caught).max() < 1e-6
    assert np.asarray(result["latch.closed"])[(t > 4.6) & (t < 6.9)].min() == 1
    assert np.asarray(result["latch.closed"])[-1] == 0
    assert np.asarray(result["latch_loss.y"])[-1] == pytest.approx(MASS * 0.1**2 / 2, rel=1e-6)


def test_a_latch_that_closes_in_the_wrong_place_holds_nothing():
    result = run(held(reach=0.01), 3.0, events=["latch.close at 1 s"])
    assert np.asarray(result["latch.closed"])[-1] == 0
    assert np.asarray(result["joint.s"])[-1] == pytest.approx(0.3, rel=1e-9)


def test_a_latch_that_is_closed_at_the_start_carries_the_weight():
    model = slide(s_start=2.0)
    on_axis(model, "latch", Latch(place=2.0, stiffness=1e6, damping=3e4, closed_start=1))
    result = run(model, 5.0, 0.1)
    assert np.asarray(result["latch.force"])[-1] == pytest.approx(MASS * G, rel=1e-6)
    assert np.asarray(result["joint.s"])[-1] == pytest.approx(2 - MASS * G / 1e6, rel=1e-9)


# --- friction and guide -------------------------------------------------------------------------------------------


def test_dry_friction_slows_a_slide_at_a_constant_rate():
    """Its speed is v_0 - mu N/m t while it slides; the smoothed part begins at millimetres per second."""
    model = slide(0.0, v_start=1.0)
    on_axis(model, "rubbing", SlidingFriction(coefficient=0.2, preload=MASS * G))
    result = run(model, 1.0)
    t, v = result.time, np.asarray(result["joint.v"])
    moving = v > 0.02
    assert np.allclose(v[moving], 1 - 0.2 * G * t[moving], atol=1e-7)
    assert abs(v[-1]) < 1e-6


def leaning(angle):
    """A slide that leans by `angle`; the centre of mass lies 3 m along its axis, the rings at 0 and 2 m."""
    model = fw.Assembly("leaning")
    model.world = World(gravity=G)
    model.lean = FixedRotation(n=(0, 1, 0), angle=angle)
    model.joint = Guide(n=(0, 0, 1), ring_distance=2.0)
    model.arm = FixedTranslation(r=(0, 0, 3.0))
    model.body = RigidBody(mass=MASS, inertia=np.diag([1e3, 1e3, 1e3]))
    model.connect(model.world.frame, model.lean.frame_a)
    model.connect(model.lean.frame_b, model.joint.frame_a)
    model.connect(model.joint.frame_b, model.arm.frame_a)
    model.connect(model.arm.frame_b, model.body.frame_a)
    return model


def test_rings_carry_a_leaning_body_as_a_lever_says():
    """Weight across the axis W sin(angle) at 3 m: 1.5 of it on the ring at 2 m, -0.5 on that at 0."""
    angle = 0.3
    result = run(leaning(angle), 0.1)
    across = np.array([math.cos(angle), 0, -math.sin(angle)])
    weight = MASS * G * math.sin(angle)
    for path, share in (("joint.second_ring", -1.5), ("joint.first_ring", 0.5)):
        assert np.allclose(np.asarray(result[path])[-1], share * weight * across, rtol=1e-9, atol=1e-6)
    assert np.asarray(result["joint.load"])[-1] == pytest.approx(2 * weight, rel=1e-6)


def test_friction_of_a_guide_grows_with_what_leans_on_it():
    """It falls by g cos - mu 2 g sin, for the two rings together carry twice the weight across the axis."""
    model = leaning(0.3)
    model.rubbing = SlidingFriction(coefficient=0.1, smooth_speed=1e-4)
    model.connect(model.joint.axis, model.rubbing.axis)
    model.connect(model.joint.load, model.rubbing.load)
    result = run(model, 1.0)
    expected = -(math.cos(0.3) - 0.1 * 2 * math.sin(0.3)) * G
    assert np.asarray(result["joint.a"])[-1] == pytest.approx(expected, rel=1e-6)


def test_the_fixed_step_engine_bounces_as_idas_does():
    model = slide(s_start=0.02)
    on_axis(model, "stop", EndStop(reference_force=MASS * G, restitution_loss=0.5))
    plant = fw.load(model).compile()
    options = {"t_end": 0.6, "output_step": 0.01}
    exact = np.asarray(plant.simulate(**options, tolerance=1e-10)["joint.s"])
    fixed = np.asarray(plant.simulate(**options, solver="fixed", step=1e-4)["joint.s"])
    assert np.abs(fixed - exact).max() < 2e-5
