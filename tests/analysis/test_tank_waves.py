"""Response operators from records of regular and irregular waves, against a linear motion that is known."""

from __future__ import annotations

import math
import warnings

import numpy as np
import pytest

import fowtlib as fw
from fowtlib.analysis.agreement import agreement, percent_difference
from fowtlib.analysis.comparison import compare_over_time, compare_results
from fowtlib.analysis.series import Series
from fowtlib.analysis.tank_waves import (
    group_speed,
    rao_of_tests,
    regular_test,
    spectral_rao,
    steady_window,
    undisturbed_window,
)
from fowtlib.components.environment.waves import irregular_waves
from fowtlib.language.errors import ModelError
from fowtlib.solving.results import Result

STIFFNESS, INERTIA, DAMPING = 854.4, 392.9, 0.044  # heave of the spar of Serret (2019) at 1:45; sections 3.13 and 3.6
W = math.sqrt(STIFFNESS / INERTIA)
STEP = 0.05


def heave(omega: np.ndarray) -> np.ndarray:
    """Heave per elevation of an oscillator that the hydrostatic force of a long wave drives."""
    return W**2 / (W**2 - np.asarray(omega) ** 2 + 2j * DAMPING * W * np.asarray(omega))


def sea(duration: float, seed: int = 1) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Times, elevation and heave in a JONSWAP sea that has energy about the resonance."""
    waves = irregular_waves(0.05, 3.6, 2.0, seed=seed, repetition_period=2.0 * duration)
    time = np.arange(0.0, duration, STEP)
    lines = np.zeros((2, time.size + 1), dtype=complex)
    index = np.rint(waves.omega * duration / np.pi).astype(int)
    lines[0, index] = waves.amplitude * np.exp(1j * waves.phase) * time.size
    lines[1, index] = lines[0, index] * heave(waves.omega)
    elevation, motion = np.fft.irfft(lines, 2 * time.size)[:, : time.size]
    return time, elevation, motion


def test_the_front_of_waves():
    """Deep water: g T / (4 pi); shallow water: sqrt(g h)."""
    assert group_speed(1.0, 50.0) == pytest.approx(9.81 / (4 * math.pi), rel=1e-6)
    assert group_speed(60.0, 0.5) == pytest.approx(math.sqrt(9.81 * 0.5), rel=1e-3)


def test_the_window_before_the_reflection():
    begin, end = undisturbed_window(1.4, 2.0, 8.0, 12.0, ramp=3.0)
    speed = group_speed(1.4, 2.0)
    assert (begin, end) == pytest.approx((8 / speed + 3, 32 / speed))
    with pytest.raises(ModelError, match="undisturbed for 1.64 s at the model, less than two periods"):
        undisturbed_window(3.33, 2.0, 2.0, 2.5, ramp=0.0)


def regular(period: float, reflection: float = 0.3, noise: float = 0.0) -> tuple[Series, Series]:
    """A wave that comes at 10 s and its reflection from 40 s on, at the actual period, 1.5 % off what was asked for."""
    actual, time = 1.015 * period, np.arange(0.0, 70.0, STEP)
    omega, rng = 2 * math.pi / actual, np.random.default_rng(5)
    incident = 0.02 * np.cos(omega * time + 0.4) * (time > 10) + reflection * 0.02 * np.cos(omega * time + 0.9) * (
        time > 40
    )
    response = 0.02 * abs(heave(omega)) * np.cos(omega * time + 0.4 + np.angle(heave(omega))) * (time > 10)
    response += 0.01 * np.cos(3.3 * time) * (time > 40)
    return (Series(time, incident + rng.normal(0, noise, time.size), "m", "elevation"),
            Series(time, response + rng.normal(0, noise, time.size), "m", "heave"))  # fmt: skip


@pytest.mark.parametrize("period", [1.2, 2.22, 3.33])
def test_a_regular_run_gives_its_actual_period_and_response(period):
    wave, motion = regular(period)
    assert steady_window(wave, period)[0] >= 10 - 1e-9
    for window, tolerance in ((None, 0.03), ((11.0, 39.0), 1e-3)):
        test = regular_test(wave, {"heave": motion}, period, window=window)
        assert test.window[1] <= 40.0 + period
        assert test.response[0] == pytest.approx(heave(2 * math.pi / test.period), rel=tolerance)
        assert test.period == pytest.approx(1.015 * period, rel=tolerance / 10)
        assert test.amplitude == pytest.approx(0.02, rel=tolerance)


def test_the_error_of_a_regular_test_is_that_of_noise():
    errors = []
    for _ in range(1):
        wave, motion = regular(2.22, noise=1e-3)
        test = regular_test(wave, {"heave": motion}, 2.22, window=(11.0, 39.0))
        errors.append(abs(abs(test.response[0]) - abs(heave(2 * math.pi / test.period))))
        assert test.error[0] == pytest.approx(1e-3 * math.sqrt(2 / 560) / 0.02, rel=0.15)
    assert max(errors) < 5 * test.error[0]


def test_a_wave_that_is_not_there():
    wave, motion = regular(2.22)
    with pytest.raises(ModelError, match="no wave within 10 % of a period of 1.6 s|no three periods"):
        regular_test(wave, {"heave": motion}, 1.6, window=(11.0, 39.0))
    with pytest.raises(ModelError, match="no three periods of 2.9 s have the same amplitude"):
        steady_window(wave, 2.9)


def test_regular_and_spectral_operators_agree():
    """Where the motion is linear they are one, over the band of the waves and at the resonance."""
    time, elevation, motion = sea(2400.0)
    spectral = spectral_rao((time, elevation), {"heave": Series(time, motion, "m", "heave")}, segment=240.0)
    runs = [regular(period, 0.0) for period in (1.2, 2.22, 3.33, 4.1)]
    tests = [regular_test(wave, {"heave": response}, period, window=(11.0, 39.0))
             for (wave, response), period in zip(runs, (1.2, 2.22, 3.33, 4.1), strict=True)]  # fmt: skip
    points = rao_of_tests(tests)
    assert points.units == ("m/m",)
    low, high = spectral.interval("heave")
    for frequency, response in zip(points.frequency, points["heave"], strict=True):
        i = int(np.argmin(np.abs(spectral.frequency - frequency)))
        if abs(spectral.frequency[i] - frequency) < 1 / 240.0:
            expected = abs(heave(2 * math.pi * spectral.frequency[i]))
            assert abs(response) == pytest.approx(abs(heave(2 * math.pi * frequency)), rel=1e-3)
            assert low[i] * 0.98 <= expected <= high[i] * 1.02
    np.testing.assert_allclose(np.abs(spectral.rao["heave"]), np.abs(heave(2 * np.pi * spectral.frequency)), rtol=0.1)
    peak = spectral.frequency[np.argmax(np.abs(spectral.rao["heave"]))]
    assert peak == pytest.approx(0.235, abs=1 / 240.0)  # Serret (2019), table 6.3; section 6.7 says 0.24 Hz


def test_intervals_of_spectra_hold_what_they_say():
    """With noise on the response 90 % circles hold the true operator at 90 % of the frequencies.

    The noise makes the ratio of the spectra too large; the linear part is free of it.
    """
    held, ratio, coherence = [], [], []
    for seed in (1, 2, 3):
        time, elevation, motion = sea(1800.0, seed)
        noisy = motion + np.random.default_rng(seed).normal(0, 0.06, time.size)
        found = spectral_rao((time, elevation), {"heave": (time, noisy)}, segment=60.0)
        away = np.abs(2 * np.pi * found.frequency / W - 1) > 0.15  # the window smears the resonance itself
        true = heave(2 * np.pi * found.frequency)
        held.append((np.abs(found.response[:, 0] - true) <= found.radius("heave", 0.9))[away].mean())
        ratio.append((found.ratio[:, 0] / np.abs(true))[away].mean())
        coherence.append(found.coherence[away, 0].mean())
    assert 0.8 < np.mean(held) < 0.97
    assert np.mean(ratio) > 1.3 and np.mean(coherence) < 0.8


def test_segments_must_fit():
    time, elevation, motion = sea(60.0)
    with pytest.raises(ModelError, match="segments of 90 s do not fit"):
        spectral_rao((time, elevation), {"heave": (time, motion)}, segment=90.0)
    one = spectral_rao((time, elevation), {"heave": (time, motion)}, segment=60.0)
    with pytest.raises(ModelError, match="one periodogram has no confidence"):
        one.radius("heave")
    with pytest.raises(ModelError, match="are not at the same times"):
        spectral_rao((time, elevation), {"heave": (time + 0.01, motion)}, segment=20.0)


def test_agreement_of_two_records():
    time = np.arange(0.0, 100.0, 0.1)
    test = Series(time, 2.0 + np.sin(time), "m", "surge")
    late = Series(time, 2.0 + 0.9 * np.sin(time - 0.2), "m", "surge")
    found = agreement(late, test)
    assert found.correlation == pytest.approx(math.cos(0.2), rel=1e-3)
    assert found.rmse == pytest.approx(math.sqrt((1 + 0.81 - 1.8 * math.cos(0.2)) / 2), rel=1e-2)
    assert found.rmse_of_std == pytest.approx(found.rmse / (1 / math.sqrt(2)), rel=1e-2)
    assert found.rmse_of_range == pytest.approx(found.rmse / 2, rel=1e-2)
    coarse = Series(time[::2], test.values[::2], "m", "surge")
    assert agreement(test, coarse, window=(10, 50)).rmse < 1e-12
    with pytest.raises(ModelError, match="no time in common"):
        agreement(Series(time + 200, test.values), test)
    with pytest.raises(ModelError, match="is in m, and the other record in deg"):
        agreement(Series(time, test.values, "deg", "pitch"), test)


@pytest.mark.parametrize(
    ("denominator", "printed"), [("larger", 5.91), ("test", -5.91), ("smaller", -6.28), ("mean", -6.09)]
)
def test_percent_differences_say_over_what(denominator, printed):
    """Heave damping of Serret (2019), table 6.3: 4.14e-3 simulated, 4.40e-3 measured, 5.91 % printed."""
    assert abs(percent_difference(4.14e-3, 4.40e-3, denominator)) == pytest.approx(abs(printed), abs=0.006)


def test_a_denominator_is_one_of_four():
    with pytest.raises(ModelError, match="not 'max'"):
        percent_difference(1.0, 2.0, "max")


def test_results_are_compared_over_time():
    time = np.arange(0.0, 50.0, 0.1)
    run = Result(time, {"surge": np.sin(time), "pitch": np.cos(time)}, {"surge": "m", "pitch": "deg"})
    test = Result(time, {"surge": 100 * np.sin(time - 0.1), "yaw": np.cos(time)}, {"surge": "cm", "yaw": "deg"})
    (found,) = compare_over_time(run, test, discard=10.0)
    assert (found.name, found.unit) == ("surge", "m")
    assert found.correlation == pytest.approx(math.cos(0.1), rel=1e-3)
    assert found.rmse == pytest.approx(2 * math.sin(0.05) / math.sqrt(2), rel=0.05)
    with pytest.raises(ModelError, match="no channel in common"):
        compare_over_time(run, Result(time, {"heave": np.sin(time)}, {"heave": "m"}))


@pytest.mark.parametrize(("of", "percent"), [("value", 25.0), ("larger", 20.0), ("smaller", 25.0), ("mean", 200 / 9)])
def test_lights_say_over_what(of, percent):
    time = np.arange(0.0, 10.0, 0.1)
    one, other = (Result(time, {"surge": size * np.sin(time)}, {"surge": "m"}) for size in (1.25, 1.0))
    found = compare_results(one, other, relative_to=of)
    assert found["surge", "std"].percent == pytest.approx(percent)
    with pytest.raises(ModelError, match="to the 'larger', .*not to 'max'"):
        compare_results(one, other, relative_to="max")


def test_spectra_of_a_run_are_its_linear_model():
    """A moored spar without drag in small waves: spectra of its run, and the linear model about still water.

    The sea repeats itself with the segments, so that only the free motions of the start are left: 2 % of the peak.
    """
    model = fw.load("oc3_spar_rigid", set={
        "wind.kind": "none", "platform.drag.drag_coefficient": 0.0, "sea.significant_wave_height": 0.2,
        "sea.peak_period": 12.0, "sea.repetition_period": 512.0,
    })  # fmt: skip
    plant = model.compile()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # the sea repeats itself: that is wanted
        run = plant.simulate(2048.0, output_step=0.5, solver="fixed", step=0.1)
    records = {name: run[name] for name in ("heave", "pitch")}
    found = spectral_rao(run["wave_elevation"], records, segment=512.0, discard=1024.0, window="boxcar")
    linear = fw.linear_rao(model, found.frequency, outputs=["heave", "pitch"])
    for name in records:
        largest = np.abs(linear[name]).max()
        np.testing.assert_allclose(found.rao[name], linear[name], atol=0.03 * largest, err_msg=name)
        assert found.rao.unit(name) == linear.unit(name)
