"""Linear waves against limits, independent formulas, the potential they come from, and statistics over seeds."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import quad
from scipy.stats import chi2

from fowtlib.components.environment import waves
from fowtlib.components.environment.waves import irregular_waves, jonswap, regular_waves, still_water, wave_number
from fowtlib.language import ModelError

G = waves.GRAVITY


# --- dispersion


@given(omega=st.floats(1e-4, 100), depth=st.floats(0.1, 1e4))
def test_dispersion_leaves_no_residual(omega, depth):
    k = float(wave_number(omega, depth))
    assert k * math.tanh(k * depth) == pytest.approx(omega**2 / G, rel=1e-13)


def test_dispersion_in_deep_and_shallow_water():
    assert wave_number(2.0, 1000.0) == pytest.approx(4 / G, rel=1e-14)
    assert wave_number(2.0, math.inf) == pytest.approx(4 / G, rel=1e-14)
    # k h = y^(1/2) (1 + y/6 + ...), y = omega^2 h / g
    y = 0.01**2 * 10 / G
    assert wave_number(0.01, 10.0) == pytest.approx(0.01 / math.sqrt(G * 10) * (1 + y / 6), rel=1e-8)
    assert wave_number([[0.0, 1.0]], 50.0).shape == (1, 2)
    assert wave_number(0.0, 50.0) == 0.0


def test_dispersion_of_a_tabulated_wave():
    # T = 10 s in 20 m: y = 0.80514 and k h = 1.03651 solves x tanh(x) = y (bisection by hand)
    k = float(wave_number(2 * math.pi / 10, 20.0))
    low, high = 0.5, 2.0
    for _ in range(60):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if middle * math.tanh(middle) < (0.2 * math.pi) ** 2 * 20 / G else (low, middle)
    assert k * 20 == pytest.approx(low, rel=1e-12)


def test_no_water_is_an_error():
    with pytest.raises(ModelError, match=r"^water depth must be positive, got 0 m$"):
        wave_number(1.0, 0.0)


# --- spectrum


def independent_jonswap(f, hs, tp, gamma):
    """The form of the reference and of IEC 61400-3, in Hz, with its fitted normalisation."""
    x = f * tp
    a = math.exp(-0.5 * ((x - 1) / (0.07 if x <= 1 else 0.09)) ** 2)
    return 0.3125 * hs**2 * tp * x**-5 * math.exp(-1.25 * x**-4) * (1 - 0.287 * math.log(gamma)) * gamma**a


@pytest.mark.parametrize("gamma", [1.0, 2.0, 3.3, 5.0])
def test_jonswap_against_the_formula_of_the_standard(gamma):
    for f in (0.06, 0.09, 0.1, 0.11, 0.15, 0.4):
        ours = float(jonswap(2 * math.pi * f, 6, 10, gamma)) * 2 * math.pi
        assert ours == pytest.approx(independent_jonswap(f, 6, 10, gamma), rel=3.5e-3)  # the fit is 0.3 % off


@settings(max_examples=15)
@given(hs=st.floats(0.1, 20), tp=st.floats(2, 25), gamma=st.floats(1, 7))
def test_jonswap_has_the_energy_of_its_height_and_its_peak(hs, tp, gamma):
    peak = 2 * math.pi / tp
    energy = sum(
        quad(lambda w: float(jonswap(w, hs, tp, gamma)), a * peak, b * peak, epsabs=0, epsrel=1e-10, limit=200)[0]
        for a, b in ((0.3, 1), (1, 2), (2, 300))
    )
    assert energy == pytest.approx(hs**2 / 16, rel=1e-8)
    omega = peak * np.linspace(0.5, 2, 1501)
    assert omega[np.argmax(jonswap(omega, hs, tp, gamma))] == pytest.approx(peak, rel=1e-3)


def test_jonswap_takes_gamma_from_the_steepness():
    assert waves.default_gamma(6, 10) == pytest.approx(math.exp(5.75 - 11.5 / math.sqrt(6)))
    assert waves.default_gamma(9, 3.59 * 3) == 5
    assert waves.default_gamma(9, 5.01 * 3) == 1
    assert jonswap([-1.0, 0.0, 1e-9, 0.01], 6, 10).tolist() == [0, 0, 0, 0]


# --- realisations


def test_components_lie_on_harmonics_of_the_repetition_period():
    sea = irregular_waves(6, 10, 320)
    n = sea.omega * 4096 / (2 * math.pi)
    np.testing.assert_allclose(n, np.rint(n), atol=1e-9)
    assert sea.omega[0] == pytest.approx(0.4 * 0.2 * math.pi, rel=3e-3)
    assert sea.omega[-1] == pytest.approx(5 * 0.2 * math.pi, rel=3e-3)
    assert sea.period == 4096 and sea.samples == 16384


def test_deterministic_amplitudes_hold_the_energy_but_for_the_cut_off():
    sea = irregular_waves(6, 10, 320, random_amplitudes=False, gamma=3.3)
    lost = quad(lambda w: float(jonswap(w, 6, 10, 3.3)), sea.omega[-1], 100, limit=300)[0]
    assert lost / (36 / 16) == pytest.approx(1.3e-3, rel=0.02)
    assert sea.variance == pytest.approx(36 / 16 - lost, rel=1e-5)
    assert sea.series(np.ones(len(sea))).var() == pytest.approx(sea.variance, rel=1e-12)


def test_random_amplitudes_average_to_the_spectrum():
    """With random amplitudes a^2/(S d_omega) is chi-square with 2 degrees of freedom, independent for every harmonic.

    The sum over N seeds and a band of n harmonics has 2 N n degrees; bounds at 1e-5 of probability for each band.
    """
    seeds, step = 40, 2 * math.pi / 4096
    seas = [irregular_waves(6, 10, 320, gamma=3.3, seed=seed) for seed in range(seeds)]
    energy = np.mean([sea.amplitude**2 / 2 for sea in seas], axis=0)
    target = jonswap(seas[0].omega, 6, 10, 3.3) * step
    for band in np.array_split(np.arange(len(target)), 30):
        degrees = 2 * seeds * len(band)
        low, high = chi2.ppf([1e-5, 1 - 1e-5], degrees) / degrees
        assert low < np.mean(energy[band] / target[band]) < high
    # the variance: sum of S d_omega chi2_2/2; its relative standard error is sqrt(sum S^2 / N) / sum S; 4.4 of them
    error = math.sqrt(np.sum(target**2) / seeds) / target.sum()
    assert np.mean([sea.variance for sea in seas]) == pytest.approx(target.sum(), rel=4.4 * error)


def test_periodogram_of_a_realisation_is_its_own_energy():
    sea = irregular_waves(6, 10, 320, seed=3)
    eta = sea.series(np.ones(len(sea)))[:, 0]
    energy = 2 * np.abs(np.fft.rfft(eta) / len(eta)) ** 2
    number = np.rint(sea.omega * sea.period / (2 * math.pi)).astype(int)
    np.testing.assert_allclose(energy[number], sea.amplitude**2 / 2, atol=1e-14)
    assert np.delete(energy, number).max() < 1e-25


def test_elevation_of_a_random_sea_is_gaussian():
    eta = np.concatenate([irregular_waves(6, 10, 320, seed=s).series(np.ones(1885))[:, 0] for s in range(20)])
    # some 20 * 4096 s / 10 s independent values: standard error of the kurtosis sqrt(24 / 8000) = 0.055, skewness 0.027
    z = eta / eta.std()
    assert abs(np.mean(z**3)) < 0.12
    assert np.mean(z**4) == pytest.approx(3, abs=0.25)


def test_series_is_the_sum_of_the_harmonics():
    sea = irregular_waves(3, 8, 40, heading=0.5, repetition_period=600)
    transfer = np.column_stack([np.ones(len(sea)), 1j * sea.omega, sea.elevation_transfer([[120.0, -40.0]])[:, 0]])
    series = sea.series(transfer)
    time = np.arange(len(series)) * sea.period / len(series)
    some = [0, 1, 17, len(series) - 1]
    np.testing.assert_allclose(series[some], sea.evaluate(transfer, time[some]), atol=1e-12)
    along = 120 * math.cos(0.5) - 40 * math.sin(0.5)
    direct = np.sum(sea.amplitude * np.cos(sea.omega * time[17] - sea.wave_number * along + sea.phase))
    assert series[17, 2] == pytest.approx(direct, abs=1e-12)


def test_seeds():
    one, same, other = (irregular_waves(6, 10, 320, seed=seed) for seed in (1, 1, 2))
    np.testing.assert_array_equal(one.amplitude, same.amplitude)
    np.testing.assert_array_equal(one.phase, same.phase)
    a, b = (sea.series(np.ones(len(sea)))[:, 0] for sea in (one, other))
    # spectra of a bandwidth of about 0.02 Hz: about 4096 * 0.02 * 2 independent pairs, standard error 0.08
    assert abs(np.corrcoef(a, b)[0, 1]) < 0.3


def test_the_noise_belongs_to_the_harmonic():
    long, short = irregular_waves(6, 12, 320, seed=5), irregular_waves(6, 10, 320, seed=5)
    common = np.intersect1d(np.rint(long.omega * 1e6), np.rint(short.omega * 1e6))
    assert len(common) > 1000
    pick = [np.isin(np.rint(sea.omega * 1e6), common) for sea in (long, short)]
    np.testing.assert_array_equal(long.phase[pick[0]], short.phase[pick[1]])


def test_regular_and_still():
    wave = regular_waves(6, 10, 320)
    assert (len(wave), wave.amplitude[0], wave.period) == (1, 3.0, 10)
    assert wave.evaluate(np.ones(1), [0.0, 5.0])[:, 0] == pytest.approx([3, -3])
    assert len(still_water(320)) == 0
    assert still_water(320).variance == 0
    assert still_water(320).series(np.zeros((0, 3))).shape == (16, 3)


def test_wrong_sea_states():
    with pytest.raises(ModelError, match=r"^repetition period 60 s is too short for a peak period of 10 s; take"):
        irregular_waves(6, 10, 320, repetition_period=60)
    with pytest.raises(ModelError, match="peak period 0 s must be positive"):
        irregular_waves(6, 0, 320)
    with pytest.raises(ModelError, match=r"^wave period must be positive, got 0 s$"):
        regular_waves(6, 0, 320)
    with pytest.raises(ModelError, match=r"^point at z = -21 m lies below the sea bed at -20 m$"):
        regular_waves(2, 8, 20).velocity_transfer([[0, 0, -21.0]])
    with pytest.raises(ValueError, match="one row a component"):
        regular_waves(2, 8, 20).series(np.ones((2, 1)))


# --- kinematics


def test_kinematics_in_deep_water():
    wave = regular_waves(4, 9, 5000)
    w, k = wave.omega[0], wave.wave_number[0]
    u = wave.velocity_transfer([[0, 0, -30.0], [0, 0, -5000.0]])[0]
    np.testing.assert_allclose(u[0], [w * math.exp(-30 * k), 0, 1j * w * math.exp(-30 * k)], rtol=1e-12)
    assert np.abs(u[1]).max() < 1e-100  # and no overflow at k h = 250


def test_kinematics_in_shallow_water():
    wave = regular_waves(1, 600, 10)  # k h = 0.01
    w, k = wave.omega[0], wave.wave_number[0]
    u = wave.velocity_transfer([[0, 0, z] for z in (0.0, -5.0, -10.0)])[0]
    np.testing.assert_allclose(u[:, 0], w / (k * 10), rtol=1e-4)
    np.testing.assert_allclose(u[:, 2], 1j * w * np.array([1, 0.5, 0]), atol=1e-4 * w)


@given(
    period=st.floats(2, 25),
    depth=st.floats(5, 500),
    heading=st.floats(-math.pi, math.pi),
    height=st.floats(0.05, 0.95),
    time=st.floats(0, 100),
)
def test_kinematics_are_the_gradient_of_the_potential(period, depth, heading, height, time):
    """Velocity is the gradient of -a omega/k cosh(k(z+h))/sinh(kh) sin(omega t - k x'), and free of divergence."""
    wave = regular_waves(2, period, depth, heading=heading)
    w, k = wave.omega[0], wave.wave_number[0]
    point = np.array([3.0, -7.0, -height * min(depth, 2 / k)])

    def potential(x, y, z):
        along = x * math.cos(heading) + y * math.sin(heading)
        shape = np.longdouble(np.cosh(np.longdouble(k * (z + depth)))) / np.sinh(np.longdouble(k * depth))
        return -float(w / k * shape) * math.sin(w * time - k * along)

    step = 1e-4 / k
    velocity = wave.evaluate(wave.velocity_transfer(point[None])[:, 0], time)[0]
    gradient = [(potential(*(point + e)) - potential(*(point - e))) / (2 * step) for e in step * np.eye(3)]
    np.testing.assert_allclose(velocity, gradient, atol=1e-6 * w)
    divergence = 0.0
    for axis, e in enumerate(step * np.eye(3)):
        ahead, behind = (wave.evaluate(wave.velocity_transfer((point + d)[None])[:, 0], time)[0] for d in (e, -e))
        divergence += (ahead - behind)[axis] / (2 * step)
    assert abs(divergence) < 1e-6 * w * k
    later, earlier = (wave.evaluate(wave.velocity_transfer(point[None])[:, 0], time + d)[0] for d in (1e-4, -1e-4))
    acceleration = wave.evaluate(wave.acceleration_transfer(point[None])[:, 0], time)[0]
    np.testing.assert_allclose(acceleration, (later - earlier) / 2e-4, atol=1e-6 * w**2)


def test_surface_and_bed():
    """The surface moves with the elevation, the bed lets nothing through, above the water nothing moves."""
    sea = irregular_waves(4, 9, 50, heading=0.7)
    u = sea.velocity_transfer([[10.0, 20.0, z] for z in (0.0, -50.0, 0.001)])
    np.testing.assert_allclose(u[:, 0, 2], 1j * sea.omega * sea.elevation_transfer([[10.0, 20.0]])[:, 0], rtol=1e-12)
    np.testing.assert_allclose(u[:, 1, 2], 0, atol=1e-15)
    assert not u[:, 2].any()
    np.testing.assert_allclose(u[:, 0, 1], u[:, 0, 0] * math.tan(0.7), rtol=1e-12)
