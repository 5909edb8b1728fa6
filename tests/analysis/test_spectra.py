"""Power spectra of signals whose spectra are known."""

from __future__ import annotations

import numpy as np
import pytest

from fowtlib.analysis.spectra import average, compare, power_spectrum
from fowtlib.language.errors import ModelError


def noise(seed: int = 1, count: int = 20000, step: float = 0.1) -> tuple[np.ndarray, np.ndarray]:
    return np.arange(count) * step, 3.0 + np.random.default_rng(seed).standard_normal(count)


def test_the_integral_is_the_variance():
    time, values = noise()
    spectrum = power_spectrum((time, values))
    assert spectrum.moment(0) == pytest.approx(values.var(), rel=1e-12)
    assert spectrum.std == pytest.approx(values.std(), rel=1e-12)
    assert spectrum.frequency[-1] == pytest.approx(5.0)


def test_white_noise_has_a_flat_density():
    spectrum = power_spectrum(noise(), segment=50)
    expected = 1.0 / 5.0  # variance 1 over 0 to 5 Hz
    np.testing.assert_allclose(spectrum.density[3:-3], expected, rtol=0.4)
    assert np.mean(spectrum.density[3:-3]) == pytest.approx(expected, rel=0.02)


def test_a_sine():
    time = np.arange(0, 1000, 0.1)
    spectrum = power_spectrum((time, 3 * np.sin(2 * np.pi * 0.1 * time)))
    assert spectrum.peak_frequency == pytest.approx(0.1)
    assert spectrum.moment(0) == pytest.approx(4.5)
    assert spectrum.significant_height == pytest.approx(4 * 3 / np.sqrt(2))
    assert spectrum.zero_crossing_period == pytest.approx(10.0)
    assert spectrum.moment(0, 0.09, 0.11) == pytest.approx(4.5)
    assert spectrum.moment(0, 0.2) == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize("segment", [None, 200.0])
def test_the_median_filter_keeps_the_level(segment):
    spectrum = power_spectrum(noise(count=40000), segment=segment)
    smooth = spectrum.median_filtered(15)
    assert smooth.moment(0) == pytest.approx(spectrum.moment(0), rel=0.03)
    assert smooth.density[10:-10].std() < 0.5 * spectrum.density[10:-10].std()
    if segment is None:  # the plain median of exponentially distributed values lies near ln 2 of their mean
        plain = spectrum.median_filtered(15, keep_level=False)
        assert plain.moment(0) == pytest.approx(0.72 * spectrum.moment(0), rel=0.03)
        assert power_spectrum(noise(count=40000), median=15).moment(0) == smooth.moment(0)


def test_seeds_average_to_the_target():
    mean = average([power_spectrum(noise(seed), median=15) for seed in range(4)])
    match = compare(mean, lambda f: np.full_like(f, 0.2), 0.5, 4.5)
    assert match.variance_ratio == pytest.approx(1.0, abs=0.03)
    assert match.deviation < 0.2


def test_the_beginning_can_be_left_out():
    time, values = noise()
    disturbed = np.where(time < 100, 1000.0, values)
    assert power_spectrum((time, disturbed), discard=100).std == pytest.approx(1.0, rel=0.02)


def test_errors():
    def message(action) -> str:
        with pytest.raises(ModelError) as caught:
            action()
        return str(caught.value)

    assert message(lambda: power_spectrum(([0, 1, 3, 4, 5], [1, 2, 3, 4, 5]), name="heave")) == (
        "heave: the points of time are not equally spaced: steps of 1 s to 2 s. "
        "Simulate with one output step, or interpolate first."
    )
    assert message(lambda: power_spectrum(noise(count=100), segment=60)) == (
        "the series: a segment of 60 s does not fit: the record has 100 points over 10 s, "
        "a segment takes 8 points or more."
    )
    assert message(lambda: power_spectrum(noise(), median=14)) == (
        "the median filter takes an odd order such as 15, not 14."
    )
    assert message(lambda: power_spectrum(noise(count=100), discard=20)) == (
        "the series: discarding 20 s leaves nothing of a record of 9.9 s."
    )
    assert message(lambda: average([power_spectrum(noise()), power_spectrum(noise(count=100))])) == (
        "spectra can be averaged when their frequencies agree: take records of equal length and step."
    )
