"""Long-term extremes against models of a response whose answer is known by integration or by counting."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest
from scipy import optimize, stats

from fowtlib.cases import Case
from fowtlib.language.errors import ParameterError
from fowtlib.metocean import (
    Each,
    Gumbel,
    States,
    Turbulence,
    UpCrossings,
    bins,
    contour,
    environmental_contour,
    excess_of_fits,
    full_long_term,
    inflated,
    known,
    modified_contours,
    on_contour,
    one_by_one,
    radius,
    site,
    states_to_cases,
)

JOINT = site("norway_5").at(90)
HOURS = 50 * 365.25 * 24
GRID = (np.arange(0.5, 45, 1.0), np.arange(0.25, 22, 0.5), np.arange(1, 34, 2.0))


def waves_alone(states: States) -> Gumbel:
    """A response of the waves: its maxima have a Gumbel law that grows with the wave height."""
    return Gumbel(2.0 * states.wave_height + 1, 0.25 * states.wave_height)


def all_three(states: States) -> Gumbel:
    """One of wind, waves and period, with a resonance at 10 s."""
    resonance = 1 + 1.5 * np.exp(-(((states.peak_period - 10) / 3) ** 2))
    return Gumbel(0.8 * states.wind_speed + 2 * resonance * states.wave_height, 0.2 + 0.15 * states.wave_height)


def growing(states: States) -> Gumbel:
    """A response to the wind that grows until the turbine stops, as yaw of two rotors does."""
    runs = states.wind_speed <= 25
    most = np.where(runs, 20 + 0.8 * states.wind_speed, 8.0)
    return Gumbel(most + states.wave_height, np.where(runs, 2.0, 1.0))


def like_thrust(states: States) -> Gumbel:
    """One that is largest at 12 m/s, and small where the turbine stands."""
    runs = states.wind_speed <= 25
    most = np.where(runs, 40 - 0.4 * abs(states.wind_speed - 12), 8.0)
    return Gumbel(most + states.wave_height, np.where(runs, 2.0, 1.0))


def by_integration(years: float) -> float:
    """Of `waves_alone`: one integral over the law of the wave height, itself one over the wind."""
    node, weight = np.polynomial.legendre.leggauss(300)
    u, h = 22.5 * (node + 1), 12.5 * (node + 1)
    density = 22.5 * (weight * JOINT.wind_speed.pdf(u)) @ JOINT.wave_height(u[:, None]).pdf(h) * 12.5 * weight
    law = stats.gumbel_r(2 * h + 1, 0.25 * h)
    assert density.sum() == pytest.approx(1, abs=1e-6)
    return optimize.brentq(lambda x: density @ law.sf(x) - 1 / (years * 365.25 * 24), 10, 100, rtol=1e-9)


def test_all_states_against_an_integral():
    """Bins of 1 m/s, 0.5 m and 2 s come within half a percent of the integral; finer bins come closer."""
    exact = by_integration(50)
    coarse = full_long_term(bins(JOINT, *GRID, keep=None), waves_alone).value(50)
    fine = full_long_term(bins(JOINT, GRID[0], np.arange(0.05, 22, 0.1), [10, 30], keep=None), waves_alone).value(50)
    assert coarse == pytest.approx(exact, rel=5e-3)
    assert fine == pytest.approx(exact, rel=5e-4)
    assert abs(fine - exact) < abs(coarse - exact) / 4


def test_all_states_against_counting():
    """The exceedance of a level in 400,000 random hours, with a random maximum in each."""
    count = 400_000
    states = JOINT.sample(count, seed=5)
    noise = np.random.default_rng(6).uniform(size=count)
    laws = all_three(states)
    maxima = laws.isf(noise)
    fine = bins(JOINT, *GRID[:2], np.arange(0.5, 34), keep=None)
    found = full_long_term(fine, all_three)
    for level in np.quantile(maxima, [0.5, 0.99, 0.9999]):
        expected = (maxima > level).mean()
        assert found.exceedance(level) == pytest.approx(expected, rel=0.02 + 4 / np.sqrt(expected * count))
    # a sample of states is another set of states with probabilities; it scatters by 1 % from seed to seed
    few_years = 40_000 / 365.25 / 24
    sampled = full_long_term(states, all_three)
    assert sampled.value(few_years) == pytest.approx(found.value(few_years), rel=0.025)


def test_a_long_term_law_is_consistent():
    found = full_long_term(bins(JOINT, *GRID, keep=1000), all_three)
    values = found.curve([1, 10, 50, 100])
    assert np.all(np.diff(values) > 0)
    assert found.exceedance(values) == pytest.approx(1 / (np.array([1, 10, 50, 100]) * 365.25 * 24), rel=1e-6)
    shares = found.shares(values[2])
    assert shares.sum() == pytest.approx(1)
    assert shares.min() >= 0
    one = full_long_term(States([10], [3], [9], [1.0]), lambda _: Gumbel(np.array([5.0]), np.array([1.0])))
    assert one.value(50) == pytest.approx(stats.gumbel_r(5, 1).isf(1 / HOURS), rel=1e-9)


def test_dropping_bins_rarer_than_1000_years_costs_little():
    """They hold 6 times the exceedance of 50 years together, but most of them are rare by their period, and mild."""
    grid = (np.arange(4, 51, 2.0), np.arange(1, 21.0), np.arange(2, 35, 2.0))
    whole = full_long_term(bins(JOINT, *grid, keep=None), all_three).value(50)
    kept = full_long_term(bins(JOINT, *grid, keep=1000), all_three).value(50)
    assert 0 <= whole - kept < 0.01 * whole


def test_few_seeds_make_the_extreme_of_all_states_too_high():
    """Ten maxima a state, of a response whose worst states are common: 12 % too high, and the bootstrap tells."""
    states = bins(JOINT, np.arange(4, 51, 2.0), np.arange(1, 21.0), np.arange(2, 35, 2.0))
    exact = full_long_term(states, growing).value(50)
    rng = np.random.default_rng(3)
    laws, fitted, corrected = growing(states), [], []
    for _ in range(4):
        maxima = laws.isf(rng.uniform(size=(10, len(states)))).T
        found = full_long_term(states, known(states, Gumbel.of_maxima(maxima)))
        fitted.append(found.value(50) / exact)
        corrected.append(fitted[-1] / excess_of_fits(found, 10, 50))
    assert 1.08 < np.mean(fitted) < 1.18
    assert np.mean(corrected) == pytest.approx(1, abs=0.04)


def test_a_contour_is_exact_for_a_response_without_randomness():
    """A response that grows with the wind alone: the contour gives the long-term value itself, at any fractile."""

    def wind_alone(states: States) -> Gumbel:
        return Gumbel(states.wind_speed, np.full(len(states), 1e-9))

    exact = float(JOINT.wind_speed.isf(1 / HOURS))
    found = environmental_contour(JOINT, wind_alone, fractile=0.5)
    assert found.value == pytest.approx(exact, rel=1e-6)
    assert found.return_period == pytest.approx(50, rel=1e-9)
    assert found.state.wind_speed == pytest.approx(exact, rel=1e-6)


def test_the_randomness_of_the_response_is_what_the_fractile_stands_for():
    """Linear in the normal variable of the wind, plus noise: exact by convolution, so is the median when inflated."""
    beta, phi = radius(50), 0.5

    def response(states: States) -> stats.rv_continuous:
        z = JOINT.wind_speed.to_normal(states.wind_speed)
        return stats.norm(np.cos(phi) * z, np.full(len(states), np.sin(phi)))

    median = environmental_contour(JOINT, response, fractile=0.5)
    assert median.value == pytest.approx(np.cos(phi) * beta, rel=1e-6)
    wide = inflated(beta, omission=np.sin(phi) ** 2)
    line = contour(JOINT, wide, points=41, upper=True)
    assert np.max(response(line).median()) == pytest.approx(beta, rel=1e-9)
    fractile = stats.norm.cdf(beta * np.tan(phi / 2))
    assert environmental_contour(JOINT, response, fractile=fractile).value == pytest.approx(beta, rel=1e-6)
    z = (np.arange(4000) + 0.5) / 4000 * 16 - 8
    states = JOINT.from_normal(np.stack([z, 0 * z, 0 * z], axis=1))
    weights = stats.norm.pdf(z) / stats.norm.pdf(z).sum()
    every = full_long_term(replace(states, probability=weights), response)
    assert every.value(50) == pytest.approx(beta, rel=1e-4)


def test_the_modified_method_sees_what_happens_below_cut_out():
    """ECM misses a response of the turbine at work, since the worst of its contour stands; MECM finds it."""
    states = bins(JOINT, *GRID, keep=None)
    exact = full_long_term(states, growing).value(50)
    rings = {"points": 9, "upper": True}
    found = modified_contours(JOINT, growing, [25.0], fractile=0.5, **rings)
    plain, ending = found.contours
    assert ending.return_period * 365.25 * 24 == pytest.approx(104.6, abs=0.05)
    assert plain.value < 0.85 * exact
    assert environmental_contour(JOINT, growing, fractile=0.9, **rings).value < 0.9 * exact
    assert found.worst is ending
    assert found.value == pytest.approx(exact, rel=0.01)
    # the law of 50 years in a state of the contour of M hours: F^(50 years / M), here at its median
    law = growing(ending.states)
    assert law.cdf(ending.values) ** (HOURS / 104.62) == pytest.approx(0.5, rel=1e-3)


def test_several_contours_find_what_is_worst_in_common_winds():
    """A thrust is largest in winds that blow thousands of hours: the contour at cut-out lets it occur too seldom."""
    exact = full_long_term(bins(JOINT, *GRID, keep=None), like_thrust).value(50)
    one = modified_contours(JOINT, like_thrust, [25.0], points=9, upper=True)
    several = modified_contours(JOINT, like_thrust, [13.0, 16.0, 20.0, 25.0], points=9, upper=True)
    assert one.value == pytest.approx(0.927 * exact, rel=0.01)
    assert several.value == pytest.approx(exact, rel=0.01)


def test_the_printed_exponents_of_the_modified_method():
    """The reference: M = 105 h gives 4174, 680 h gives 645; the fractile by the closed form of a Gumbel law."""
    for hours, printed in ((105, 4174), (680, 645)):
        assert HOURS / hours == pytest.approx(printed, abs=0.6)
        beta = float(stats.norm.isf(1 / hours))
        states = States([10.0], [3.0], [9.0])
        found = on_contour(
            states, lambda _: Gumbel(np.array([7.0]), np.array([2.0])), years=50, beta=beta, fractile=0.5
        )
        assert found.value == pytest.approx(7 + 2 * (np.log(HOURS / hours) - np.log(-np.log(0.5))), rel=1e-6)


# -- short-term laws --------------------------------------------------------------------------------------------------


def test_gumbel_by_moments():
    maxima = stats.gumbel_r(12, 3).rvs((200, 50), random_state=1)
    fit = Gumbel.of_maxima(maxima)
    assert fit.location.mean() == pytest.approx(12, abs=0.1)
    assert fit.scale.mean() == pytest.approx(3, abs=0.1)
    assert Gumbel.of_maxima([1.0, 2.0, 3.0]).scale == pytest.approx(np.sqrt(6) / np.pi)
    with pytest.raises(ParameterError, match="two runs or more"):
        Gumbel.of_maxima([1.0])


def test_up_crossings_of_a_gaussian_process():
    """F = exp(-nu T exp(-x^2 / 2 s^2)); fractile s sqrt(2 ln(nu T / ln(1/p))), its printed form."""
    law = UpCrossings(q=0.1, a=1 / (2 * 1.5**2), b=4.0, c=2.0, duration=3600)
    for p in (0.3, 0.5, 0.9, 0.999):
        assert law.isf(1 - p) == pytest.approx(4 + 1.5 * np.sqrt(2 * np.log(0.1 * 3600 / np.log(1 / p))), rel=1e-9)
        assert law.cdf(law.isf(1 - p)) == pytest.approx(p, rel=1e-9)
    high = UpCrossings(q=0.1, a=0.2, b=np.array([4.0, 5.0]), c=2.0, threshold=np.array([6.0, 9.0]))
    assert high.sf(5.9).tolist() == [1.0, 1.0]
    assert high.isf(1.0) == pytest.approx([6.0, 9.0])
    assert high.sf(high.isf(1e-4)) == pytest.approx([1e-4, 1e-4])


def test_single_laws_stand_for_many():
    states = bins(JOINT, [10, 14, 18], [2, 4, 6], [8, 10, 12], keep=None)
    together = all_three(states)
    single = [stats.gumbel_r(a, b) for a, b in zip(together.location, together.scale, strict=True)]
    answers = dict(zip(states, single, strict=True))
    total = float(states.weights.sum())
    years = 10 / total / 365.25 / 24
    whole = full_long_term(states, all_three).value(years)
    assert full_long_term(states, one_by_one(answers.__getitem__)).value(years) == pytest.approx(whole, rel=1e-9)
    for laws in (together, Each(single)):
        fitted = known(states, laws)
        assert full_long_term(states, fitted).value(years) == pytest.approx(whole, rel=1e-9)
        assert fitted(states[[3, 1]]).sf(20.0) == pytest.approx(together.sf(20.0)[[3, 1]])
        with pytest.raises(ParameterError, match="there is no fit for 1 of 1 states; the first is 9 m/s"):
            fitted(States([9], [2], [8]))


def test_refusals():
    line = contour(JOINT, radius(50))
    with pytest.raises(ParameterError, match="these states have no probabilities"):
        full_long_term(line, waves_alone)
    with pytest.raises(ParameterError, match="a fractile lies between 0 and 1, and is not 1"):
        environmental_contour(JOINT, waves_alone, fractile=1.0)
    with pytest.raises(ParameterError, match="no contour below that of the return period ends there"):
        modified_contours(JOINT, waves_alone, [45.0])
    with pytest.raises(ParameterError, match="one value for each of"):
        full_long_term(bins(JOINT, *GRID), lambda _: Gumbel(np.zeros(3), 1.0))
    with pytest.raises(ParameterError, match="no finite extreme"):
        environmental_contour(JOINT, lambda s: Gumbel(np.full(len(s), np.nan), 1.0))
    with pytest.raises(ParameterError, match="less than one in"):
        full_long_term(States([10], [3], [9], [1e-9]), lambda _: Gumbel(np.array([5.0]), 1.0)).value(50)
    with pytest.raises(ParameterError, match="of sum 1 at most"):
        States([10, 11], [3, 3], [9, 9], [0.6, 0.6])
    with pytest.raises(ParameterError, match="wave_height has"):
        States([10, 11], [3], [9, 9])


# -- run lists --------------------------------------------------------------------------------------------------------


def test_states_become_cases():
    states = bins(JOINT, [22, 24, 26], [4, 6], [10, 12], keep=None)
    rows = states_to_cases(
        states,
        "two_rotor_spar_rigid",
        seeds=3,
        parameters={"sea.heading": 0.2},
        cut_out=25,
        above_cut_out={"start": "rest", "parameters": {"wind.kind": "steady"}},
        group="FLTA",
        duration=4000.0,
        discard=400.0,
    )
    json.dumps(rows)
    cases = [Case.from_plain(row) for row in rows]
    assert len(cases) == 3 * len(states)
    assert len({case.name for case in cases}) == len(cases)
    assert len({case.parameters[f"{what}.seed"] for case in cases for what in ("wind", "sea")}) == 2 * len(cases)
    assert sum(case.weight for case in cases) == pytest.approx(states.weights.sum())
    first, last = cases[0], cases[-1]
    assert first.parameters["wind.mean_speed"] == first.labels["wind_speed"] == 22
    assert first.parameters["wind.kind"] == "kaimal" and first.start == ""
    assert last.parameters["wind.mean_speed"] == 26
    assert last.parameters["wind.kind"] == "steady" and last.start == "rest"
    assert last.parameters["sea.heading"] == 0.2 and last.duration == 4000 and last.group == "FLTA"


def test_cases_of_random_turbulence_and_of_a_contour():
    drawn = Turbulence("B").draw(JOINT.sample(4, seed=1), seed=1)
    row = states_to_cases(drawn, "oc3_spar_rigid")[2]
    assert row["parameters"]["wind.turbulence_intensity"] == drawn.turbulence_intensity[2]
    assert row["weight"] == 0.25
    assert states_to_cases(contour(JOINT, radius(50), points=3), "oc3_spar_rigid", seeds=2)[0]["weight"] == 1
    with pytest.raises(ParameterError, match="give cut_out and above_cut_out together"):
        states_to_cases(drawn, "oc3_spar_rigid", cut_out=25)
    with pytest.raises(ParameterError, match="one seed or more"):
        states_to_cases(drawn, "oc3_spar_rigid", seeds=0)


def test_a_case_of_the_list_runs(tmp_path):
    import fowtlib as fw

    case = Case.from_plain(
        states_to_cases(contour(JOINT, 2.0, points=3, upper=True), "oc3_spar_rigid", duration=1.0)[1]
    )
    plant = fw.load(case.model).compile()
    result = plant.simulate(case.duration, parameters=dict(case.parameters))
    assert result.time[-1] == 1.0
