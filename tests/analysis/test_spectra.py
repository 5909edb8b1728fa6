"""Power spectra of signals whose spectra are known."""

from __future__ import annotations

import numpy as np
import pytest

from fowtlib.analysis.spectra import Spectrum, average, compare, power_spectrum, realisation
from fowtlib.analysis.statistics import up_crossings
from fowtlib.language.errors import ModelError


def noise(seed: int = 1, count: int = 20000, step: float = 0.1) -> tuple[np.ndarray, np.ndarray]:
    return np.arange(count) * step, 3.0 + np.random.default_rng(seed).standard_normal(count)


def test_the_integral_is_the_variance():
    time, values = noise()
    spectrum = power_spectrum((time, values))
    assert spectrum.moment(0) == pytest.approx(values.var(), rel=1e-12)
    assert spectrum.std == pytest.approx(values.std(), rel=1e-12)
    assert spectrum.frequency[-1] == pytest.approx(5.0)


@pytest.mark.parametrize("window", [None, "boxcar", "hamming"])
def test_the_integral_of_the_average_is_the_variance(window):
    """Within the scatter of what the window weighs little, for noise and for a sine beside it."""
    time, values = noise(count=40000)
    values = values + 2 * np.sin(2 * np.pi * 0.2 * time)
    spectrum = power_spectrum((time, values), segment=100, window=window)
    assert spectrum.moment(0) == pytest.approx(values.var(), rel=0.01)
    assert spectrum.unit == "1" and spectrum.frequency[0] == 0.0


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


def test_the_median_filter_keeps_slow_motions():
    """A density that rises towards 0 Hz keeps its level there; with zeros below 0 Hz it would be cut off."""
    target = Spectrum(np.arange(2001) * 0.0005, 1.0 / (1.0 + (np.arange(2001) * 0.0005 / 0.05) ** 2), "m", "drift")
    spectra = [power_spectrum(realisation(target, 4000.0, 0.5, seed=seed)) for seed in range(200)]
    plain, smooth = average(spectra), average([spectrum.median_filtered(15) for spectrum in spectra])
    low = slice(1, 7)  # beside 0 Hz
    expected = target.density[1] * 6
    assert plain.density[low].sum() == pytest.approx(expected, rel=0.06)
    assert smooth.density[low].sum() == pytest.approx(expected, rel=0.06)
    assert smooth.moment(0) == pytest.approx(plain.moment(0), rel=0.01)


def test_rates_of_a_flat_band():
    """m_n = (b^(n+1) - a^(n+1)) / (n + 1) between a and b."""
    f = (np.arange(20000) + 0.5) * 1e-5
    spectrum = Spectrum(f, np.where(f > 0.1, 1.0, 0.0))
    m0, m2, m4 = (((0.2 ** (n + 1)) - 0.1 ** (n + 1)) / (n + 1) for n in (0, 2, 4))
    assert spectrum.moment(2) == pytest.approx(m2, rel=1e-6)
    assert spectrum.up_crossing_rate == pytest.approx(np.sqrt(m2 / m0), rel=1e-6)
    assert spectrum.maxima_rate == pytest.approx(np.sqrt(m4 / m2), rel=1e-6)
    assert spectrum.irregularity == pytest.approx(m2 / np.sqrt(m0 * m4), rel=1e-6)
    assert spectrum.zero_crossing_period == pytest.approx(1 / spectrum.up_crossing_rate)


def test_realisations_have_the_spectrum_and_count_as_gaussian():
    f = (np.arange(4000) + 0.5) * 5e-5
    target = Spectrum(f, np.where(f > 0.1, 10.0, 0.0), "kN", "tension")
    runs = [realisation(target, 20000.0, 0.5, seed=seed, mean=3.0) for seed in range(20)]
    values = np.stack([run.values for run in runs])
    assert runs[0].unit == "kN" and runs[0].name == "tension, seed 0"
    assert values.mean() == pytest.approx(3.0, abs=1e-9)
    assert values.var(axis=1).mean() == pytest.approx(1.0, abs=0.02)
    assert np.mean(((values - 3.0) / values.std()) ** 4) == pytest.approx(3.0, abs=0.1)
    rate = np.mean([up_crossings(run).rate for run in runs])
    assert rate == pytest.approx(target.up_crossing_rate, rel=0.005)
    mean = average([power_spectrum(run, segment=2000.0) for run in runs])
    match = compare(mean, lambda f: np.full_like(f, 10.0), 0.105, 0.195)
    assert match.variance_ratio == pytest.approx(1.0, abs=0.03) and match.deviation < 0.1
    np.testing.assert_array_equal(realisation(target, 20000.0, 0.5, seed=3, mean=3.0).values, runs[3].values)


def test_errors_of_realisations():
    f = np.arange(101) * 0.01
    target = Spectrum(f, np.ones(101), "m", "sea")

    def message(action) -> str:
        with pytest.raises(ModelError) as caught:
            action()
        return str(caught.value)

    assert message(lambda: realisation(target, 50.0, 0.1, seed=1)) == (
        "sea has a density every 0.01 Hz; a series of 50 s would take one every 0.02 Hz and miss what lies between. "
        "Take 100 s or more."
    )
    assert message(lambda: realisation(target, 200.0, 1.0, seed=1)) == (
        "50 % of the variance of sea lies above 0.5 Hz, which steps of 1 s cannot follow; take shorter ones."
    )
    assert message(lambda: realisation(target, 200.0, 0.0, seed=1)) == (
        "a series takes a duration and a step above 0 s, not 200 s and 0 s."
    )
    assert message(lambda: realisation(target, 2.0, 1.0, seed=1)) == (
        "a series of 2 s in steps of 1 s is too short; it takes 8 steps or more."
    )
