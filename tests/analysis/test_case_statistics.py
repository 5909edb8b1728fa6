"""Statistics of a run and of many, against numbers that are known and against scipy's."""

from __future__ import annotations

import json
import time as clock

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy import stats

from fowtlib.analysis.case_statistics import case_statistics, over_cases
from fowtlib.analysis.crossings import count_up_crossings, gaussian_rate, mean_crossing_rate
from fowtlib.analysis.spectra import power_spectrum
from fowtlib.analysis.statistics import up_crossings
from fowtlib.language.errors import ModelError
from fowtlib.solving.results import Result

FLOATS = st.floats(-1e6, 1e6, allow_subnormal=False)


def run(time, units=None, **values) -> Result:
    return Result(time, values, units)


def gaussian(seed: int, count: int = 6000, step: float = 0.1, peak: float = 0.1) -> tuple[np.ndarray, np.ndarray]:
    """A Gaussian process with a bell-shaped spectrum about `peak` [Hz], standard deviation near 1."""
    rng = np.random.default_rng(seed)
    f = np.fft.rfftfreq(count, step)
    density = np.exp(-0.5 * ((f - peak) / (0.2 * peak)) ** 2)
    amplitude = np.sqrt(density / density.sum()) * count / np.sqrt(2)
    values = np.fft.irfft(amplitude * (rng.standard_normal(f.size) + 1j * rng.standard_normal(f.size)), count)
    return np.arange(count) * step, values / np.sqrt(2)


def test_a_sine_has_the_statistics_of_a_sine():
    time = np.arange(0.0, 1000.0, 0.05)
    told = case_statistics(run(time, {"surge": "m"}, surge=2.0 + 3.0 * np.sin(0.2 * np.pi * time)))["channels"]["surge"]
    assert told["unit"] == "m"
    assert told["mean"] == pytest.approx(2.0, abs=1e-9)
    assert told["std"] == pytest.approx(3.0 / np.sqrt(2.0), rel=1e-9)
    assert told["rms"] == pytest.approx(np.sqrt(4.0 + 4.5), rel=1e-9)
    assert (told["min"], told["max"]) == pytest.approx((-1.0, 5.0), abs=1e-6)
    assert told["max_time"] == pytest.approx(2.5) or told["max_time"] % 10.0 == pytest.approx(2.5)
    assert told["skewness"] == pytest.approx(0.0, abs=1e-9)
    assert told["kurtosis"] == pytest.approx(1.5, rel=1e-9)
    assert told["percentiles"]["50"] == pytest.approx(2.0, abs=0.02)
    assert told["percentiles"]["75"] == pytest.approx(2.0 + 3.0 * np.sin(np.pi / 4), abs=0.02)
    assert told["mean_crossing_rate"] == pytest.approx(0.1, rel=0.011)  # the first of 100 is at the edge
    assert len(told["crossings"]["above"]) == 15  # the amplitude is 1.414 standard deviations, 14 steps of 0.1
    assert set(told["crossings"]["above"][1:]) == {100}


def test_all_moments_are_those_of_scipy():
    time, values = gaussian(3)
    values = values + 0.3 * values**2
    told = case_statistics(run(time, a=values), 100.0)
    kept, channel = values[1000:], told["channels"]["a"]
    assert told["first"] == pytest.approx(100.0)
    assert told["points"] == 5000
    assert channel["skewness"] == pytest.approx(stats.skew(kept), rel=1e-9)
    assert channel["kurtosis"] == pytest.approx(stats.kurtosis(kept, fisher=False), rel=1e-9)
    assert channel["percentiles"]["99"] == pytest.approx(np.percentile(kept, 99), rel=1e-12)


def test_the_summary_of_a_result_has_the_same_numbers():
    time = np.sort(np.random.default_rng(1).uniform(0.0, 100.0, 500))  # uneven steps: weighted by time
    result = run(time, a=np.cos(time), b=time**2)
    told, table = case_statistics(result, 5.0)["channels"], result.statistics(5.0)
    for name in ("a", "b"):
        for key in ("mean", "std", "min", "max", "rms"):
            assert told[name][key] == pytest.approx(getattr(table[name], key), rel=1e-12)
    assert told["b"]["percentiles"]["50"] == pytest.approx(((5.0 + time[-1]) / 2) ** 2, rel=0.02)


def test_values_at_the_same_time():
    time = np.arange(5.0)
    told = case_statistics(run(time, a=[0, 5, 1, -4, 0], force=np.column_stack([[9, 1, 2, 3, 4], [1, 2, 3, 4, 0]])))
    at = told["at_extremes"]
    assert at["names"] == ["a", "force[0]", "force[1]"]
    assert at["max"] == [[5, 1, 2], [0, 9, 1], [-4, 3, 4]]
    assert at["min"] == [[-4, 3, 4], [5, 1, 2], [0, 4, 0]]


def test_json_can_hold_it_and_it_is_quick():
    time = np.arange(6000) * 0.1
    rng = np.random.default_rng(1)
    result = run(time, **{f"channel_{i}": rng.standard_normal(6000) for i in range(35)}, constant=np.ones(6000))
    told = case_statistics(result)
    assert json.loads(json.dumps(told, allow_nan=False)) == told
    assert told["channels"]["constant"]["skewness"] is None
    assert told["channels"]["constant"]["crossings"] == {"step": 0.1, "above": [], "below": []}
    spent = []
    for _ in range(3):
        start = clock.process_time()
        case_statistics(result)
        spent.append(clock.process_time() - start)
    assert min(spent) < 0.2  # 0.03 s here; the bound is for slow computers


