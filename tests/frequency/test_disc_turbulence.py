"""Turbulence on rings that turn: sums of shares, limits, and a rotor in a random field of known waves."""

from __future__ import annotations

import numpy as np
import pytest

from fowtlib.components.environment.disc_turbulence import ring_shares, turning_density
from fowtlib.components.environment.turbulence import PlaneCoherence, coherence, kaimal

RADII, SPEED = np.array([15.0, 40.0, 60.0]), 12.0


def exponential(frequency, distance):
    return coherence(frequency, distance, SPEED)


def spectrum(omega):
    return kaimal(omega / (2 * np.pi), SPEED, 1.8) / (2 * np.pi)


def test_shares_of_all_orders_are_the_coherence_of_one_ray():
    frequency = np.array([1e-3, 0.02, 0.3])
    shares = ring_shares(frequency, RADII, np.arange(-48, 48), exponential).sum(axis=1)
    gaps = np.abs(RADII[:, None] - RADII)
    for f, total in zip(frequency, shares, strict=True):
        assert total == pytest.approx(exponential(f, gaps), rel=1e-2)


def test_slow_eddies_are_felt_whole_and_small_ones_are_averaged():
    whole, small = ring_shares([1e-6, 2.0], RADII, [0], lambda f, d: np.exp(-12 * f * d / SPEED))[:, 0]
    assert np.diag(whole) == pytest.approx(np.ones(3), abs=2e-3)
    assert np.diag(small).max() < 0.06


@pytest.mark.parametrize("speed", [0.003, 2.0, 12.0, 60.0])
def test_one_table_over_the_decay_of_coherence_stands_for_all_mean_speeds(speed):
    """Beside the coherence itself at the frequencies of each speed; at 3 mm/s it decays faster than the table goes."""
    omega, ways = np.geomspace(0.01, 10.0, 60), [PlaneCoherence(speed, 90.0), lambda f, r: coherence(f, r, speed)]
    for weights in (np.array([[0.2, 0.3, 0.5]]), None):  # of one sum, and of each ring
        found, wanted = (turning_density(omega, RADII, 1.2, spectrum, of, uniform=weights, once=weights) for of in ways)
        assert np.abs(found - wanted).max() < 1e-13 * np.abs(wanted).max()


def test_a_rotor_at_rest_and_one_of_very_many_blades_feel_the_mean_of_the_ring():
    omega = np.array([0.05, 0.5])
    found = turning_density(omega, RADII, 1.2, spectrum, exponential, blades=10)
    mean = ring_shares(omega / (2 * np.pi), RADII, [0], exponential)[:, 0] * spectrum(omega)[:, None, None]
    assert found[:, :3, :3].real == pytest.approx(mean, rel=2e-2)


def test_energy_moves_to_multiples_of_the_blade_passing():
    rotor_speed = 1.2
    omega = np.linspace(0.02, 9.0, 900)
    of_ring = turning_density(omega, [60.0], rotor_speed, spectrum, exponential)[:, 0, 0].real
    at = {k: of_ring[np.argmin(np.abs(omega - 3 * k * rotor_speed))] for k in (1, 2)}
    between = of_ring[np.argmin(np.abs(omega - 1.5 * rotor_speed * 3))]
    assert at[1] > 20 * between
    assert at[2] > 3 * between


def test_densities_are_those_of_spectra():
    found = turning_density(np.linspace(0.05, 5.0, 40), RADII, 1.2, spectrum, exponential)
    assert found == pytest.approx(found.conj().transpose(0, 2, 1))
    assert np.linalg.eigvalsh(found).min() > -1e-9 * np.abs(found).max()


def test_against_the_blades_of_a_rotor_in_one_wave_on_the_ring():
    """a_m exp(i m theta) of one order and one frequency: the blades feel it where the formula says."""
    rotor_speed, wave, order = 1.0, 0.4, 4
    time = 2 * np.pi / 0.1 * np.arange(4000) / 4000
    total = np.zeros(time.size)
    for blade in range(3):
        psi = rotor_speed * time + 2 * np.pi * blade / 3
        total += np.cos(psi) * np.cos(order * psi + wave * time) * 2 / 3
    line = np.abs(np.fft.rfft(total)) / time.size * 2
    frequency = 0.1 * np.arange(line.size)
    peaks = frequency[line > 0.5]
    assert peaks == pytest.approx([wave + 3 * rotor_speed])  # order 4 = 1 + 3: once shifted by three turns
