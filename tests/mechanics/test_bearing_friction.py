"""Friction of a bearing: constant while it turns, without a jump at rest."""

import numpy as np
import pytest

import fowtlib as fw
from fowtlib.components.blocks import Constant
from fowtlib.components.mechanics import BearingFriction, Inertia, TorqueSource


def turning(torque=0.0, **friction):
    model = fw.Assembly("a wheel on a bearing")
    model.wheel = Inertia(inertia=50.0, w_start=friction.pop("w_start", 0.0))
    model.bearing = BearingFriction(**friction)
    model.source, model.drive = TorqueSource(), Constant(value=torque)
    model.connect(model.drive.y, model.source.torque)
    model.connect(model.source.flange, model.wheel.flange_a)
    model.connect(model.bearing.flange, model.wheel.flange_b)
    return fw.load(model).compile()


def test_wheel_stops_as_coulomb_has_it():
    """W = w0 - T t / J until it stands."""
    result = turning(friction_torque=10.0, creep_speed=1e-3, w_start=2.0).simulate(15.0, output_step=0.5)
    w, t = np.asarray(result["wheel.w"]).ravel(), np.asarray(result.time)
    np.testing.assert_allclose(w, np.maximum(2.0 - 10 * t / 50, 0.0), atol=3e-3)


@pytest.mark.parametrize(("torque", "speed"), [(5.0, 1e-3 * 0.5 / np.sqrt(0.75)), (-5.0, -1e-3 * 0.5 / np.sqrt(0.75))])
def test_it_creeps_under_less_than_its_friction(torque, speed):
    result = turning(torque, friction_torque=10.0, creep_speed=1e-3).simulate(5.0, output_step=1.0)
    assert np.asarray(result["wheel.w"]).ravel()[-1] == pytest.approx(speed, rel=1e-4)


def test_damping_grows_with_the_speed():
    result = turning(30.0, friction_torque=10.0, damping=20.0).simulate(60.0, output_step=10.0)
    assert np.asarray(result["wheel.w"]).ravel()[-1] == pytest.approx(1.0, rel=1e-6)
