"""Many states: sums by hand, extremes of the long term, what is kept of a list that fails or stops, and fatigue."""

from __future__ import annotations

import csv
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import fowtlib as fw
from fowtlib.analysis.fatigue import TubeSection, sn_curve
from fowtlib.analysis.fatigue.lifetime import YEAR
from fowtlib.frequency import response
from fowtlib.frequency.many import responses
from fowtlib.language.errors import ModelError, ParameterError
from fowtlib.solving.binding import RunTrees, tree_with
from tests.frequency.conftest import oscillator

LEVELS, SHARES = [2.0, 8.0, 18.0], [0.5, 0.3, 0.1]


@pytest.fixture(scope="module")
def plant():
    return oscillator().compile()


@pytest.fixture(scope="module")
def found(plant):
    return responses(plant, {"one.level": LEVELS, "probability": SHARES})


def test_probabilities_stand_in_each_state_or_in_a_column(plant, found):
    rows = [{"one.level": level, "probability": share} for level, share in zip(LEVELS, SHARES, strict=True)]
    assert responses(plant, rows).weighted_std("x") == found.weighted_std("x")
    with pytest.raises(ModelError, match="state 2 has the probability -1"):
        responses(plant, [rows[0], rows[1] | {"probability": -1}])


@pytest.mark.parametrize(
    ("wrong", "text"),
    [({"outputs": []}, "outputs are empty"), ({"tolerance": 0}, "tolerance is a number above 0"),
     ({"tolerance": "1e-4"}, "tolerance is a number above 0"), ({"state": 3}, "state is a mean")],
)  # fmt: skip
def test_what_a_response_is_not_told(plant, wrong, text):
    with pytest.raises(ModelError, match=text):
        response(plant, **wrong)


def test_weights_are_those_of_a_sum_by_hand(found):
    # a linear oscillator: the deviation goes with the root of the level, 1 : 2 : 3
    first = found[0].std("x")
    assert found.std("x") == pytest.approx([first, 2 * first, 3 * first])
    assert found.weighted_std("x") == pytest.approx(first * (0.5 + 0.6 + 0.3) / 0.9)
    limit = 7.0
    duty = np.sqrt(2 / np.pi) * found.std("v") / limit  # the rate of x is v
    assert found.weighted_duty_cycle("x", limit) == pytest.approx(np.dot(SHARES, duty) / 0.9)


def test_fatigue_of_a_life_is_the_sum_over_its_states(found):
    exponent = 3.0
    loads = np.array([one.equivalent_load("x", exponent) for one in found])
    assert found.equivalent_load("x", exponent) == pytest.approx((SHARES @ loads**exponent) ** (1 / exponent))
    of_life = found.equivalent_load("x", exponent, lifetime=20 * YEAR, equivalent_cycles=1e7)
    assert of_life == pytest.approx((SHARES @ loads**exponent * 20 * YEAR / 1e7) ** (1 / exponent))


def test_the_worst_state_and_the_level_of_the_long_term(found):
    value, number = found.extreme("x")
    assert (value, number) == (found[2].extreme("x"), 2)
    assert found.extreme("x", side="min") == (pytest.approx(-value), 2)
    level = found.long_term_extreme("x", 50.0)
    rates = [p * one["x"].up_crossing_rate * np.exp(-0.5 * (level / one.std("x")) ** 2)
             for p, one in zip(SHARES, found, strict=True)]  # fmt: skip
    assert sum(rates) * 50 * YEAR == pytest.approx(1.0, rel=1e-6)
    assert found.long_term_extreme("x", 50.0, side="min") == pytest.approx(-level)
    assert found.long_term_extreme("x", 1.0) < level


def test_a_state_that_fails_leaves_the_others_and_is_named(plant):
    with pytest.warns(UserWarning, match=r"state 2 \(damping -0.2\) has no response.*unstable"):
        some = responses(plant, {"one.damping": [0.3, -0.2, 0.6], "probability": [0.5, 0.1, 0.4]}, outputs=["x"])
    assert list(some.failures) == [1]
    assert np.isnan(some.std("x")[1])
    with pytest.raises(ModelError, match="10 % of the states by probability have no response. State 2.*missing=0.1"):
        some.weighted_std("x")
    by_hand = (0.5 * some[0].std("x") + 0.4 * some[2].std("x")) / 0.9
    assert some.weighted_std("x", missing=0.2) == pytest.approx(by_hand)
    with pytest.raises(ModelError, match=r"state 2 \(damping -0.2\) has no response: the state is unstable"):
        some[1]


