"""Azimuths of a rotor whose speed is random and depends on the azimuth, against closed forms and against series."""

from __future__ import annotations

import numpy as np
import pytest

from fowtlib.frequency.lines import RandomSpeed
from fowtlib.frequency.lingering import Lingering

FREQUENCY = np.sort(np.concatenate([np.geomspace(1e-4, 3.0, 400), np.linspace(2e-3, 3e-2, 300)]))
EDGES = np.linspace(-0.2025, 0.1975, 81)  # no line at one of them


def band(low: float, high: float, variance: float) -> np.ndarray:
    """A density of this variance between two frequencies."""
    inside = np.where((low < FREQUENCY) & (high > FREQUENCY), 1.0, 0.0)
    return inside * variance / np.trapezoid(inside, FREQUENCY)


def lingering(speed: float, density: np.ndarray, by_azimuth: dict[int, complex], orders: int = 12) -> Lingering:
    v = np.zeros(orders, dtype=complex)
    for n, value in by_azimuth.items():
        v[n - 1] = value
    return Lingering(RandomSpeed(speed, FREQUENCY, density), v)


def of_order(found: Lingering, n: int, edges: np.ndarray) -> np.ndarray:
    """What the parts of the axis have of one order."""
    (own,) = [parts[:, k, k].real for orders, parts in found.spectra(edges) for k in np.flatnonzero(orders == n)]
    return own


@pytest.mark.parametrize("n", [1, 3])
def test_where_no_azimuth_has_its_speed_the_lines_are_those_of_a_random_speed(n):
    density = band(1e-3, 0.3, 0.03**2)
    found = lingering(-0.02, density, {}, orders=3)
    line = found.speed.line(n)
    shares = np.histogram(line.omega / (2 * np.pi), EDGES, weights=line.share)[0]
    assert of_order(found, n, EDGES) == pytest.approx(shares, abs=0.03 * shares.max())
    assert not found.matters


@pytest.mark.parametrize("speed", [0.02, -0.02])
def test_a_speed_that_is_hardly_random_leaves_the_rotor_where_it_is_slow(speed):
    """V = W + a cos 3 psi, a density like 1/V: E[exp(3 i psi)] = (sqrt(W^2 - a^2) - |W|) / a sign W, and its square."""
    a = 0.012
    found = lingering(speed, band(1e-3, 0.3, 0.002**2), {3: a / 2})
    wanted = (np.sqrt(speed**2 - a**2) - abs(speed)) / (a * np.sign(speed))
    assert found.step == 3
    assert found.means[3] == pytest.approx(wanted, abs=0.01)
    assert found.means[6] == pytest.approx(wanted**2, abs=0.01)
    mean = speed + 2 * (found.by_azimuth[2] * found.means[3]).real
    assert mean == pytest.approx(np.sign(speed) * np.sqrt(speed**2 - a**2), rel=0.01)
    assert found.matters


def test_a_speed_that_is_very_random_does_not_linger():
    assert not lingering(-0.02, band(1e-3, 0.3, 1.0), {3: 0.006}).matters


def test_nothing_random_is_not_taken():
    found = lingering(-0.02, np.zeros_like(FREQUENCY), {3: 0.006})
    assert not found.means[1:].any()
    assert not found.matters


def test_covariances_are_whole():
    """In all, an order has 1 - |E z|^2; what ties orders together is no more than both of them have."""
    found = lingering(-0.02, band(1e-3, 0.3, 0.025**2), {3: 0.004 + 0.003j, 6: 0.003j})
    for orders, parts in found.spectra(np.array([-1.1, -0.01, 0.0, 0.01, 1.1])):
        whole = parts.sum(axis=0)
        for k, n in enumerate(orders.tolist()):
            assert whole[k, k] == pytest.approx(1 - abs(found.means[abs(n)]) ** 2, abs=1e-9)
        for part in parts:
            assert part == pytest.approx(part.conj().T, abs=1e-12)
            assert np.linalg.eigvalsh(part).min() > -1e-12


def test_what_lingers_is_that_of_series():
    """Means of the phasors, and what an oscillator answers to a load of two of them, in 64 long series.

    Numbers are those of an idling rotor of 5 MW in a storm, the oscillator is like a platform in yaw.
    """
    count, step, lanes, first = 2**14, 0.5, 64, 2**11
    speed, v3, v6, load3, load6 = -0.02, 0.004 + 0.003j, -0.003j, 1.0, -0.6 + 0.5j
    density = band(1e-4, 0.2, 0.022**2)
    root, damping = 0.07, 0.06
    random = np.random.default_rng(5)
    f = np.fft.rfftfreq(count, step)
    noise = random.standard_normal((lanes, f.size)) + 1j * random.standard_normal((lanes, f.size))
    xi = np.fft.irfft(noise * count * np.sqrt(np.interp(f, FREQUENCY, density) * f[1]) / 2, count)
    angle = np.empty((lanes, count))
    psi = random.uniform(0, 2 * np.pi, lanes)
    for k in range(count):
        angle[:, k] = psi
        z = np.exp(3j * psi)
        psi = psi + step * (speed + 2 * (v3 * z + v6 * z * z).real + xi[:, k])
    z = np.exp(3j * angle)
    load = 2 * (load3 * z + load6 * z * z).real
    H = 1 / (root**2 - (2 * np.pi * f) ** 2 + 2j * damping * root * 2 * np.pi * f)
    answer = np.fft.irfft(np.fft.rfft(load[:, first:]) * np.interp(
        np.fft.rfftfreq(count - first, step), f, H), count - first)[:, first:]  # fmt: skip
    answers = answer.var(axis=1)

    found = lingering(speed, density, {3: v3, 6: v6})
    for n, phasors in ((3, z), (6, z * z)):
        means = phasors[:, first:].mean(axis=1)
        error = means.std() / np.sqrt(lanes)
        assert abs(found.means[n] - means.mean()) < 3 * error + 0.02
    edges = 2 * np.linspace(-0.1, 0.1, 4001)
    middle = np.pi * (edges[1:] + edges[:-1])
    transfer = 1 / (root**2 - middle**2 + 2j * damping * root * middle)
    ((orders, parts),) = [item for item in found.spectra(edges) if 3 in item[0]]
    loads = {3: load3, 6: load6, -3: np.conj(load3), -6: np.conj(load6)}
    c = np.array([loads.get(n, 0.0) for n in orders.tolist()])
    spectrum = np.abs(transfer) ** 2 * np.einsum("k,qkj,j->q", c, parts, c.conj()).real
    spectrum[np.abs(middle) < 2 * np.pi / (step * (count - first))] = 0.0
    scatter = answers.std() / np.sqrt(lanes) / answers.mean()
    assert spectrum.sum() == pytest.approx(answers.mean(), rel=3 * scatter + 0.03)
