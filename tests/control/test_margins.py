"""Margins against closed forms, and against what a change of the loop does."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy import signal

from fowtlib.control import discretized, disk_margin, lqr, margins
from fowtlib.language.errors import ModelError
from fowtlib.solving import LinearModel


def loop(numerator, denominator):
    A, B, C, D = signal.tf2ss(numerator, denominator)
    return LinearModel(A, B, C, D, [f"x{i}" for i in range(len(A))], ["u"], ["u"], {})


def test_three_equal_lags():
    """K / (s + 1)^3: the phase is -180 deg at sqrt(3), where |L| = k / 8."""
    for k in (2.0, 4.0):
        found = margins(loop([k], np.poly([-1, -1, -1])))["u"]
        assert_allclose(found.gain, (0.0, 8 / k), rtol=1e-6)
        omega = np.sqrt(k ** (2 / 3) - 1)
        assert_allclose(found.crossover, [omega], rtol=1e-6)
        assert_allclose(found.phase, np.pi - 3 * np.arctan(omega), rtol=1e-5)
        assert_allclose(found.delay, found.phase / omega, rtol=1e-5)


def test_the_regulator_of_a_double_integrator():
    """L = (sqrt(2) s + 1) / s^2: 65.53 deg at sqrt(1 + sqrt(2)); any gain above 0; it keeps out of the unit circle."""
    cart = LinearModel(np.array([[0.0, 1], [0, 0]]), np.array([[0.0], [1]]), np.eye(2), np.zeros((2, 1)), ["x", "v"],
                       ["u"], ["x", "v"], {})  # fmt: skip
    found = margins(lqr(cart, {"x": 1.0}, 1.0).loop)["u"]
    omega = np.sqrt(1 + np.sqrt(2))
    assert_allclose(found.crossover, [omega], rtol=1e-7)
    assert_allclose(found.phase, np.arctan(np.sqrt(2) * omega), rtol=1e-6)
    assert found.gain == (0.0, float("inf"))
    assert found.disk_gain[0] <= 0.5 + 1e-9 and found.disk_phase > np.radians(36.8)


def test_an_unstable_plant_has_a_least_gain():
    """Gain k of k (s + 2) / (s^2 - s + 1) must be above 1 for damping; from 3 that is the factor 1/3."""
    found = margins(loop([3.0, 6.0], [1, -1, 1]))["u"]
    assert_allclose(found.gain[0], 1 / 3, rtol=1e-6)
    assert found.gain[1] == float("inf")


def test_disk_margin_of_first_and_second_order():
    """S - T of k/s is all-pass, alpha = 2. Of 1/(s (s + 1)): the largest |(s^2 + s - 1) / (s^2 + s + 1)|."""
    assert_allclose(disk_margin(loop([3.0], [1, 0])), 2.0, rtol=1e-9)
    omega = np.linspace(0, 5, 500001)
    s = 1j * omega
    largest = np.abs((s**2 + s - 1) / (s**2 + s + 1)).max()
    assert_allclose(disk_margin(loop([1.0], [1, 1, 0])), 2 / largest, rtol=1e-8)
    assert_allclose(margins(loop([1.0], [1, 1, 0]))["u"].disk, 2 / largest, rtol=1e-8)


@pytest.mark.parametrize(("numerator", "denominator"), [
    ([2.0], np.poly([-1, -1, -1])), ([1.0, 0.2], [1, 0.5, 1, 0]), ([2.5, 0.5, 0.5], np.poly([0, -1, -2, -9, -0.1])),
])  # fmt: skip
def test_the_loop_is_at_its_limit_where_the_margins_say(numerator, denominator):
    """With the loop changed by each factor of the margin a pole of the closed loop lies on the axis."""
    found = margins(loop(numerator, denominator))["u"]
    for factor in found.gain:
        if 0 < factor < np.inf:
            poles = np.roots(np.polyadd(denominator, factor * np.asarray(numerator)))
            assert abs(poles.real).min() < 1e-6
    low, high = found.disk_gain
    assert found.gain[0] <= low + 1e-9 and high <= found.gain[1] + 1e-9 and found.disk_phase <= found.phase + 1e-9


def test_a_sampled_loop():
    """The margins of a finely sampled loop are nearly those of the continuous one; exactly at its own limit."""
    continuous = loop([2.0], np.poly([-1, -1, -1]))
    sampled = discretized(continuous, 0.05)
    found, near = margins(sampled)["u"], margins(continuous)["u"]
    assert_allclose(found.gain[1], near.gain[1], rtol=0.1)
    A, B, C, D = (sampled.matrices[name] for name in "ABCD")
    assert_allclose(np.abs(np.linalg.eigvals(A - found.gain[1] * B @ C)).max(), 1.0, rtol=1e-7)
    assert_allclose(np.abs(sampled.frequency_response(found.crossover)), 1.0, rtol=1e-5)
    assert found.disk < near.disk  # the hold delays


def test_two_loops_each_with_the_other_closed():
    """A triangular loop: its channels are what they are alone; changed together it is no better."""
    A, B = np.diag([-1.0, -2.0]), np.eye(2)
    C, D = np.array([[3.0, 0], [4.0, 5]]), np.zeros((2, 2))
    pair = LinearModel(A, B, C, D, ["a", "b"], ["one", "two"], ["a", "b"], {})
    found = margins(pair)
    for name, k, pole in (("one", 3.0, 1.0), ("two", 5.0, 2.0)):
        alone = margins(loop([k], [1, pole]))["u"]
        assert_allclose(found[name].phase, alone.phase, rtol=1e-6)
        assert_allclose(found[name].disk, alone.disk, rtol=1e-7)
    assert disk_margin(pair) <= min(item.disk for item in found.values()) + 1e-9


def test_an_unstable_loop_has_no_margins():
    with pytest.raises(ModelError, match="not stable: it has a pole"):
        margins(loop([20.0], np.poly([-1, -1, -1])))
    with pytest.raises(ModelError, match="as many outputs as inputs"):
        margins(LinearModel(-np.eye(1), np.ones((1, 2)), np.eye(1), np.zeros((1, 2)), ["x"], ["a", "b"], ["x"], {}))
