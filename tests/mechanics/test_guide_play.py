"""A guide with play: flight, impact, rest, energy, momentum, and what is left of it when the play goes to zero."""

from __future__ import annotations

import math

import numpy as np
import pytest

import fowtlib as fw
from fowtlib.components.blocks import Integrator
from fowtlib.components.mechanics import (
    FixedRotation,
    FixedTranslation,
    FreeMotion,
    Guide,
    LooseGuide,
    RigidBody,
    SlidingFriction,
    World,
)

G, MASS, FAR = 9.80665, 1000.0, 2.0
CONTACT = {"reference_force": 2e5, "reference_depth": 0.005}


def guided(joint, angle=0.0, gravity=G, centre=3.0, free=False):
    """A body on a guide along z of a carrier that leans by `angle`; its centre of mass lies `centre` along the axis."""
    model = fw.Assembly("guided")
    model.world, model.joint = World(gravity=gravity), joint
    model.lean = FixedRotation(n=(0, 1, 0), angle=angle)
    model.arm = FixedTranslation(r=(0, 0, centre))
    model.body = RigidBody(mass=MASS, inertia=np.diag([1e3, 1e3, 1e3]))
    root = model.world.frame
    if free:
        model.motion = FreeMotion()
        model.carrier = RigidBody(mass=2 * MASS, r_cm=(0.3, 0, 1.0), inertia=np.diag([3e3, 3e3, 3e3]))
        model.connect(root, model.motion.frame_a)
        root = model.motion.frame_b
        model.connect(root, model.carrier.frame_a)
    model.connect(root, model.lean.frame_a)
    model.connect(model.lean.frame_b, joint.frame_a)
    model.connect(joint.frame_b, model.arm.frame_a)
    model.connect(model.arm.frame_b, model.body.frame_a)
    if isinstance(joint, LooseGuide):
        model.lost = Integrator()
        model.connect(joint.lost_power, model.lost.u)
    return model


def run(model, t_end, step=0.01, start=None, **options):
    plant = fw.load(model).compile()
    state = plant.initial_state(start={f"joint.{name}": value for name, value in (start or {}).items()})
    return plant.simulate(t_end, step, start=state, **{"tolerance": 1e-10, **options})


def of(result, *names):
    found = [np.asarray(result[name]) for name in names]
    return found if len(found) > 1 else found[0]


def test_it_flies_from_wall_to_wall_and_comes_back_slower():
    """Both rings at once, the centre of mass between them: 2 x play at v, then at (1 - alpha v) v (Hunt, Crossley)."""
    v, play = 0.2, 0.03
    joint = LooseGuide(n=(0, 0, 1), ring_distance=FAR, play=play, restitution_loss=0.3, **CONTACT)
    result = run(guided(joint, gravity=0.0, centre=FAR / 2), 0.6, 0.001, {"aside[0]": -play, "aside_rate[0]": v})
    t, x, rate = result.time, of(result, "joint.aside")[:, 0], of(result, "joint.aside_rate")[:, 0]
    flying = t < 2 * play / v
    assert np.allclose(x[flying], v * t[flying] - play, atol=1e-6)
    back = -rate[(x < 0.02) & (t > 0.3)][0] / v
    assert back == pytest.approx(1 - 0.3 * v, abs=(0.3 * v) ** 2)
    assert np.abs(of(result, "joint.lean")).max() < 1e-9
    kinetic = MASS * (v**2 - rate[-1] ** 2) / 2
    assert of(result, "lost.y")[-1] == pytest.approx(kinetic, rel=1e-6)


