"""Shares of a life, equivalent loads and damage of a life, against sums over all of its cycles."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import weibull_min

from fowtlib.analysis.fatigue import (
    YEAR,
    damage_equivalent_load,
    lifetime_damage,
    lifetime_equivalent_load,
    table_weights,
    weibull_weights,
)
from fowtlib.language.errors import ModelError


def message(action) -> str:
    with pytest.raises(ModelError) as caught:
        action()
    return str(caught.value)


def test_weibull_weights_of_bins_and_seeds():
    speeds = np.repeat(np.arange(4, 25, 2), 3)  # three seeds a bin
    weights = weibull_weights(speeds, scale=9.0, shape=1.8)
    law = weibull_min(1.8, scale=9.0)
    assert weights.sum() == pytest.approx(law.cdf(25) - law.cdf(3), rel=1e-12)
    assert weights[speeds == 10] == pytest.approx([(law.cdf(11) - law.cdf(9)) / 3] * 3, rel=1e-12)
    shuffled = np.random.default_rng(1).permutation(speeds.size)
    np.testing.assert_allclose(weibull_weights(speeds[shuffled], scale=9.0, shape=1.8), weights[shuffled])


def test_weibull_weights_by_the_mean_and_edges():
    """IEC 61400-1, class I: Rayleigh with a mean of 10 m/s, P(V < V0) = 1 - exp(-pi (V0 / 2 / mean)^2)."""
    weights = weibull_weights([5.0, 15.0], mean=10.0, edges=[3, 10, 25])
    rayleigh = 1 - np.exp(-np.pi * (np.array([3, 10, 25]) / 20) ** 2)
    np.testing.assert_allclose(weights, np.diff(rayleigh), rtol=1e-12)
    uneven = weibull_weights([4.0, 6.0, 10.0], scale=8.0)
    law = weibull_min(2, scale=8.0)
    np.testing.assert_allclose(uneven, np.diff(law.cdf([3, 5, 8, 12])), rtol=1e-12)


def test_weights_by_a_scatter_table():
    table = np.array([[10, 30, 0], [20, 40, 0]])  # Hs 0-2, 2-4; Tp 4-8, 8-12, 12-16
    states = [[1, 5], [1, 9], [3, 5], [3, 9], [3, 11]]  # two cases share one cell
    weights = table_weights(states, ([0, 2, 4], [4, 8, 12, 16]), table)
    np.testing.assert_allclose(weights, [0.1, 0.3, 0.2, 0.2, 0.2])
    np.testing.assert_allclose(table_weights(states, ([0, 2, 4], [4, 8, 12, 16]), table, total=200), weights / 2)
    np.testing.assert_allclose(table_weights([1.0, 3.0], ([0, 2, 4],), [0.25, 0.5], total=1), [0.25, 0.5])
    few = table_weights(states[:3], ([0, 2, 4], [4, 8, 12, 16]), table, missing=0.4)
    np.testing.assert_allclose(few, [0.1, 0.3, 0.2])


def test_the_load_of_a_life_is_that_of_all_its_cycles():
    t = np.arange(0, 100 + 1e-9, 0.025)
    calm, rough = (a * np.cos(2 * np.pi * f * t) for a, f in ((1.0, 1.0), (3.0, 0.5)))
    exponents = [3, 4, 10]
    loads = [damage_equivalent_load((t, load), exponents) for load in (calm, rough)]
    found = lifetime_equivalent_load(loads, exponents, [0.7, 0.3])
    by_hand = [(0.7 * 1.0 * 2.0**m + 0.3 * 0.5 * 6.0**m) ** (1 / m) for m in exponents]
    np.testing.assert_allclose(found, by_hand, rtol=1e-12)
    life = lifetime_equivalent_load(loads, exponents, [0.7, 0.3], lifetime=20 * YEAR, equivalent_cycles=1e7)
    ratio = 20 * 365.25 * 24 * 3600 / 1e7
    np.testing.assert_allclose(life, np.array(by_hand) * ratio ** (1 / np.array(exponents)), rtol=1e-12)
    single = lifetime_equivalent_load(np.array(loads)[:, 0], 3, [0.7, 0.3])
    assert isinstance(single, float) and single == pytest.approx(by_hand[0], rel=1e-12)


def test_equal_cases_and_idle_time():
    assert lifetime_equivalent_load([5.0, 5.0], 4, [0.5, 0.5]) == pytest.approx(5.0, rel=1e-14)
    assert lifetime_equivalent_load([5.0], 4, [0.5]) == pytest.approx(5.0 * 0.5**0.25, rel=1e-14)
    assert lifetime_equivalent_load([0.0, 0.0], 4, [0.5, 0.5]) == 0.0
    assert lifetime_equivalent_load([3e9, 1e9], 60, [0.5, 0.5]) == pytest.approx(3e9 * 0.5 ** (1 / 60), rel=1e-9)


def test_damage_of_a_life():
    """20 years hold 175,320 states of one hour."""
    damage = lifetime_damage([1e-6, 4e-6], 3600.0, [0.75, 0.25])
    assert damage == pytest.approx(175_320 * (0.75e-6 + 1e-6), rel=1e-12)
    around = lifetime_damage(
        [[1e-6, 0], [4e-6, 8e-6]], [3600, 7200], [0.5, 0.5], lifetime=YEAR, design_fatigue_factor=3
    )
    np.testing.assert_allclose(around, 3 * 8766 * np.array([0.5e-6 + 1e-6, 2e-6]), rtol=1e-12)


def test_errors():
    assert message(lambda: weibull_weights([5, 7])) == (
        "a Weibull distribution of the wind takes either its mean or its scale in m/s."
    )
    assert message(lambda: weibull_weights([5, 7], mean=-1)) == (
        "a Weibull distribution takes numbers above 0, not a mean or scale of -1 m/s and a shape of 2."
    )
    assert message(lambda: weibull_weights([5, 5], mean=8)) == (
        "the bins of a single wind speed are not known; give their edges."
    )
    assert message(lambda: weibull_weights([5, 30], mean=8, edges=[3, 25])) == (
        "the case with wind speed [m/s] 30.0 lies outside of the bins."
    )
    assert message(lambda: weibull_weights([5, 7], mean=8, edges=[3, 25, 4])) == (
        "the edges of the bins of wind speeds are two or more rising numbers."
    )
    assert message(lambda: table_weights([[1, 5]], ([0, 2], [4, 8]), [[1, 2]])) == (
        "a scatter table of 1 x 1 cells takes a table of that shape and 2 variables per case; "
        "there are 1 x 2 cells, and states of shape (1, 2)."
    )
    assert message(lambda: table_weights([1.0], ([0, 2, 4],), [1, 3])) == (
        "0.75 of the scatter table lies in cells without a case; "
        "add cases, or say missing=0.75 to count it for nothing."
    )
    assert message(lambda: table_weights([1.0], ([0, 2, 4],), [1, -3])) == (
        "the cells of a scatter table are numbers of 0 or more, and sum up to its total at the most."
    )
    assert message(lambda: lifetime_equivalent_load([1, 2], 4, [0.7, 0.7])) == (
        "weights are shares of the life: numbers of 0 or more with a sum of at most 1; their sum is 1.4."
    )
    assert message(lambda: lifetime_equivalent_load([1, 2], 4, [0.7])) == (
        "there are 1 weights for 2 cases; give one per case."
    )
    assert message(lambda: lifetime_equivalent_load([1, np.nan], 4, [0.5, 0.5])) == (
        "equivalent loads of cases are finite numbers of 0 or more."
    )
    assert message(lambda: lifetime_equivalent_load([1, 2], [4, 10], [0.5, 0.5])) == (
        "there are 2 exponents for loads of shape (2,): (cases, exponents)."
    )
    assert message(lambda: lifetime_equivalent_load([1, 2], 4, [0.5, 0.5], lifetime=YEAR)) == (
        "the load of a number of cycles in a life takes both: lifetime in s, and equivalent_cycles."
    )
    assert message(lambda: lifetime_damage([1, 2], 0, [0.5, 0.5])) == (
        "the durations of cases are numbers of seconds above 0."
    )
    assert message(lambda: weibull_weights([5, np.nan], mean=8)) == (
        "the edges of the bins of wind speeds are two or more rising numbers."
    )
    assert message(lambda: lifetime_damage([1, 2], 600, [0.5, 0.5], design_fatigue_factor=0)) == (
        "lifetime and design_fatigue_factor are numbers above 0."
    )
    assert message(lambda: lifetime_damage([1, -2], 600, [0.5, 0.5])) == "damages of cases are numbers of 0 or more."
