"""Fatigue from spectra: numbers computed elsewhere, integrals by quadrature, and rainflow counts of Gaussian series."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.integrate import quad

from fowtlib.analysis.fatigue import (
    SNCurve,
    TubeSection,
    damage_equivalent_load,
    dirlik,
    narrow_band,
    rainflow_cycles,
    sn_curve,
    tovo_benasciutti,
)
from fowtlib.analysis.series import Series
from fowtlib.analysis.spectra import Spectrum, power_spectrum, realisation
from fowtlib.language.errors import ModelError

METHODS = (narrow_band, dirlik, tovo_benasciutti)
STEEL = SNCurve(3.0, 12.164, name="one slope")


def bands(*parts, step=1e-5, unit="MPa") -> Spectrum:
    """Flat densities as (from Hz, to Hz, density per Hz)."""
    highest = max(part[1] for part in parts)
    frequency = (np.arange(int(round(highest / step))) + 0.5) * step
    density = np.zeros_like(frequency)
    for low, high, level in parts:
        density[(frequency > low) & (frequency < high)] = level
    return Spectrum(frequency, density, unit, "flat")


def circular(*parts) -> Spectrum:
    """The same with rad/s."""
    spectrum = bands(*parts)
    return Spectrum(spectrum.frequency / (2 * np.pi), spectrum.density * 2 * np.pi, spectrum.unit, spectrum.name)


# Computed independently with NumPy and SciPy; m = 3, log K = 12.164, one hour, MPa^2 s/rad over rad/s.
def test_damage_of_one_flat_band():
    spectrum = circular((0.2, 1.0, 1000.0))
    assert dirlik(spectrum).damage(STEEL, 3600.0) == pytest.approx(1.55353e-4, rel=1e-5)
    assert narrow_band(spectrum).damage(STEEL, 3600.0) == pytest.approx(1.71862e-4, rel=1e-5)
    law = dirlik(spectrum)
    np.testing.assert_allclose(law.weights, [0.10456, 0.17926, 0.71618], atol=1e-5)  # G1, G2, G3
    size = 2 * math.sqrt(2 * spectrum.moment(0))
    assert law.scales[1] / size == pytest.approx(0.55610, abs=1e-5)  # R
    assert law.scales[0] / size * math.sqrt(2) == pytest.approx(0.13070, abs=2e-5)  # Q
    assert spectrum.irregularity == pytest.approx(0.82680, abs=1e-5)


def test_damage_of_two_flat_bands():
    spectrum = circular((0.1, 0.2, 2000.0), (2.5, 2.7, 200.0))
    assert dirlik(spectrum).damage(STEEL, 3600.0) == pytest.approx(1.63537e-5, rel=1e-5)
    assert narrow_band(spectrum).damage(STEEL, 3600.0) == pytest.approx(4.70359e-5, rel=1e-5)


# Likewise, equivalent loads at 1 Hz for m = 3, 4 and 10; the last column is rainflow counting of long Gaussian series.
ONE = ((0.1, 0.2, 1.0),)
TWO = ((0.02, 0.04, 50.0), (0.28, 0.32, 5.0))


@pytest.mark.parametrize(
    "parts, rates, wanted, narrow",
    [
        (ONE, (0.15275, 0.16301, 0.93709), (0.5205, 0.6585, 1.1891), (0.5257, 0.6650, 1.1964)),
        (TWO, (0.1257, 0.29369, 0.42799), (1.3299, 1.7763, 3.7153), (1.7066, 2.1939, 4.0643)),
    ],
)
def test_equivalent_loads_of_flat_bands(parts, rates, wanted, narrow):
    spectrum = bands(*parts)
    found = (spectrum.up_crossing_rate, spectrum.maxima_rate, spectrum.irregularity)
    np.testing.assert_allclose(found, rates, rtol=1e-4)
    np.testing.assert_allclose(dirlik(spectrum).equivalent_load((3, 4, 10)), wanted, rtol=1e-4)
    np.testing.assert_allclose(narrow_band(spectrum).equivalent_load((3, 4, 10)), narrow, rtol=1e-4)


def test_the_narrow_band_in_closed_form():
    """D = T nu / K (2 sqrt(2 m0))^m Gamma(1 + m/2)."""
    spectrum = bands((0.1, 0.11, 1000.0))
    rate, variance = spectrum.up_crossing_rate, spectrum.moment(0)
    by_hand = 3600 * rate / 10**12.164 * (2 * math.sqrt(2 * variance)) ** 3 * math.gamma(2.5)
    assert narrow_band(spectrum).damage(STEEL, 3600.0) == pytest.approx(by_hand, rel=1e-12)
    size = 2 * math.sqrt(2 * variance)
    for m in (1, 3, 7.5):
        wanted = (rate * size**m * math.gamma(1 + m / 2)) ** (1 / m)
        assert narrow_band(spectrum).equivalent_load(m) == pytest.approx(wanted, rel=1e-12)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("level", [0.01, 1.0, 100.0, 1e4])
def test_two_slopes_against_quadrature(method, level):
    """From stresses far below the knee to far above it."""
    curve = sn_curve("D")
    law = method(bands((0.02, 0.04, 1000.0 * level), (0.28, 0.32, 200.0 * level)))
    knee = curve.knee / 1e6
    numbers = [
        quad(lambda s: float(law.density(s) / curve.endurance(s * 1e6)), low, high, limit=400, epsabs=0, epsrel=1e-9)[0]
        for low, high in ((0, min(knee, 60 * law.scales.max())), (knee, knee + 60 * law.scales.max()))
    ]
    assert law.damage(curve, 3600.0) == pytest.approx(3600 * law.rate * sum(numbers), rel=1e-6)


@pytest.mark.parametrize("method", METHODS)
def test_the_laws_are_distributions(method):
    law = method(bands(*TWO))
    for order, wanted in ((0, law.weights.sum()), (1, law.moment(1)), (4, law.moment(4))):
        found = quad(lambda s, n=order: float(s**n * law.density(s)), 0, 60 * law.scales.max(), limit=400)[0]
        assert found == pytest.approx(wanted, rel=1e-6)
    assert 0.3 < law.weights.sum() <= 1 + 1e-12
    parts = law.moment(3, 0.0, 2.0) + law.moment(3, 2.0, 5.0) + law.moment(3, 5.0)
    assert parts == pytest.approx(law.moment(3), rel=1e-12)


@pytest.mark.parametrize("method", METHODS)
def test_one_slope_is_the_limit_of_two(method):
    law = method(bands((0.02, 0.04, 5e4), (0.28, 0.32, 5e3)))
    same = SNCurve(3.0, 12.164, 3.0 + 1e-9, 12.164 + 1e-9)
    assert law.damage(same, 3600.0) == pytest.approx(law.damage(STEEL, 3600.0), rel=1e-6)
    scaled = method(bands((0.02, 0.04, 4 * 5e4), (0.28, 0.32, 4 * 5e3)))
    assert scaled.damage(STEEL, 3600.0) == pytest.approx(8 * law.damage(STEEL, 3600.0), rel=1e-9)
    assert scaled.equivalent_load(5) == pytest.approx(2 * law.equivalent_load(5), rel=1e-9)
    in_pascal = bands((0.02, 0.04, 5e16), (0.28, 0.32, 5e15), unit="Pa")
    assert method(in_pascal).damage(STEEL, 3600.0) == pytest.approx(law.damage(STEEL, 3600.0), rel=1e-9)


@pytest.mark.parametrize("width", [1e-2, 1e-3, 1e-4])
def test_all_agree_on_a_narrow_spectrum(width):
    spectrum = bands((0.1, 0.1 * (1 + width), 1.0), step=0.1 * width / 50)
    wanted = narrow_band(spectrum).equivalent_load(4)
    for method in (dirlik, tovo_benasciutti):
        assert method(spectrum).equivalent_load(4) == pytest.approx(wanted, rel=2e-3)
    line = Spectrum(np.array([0.0, 0.1, 0.2]), np.array([0.0, 5.0, 0.0]))
    for method in METHODS:
        assert method(line).equivalent_load(4) == pytest.approx(narrow_band(line).equivalent_load(4))


def counted(spectrum: Spectrum, exponents, seeds=20, duration=20000.0, step=0.1) -> tuple[np.ndarray, np.ndarray]:
    """Rainflow counting of Gaussian series: mean and standard error of equivalent loads over the seeds."""
    loads = [
        damage_equivalent_load(realisation(spectrum, duration, step, seed=seed), exponents) for seed in range(seeds)
    ]
    return np.mean(loads, axis=0), np.std(loads, axis=0, ddof=1) / math.sqrt(seeds)


@pytest.mark.parametrize(
    "parts, simulated, model_error",
    [(ONE, (0.5221, 0.6600, 1.1958), 0.006), (TWO, (1.372, 1.845, 3.84), 0.04)],
)
def test_against_rainflow_of_gaussian_series(parts, simulated, model_error):
    """The simulation agrees with another one, by digits and the scatter of seeds; Dirlik by its known error."""
    spectrum = bands(*parts, step=5e-5)
    mean, error = counted(spectrum, (3, 4, 10))
    assert np.all(error[:2] < 0.01 * mean[:2]) and error[2] < 0.02 * mean[2]
    assert np.all(np.abs(mean - simulated) < 3 * error + 0.002 * mean)
    for method in (dirlik, tovo_benasciutti):
        found = method(spectrum).equivalent_load((3, 4, 10))
        assert np.all(np.abs(found - mean) < 3 * error + model_error * mean)
    assert np.all(narrow_band(spectrum).equivalent_load((3, 4, 10)) > mean - 3 * error)


def test_the_narrow_band_is_exact_for_a_narrow_spectrum():
    spectrum = bands((0.1, 0.105, 1.0), step=5e-5)
    mean, error = counted(spectrum, (3, 4))
    assert np.all(np.abs(narrow_band(spectrum).equivalent_load((3, 4)) - mean) < 3 * error + 0.004 * mean)


def test_two_slopes_against_rainflow_of_gaussian_series():
    """Stress ranges on both sides of the knee of D."""
    spectrum = bands((0.05, 0.15, 2000.0), step=5e-5)
    series = [realisation(spectrum, 20000.0, 0.25, seed=seed) for seed in range(8)]
    damages = [sn_curve("D").damage(rainflow_cycles(each)) for each in series]
    mean, error = np.mean(damages), np.std(damages, ddof=1) / math.sqrt(8)
    found = dirlik(spectrum).damage(sn_curve("D"), 20000.0)
    assert error < 0.04 * mean
    assert abs(found - mean) < 3 * error + 0.04 * mean
    assert found < 0.95 * dirlik(spectrum).damage(STEEL, 20000.0)  # the second slope matters


def test_stress_from_the_spectrum_of_a_bending_moment():
    """The same as the spectrum of the stress, and its damage."""
    section = TubeSection(6.5, 0.027)
    moment = realisation(bands((0.05, 0.15, 4e15), step=5e-5, unit="N*m"), 20000.0, 0.5, seed=1)
    stress = Series(
        moment.time, section.stress(0.0 * moment.time, moment.values, 0 * moment.time, [np.pi / 2])[:, 0], "Pa"
    )
    one = power_spectrum(moment).scaled(section.bending, "Pa")
    two = power_spectrum(stress)
    np.testing.assert_allclose(one.density, two.density, rtol=1e-6, atol=1e-9 * two.density.max())
    assert dirlik(one).damage(sn_curve("D"), 3600) == pytest.approx(dirlik(two).damage(sn_curve("D"), 3600), rel=1e-9)


@pytest.mark.parametrize("method", METHODS)
def test_a_load_that_does_not_change(method):
    still = Spectrum(np.arange(5.0), np.zeros(5), "MPa")
    assert method(still).damage(STEEL, 3600.0) == 0.0
    assert method(still).equivalent_load(4) == 0.0
    np.testing.assert_array_equal(method(still).equivalent_load([4, 10]), [0.0, 0.0])


def message(action) -> str:
    with pytest.raises(ModelError) as caught:
        action()
    return str(caught.value)


def test_errors():
    law = dirlik(bands(*ONE, unit="kN m"))
    assert message(lambda: law.damage(STEEL, 600.0)) == (
        "flat is in kN m; an S-N curve takes stresses, in Pa or a multiple of it."
    )
    assert message(lambda: law.equivalent_load(-4)) == (
        "an exponent of an S-N curve is a number above 0, such as 4 or 10, not -4."
    )
    assert message(lambda: law.equivalent_load(4, frequency=0)) == (
        "the frequency of the equivalent cycles is above 0 Hz, not 0 Hz."
    )
    assert message(lambda: dirlik(bands(*ONE)).damage(STEEL, -1)) == "a duration is 0 s or longer, not -1 s."
    wrong = Spectrum(np.arange(3.0), np.array([0, np.nan, 1]), "Pa", "thrust")
    assert message(lambda: dirlik(wrong)) == "thrust: densities are finite numbers of 0 or more."
