"""Lines of what goes round with a rotor whose speed is random, against closed forms and against series."""

from __future__ import annotations

import numpy as np
import pytest

from fowtlib.frequency.lines import RandomSpeed

FREQUENCY = np.sort(
    np.concatenate([np.geomspace(1e-4, 3.0, 400), np.linspace(5e-3, 1e-2, 200), np.linspace(0.05, 2.5, 400)])
)


def band(low: float, high: float, variance: float) -> np.ndarray:
    """A density of this variance between two frequencies."""
    inside = np.where((low < FREQUENCY) & (high > FREQUENCY), 1.0, 0.0)
    return inside * variance / np.trapezoid(inside, FREQUENCY)


@pytest.mark.parametrize("speed", [1.3, -0.7])
def test_a_steady_speed_has_a_line(speed):
    line = RandomSpeed(speed, FREQUENCY, np.zeros_like(FREQUENCY)).line(3)
    assert line.share == pytest.approx([1.0])
    assert line.omega == pytest.approx([3 * speed], rel=1e-12)
    assert line.where == [np.argmin(np.abs(FREQUENCY - 3 * abs(speed) / (2 * np.pi)))]


def test_a_speed_that_changes_slowly_has_its_distribution():
    """At n times the speed; the variance of the frequency is that of n times the speed, whatever its spectrum is."""
    line = RandomSpeed(1.3, FREQUENCY, band(2e-4, 2e-3, 0.1**2)).line(3)
    assert line.share.sum() == pytest.approx(1.0, abs=1e-4)
    mean = line.share @ line.omega / line.share.sum()
    assert mean == pytest.approx(3.9, abs=1e-3)
    assert np.sqrt(line.share @ (line.omega - mean) ** 2) == pytest.approx(0.3, rel=1e-2)
    beyond = line.share[line.omega > 3.9 + 0.3].sum()
    assert beyond == pytest.approx(0.1587, abs=0.01)  # of a normal distribution


def test_a_speed_that_changes_quickly_keeps_a_line():
    """Of the share exp(-variance of the angle)."""
    density = band(0.5, 0.7, 0.5**2)
    angle = np.trapezoid(density / (2 * np.pi * FREQUENCY) ** 2, FREQUENCY)
    line = RandomSpeed(1.3, FREQUENCY, density).line(2)
    at = np.argmin(np.abs(FREQUENCY - 2.6 / (2 * np.pi)))
    assert line.share[line.where == at].sum() == pytest.approx(np.exp(-4 * angle), rel=1e-2)


def test_a_rotor_that_turns_to_and_fro_has_parts_on_both_sides():
    line = RandomSpeed(-0.02, FREQUENCY, band(2e-3, 2e-2, 0.02**2)).line(3)
    forwards, backwards = line.share[line.omega > 0].sum(), line.share[line.omega < 0].sum()
    assert 0.05 < forwards < 0.4 < backwards
    assert np.all(FREQUENCY[line.where] > 0)


@pytest.mark.parametrize(("n", "speed"), [(3, 1.3), (1, -0.04)])
def test_a_line_is_that_of_series(n, speed):
    """What an oscillator answers to cos(n psi), with psi by summing a random speed up, in 24 long series."""
    count, step, root = 2**17, 0.2, 2 * np.pi * 0.62 if n == 3 else 0.05
    damping, sigma = 0.02, 0.09 if n == 3 else 0.03
    density = band(4e-3, 5e-2, sigma**2)
    f = np.fft.rfftfreq(count, step)
    random = np.random.default_rng(8)
    amplitude = count * np.sqrt(np.interp(f, FREQUENCY, density) * f[1]) / 2
    H = 1 / (root**2 - (2 * np.pi * f) ** 2 + 2j * damping * root * 2 * np.pi * f)
    squares = []
    for _ in range(24):
        noise = amplitude * (random.standard_normal(f.size) + 1j * random.standard_normal(f.size))
        angle = np.cumsum(speed + np.fft.irfft(noise, count)) * step
        force = np.cos(n * angle + random.uniform(0, 2 * np.pi))
        squares.append(np.var(np.fft.irfft(np.fft.rfft(force) * H, count)))
    line = RandomSpeed(speed, FREQUENCY, density).line(n)
    answer = np.abs(1 / (root**2 - line.omega**2 + 2j * damping * root * line.omega)) ** 2
    found = 0.5 * answer @ line.share
    assert found == pytest.approx(np.mean(squares), rel=3 * np.std(squares) / np.sqrt(24) / np.mean(squares) + 0.01)
