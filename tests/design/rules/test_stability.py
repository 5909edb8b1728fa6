"""Rules of stability and limits of standards, each against a second computation."""

import math

import casadi as ca
import numpy as np
import pytest
from scipy.integrate import quad

from fowtlib.design import rules
from fowtlib.design.standards import check_result
from fowtlib.language.errors import ModelError
from fowtlib.solving.results import Result


def test_the_area_ratio_is_that_of_the_integrals():
    weight, GM, BM, thrust, lever = 1.7e8, 3.0, 0.15, 1e6, 120.0
    for until in (0.1, 0.5, 1.0):
        righting = quad(lambda x: weight * rules.righting_arm(x, GM, BM), 0, until)[0]
        wind = quad(lambda x: thrust * lever * math.cos(x) ** 2, 0, until)[0]
        assert rules.stability_area_ratio(weight, GM, BM, thrust, lever, until) == pytest.approx(righting / wind)


def test_a_small_heel_is_where_both_moments_meet():
    weight, GM, BM, thrust, lever = 1.7e8, 7.0, 0.15, 1e6, 120.0
    heel = rules.static_heel(thrust, lever, weight, GM)
    assert weight * rules.righting_arm(heel, GM, BM) == pytest.approx(thrust * lever * math.cos(heel) ** 2, rel=0.015)


def test_the_acceleration_of_a_nacelle():
    """A body that swings about the point where surge is measured: lever times pitch'', and the weight aside."""
    assert rules.nacelle_acceleration(0.5, 0.01, 0.1, 100.0, 10.0) == pytest.approx(0.5 + 1.0 + 10 * math.sin(0.1))


def test_the_highest_wave_of_three_hours():
    """1.86 for 1000 waves; and the most probable largest of 1000 Rayleigh heights, by its density."""
    assert rules.highest_wave_ratio(1000) == pytest.approx(1.858, abs=1e-3)
    h = np.linspace(1.0, 3.0, 20001)
    below = 1 - np.exp(-2 * h**2)
    density = 1000 * below**999 * 4 * h * np.exp(-2 * h**2)
    assert h[density.argmax()] == pytest.approx(rules.highest_wave_ratio(1000), rel=0.02)


def test_rules_take_expressions():
    x = ca.SX.sym("x")
    slope = ca.Function("slope", [x], [ca.jacobian(rules.righting_arm(x, 3.0, 0.2), x)])
    assert float(slope(0.0)) == pytest.approx(3.0)


def test_limits_of_a_spar():
    kept = rules.check_limits({"metacentric height": 2.0, "heel": math.radians(4.5), "nacelle acceleration": 2.4})
    assert all(verdict.kept for verdict in kept) and not rules.broken(kept)
    missed = rules.check_limits({"metacentric height": 0.9, "heel": 0.1, "area ratio": 1.29,
                                 "nacelle acceleration": 3.0, "highest wave over significant": 1.8})  # fmt: skip
    assert not any(verdict.kept for verdict in missed)
    told = "metacentric height is 0.9 m, and at least 1 m is asked for (C. Serret (2019), 4.2)."
    assert rules.broken(missed)[0] == told
    assert rules.check_periods({"heave": 20.0, "pitch": 90.0, "yaw": 100.0})[0].kept
    assert rules.within_wave_band({"heave": 24.0, "pitch": 30.0, "yaw": 4.0}) == ["heave"]


@pytest.mark.parametrize(
    ("action", "words"),
    [
        (lambda: rules.check_limits({"heal": 0.1}), "there is no limit on 'heal'"),
        (lambda: rules.check_periods({"heave": math.nan}), "not a number"),
        (lambda: rules.righting_arm(1.2, 1.0, 1.0), "up_to_60_degrees"),
        (lambda: rules.static_heel(1.0, 1.0, 1.0, -2.0), "pitch_stiffness"),
        (lambda: rules.highest_wave_ratio(1), "waves"),
    ],
)
def test_mistakes(action, words):
    with pytest.raises(ModelError, match=words):
        action()


def test_limits_on_a_run():
    """A pitch of 4 degrees with a swing of 1, and an acceleration in g: 5 degrees are too many, 0.25 g are kept."""
    time = np.linspace(0.0, 100.0, 1001)
    series = {"pitch": 4.0 + np.sin(time), "acceleration": 2.45 * np.sin(time)}
    result = Result(time, series, units={"pitch": "deg", "acceleration": "m/s^2"})
    heel, nacelle = check_result(result, {"heel": "pitch", "nacelle acceleration": "acceleration"})
    assert heel.value == pytest.approx(math.radians(5.0), rel=1e-3) and not heel.kept
    assert nacelle.value == pytest.approx(2.45, rel=1e-3) and nacelle.kept
    with pytest.raises(ModelError, match="pitch"):
        check_result(result, {"nacelle acceleration": "pitch"})
    with pytest.raises(ModelError, match="no limit on 'heal'"):
        check_result(result, {"heal": "pitch"})
