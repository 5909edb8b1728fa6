"""Operating points: the cut plant is the closed one without its controller."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

import fowtlib as fw
from fowtlib.control import OperatingPoints
from fowtlib.language.errors import ModelError


@pytest.fixture(scope="module")
def points():
    return OperatingPoints(fw.load("oc3_spar_rigid"), {"pitch": "turbine.rotor.blade_pitch"}, ["turbine.rotor.w"])


def test_the_cut_plant_with_its_controller_closed_again_is_the_model(points):
    """Rates of the plant by the blade pitch, times what the controller makes of it, are those of the closed loop."""
    point = points.at(15.0)
    states = dict(zip(points.plant.layout.x, point.state.x, strict=True))
    closed = points.closed.linearize(points.closed.initial_state({"wind.mean_speed": 15.0}, states))
    k = closed.states.index("turbine.control.pitch.pitch")
    into = point.linear.matrices["B"][:, [point.linear.inputs.index("pitch")]]
    again = point.linear.matrices["A"] + into @ np.eye(len(closed.states))[[k]]
    assert_allclose(again, closed.matrices["A"], rtol=1e-6, atol=1e-8)


def test_nothing_moves_at_a_point(points):
    """A run of the cut plant from the point, with its inputs held, stays there."""
    point = points.at(15.0)
    result = points.plant.simulate(
        4.0, 1.0, start=point.state, parameters={"wind.mean_speed": 15.0}, inputs=point.inputs, solver="idas"
    )
    speed = np.asarray(result["turbine.rotor.w"])
    assert_allclose(speed, speed[0], rtol=1e-5)
    assert point["pitch"] > 0.1 and point.value == 15.0


def test_a_point_may_be_held_off_the_controller(points):
    """At 9 m/s with 3 deg of pitch the rotor turns slower than at zero pitch."""
    free, held = points.at(9.0), points.at(9.0, held={"pitch": 0.052})
    assert held["pitch"] == 0.052 and held["turbine.rotor.w"] < free["turbine.rotor.w"] - 0.01


def test_mistakes_name_what_is_wrong(points):
    with pytest.raises(ModelError, match=r"wind.mean_speed = -5.0 is below its minimum"):
        points.at(-5.0)
    with pytest.raises(ModelError, match=r"no input 'pich'; did you mean 'pitch'"):
        points.at(9.0, held={"pich": 0.05})
