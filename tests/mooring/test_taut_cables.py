"""Three taut cables that hold a point: where it hangs, and what they pull, by geometry and statics."""

from __future__ import annotations

import numpy as np
import pytest

import fowtlib as fw
from fowtlib.components.mechanics import Fixed, FixedTranslation, FreeMotion, PointMass, RigidBody, World, WorldForce
from fowtlib.components.mooring import TautCables
from fowtlib.language import Component, RealOutput, Vector, eq, param, port
from fowtlib.language.errors import ParameterError

AT = np.array([[-160.0, 0, -16], [80, 138, -16], [80, -138, -16]])
PLACE = np.array([-120.0, 0, -64])


class Given(Component):
    """Three numbers."""

    value: Vector = param(doc="the numbers")
    y: RealOutput = port(shape=(3,), doc="output")

    def equations(self):
        return [eq(self.y, self.value)]


def hung(moved=0.0, lift=0.0, place=PLACE):
    """A mass of 200 t on cables whose ends were moved, with a force up."""
    model = fw.Assembly("cables")
    model.world, model.middle, model.cables = World(), Fixed(), TautCables(place=tuple(place), ends_at=AT.tolist())
    model.mass, model.pull, model.given = PointMass(mass=2e5), WorldForce(), Given(value=(0, 0, lift))
    model.connect(model.middle.frame, model.cables.frame_a)
    model.connect(model.cables.frame_b, model.mass.frame_a)
    model.connect(model.cables.frame_b, model.pull.frame)
    model.connect(model.given.y, model.pull.force)
    for k, point in enumerate(AT + moved):
        end = model.add(f"end_{k}", Fixed(r=tuple(point)))
        model.connect(end.frame, model.cables.ends[k])
    return fw.load(model).compile()


def test_lengths_stay_and_tensions_hold_the_weight():
    moved = np.array([[1.0, -0.5, 2.0], [0.3, 0.8, -1.5], [-2.0, 0.4, 0.7]])
    state = hung(moved).initial_state()
    place = state["cables.frame_b.r"].ravel()
    ways = AT + moved - place
    np.testing.assert_allclose(np.linalg.norm(ways, axis=1), np.linalg.norm(AT - PLACE, axis=1), rtol=1e-12)
    assert place[2] < -50  # below the ends, as at rest
    assert np.linalg.norm(place - PLACE) > 0.5
    pull = (ways / np.linalg.norm(ways, axis=1)[:, None]).T @ state["cables.tension"].ravel()
    np.testing.assert_allclose(pull, [0, 0, 2e5 * 9.80665], atol=1e-6 * 2e6)


def test_on_a_rigid_body_the_point_is_a_point_of_the_body():
    """It moves as r + R place, and the mass there is felt as if it were fixed: one free fall, with the same turn."""

    def accelerations(with_cables):
        model = fw.Assembly("a body with a mass below it")
        model.world, model.motion = World(), FreeMotion(roll_start=0.1, pitch_start=-0.2, yaw_start=0.5,
                                                        angle_rates_start=(0.02, 0.01, 0.03))  # fmt: skip
        model.body = RigidBody(mass=1e6, r_cm=(10, 2, -5), inertia=np.diag([3e9, 4e9, 5e9]))
        model.mass = PointMass(mass=2e5)
        link = TautCables(place=tuple(PLACE), ends_at=AT.tolist())
        if not with_cables:
            link = FixedTranslation(r=tuple(PLACE))
        model.link = link
        for k, point in enumerate(AT if with_cables else ()):
            arm = model.add(f"arm_{k}", FixedTranslation(r=tuple(point)))
            model.connect(model.motion.frame_b, arm.frame_a)
            model.connect(arm.frame_b, model.link.ends[k])
        model.connect(model.world.frame, model.motion.frame_a)
        model.connect(model.motion.frame_b, model.body.frame_a)
        model.connect(model.motion.frame_b, model.link.frame_a)
        model.connect(model.link.frame_b, model.mass.frame_a)
        state = fw.load(model).compile().initial_state()
        return [state[name].ravel() for name in ("link.frame_b.r", "motion.angle_accelerations")]

    for found, expected in zip(accelerations(True), accelerations(False), strict=True):
        np.testing.assert_allclose(found, expected, rtol=1e-9, atol=1e-12)


def test_a_cable_that_pushes_is_told():
    with pytest.warns(UserWarning, match="cable . is not taut but pushes") as told:
        hung(lift=3e6).simulate(0.1, output_step=0.1)
    assert {str(one.message).split(" is")[0] for one in told} == {f"cables: cable {k}" for k in (1, 2, 3)}


@pytest.mark.parametrize("place", [(-120.0, 0, -16), (80.0, 138, -16)])
def test_a_point_in_the_plane_of_the_ends_is_refused(place):
    with pytest.raises(ParameterError, match="lies in the plane of the three ends.*lower the point"):
        hung(place=place)
