"""Reliability of welds: closed form against quadrature and sampling, limits of series, and what inspections say."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.special import ndtr

from fowtlib.analysis.fatigue import (
    FatigueReliability,
    InspectedReliability,
    Inspection,
    break_even_inspection,
    equivalent_factor,
    factor_for,
    present_value,
)
from fowtlib.language.errors import ModelError

DFF_3 = FatigueReliability(3.0)


def test_one_weld_by_hand():
    """All logarithms normal: beta = mean over deviation, after 20 years with the factor 3."""
    mean = math.log(3) + 2 * 0.2 * math.log(10) + 3 * math.log(1.04) / 2
    deviation = math.sqrt((0.2 * math.log(10)) ** 2 + math.log(1.09) + 9 * math.log(1.04))
    assert DFF_3.reliability_index(20) == pytest.approx(mean / deviation, rel=1e-12)
    assert DFF_3.failure_probability(20) == pytest.approx(ndtr(-mean / deviation), rel=1e-12)


def test_series_against_samples():
    """Ten million lives of eight welds: the shares that fail differ by the error of sampling."""
    rng, n, failed = np.random.default_rng(1), 500_000, 0
    one = FatigueReliability(1.5, welds=8)
    for _ in range(4):
        load = np.exp(math.sqrt(math.log(1.04)) * rng.standard_normal(n) - math.log(1.04) / 2)
        strength = np.exp(math.sqrt(math.log(1.09)) * rng.standard_normal((8, n)))
        curve = 10 ** (-0.2 * (2 + rng.standard_normal((8, n))))
        failed += np.sum(np.any(load**3 / 1.5 * curve > strength, axis=0))
    share, wanted = failed / (4 * n), one.failure_probability(20)
    assert abs(share - wanted) < 4 * math.sqrt(wanted / (4 * n))


@pytest.mark.parametrize("welds", [2, 8, 12])
def test_a_series_lies_between_its_bounds(welds):
    """Between one weld and independent welds: near the one where strengths hardly differ, at the other without load."""
    one, series = DFF_3.failure_probability(20), replace(DFF_3, welds=welds)
    independent = -math.expm1(welds * math.log1p(-one))
    assert one < series.failure_probability(20) < independent
    alike = FatigueReliability(3.0, scatter=0.0, miner=0.02, load=0.3)
    assert replace(alike, welds=welds).failure_probability(20) == pytest.approx(alike.failure_probability(20), rel=0.2)
    alone = FatigueReliability(3.0, load=0.0)
    apart = -math.expm1(welds * math.log1p(-alone.failure_probability(20)))
    assert replace(alone, welds=welds).failure_probability(20) == pytest.approx(apart, rel=1e-9)


def test_factors_of_series():
    """The factor that makes a series as good as one weld; J.M. Hegseth, NTNU 2020:356, section 4.4: twice for eight.

    His scatter of the loads is not printed: with coefficients of variation from 0.1 to 0.3 it is 1.41 to 1.80.
    """
    for load, wanted in ((0.1, 1.41), (0.2, 1.63), (0.3, 1.80)):
        one = FatigueReliability(3.0, load=load)
        needed = factor_for(one.reliability_index(20), 20, replace(one, welds=8))
        assert needed / 3 == pytest.approx(wanted, abs=0.01)
        series = replace(one, welds=8, factor=needed)
        assert equivalent_factor(series, 20) == pytest.approx(3.0, rel=1e-6)


def test_probability_in_a_year():
    ends = [DFF_3.failure_probability(t) for t in (19, 20)]
    assert DFF_3.annual_probability(20) == pytest.approx((ends[1] - ends[0]) / (1 - ends[0]), rel=1e-12)


def test_growth_of_cracks_is_as_reliable_as_the_curve():
    for factor in (1.0, 3.0):
        welds = FatigueReliability(factor)
        cracks = InspectedReliability(welds, [])
        for time in (5.0, 10.0, 15.0, 20.0):
            assert cracks.reliability_index(time) == pytest.approx(welds.reliability_index(time), abs=0.02)


def test_inspections_in_place_of_steel():
    """DFF 1 inspected every 2 years and DFF 2 every 5 are as reliable as DFF 3 without, after 20 years, within 5 %.

    Source: J.M. Hegseth, NTNU 2020:356, section 4.4; its distributions are not printed, these are the usual ones.
    """
    wanted = DFF_3.reliability_index(20)
    often = InspectedReliability(FatigueReliability(1.0), range(2, 20, 2))
    seldom = InspectedReliability(FatigueReliability(2.0), [5, 10, 15])
    assert often.reliability_index(20) == pytest.approx(wanted, rel=0.05)
    assert seldom.reliability_index(20) == pytest.approx(wanted, rel=0.05)


def test_what_an_inspection_tells():
    """Blind eyes tell nothing; better eyes and more looks make what is not found more reliable."""
    welds = FatigueReliability(1.0)
    blind = InspectedReliability(welds, [10], Inspection(depth=1e9))
    bare = InspectedReliability(welds, [])
    assert blind.failure_probability(20) == pytest.approx(bare.failure_probability(20), rel=1e-6)
    found = [InspectedReliability(welds, times, Inspection(depth=depth)).reliability_index(20)
             for times, depth in (([], 0.45), ([10], 5.0), ([10], 0.45), ([10, 15], 0.45))]  # fmt: skip
    assert np.all(np.diff(found) > 0.01)


def test_what_inspections_are_worth_today_by_geometric_series():
    r = 1.05**-2
    assert present_value(range(2, 20, 2)) == pytest.approx(r * (1 - r**9) / (1 - r), rel=1e-12)  # 9 in life
    assert present_value([5, 10, 15], 0.0) == 3 and present_value([]) == 0


def test_below_the_break_even_the_design_with_inspections_is_cheaper():
    """Factors 1, 2, 3 with 9, 3 and no inspections (J.M. Hegseth, NTNU 2020:356, section 4.4: 0.21, 0.65 MEUR)."""
    nine, three = range(2, 20, 2), [5, 10, 15]
    first, second = (0.21 * (present_value(nine) - present_value(three)), 0.65 * present_value(three))
    assert break_even_inspection(first, nine, three) == pytest.approx(0.21)
    assert break_even_inspection(second, three) == pytest.approx(0.65)
    steel = np.array([0.0, first, first + second])
    for cost, cheapest in ((0.20, 0), (0.22, 1), (0.64, 1), (0.66, 2)):
        whole = steel + cost * np.array([present_value(nine), present_value(three), 0.0])
        assert whole.argmin() == cheapest
    with pytest.raises(ModelError, match="no more inspections"):
        break_even_inspection(1.0, three, nine)
    with pytest.raises(ModelError, match="years are 0 or later"):
        present_value([-1.0])


def test_a_clean_weld_by_bayes():
    """One look in the middle of a life, by samples of cracks: P(fail | not found), from the calibrated growth."""
    cracks = InspectedReliability(FatigueReliability(1.0), [10])
    rng, n = np.random.default_rng(3), 2_000_000
    start = rng.exponential(0.04, n) ** -0.5
    deviation = math.hypot(cracks.growth_deviation, cracks.welds.load_deviation)
    growth = cracks.median * np.exp(deviation * rng.standard_normal(n))
    end = 25.0**-0.5
    middle, last = start - growth / 2, start - growth
    alive = middle > end
    unseen = 1 / (1 + (np.maximum(middle, end) ** -2 / 0.45) ** 0.9) * alive
    early = 1 - np.mean(alive)
    wanted = early + (1 - early) * np.sum(unseen * (last <= end)) / np.sum(unseen)
    assert cracks.failure_probability(20) == pytest.approx(wanted, rel=0.01)


@pytest.mark.parametrize(
    ("what", "message"),
    [
        (lambda: FatigueReliability(0.0), "a design fatigue factor, a life and an exponent are above 0."),
        (lambda: FatigueReliability(1.0, welds=0), "a series has one weld or more, a whole number, not 0."),
        (lambda: FatigueReliability(1.0, welds=1.5), "a series has one weld or more, a whole number, not 1.5."),
        (lambda: DFF_3.failure_probability(0.0), "after a time above 0 years, not 0."),
        (lambda: InspectedReliability(DFF_3, [-1.0]), "inspections are after more than 0 years."),
        (lambda: InspectedReliability(replace(DFF_3, exponent=2.0), []), "with an exponent above 2, not 2."),
        (lambda: factor_for(80.0, 20.0, DFF_3), "no design fatigue factor between 1e-6 and 1e6 gives an index of 80."),
    ],
)
def test_messages(what, message):
    with pytest.raises(ModelError, match=message.replace(".", r"\.")):
        what()