def test_a_channel_that_is_not_finite_is_refused_by_name():
    time = np.arange(10.0)
    told = case_statistics(run(time, good=time, bad=np.where(time == 7, np.nan, time), worse=np.full(10, np.inf)))
    assert list(told["channels"]) == ["good"]
    assert told["refused"] == {"bad": "the value at 7 s is not a finite number.",
                               "worse": "the value at 0 s is not a finite number."}  # fmt: skip
    assert told["at_extremes"]["names"] == ["good"]


def test_some_channels_only():
    time = np.arange(10.0)
    told = case_statistics(run(time, a=time, v=np.column_stack([time, -time])), names=["v[1]"], percentiles=())
    assert list(told["channels"]) == ["v[1]"]
    assert told["channels"]["v[1]"]["percentiles"] == {}


@pytest.mark.parametrize(
    ("action", "words"),
    [
        (lambda result: case_statistics(result, 8.5), "discarding 8.5 s leaves 1 points of a result of 9 s"),
        (lambda result: case_statistics(result, percentiles=[101]), "between 0 and 100"),
        (lambda result: case_statistics(result, names=["b"]), "there is no result 'b'"),
        (lambda result: over_cases({}), "no cases"),
        (lambda result: over_cases({"one": case_statistics(result)}, {"two": 1.0}), "one for each case"),
    ],
)
def test_errors(action, words):
    with pytest.raises(ModelError, match=words):
        action(run(np.arange(10.0), a=np.arange(10.0)))


def test_over_cases_is_as_if_they_were_one():
    rng = np.random.default_rng(5)
    runs = {f"seed {i}": rng.normal(i, 1.0 + i, 1000) for i in range(4)}
    told = over_cases({name: case_statistics(run(np.arange(1000.0), a=values)) for name, values in runs.items()})["a"]
    together = np.concatenate(list(runs.values()))
    assert told["mean"] == pytest.approx(together.mean(), rel=1e-12)
    assert told["total_std"] == pytest.approx(together.std(), rel=1e-12)
    assert (told["max"], told["min"]) == (together.max(), together.min())
    assert told["max_case"] == max(runs, key=lambda name: runs[name].max())
    assert told["mean_max"] == pytest.approx(np.mean([values.max() for values in runs.values()]))
    assert told["std_min"] == pytest.approx(np.std([values.min() for values in runs.values()], ddof=1))


def test_weights_of_cases():
    cases = {name: case_statistics(run(np.arange(3.0), a=values)) for name, values in
             {"calm": [0.0, 1.0, 2.0], "storm": [9.0, 10.0, 11.0]}.items()}  # fmt: skip
    assert over_cases(cases, {"calm": 9.0, "storm": 1.0})["a"]["mean"] == pytest.approx(1.9)


def test_units_that_differ_are_refused():
    time = np.arange(3.0)
    cases = {unit: case_statistics(run(time, {"a": unit}, a=time)) for unit in ("kN", "N")}
    with pytest.raises(ModelError, match="different units: N, kN"):
        over_cases(cases)


@given(arrays(float, st.integers(3, 40), elements=FLOATS), st.lists(FLOATS, min_size=1, max_size=5, unique=True))
def test_crossings_are_counted_as_by_hand(values, levels):
    levels = sorted(levels)
    by_hand = [sum(a <= level < b for a, b in zip(values[:-1], values[1:], strict=True)) for level in levels]
    assert count_up_crossings(values, levels).tolist() == by_hand
    series = (np.arange(values.size), values)
    assert [up_crossings(series, level=level).count for level in levels] == by_hand


@given(arrays(float, st.integers(3, 40), elements=FLOATS), st.floats(0.1, 10.0), st.floats(-100.0, 100.0))
def test_a_change_of_scale_changes_what_it_must(values, factor, shift):
    time = np.arange(float(values.size))
    one = case_statistics(run(time, a=values))["channels"]["a"]
    other = case_statistics(run(time, a=factor * values + shift))["channels"]["a"]
    size = 1e-9 * (1.0 + np.abs(values).max() * factor + abs(shift))
    for key in ("mean", "min", "max"):
        assert other[key] == pytest.approx(factor * one[key] + shift, abs=size)
    assert other["std"] == pytest.approx(factor * one["std"], abs=size)
    assert one["min"] <= one["percentiles"]["5"] <= one["percentiles"]["95"] <= one["max"]
    if one["std"] > 1e-3 * (1.0 + np.abs(values).max()) and other["std"] > 1e-3 * (1.0 + abs(other["max"])):
        assert other["skewness"] == pytest.approx(one["skewness"], abs=1e-6)
        assert one["kurtosis"] >= 1.0 + one["skewness"] ** 2 - 1e-9  # of any distribution


def test_a_gaussian_process_crosses_as_rice_says():
    step, seeds = 0.1, range(8)
    rates, levels = [], np.array([0.0, 1.0, 2.0])
    for seed in seeds:
        time, values = gaussian(seed, count=60000, step=step)
        rates.append(count_up_crossings(values, levels) / time[-1])
    spectrum = power_spectrum((time, values))
    assert mean_crossing_rate(spectrum) == pytest.approx(1.0 / spectrum.zero_crossing_period, rel=1e-12)
    exact = 0.1 * np.sqrt(1.0 + 0.2**2)  # of a bell of relative width 0.2 about 0.1 Hz
    expected = gaussian_rate(levels, 0.0, 1.0, exact)
    np.testing.assert_allclose(np.mean(rates, axis=0), expected, rtol=0.05)
    assert np.mean(rates, axis=0)[0] == pytest.approx(exact, rel=0.01)


def test_a_process_without_a_deviation_has_no_rate():
    with pytest.raises(ModelError, match="above 0"):
        gaussian_rate(1.0, 0.0, 0.0, 0.1)