def test_a_list_that_is_stopped_keeps_what_it_has(plant):
    def stop(done: int, total: int) -> None:
        if done == 2:
            raise KeyboardInterrupt

    with pytest.warns(UserWarning, match="stopped after 2 of 3 states"):
        some = responses(plant, [{"one.level": level} for level in LEVELS], progress=stop)
    assert not some.complete
    assert np.isfinite(some.std("x")).tolist() == [True, True, False]
    with pytest.raises(ModelError, match="The list was stopped before its end"):
        some.weighted_std("x")


def test_mistakes_of_a_list_are_told_at_once(plant):
    with pytest.raises(ModelError, match="no tunable parameter 'one.lewel'"):
        responses(plant, {"one.lewel": LEVELS})
    with pytest.raises(ModelError, match="columns of different lengths"):
        responses(plant, {"one.level": LEVELS, "probability": [1.0]})
    with pytest.raises(ModelError, match="state 3 has the probability -0.1; a probability is 0 or more"):
        responses(plant, {"one.level": LEVELS}, probability=[0.5, 0.6, -0.1])
    with pytest.raises(ModelError, match="3 states and 1 probabilities"):
        responses(plant, {"one.level": LEVELS}, probability=[1.0])
    with pytest.raises(ModelError, match="the probabilities of all states are 0"):
        responses(plant, {"one.level": LEVELS}, probability=[0.0, 0.0, 0.0])
    with pytest.raises(ModelError, match="there are no states"):
        responses(plant, [])
    with pytest.raises(ModelError, match="the model has no result 'y'"):
        responses(plant, {"one.level": LEVELS}, outputs=["y"])
    twice = responses(plant, {"one.level": LEVELS}, probability=[0.8, 0.3, 0.07])
    with pytest.raises(ModelError, match="have the sum 1.17"):
        twice.equivalent_load("x")