@pytest.mark.parametrize("angle, centre", [(0.3, 3.0), (-0.2, 1.4)])
def test_it_rests_on_its_rings_as_a_lever_says(angle, centre):
    """Loads by moments about the first ring, of the body as it leans; places by Hertz and the play, by iteration."""
    play, beta = 0.02, 0.0
    joint = LooseGuide(n=(0, 0, 1), ring_distance=FAR, play=play, pad_damping=2e4, **CONTACT)
    model = guided(joint, angle, centre=centre)
    model.rubbing = SlidingFriction(viscous=1e6)
    model.connect(joint.axis, model.rubbing.axis)
    result = run(model, 4.0, 0.5)
    down, along = MASS * G * math.sin(angle), MASS * G * math.cos(angle)
    for _ in range(20):
        second = centre / FAR * (down + along * math.tan(beta))  # what leans on the ring, along x of the carrier
        loads = down - second, second
        depths = [0.005 * (abs(load) / 2e5) ** (2 / 3) for load in loads]
        places = [math.copysign(play + depth, load) for depth, load in zip(depths, loads, strict=True)]
        beta = math.asin((places[1] - places[0]) / FAR)
    across = np.array([math.cos(angle), 0, -math.sin(angle)])
    for path, load, depth in zip(("first", "second"), loads, depths, strict=True):
        assert np.allclose(of(result, f"joint.{path}_ring")[-1], -load * across, rtol=1e-5, atol=0.01), path
        assert of(result, f"joint.{path}_gap")[-1] == pytest.approx(-depth, rel=1e-5)
    assert of(result, "joint.aside")[-1, 0] == pytest.approx(places[0], rel=1e-5)
    assert of(result, "joint.lean")[-1, 1] == pytest.approx(beta, rel=1e-5)


def test_energy_of_a_body_that_knocks_about_is_accounted_for():
    """Kinetic and potential energy, that in rings and pads, and what they took: constant to 1e-6 of what moves."""
    joint = LooseGuide(n=(0, 0, 1), ring_distance=FAR, play=0.02, pad_stiffness=3e3, pad_damping=50.0, **CONTACT)
    model = guided(joint, 0.3)
    start = {"aside_rate[0]": 0.4, "aside_rate[1]": -0.3, "lean_rate[0]": 0.2, "lean_rate[1]": 0.3}
    result = run(model, 1.5, 0.001, start)
    r, v, w = of(result, "body.frame_a.r", "body.v", "body.frame_a.w")
    kinetic = (MASS * v**2 + 1e3 * w**2).sum(axis=1) / 2
    potential = MASS * G * r[:, 2]
    total = kinetic + potential + of(result, "joint.energy") + of(result, "lost.y")
    assert np.abs(total - total[0]).max() < 1e-6 * (kinetic.max() + np.ptp(potential))
    assert of(result, "lost.y")[-1] > 10 and of(result, "joint.second_gap").min() < 0


def test_momentum_of_carrier_and_slide_that_float():
    """Both free: their centre of mass goes on as it did, and the moment of momentum stays, while they knock."""
    joint = LooseGuide(n=(0, 0, 1), ring_distance=FAR, play=0.02, **CONTACT)
    model = guided(joint, 0.1, gravity=0.0, free=True)
    result = run(model, 2.0, 0.002, {"aside_rate[0]": 0.3, "lean_rate[0]": 0.1, "v": 0.2})
    loads = of(result, "carrier.frame_a.f"), of(result, "body.frame_a.f")
    assert np.abs(loads[0] + loads[1]).max() < 1e-6 * np.abs(loads[0]).max()
    a, b = of(result, "carrier.frame_a.r"), of(result, "body.frame_a.r")
    turning = of(result, "carrier.frame_a.t"), of(result, "body.frame_a.t")
    moments = turning[0] + np.cross(a, loads[0]), turning[1] + np.cross(b, loads[1])
    assert np.abs(moments[0]).max() > 1e3
    assert np.abs(moments[0] + moments[1]).max() < 1e-6 * np.abs(moments[0]).max()


def test_without_play_and_stiff_it_is_the_guide_that_fits():
    """It slides under its weight with friction of its rings: the place to 1e-3 of the way, the loads to 1 %."""
    found = []
    for joint in (Guide(n=(0, 0, 1), ring_distance=FAR),
                  LooseGuide(n=(0, 0, 1), ring_distance=FAR, play=0.0, pad_damping=5e4, reference_force=1e8,
                             reference_depth=0.005)):  # fmt: skip
        model = guided(joint, 0.3)
        model.rubbing = SlidingFriction(coefficient=0.1, smooth_speed=1e-4)
        model.connect(joint.axis, model.rubbing.axis)
        model.connect(joint.load, model.rubbing.load)
        result = run(model, 1.0, 0.1)
        found.append((of(result, "joint.s")[-1], of(result, "joint.load")[-1]))
    assert found[1][0] == pytest.approx(found[0][0], rel=1e-3)
    assert found[1][1] == pytest.approx(found[0][1], rel=1e-2)
