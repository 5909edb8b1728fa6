"""Free decay against oscillators whose period and damping are known."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from fowtlib.analysis.decay import analyse_decay
from fowtlib.language.errors import ModelError

TIME = np.arange(0.0, 600.05, 0.1)


def linear(damping: float, period: float, rest: float, offset: float = 10.0, time: np.ndarray = TIME) -> np.ndarray:
    w = 2 * np.pi / period
    wd = w * np.sqrt(1 - damping**2)
    return rest + offset * np.exp(-damping * w * time) * (np.cos(wd * time) + damping * w / wd * np.sin(wd * time))


@pytest.mark.parametrize("damping", [0.002, 0.0146, 0.05, 0.15])
@pytest.mark.parametrize(("period", "rest"), [(8.0, 0.0), (28.0, -3.0), (125.0, 20.0)])
def test_linear_oscillator(damping, period, rest):
    decay = analyse_decay((TIME, linear(damping, period, rest)))
    assert decay.damping_ratio == pytest.approx(damping, rel=1e-4)
    assert decay.period == pytest.approx(period / np.sqrt(1 - damping**2), rel=1e-5)
    assert decay.natural_frequency == pytest.approx(1 / period, rel=1e-5)
    assert decay.rest == pytest.approx(rest, abs=1e-4)
    assert decay.damping_slope == pytest.approx(0.0, abs=1e-5)
    np.testing.assert_allclose(decay.envelope(TIME), 10 * np.exp(-damping * 2 * np.pi / period * TIME), atol=2e-3)


def test_logarithmic_decrement_is_that_of_two_crests():
    damping = 0.1
    decay = analyse_decay((TIME, linear(damping, 20.0, 0.0)))
    assert decay.logarithmic_decrement == pytest.approx(2 * np.pi * damping / np.sqrt(1 - damping**2), rel=1e-4)


def test_quadratic_damping_grows_with_amplitude():
    """X'' + 2 zeta w x' + beta x'|x'| + w^2 x = 0: zeta(A) = zeta + 4 beta A / (3 pi), for small beta A."""
    w, damping, beta = 2 * np.pi / 28.0, 0.01, 0.005
    solution = solve_ivp(
        lambda t, y: [y[1], -2 * damping * w * y[1] - beta * y[1] * abs(y[1]) - w**2 * y[0]],
        (0, 600),
        [10.0, 0.0],
        t_eval=TIME[:-1],
        rtol=1e-9,
        atol=1e-11,
    )
    decay = analyse_decay((solution.t, solution.y[0]))
    assert decay.damping_at_zero == pytest.approx(damping, rel=0.01)
    assert decay.damping_slope == pytest.approx(4 * beta / (3 * np.pi), rel=0.01)
    assert decay.damping[0] > 2 * decay.damping[-1]
    np.testing.assert_allclose(decay.envelope(decay.extrema_time), np.abs(decay.extrema - decay.rest), rtol=0.01)


def test_noise_and_a_slow_drift_do_not_matter_much():
    noise = np.random.default_rng(1).normal(0.0, 0.01, TIME.size)
    decay = analyse_decay((TIME, linear(0.03, 28.0, 5.0) + noise), smallest=0.1)
    assert decay.damping_ratio == pytest.approx(0.03, rel=0.02)
    assert decay.period == pytest.approx(28.0126, rel=1e-3)


def test_a_start_with_speed_is_no_extremum():
    values = linear(0.05, 28.0, 0.0)
    decay = analyse_decay((TIME[30:], values[30:]))
    assert decay.extrema_time[0] > 10.0
    assert decay.damping_ratio == pytest.approx(0.05, rel=1e-4)


@pytest.mark.parametrize(
    ("time", "values", "message"),
    [
        (
            TIME[:450],
            linear(0.05, 28.0, 0.0)[:450],
            "free decay of surge: in 44.9 s it passes its rest position 0 m 3 times, 5 are needed. Simulate longer; "
            "a motion that only creeps back is overdamped and has no period.",
        ),
        (
            TIME,
            10 * np.exp(-TIME / 20),
            "free decay of surge: in 600 s it passes its rest position 0 m 0 times, 5 are needed. Simulate longer; "
            "a motion that only creeps back is overdamped and has no period.",
        ),
        (TIME, 0 * TIME, "free decay of surge: nothing moves. Is the offset zero, or the motion locked?"),
        (TIME, np.where(TIME < 300, TIME, np.nan), "surge: the value at 300 s is not a finite number."),
    ],
)
def test_records_that_tell_nothing(time, values, message):
    import xarray

    series = xarray.DataArray(values, {"time": time}, ("time",), "surge", {"units": "m"})
    with pytest.raises(ModelError) as caught:
        analyse_decay(series, rest=0.0)
    assert str(caught.value) == message
