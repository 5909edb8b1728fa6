"""A model cut in two at a point: force and position against what follows by hand."""

from __future__ import annotations

import numpy as np
import pytest

import fowtlib as fw
from fowtlib.components.blocks import Constant, Mux, Sine
from fowtlib.components.mechanics import (
    FixedTranslation,
    ForceToPositionAdaptor,
    FreeMotion,
    PointMass,
    PositionToForceAdaptor,
    RigidBody,
    SpringDamper,
    World,
)
from fowtlib.language.errors import ModelError


def cut_body() -> fw.Assembly:
    """A body of 2 kg without weight, with a cut point 1 m beside its centre of mass."""
    root = fw.Assembly("body")
    root.world, root.motion = World(gravity=0), FreeMotion()
    root.body = RigidBody(mass=2.0, inertia=np.diag([3.0, 3.0, 4.0]))
    root.arm, root.cut = FixedTranslation(r=[0, 1, 0]), ForceToPositionAdaptor()
    for a, b in (
        (root.world.frame, root.motion.frame_a), (root.motion.frame_b, root.body.frame_a),
        (root.motion.frame_b, root.arm.frame_a), (root.arm.frame_b, root.cut.frame),
    ):  # fmt: skip
        root.connect(a, b)
    return root


def held_spring(damping: float = 0.0) -> fw.Assembly:
    """A spring from the world to a point that is moved from outside."""
    root = fw.Assembly("spring")
    root.world = World()
    root.spring = SpringDamper(stiffness=50.0, natural_length=1.0, damping=damping)
    root.cut = PositionToForceAdaptor(position_start=[2.0, 0, 0])
    root.connect(root.world.frame, root.spring.frame_a)
    root.connect(root.spring.frame_b, root.cut.frame)
    return root


def test_a_force_from_outside_moves_the_body():
    plant = fw.load(cut_body()).compile()
    path, names = "cut.force", ["cut.position", "cut.velocity", "motion.yaw", "motion.acceleration"]
    assert list(plant.dae.inputs) == [path]
    run = plant.simulate(0.1, 0.01, inputs={path: [6.0, 0.0, 8.0]}, outputs=names, tolerance=1e-9)
    # acceleration 6/2 along x, and -6 * 1 / 4 about z: a push on the left side turns to the right
    assert np.asarray(run["motion.yaw"])[-1] == pytest.approx(-1.5 * 0.1**2 / 2, rel=1e-3)
    assert np.asarray(run["motion.acceleration"])[0] == pytest.approx([3.0, 0.0, 4.0], abs=1e-9)
    # the point: 3 + 1.5 * 1 along x; along z 4 + (8 * 1 / 3) * 1
    assert np.asarray(run["cut.velocity"])[1] == pytest.approx([0.045, 0.0, 0.2 / 3], rel=1e-4, abs=1e-4)
    assert np.asarray(run["cut.position"])[1, 2] == pytest.approx((20 / 3) * 0.01**2 / 2, rel=1e-3)


def test_without_a_force_the_body_stays():
    run = fw.load(cut_body()).compile().simulate(1.0, outputs=["cut.position"])
    assert np.asarray(run["cut.position"])[-1] == pytest.approx([0, 1, 0], abs=1e-12)


@pytest.mark.parametrize("place", [[2.0, 0, 0], [0, 3.0, 4.0], [0.3, -0.4, 0]])
def test_the_force_is_that_on_the_missing_body(place):
    state = fw.load(held_spring()).compile().initial_state(inputs={"cut.position": place})
    length = np.linalg.norm(place)
    expected = -50.0 * (length - 1.0) * np.array(place) / length  # a stretched spring pulls the body back
    assert state["cut.force"] == pytest.approx(expected, rel=1e-9)


def test_a_damper_feels_the_velocity_that_is_given():
    plant = fw.load(held_spring(damping=3.0)).compile()
    state = plant.initial_state(inputs={"cut.position": [0, 2.0, 0], "cut.velocity": [5.0, 4.0, 0]})
    assert state["cut.force"] == pytest.approx([0, -50.0 - 3.0 * 4.0, 0], rel=1e-9)
    still = plant.initial_state(inputs={"cut.position": [0, 2.0, 0]})
    assert still["cut.force"] == pytest.approx([0, -50.0, 0], rel=1e-9)


def test_a_position_that_is_driven_has_its_own_rate():
    """Inside of one model the two adaptors are a rigid link, whatever the input `velocity` says."""
    root = held_spring(damping=3.0)
    root.sine = Sine(amplitude=0.5, frequency=1 / (2 * np.pi), offset=2.0)
    root.zero, root.place = Constant(value=0.0), Mux(n=3)
    for k, y in enumerate((root.sine.y, root.zero.y, root.zero.y)):
        root.connect(y, root.place.u[k])
    root.connect(root.place.y, root.cut.position)
    run = fw.load(root).compile().simulate(1.0, 0.5, inputs={"cut.velocity": [9.0, 9.0, 9.0]}, outputs=["cut.force"])
    t = run.time
    expected = -50.0 * (1.0 + 0.5 * np.sin(t)) - 3.0 * 0.5 * np.cos(t)
    assert np.asarray(run["cut.force"])[:, 0] == pytest.approx(expected, rel=1e-6)


def test_a_moment_at_the_cut_stops_the_run():
    root = fw.Assembly("weight")
    root.world, root.cut = World(), PositionToForceAdaptor()
    root.arm, root.weight = FixedTranslation(r=[1, 0, 0]), PointMass(mass=1.0)
    root.connect(root.cut.frame, root.arm.frame_a)
    root.connect(root.arm.frame_b, root.weight.frame_a)
    with pytest.raises(ModelError, match=r"cut: a moment acts on the point where the model is cut"):
        fw.load(root).compile().simulate(0.1)
