"""Corners of control laws within the deviations of a response: found with their probability, named, and told."""

from __future__ import annotations

import warnings

import numpy as np
import pytest
from scipy.stats import norm

import fowtlib as fw
from fowtlib.design import DesignCase
from fowtlib.design.measures import Meter
from fowtlib.frequency import response
from fowtlib.frequency.corners import CHANGED, CornerWarning
from fowtlib.language import Scalar, der, eq, param, var
from fowtlib.language import math as m
from tests.frequency.conftest import Oscillator

TIME = 0.4  # s


class Follower(Oscillator):
    """An oscillator pushed at random, and a state that follows what a law makes of its displacement."""

    at: Scalar = param(default=0.0, unit="m", doc="corner of the law")
    limit: Scalar = param(default=1e6, unit="m/s", doc="of the rate of what follows")
    response_time: Scalar = param(default=TIME, unit="s", doc="with which it follows")
    law: str = param(default="above", choices=("above", "below", "away", "switched"), doc="which law")

    y: Scalar = var(unit="m", start=0.0, fixed=True, state="prefer", doc="what follows")

    def asked(self):
        x, at = self.x, self.at
        laws = {
            "above": lambda: m.fmax(x, at), "below": lambda: m.fmin(x, at), "away": lambda: m.abs(x - at),
            "switched": lambda: m.if_else(x > at, x, at),
        }  # fmt: skip
        return laws[self.law]()

    def equations(self):
        rate = (self.asked() - self.y) / self.response_time
        return [*super().equations(), eq(der(self.y), m.fmin(m.fmax(rate, -self.limit), self.limit))]


def follower(**parameters):
    root = fw.Assembly("followers")
    root.one = Follower(**parameters)
    return fw.Model(root, outputs={"x": "one.x", "y": "one.y"})


@pytest.mark.parametrize("law, side", [("above", -1), ("below", 1), ("away", -1), ("switched", -1)])
@pytest.mark.parametrize("far", [0.3, 1.0])
def test_the_probability_of_a_corner_is_that_of_a_gaussian_state_beyond_it(law, side, far):
    s = response(follower(at=-100.0)).std("x")
    with pytest.warns(CornerWarning, match=r"the law of one\.y is another one .* where one\.x is (above|below)"):
        found = response(follower(law=law, at=side * far * s))
    (corner,) = found.corners
    # the law is off by the way beyond the corner (twice that where its slope turns round), in parts of its size
    off = (2 if law == "away" else 1) / TIME
    beyond = CHANGED * np.hypot(found.std("x"), found.std("y")) / TIME / off
    assert corner.probability == pytest.approx(norm.cdf(-(far * s + beyond) / s), abs=0.02)
    assert corner.border == pytest.approx(side * (far * s + beyond), abs=0.1 * s)
    assert (corner.state, corner.above, corner.mean) == ("one.x", side > 0, pytest.approx(0.0, abs=1e-9))
    assert corner.deviation == pytest.approx(s, rel=0.02)


def test_a_corner_that_is_far_away_is_not_told():
    s = response(follower(at=-100.0)).std("x")
    for law, at in (("above", -3 * s), ("below", 3 * s), ("away", -3 * s), ("switched", -3 * s)):
        with warnings.catch_warnings():
            warnings.simplefilter("error", CornerWarning)
            assert response(follower(law=law, at=at)).corners == ()


@pytest.mark.parametrize("limit", [1e6, 20.0])
def test_a_limit_of_the_rate_does_not_hide_that_what_is_followed_has_gone(limit):
    # the follower is some 0.5 m from what it follows there, 50 m/s of its law, which else moves at 2 m/s
    s = response(follower(at=-100.0)).std("x")
    with pytest.warns(CornerWarning):
        found = response(follower(at=-0.5 * s, response_time=0.01, limit=limit))
    off = CHANGED * np.hypot(found.std("x"), found.std("y"))
    (corner,) = found.corners
    assert corner.probability == pytest.approx(norm.cdf(-0.5 - off / s), abs=0.02)


def weather(speed):
    return {"wind.kind": "kaimal", "wind.mean_speed": speed, "wind.turbulence_class": "B",
            "sea.significant_wave_height": 3.0, "sea.peak_period": 10.0}  # fmt: skip


def test_a_turbine_near_rated_wind_reaches_over_its_corners_and_one_far_above_does_not():
    plant = fw.load("oc3_spar_rigid").compile()
    with pytest.warns(CornerWarning, match=r"turbine\.control\.torque\.actual"):
        near = response(plant, outputs=["pitch"], parameters=weather(12.0))
    assert {corner.law for corner in near.corners} == {
        "turbine.control.torque.actual", "turbine.control.pitch.pitch", "turbine.control.pitch.integral"
    }  # fmt: skip
    for speed in (6.0, 18.0):
        with warnings.catch_warnings():
            warnings.simplefilter("error", CornerWarning)
            response(plant, outputs=["pitch"], parameters=weather(speed))
    with pytest.warns(CornerWarning, match=r"2 of 3 responses .* states 1, 3") as told:
        fw.responses(plant, [weather(speed) for speed in (10.0, 18.0, 12.0)], outputs=["pitch"])
    assert len([one for one in told if issubclass(one.category, CornerWarning)]) == 1


def test_a_search_is_told_of_the_corners_of_a_case_once():
    meter = Meter(fw.load("oc3_spar_rigid").compile(), DesignCase("near rated", weather(12.0)), ["std of pitch"])
    with pytest.warns(CornerWarning):
        meter.measure({})
    with warnings.catch_warnings():
        warnings.simplefilter("error", CornerWarning)
        assert meter.measure({"sea.significant_wave_height": 4.0}).values["std of pitch"] > 0
