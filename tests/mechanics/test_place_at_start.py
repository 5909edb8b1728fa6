"""Where a frame is when a run starts, without solving: against the solved start."""

import numpy as np
import pytest

import fowtlib as fw
from fowtlib.components.mechanics import Fixed, FixedRotation, FixedTranslation, FreeMotion, Prismatic, RigidBody, World
from fowtlib.components.mechanics.attitude import place_at_start


def chained():
    root = fw.Assembly("a chain of links and joints")
    root.world, root.ground = World(), Fixed(r=(10, -4, 2), angles=(0.1, -0.2, 0.7))
    root.slide = Prismatic(n=(1, 2, 0), s_start=3.0)
    root.free = FreeMotion(surge_start=5.0, heave_start=-2.0, roll_start=0.2, pitch_start=0.1, yaw_start=-0.4)
    root.turn, root.link = FixedRotation(n=(0, 1, 1), angle=0.6, r=(1, 0, 2)), FixedTranslation(r=(0, 7, -1))
    root.carrier = RigidBody(mass=10, inertia=np.eye(3))
    root.body = RigidBody(mass=10, inertia=np.eye(3))
    root.connect(root.ground.frame, root.slide.frame_a)
    for one, other in ((root.slide, root.free), (root.free, root.turn), (root.turn, root.link)):
        root.connect(one.frame_b, other.frame_a)
    root.connect(root.slide.frame_b, root.carrier.frame_a)
    root.connect(root.link.frame_b, root.body.frame_a)
    return root


def test_the_way_through_links_and_joints_is_that_of_the_solved_start():
    root = chained()
    expected = fw.load(root).compile().initial_state()
    for part, port in ((root.link, "frame_b"), (root.turn, "frame_b"), (root.free, "frame_a"), (root.body, "frame_a")):
        found = place_at_start(part, port)
        assert found == pytest.approx(np.ravel(expected[f"{part.path}.{port}.r"]), abs=1e-9), part.path
    root.loose = FixedTranslation(r=(1, 0, 0))
    assert place_at_start(root.loose, "frame_b") is None