def test_a_table_has_a_row_for_each_state(found, tmp_path: Path):
    with found.save(tmp_path / "each.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert [float(row["one.level"]) for row in rows] == LEVELS
    assert [float(row["std of x [m]"]) for row in rows] == pytest.approx(found.std("x"), rel=1e-6)
    again = found.dataset
    assert again["std of x"].attrs["units"] == "m"
    found.save(tmp_path / "each.nc")


# --- what follows from one response -----------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def one(plant):
    return response(plant)


def test_the_rate_of_a_result_has_the_spectrum_of_its_derivative(one):
    assert one.rate("x").density == pytest.approx(one["v"].density, rel=1e-6)
    assert one.rate("x").unit == "(m)/s"
    assert one.duty_cycle("x", "50 cm/s") == pytest.approx(np.sqrt(2 / np.pi) * one.std("v") / 0.5)


def test_series_have_the_deviation_and_the_crossings_of_the_response(one):
    records = [one.series("x", 3600.0, 0.1, seed=seed) for seed in range(4)]
    deviation = np.sqrt(np.mean([record.values.var() for record in records]))
    assert deviation == pytest.approx(one.std("x"), rel=0.05)
    values = np.concatenate([record.values for record in records])
    rate = np.sum((values[:-1] < 0) & (values[1:] >= 0)) / (4 * 3600)
    assert rate == pytest.approx(one["x"].up_crossing_rate, rel=0.03)


@pytest.mark.parametrize("exponent", [3.0, 5.0])
def test_counting_series_agrees_with_dirlik(one, exponent):
    counted = one.equivalent_load("x", exponent, method="rainflow", seeds=6)
    assert counted == pytest.approx(one.equivalent_load("x", exponent), rel=0.06)


def stress_of(found, scale):
    """The same response with x as a stress in MPa."""
    shares = {name: density * scale**2 for name, density in found.shares.items()}
    transfer = {name: H * scale for name, H in found.transfer.items()}
    return replace(found, shares=shares, transfer=transfer, units=("MPa", "MN*m"), mean=found.mean * scale)


def test_damage_with_two_slopes_by_counting_and_by_dirlik(one):
    stress = stress_of(one, 30.0)  # a deviation of about 30 MPa: cycles on both sides of the knee
    curve = sn_curve("D", thickness=0.06)
    by_law = stress.damage("x", curve, duration=3600.0)
    assert stress.damage("x", curve, duration=3600.0, method="rainflow") == pytest.approx(by_law, rel=0.25)
    assert by_law > 1.2 * stress.damage("x", sn_curve("D"), duration=3600.0)  # the wall is thick
    with pytest.raises(ModelError, match="no method 'dirlic'; did you mean 'dirlik'"):
        stress.damage("x", curve, method="dirlic")
    with pytest.raises(ModelError, match="seeds: only the method 'rainflow'"):
        stress.damage("x", curve, seeds=3)


def test_around_a_tube_the_stress_is_that_of_both_moments_together(one):
    moments = replace(stress_of(one, 1.0), outputs=("mx", "my"), units=("MN*m", "MN*m"))
    section, curve = TubeSection(6.0, 0.03), sn_curve("D", thickness=0.03)
    around = moments.tube_damage(section, curve, "mx", "my", points=4)
    assert around.damage[1] == pytest.approx(moments.damage("mx", curve, section), rel=1e-9)
    assert around.damage[0] == pytest.approx(moments.damage("my", curve, section), rel=1e-9)
    # x and v of a stationary oscillator do not go together: at 45 degrees half of each variance
    at_45 = moments.combined({"mx": np.sqrt(0.5), "my": np.sqrt(0.5)})
    assert at_45.std**2 == pytest.approx((moments.std("mx") ** 2 + moments.std("my") ** 2) / 2, rel=1e-6)
    kept = replace(moments, transfer={}, driving={})
    with pytest.raises(ModelError, match="keep_transfer=True"):
        kept.tube_damage(section, curve, "mx", "my")


# --- a turbine --------------------------------------------------------------------------------------------------------


@pytest.mark.filterwarnings("ignore:the frequencies")
def test_states_in_any_order_have_the_same_responses_as_alone():
    # means are found from those of other winds, linear models are shared by the seas of one wind
    wind, sea = "wind.mean_speed", "sea.significant_wave_height"
    rows = [{wind: 20.0, sea: 4.0}, {wind: 8.0, sea: 2.0}, {wind: 14.0, sea: 2.0}, {wind: 8.0, sea: 3.0}]
    frequency = np.geomspace(1e-3, 0.5, 150)
    asked = {"outputs": ["surge", "pitch", "rotor_speed"], "frequencies": frequency, "tolerance": 1e-9}
    together = responses(fw.load("oc3_spar_rigid").compile(), rows, **asked)
    for row, found in zip(rows[1:3], list(together)[1:3], strict=True):
        alone = response(fw.load("oc3_spar_rigid").compile(), parameters=row, **asked)
        assert found.mean == pytest.approx(alone.mean, rel=1e-7)
        assert found.density == pytest.approx(alone.density, rel=1e-6, abs=1e-9 * alone.density.max())


def test_a_tree_that_is_used_again_is_that_of_the_run_alone():
    plant = fw.load("oc3_spar_rigid").compile()
    trees = RunTrees(plant.dae, plant.root)
    runs = [{"wind.mean_speed": 8.0, "sea.peak_period": 9.0, "platform.mooring.yaw_stiffness": 9e7},
            {"wind.mean_speed": 18, "sea.peak_period": 12.0, "platform.mooring.yaw_stiffness": 8e7},
            {"wind.mean_speed": 12.0, "wind.kind": "steady"}, {"sea.peak_period": 7.0}]  # fmt: skip
    for run in [*runs, *runs]:
        again, alone = trees(run), tree_with(plant.dae, plant.root, run)
        for part in alone.walk():
            twin = again.find(part.path)
            assert type(twin) is type(part)
            for name in {*part._values, *twin._values}:
                assert str(twin.parameter_value(name)) == str(part.parameter_value(name)), (part.path, name)
    assert trees(runs[0]) is trees({**runs[0], "wind.mean_speed": 9.0})
    with pytest.raises(ParameterError, match="peak_period"):
        trees({**runs[0], "sea.peak_period": -1.0})
    assert float(trees(runs[0]).find("sea").parameter_value("peak_period")) == 9.0
