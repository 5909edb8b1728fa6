"""Linear and quadratic damping from records whose numbers are known, with noise, and their intervals."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from fowtlib.analysis.decay_fits import METHODS, damped_sinusoid, decay_equation, linear_quadratic
from fowtlib.analysis.series import Series
from fowtlib.language.errors import ModelError

W = 2 * math.pi / 4.261  # heave of a spar at 1:45, Serret (2019), table 5.16
STEP = 0.1


def record(p1: float, p2: float, *, noise: float = 0.0, seed: int = 0, rest: float = 0.01, offset: float = 0.05,
           duration: float = 80.0) -> Series:  # fmt: skip
    time = np.arange(0.0, duration, STEP)
    motion = solve_ivp(
        lambda _, y: [y[1], -(p1 + p2 * abs(y[1])) * y[1] - W**2 * y[0]], (0, duration), [offset, 0.0], t_eval=time,
        rtol=1e-8, atol=1e-10,
    ).y[0]  # fmt: skip
    return Series(time, rest + motion + np.random.default_rng(seed).normal(0.0, noise, time.size), "m", "heave")


@pytest.mark.parametrize("damping", [0.0008, 0.0044, 0.05, 0.2])
def test_the_damped_sinusoid_of_a_linear_motion(damping):
    fit = damped_sinusoid(record(2 * damping * W, 0.0))
    assert fit.natural_frequency.value == pytest.approx(W, rel=1e-6)
    assert fit.damping_ratio.value == pytest.approx(damping, rel=1e-5)
    assert fit.period.value == pytest.approx(4.261 / math.sqrt(1 - damping**2), rel=1e-6)
    assert fit.rest == pytest.approx(0.01, abs=1e-8)
    assert fit.p2.value == 0.0


@pytest.mark.parametrize(("p1", "p2"), [(0.013, 1.0), (0.059, 2.0), (0.013, 0.3)])
def test_linear_and_quadratic_damping_come_back(p1, p2):
    """The straight line is equivalent linearisation, good to the first order of the damping; the equation is exact."""
    line, exact = linear_quadratic(record(p1, p2)), decay_equation(record(p1, p2))
    assert line.p1.value == pytest.approx(p1, rel=0.01)
    assert line.p2.value == pytest.approx(p2, rel=0.01)
    for found, wanted in ((exact.p1, p1), (exact.p2, p2), (exact.natural_frequency, W)):
        assert found.value == pytest.approx(wanted, rel=1e-5)
    assert exact.residual < 1e-7
    assert line.amplitude.size == line.rate.size > 10


def test_strong_damping_is_for_the_equation():
    p1, p2 = 0.2 * W, 3.0
    exact = decay_equation(record(p1, p2, noise=1e-4, seed=4))
    assert exact.p1.value == pytest.approx(p1, rel=0.02)
    assert exact.p2.value == pytest.approx(p2, rel=0.05)


@pytest.mark.parametrize("method", ["line", "equation"])
def test_intervals_hold_what_they_say(method):
    """Of records with noise of 1 % of the offset, the 90 % intervals of p1, p2 and w hold the true ones that often."""
    p1, p2 = 0.026, 1.0
    count = 16
    fits = [METHODS[method](record(p1, p2, noise=5e-4, seed=seed, duration=50.0)) for seed in range(count)]
    held = np.array([[fit.p1.holds(p1, 0.9), fit.p2.holds(p2, 0.9)] for fit in fits])
    assert (held.sum(axis=0) >= 11).all()  # fewer of 16 with 0.9 each have a probability below 1 %
    assert not held.all()  # wider ones would hold all of them
    spread = np.std([fit.p2.value for fit in fits], ddof=1)
    stated = np.mean([fit.p2.error for fit in fits])
    assert 0.6 < stated / spread < 1.6
    assert np.mean([fit.p2.value for fit in fits]) == pytest.approx(p2, abs=3 * spread / math.sqrt(count))


def test_no_quadratic_damping_is_found_where_there_is_none():
    fit = linear_quadratic(record(0.026, 0.0, noise=2e-4, seed=7))
    assert fit.p2.holds(0.0)
    assert fit.p1.holds(0.026, 0.99)
    assert abs(fit.correlation) < 0.6


def test_one_damping_for_all_cycles_leaves_a_rest_that_is_no_noise():
    quadratic = record(0.013, 2.0, noise=1e-4, seed=2)
    assert damped_sinusoid(quadratic).correlation > 0.9
    assert abs(decay_equation(quadratic).correlation) < 0.1


def test_equivalent_damping_at_an_amplitude():
    """B_eq = B1 + 8/(3 pi) w X B2, which loses the energy of a cycle of the quadratic law: integrated here."""
    p1, p2, amplitude, inertia = 0.026, 1.5, 0.03, 392.9
    fit = decay_equation(record(p1, p2))
    w, angle = fit.natural_frequency.value, np.linspace(0, 2 * np.pi, 20001)
    speed = amplitude * w * np.sin(angle)
    lost = np.trapezoid((p1 * speed + p2 * np.abs(speed) * speed) * speed, angle / w) * inertia
    equivalent = fit.equivalent_damping(amplitude, inertia)
    assert equivalent.value * math.pi * w * amplitude**2 == pytest.approx(lost, rel=1e-4)
    ratio = fit.equivalent_damping_ratio(amplitude)
    assert equivalent.value == pytest.approx(2 * w * inertia * ratio.value, rel=1e-9)
    linear, quadratic = fit.coefficients(inertia)
    assert (linear.value, quadratic.value) == pytest.approx((p1 * inertia, p2 * inertia), rel=1e-4)


def test_the_rows_of_a_table():
    rows = {name: tuple(numbers) for name, *numbers in damped_sinusoid(record(0.02, 0)).rows(0.02)}
    assert rows["quadratic damping p2"][3] == "1/m"
    value, low, high, unit = rows["damped period"]
    assert (low <= value <= high, unit) == (True, "s")
    assert "damping ratio at 0.02 m" in rows


@pytest.mark.parametrize(
    ("series", "message"),
    [
        (Series(np.arange(0, 60, 0.1), np.zeros(600), "m", "heave"), "decay of heave: nothing moves."),
        (Series(np.arange(0, 60, 3.0), np.cos(np.arange(0, 60, 3.0)), "m", "heave"), "periods of .* steps at least"),
        (record(0.02, 0.0, duration=5.0), "hold 1.1.* periods .*; a fit takes 2 periods of 8 steps at least"),
    ],
)  # fmt: skip
def test_records_that_tell_nothing(series, message):
    with pytest.raises(ModelError, match=message):
        damped_sinusoid(series)


def test_a_line_needs_half_cycles_above_the_noise():
    with pytest.raises(ModelError, match="half cycles stand out of the rest, 5 are needed"):
        linear_quadratic(record(0.6, 0.0, noise=5e-3, seed=1))
