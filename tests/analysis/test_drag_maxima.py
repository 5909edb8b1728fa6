"""The law of maxima of drag and inertia: its limits, and maxima of loads that are made of both."""

import numpy as np
import pytest

from fowtlib.analysis.drag_maxima import (
    rayleigh_exponential,
    rayleigh_exponential_extreme,
    rayleigh_exponential_quantile,
)
from fowtlib.language.errors import ModelError

Y = np.linspace(0, 12, 2401)


def test_without_drag_it_is_rayleigh_s_law():
    assert rayleigh_exponential(Y, 0.0) == pytest.approx(1 - np.exp(-(Y**2) / 2), abs=1e-12)
    assert rayleigh_exponential_extreme(400, 0.0, None) == pytest.approx(np.sqrt(2 * np.log(401)), rel=1e-12)
    median = np.sqrt(2 * np.log(4000 / np.log(2)))  # of the largest of many
    assert rayleigh_exponential_extreme(4000, 0.0, 0.5) == pytest.approx(median, rel=1e-4)


def test_drag_alone_has_the_maxima_of_a_square():
    """(A^2 with Rayleigh's A) over sqrt(3) times the square of its deviation: 1 - exp(-sqrt(3) y / 2)."""
    y = Y[1:]
    assert rayleigh_exponential(y, 1e4) == pytest.approx(1 - np.exp(-np.sqrt(3) * y / 2), abs=1e-4)


@pytest.mark.parametrize("k", [0.05, 0.2, 1.0, 5.0])
def test_one_law_smooth_where_its_branches_meet(k):
    F = rayleigh_exponential(Y, k)
    assert F[0] == 0 and np.all(np.diff(F) >= 0) and F[-1] <= 1
    y0 = 1 / (2 * k * np.sqrt(3 * k**2 + 1))
    values = rayleigh_exponential(y0 * np.array([1 - 1e-4, 1, 1 + 1e-4]), k)
    assert values[2] - values[1] == pytest.approx(values[1] - values[0], rel=1e-3)
    p = np.array([0.0, 0.1, 0.5, 0.9, 0.999, 1 - 1e-9])
    assert rayleigh_exponential(rayleigh_exponential_quantile(p, k), k) == pytest.approx(p, abs=1e-12)
    largest = rayleigh_exponential_extreme(300, k, 0.9)
    assert rayleigh_exponential(largest, k) ** 300 == pytest.approx(0.9, rel=1e-9)
    # the printed closed form: of N maxima one exceeds with 1/(N + 1)
    n, root = 350.0, np.sqrt(3 * k**2 + 1)
    printed = np.sqrt(2 * np.log(n + 1)) / root if n <= np.exp(1 / (8 * k**2)) - 1 else (
        (1 + 8 * k**2 * np.log(n + 1)) / (4 * k * root))  # fmt: skip
    assert rayleigh_exponential_extreme(n, k, None) == pytest.approx(printed, rel=1e-12)


@pytest.mark.parametrize("k", [0.3, 1.0])
def test_maxima_of_drag_and_inertia(k):
    """One narrow band: of each amplitude the largest of c |u| u + z over a turn, u and z a quarter turn apart."""
    amplitude = np.random.default_rng(3).rayleigh(1.0, 40000)  # over the deviation of u
    turn = np.linspace(0, np.pi / 2, 400)
    load = k * (amplitude[:, None] * np.cos(turn)) ** 2 + amplitude[:, None] * np.sin(turn)  # deviation of z is 1
    maxima = np.sort(load.max(axis=1)) / np.sqrt(1 + 3 * k**2)
    for y in (1.0, 2.0, 3.0):
        exceeded = np.mean(maxima > y)
        error = 3.5 * np.sqrt(exceeded / maxima.size)
        assert 1 - rayleigh_exponential(y, k) == pytest.approx(exceeded, abs=error)


@pytest.mark.parametrize("call", [
    lambda: rayleigh_exponential(-1.0, 0.3),
    lambda: rayleigh_exponential(1.0, -0.3),
    lambda: rayleigh_exponential_quantile(1.0, 0.3),
    lambda: rayleigh_exponential_extreme(100, 0.3, 1.0),
    lambda: rayleigh_exponential_extreme(0.2, 0.3),
])  # fmt: skip
def test_what_the_law_does_not_take(call):
    with pytest.raises(ModelError):
        call()
