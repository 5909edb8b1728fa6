"""Yaw of the nacelle into the wind."""

import numpy as np
import pytest

import fowtlib as fw
from fowtlib.components.blocks import Step
from fowtlib.components.environment.wind import SteadyWind
from fowtlib.components.mechanics import Fixed, FixedRotation, RigidBody, World
from fowtlib.components.servo import YawController
from fowtlib.components.turbine import ActuatedBearing

SOLVERS = [("fixed", {"step": 0.05}), ("idas", {"tolerance": 1e-8})]


@pytest.fixture(scope="module")
def plant():
    """A nacelle on a tower top that stands turned by 5 deg."""
    model = fw.Assembly("nacelle")
    model.world, model.base, model.wind = World(), Fixed(), SteadyWind(mean_speed=10.0)
    model.turned = FixedRotation(n=(0, 0, 1), angle="5 deg")
    model.yaw, model.drive = YawController(), ActuatedBearing(natural_frequency=1.0, damping_ratio=0.7)
    model.body = RigidBody(mass=1.0, inertia=np.eye(3))
    model.power = Step(offset=1.0, height=0.0, start_time=40.0)
    for ports in (
        (model.base.frame, model.turned.frame_a), (model.turned.frame_b, model.drive.frame_a),
            (model.turned.frame_b, model.yaw.frame),
        (model.drive.frame_b, model.body.frame_a), (model.yaw.command, model.drive.command),
        (model.power.y, model.yaw.enabled),
    ):  # fmt: skip
        model.connect(*ports)
    return fw.load(model).compile()


def run(plant, direction, end=200.0, solver=SOLVERS[0], **parameters):
    names = ["yaw.command", "drive.angle", "yaw.way", "yaw.error", "yaw.since"]
    result = plant.simulate(end, 0.5, solver=solver[0], **solver[1], outputs=names,
                            parameters={"wind.direction": direction, **parameters})  # fmt: skip
    return [np.degrees(np.asarray(result[name])) if name != names[2] else np.asarray(result[name]) for name in names]


@pytest.mark.parametrize("solver", SOLVERS)
@pytest.mark.parametrize("side", [1, -1])
def test_it_yaws_from_the_deadband_until_the_error_is_gone(plant, solver, side):
    """The mean of an error e passes 8 deg at -T log(1 - 8/e); then 0.3 deg/s, and the short mean lags by 5 s."""
    error = 20.0
    command, angle, way, left, since = run(plant, f"{5 + side * error} deg", solver=solver)
    begins = -60 * np.log(1 - 8 / error)
    assert np.radians(since[100]) == pytest.approx(begins, abs=0.02)
    t = np.arange(0, 200.25, 0.5)
    on = way != 0
    np.testing.assert_allclose(command[on], side * 0.3 * (t[on] - begins), atol=0.01)
    assert set(way[on]) == {side} and np.radians(since[-1]) == pytest.approx(begins + error / 0.3 + 5, abs=0.01)
    assert left[-1] == pytest.approx(-side * 0.3 * 5, abs=0.01)  # by the lag of the short mean
    np.testing.assert_allclose(angle[-1], command[-1], atol=1e-3)
    assert not on[-1]


def test_within_the_deadband_it_rests(plant):
    for error in (7.9, -7.9):
        command, _, way, left, _ = run(plant, f"{5 + error} deg", end=600.0)
        assert not command.any() and not way.any() and left[-1] == pytest.approx(error)


def test_it_goes_the_short_way_round(plant):
    command, *_ = run(plant, "-172 deg", end=100.0)
    assert command[-1] < -5


def test_without_power_it_stops_where_it_is_and_goes_on_later(plant):
    command, *_ = run(plant, "25 deg", end=100.0, **{"power.height": -1.0})
    begins = -60 * np.log(1 - 8 / 20)
    np.testing.assert_allclose(command[81:], 0.3 * (40 - begins), atol=0.01)
