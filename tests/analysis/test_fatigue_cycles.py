"""Rainflow counting and damage-equivalent loads: the example of the standard, waves with known cycles, invariants."""

from __future__ import annotations

import time
from collections import Counter

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import signal

from fowtlib.analysis.fatigue import damage_equivalent_load, equivalent_loads, rainflow_cycles
from fowtlib.analysis.fatigue.cycles import turning_points
from fowtlib.analysis.series import Series
from fowtlib.language.errors import ModelError
from fowtlib.solving.results import Result

ASTM = [-2.0, 1, -3, 5, -1, 3, -4, 4, -2]  # ASTM E1049-85, figure 6
loads = st.lists(st.integers(-1000, 1000).map(float), min_size=3, max_size=60)


def series(values) -> tuple[np.ndarray, np.ndarray]:
    return np.arange(len(values), dtype=float), np.asarray(values, dtype=float)


def sine(amplitude=3.0, cycles=25, mean=7.0) -> tuple[np.ndarray, np.ndarray]:
    t = np.arange(cycles * 40 + 1) / 40.0  # 1 Hz, from crest to crest
    return t, mean + amplitude * np.cos(2 * np.pi * t)


def test_the_example_of_the_standard():
    cycles = rainflow_cycles(series(ASTM))
    assert cycles.table() == [(3.0, 0.5), (4.0, 1.5), (6.0, 0.5), (8.0, 1.0), (9.0, 0.5)]
    assert cycles.number == 4.0
    whole = [(r, m) for r, m, n in zip(cycles.ranges, cycles.means, cycles.counts, strict=True) if n == 1.0]
    assert whole == [(4.0, 1.0)]  # from -1 to 3


def test_the_example_of_the_standard_when_it_repeats():
    """ASTM E1049-85, figure 7: every cycle closes."""
    cycles = rainflow_cycles(series(ASTM), repeating=True)
    assert cycles.table() == [(3.0, 1.0), (4.0, 1.0), (7.0, 1.0), (9.0, 1.0)]


def test_equivalent_ranges_of_the_example():
    """One cycle in place of all: the sum of counts times range^m, to the power 1/m, by hand of the printed table."""
    found = damage_equivalent_load(series(ASTM), [3, 4, 6, 10], equivalent_cycles=1)
    np.testing.assert_allclose(found, [10.303998, 9.587411, 9.072638, 8.820004], rtol=1e-6)
    by_hand = (0.5 * 3**3 + 1.5 * 4**3 + 0.5 * 6**3 + 8**3 + 0.5 * 9**3) ** (1 / 3)
    assert damage_equivalent_load(series(ASTM), 3, equivalent_cycles=1) == pytest.approx(by_hand, rel=1e-14)


@pytest.mark.parametrize("exponent", [1, 3, 4, 10, 25])
def test_a_sine_is_its_own_equivalent_load(exponent):
    assert damage_equivalent_load(sine(), exponent) == pytest.approx(6.0, rel=1e-12)  # 1 Hz
    assert damage_equivalent_load(sine(), exponent, equivalent_cycles=25) == pytest.approx(6.0, rel=1e-12)
    half = damage_equivalent_load(sine(), exponent, frequency=0.5)
    assert half == pytest.approx(6.0 * 2 ** (1 / exponent), rel=1e-12)


def test_the_beginning_can_be_left_out():
    t, values = sine()
    disturbed = np.where(t < 5, 1000.0, values)
    assert damage_equivalent_load((t, disturbed), 4, discard=5) == pytest.approx(6.0, rel=1e-12)


def four_points(points: list[float]) -> Counter:
    """The same count by another road: close inner ranges first, then halves of what is left (Amzallag, 1994)."""
    rest, found = [], Counter()
    for point in points:
        rest.append(point)
        while len(rest) > 3 and abs(rest[-3] - rest[-2]) <= min(abs(rest[-4] - rest[-3]), abs(rest[-2] - rest[-1])):
            found[abs(rest[-3] - rest[-2])] += 1.0
            del rest[-3:-1]
    for one, other in zip(rest, rest[1:], strict=False):
        found[abs(other - one)] += 0.5
    return found


@given(loads)
@settings(max_examples=200, deadline=None)
def test_two_ways_of_counting_agree(values):
    assert dict(rainflow_cycles(series(values)).table()) == dict(four_points(turning_points(np.array(values)).tolist()))


@given(loads)
@settings(max_examples=100, deadline=None)
def test_what_every_count_has(values):
    cycles = rainflow_cycles(series(values))
    points = turning_points(np.array(values))
    assert cycles.number == (points.size - 1) / 2
    assert cycles.ranges.max(initial=0.0) == np.ptp(values)
    assert np.sum(cycles.ranges * cycles.counts) == pytest.approx(np.abs(np.diff(values)).sum() / 2)
    closed = rainflow_cycles(series(values), repeating=True)
    assert closed.ranges.max(initial=0.0) == np.ptp(values)
    around = np.append(values, values[0])
    assert np.sum(closed.ranges * closed.counts) == pytest.approx(np.abs(np.diff(around)).sum() / 2)


@given(loads, st.floats(0.01, 100), st.floats(-1e4, 1e4), st.floats(1.0, 12.0))
@settings(max_examples=100, deadline=None)
def test_scale_shift_and_sign(values, scale, shift, exponent):
    base = damage_equivalent_load(series(values), exponent)
    t, values = series(values)
    for other in (scale * values, -values * scale, scale * values + np.round(shift)):
        assert damage_equivalent_load((t, other), exponent) == pytest.approx(scale * base, rel=1e-6, abs=1e-9)


@given(loads)
@settings(max_examples=50, deadline=None)
def test_points_between_turns_and_repeated_points_change_nothing(values):
    t, values = series(values)
    fine = np.linspace(0, t[-1], 3 * (t.size - 1) + 1)
    between = np.interp(fine, t, values)
    between[::3] = values  # the interpolation may round
    plain = rainflow_cycles((t, values))
    assert rainflow_cycles((fine, between)).table() == plain.table()
    twice = rainflow_cycles(series(np.repeat(values, 2)))
    assert twice.table() == plain.table()


@given(loads.filter(lambda values: np.ptp(values) > 0))
@settings(max_examples=50, deadline=None)
def test_a_higher_exponent_gives_a_larger_load_up_to_the_largest_range(values):
    cycles = rainflow_cycles(series(values))
    found = damage_equivalent_load(cycles, [1, 2, 4, 8, 16, 300], equivalent_cycles=cycles.number)
    assert np.all(np.diff(found) >= -1e-9 * found[-1])
    assert 0.9 * np.ptp(values) <= found[-1] <= np.ptp(values) * (1 + 1e-12)


def test_large_loads_and_exponents_do_not_overflow():
    t, values = sine(amplitude=3e9)
    assert damage_equivalent_load((t, values), 40) == pytest.approx(6e9, rel=1e-9)


def test_a_load_that_does_not_change():
    constant = (np.arange(5.0), np.full(5, 3.0))
    assert damage_equivalent_load(constant, 4) == 0.0
    assert rainflow_cycles(constant).table() == []
    assert rainflow_cycles(constant).binned(10).number == 0.0
    np.testing.assert_array_equal(damage_equivalent_load(constant, [4, 10]), [0.0, 0.0])


def test_the_form_of_the_answer_follows_the_exponents():
    one = damage_equivalent_load(sine(), 4)
    assert isinstance(one, float)
    assert damage_equivalent_load(sine(), [4]).shape == (1,)
    assert damage_equivalent_load(sine(), [[4, 10], [3, 5]]).shape == (2, 2)


@given(loads, st.integers(1, 200))
@settings(max_examples=50, deadline=None)
def test_bins_are_on_the_safe_side_by_less_than_their_width(values, bins):
    cycles = rainflow_cycles(series(values))
    binned = cycles.binned(bins)
    assert binned.number == pytest.approx(cycles.number)
    width = np.ptp(values) / bins
    for m in (3, 10):
        exact = cycles.power_mean(m, cycles.number or 1.0)
        assert exact * (1 - 1e-9) <= binned.power_mean(m, cycles.number or 1.0) <= (exact + width) * (1 + 1e-9)
    assert np.sum(binned.counts * binned.means) == pytest.approx(np.sum(cycles.counts * cycles.means), abs=1e-6)


def test_ranges_on_the_edge_of_a_bin_stay_there():
    assert rainflow_cycles(series(ASTM)).binned(9).table() == rainflow_cycles(series(ASTM)).table()


def test_goodman():
    cycles = rainflow_cycles(sine(amplitude=3.0, mean=7.0))
    moved = cycles.goodman(20.0)
    np.testing.assert_allclose(moved.ranges, 6.0 * 20.0 / (20.0 - 7.0))  # about zero, the range that does as much
    np.testing.assert_allclose(cycles.goodman(20.0, mean=7.0).ranges, 6.0)
    np.testing.assert_allclose(rainflow_cycles(sine(mean=0.0)).goodman(20.0).ranges, 6.0)
    assert damage_equivalent_load(sine(), 4, ultimate=20.0) == pytest.approx(6.0 * 20 / 13)
    assert damage_equivalent_load(sine(mean=-7.0), 4, ultimate=20.0) == pytest.approx(6.0 * 20 / 13)
    assert damage_equivalent_load(sine(), 4, ultimate=1e9) == pytest.approx(6.0, rel=1e-6)


def a_result() -> Result:
    t, values = sine()
    columns = {
        "thrust": values,
        "tension": np.stack([values, 2 * values], axis=1),
        "moment": 3 * values,
        "stress": 4 * values,
        "surge": values,
        "odd": values,
    }
    units = {"thrust": "kN", "tension": "N", "moment": "kN m", "stress": "MPa", "surge": "m", "odd": "-"}
    return Result(t, columns, units)


def test_every_load_of_a_result():
    table = equivalent_loads(a_result())
    assert list(table) == ["thrust", "tension[0]", "tension[1]", "moment", "stress"]
    assert list(table["thrust"]) == [4.0, 10.0]
    for name, factor in {"thrust": 1, "tension[0]": 1, "tension[1]": 2, "moment": 3, "stress": 4}.items():
        assert list(table[name].values()) == pytest.approx([6.0 * factor] * 2)


def test_the_named_series_of_a_result():
    table = equivalent_loads(a_result(), [3], names=["surge", "tension[1]"], discard=5.0, frequency=0.5)
    assert table == {
        "surge": {3.0: pytest.approx(6.0 * 2 ** (1 / 3))},
        "tension[1]": {3.0: pytest.approx(12 * 2 ** (1 / 3))},
    }
    by_label = damage_equivalent_load(a_result()["surge"], 3, frequency=0.5, discard=5.0)
    assert by_label == pytest.approx(table["surge"][3.0], rel=1e-14)
    assert list(equivalent_loads(a_result(), names=["tension", "thrust"])) == ["tension[0]", "tension[1]", "thrust"]
    with pytest.raises(ModelError, match="there is no result 'thrusts'; did you mean 'thrust'?"):
        equivalent_loads(a_result(), names=["thrusts"])


def test_600_s_at_20_hz_of_36_channels_are_counted_in_well_under_a_second():
    """Measured for loads up to 2 Hz 0.05 s of processor time, and 0.21 s for white noise, the worst case."""
    t = np.arange(12000) * 0.05
    noise = np.random.default_rng(0).standard_normal((12000, 36))
    slow = signal.lfilter(*signal.butter(4, 2 / 10), noise, axis=0)
    result = Result(t, {"load": slow}, {"load": "N"})
    began = time.process_time()
    assert len(equivalent_loads(result)) == 36
    assert time.process_time() - began < 0.5


def message(action) -> str:
    with pytest.raises(ModelError) as caught:
        action()
    return str(caught.value)


@pytest.mark.parametrize(
    "exponent, wrong", [(0, "0"), (-3, "-3"), ([4, float("nan")], "nan"), (float("inf"), "inf"), ([], "none")]
)
def test_wrong_exponents(exponent, wrong):
    assert message(lambda: damage_equivalent_load(sine(), exponent)) == (
        f"an exponent of an S-N curve is a number above 0, such as 4 or 10, not {wrong}."
    )


def test_errors():
    t, values = sine()
    gap = values.copy()
    gap[40] = np.nan
    assert message(lambda: damage_equivalent_load((t, gap), 4)) == (
        "the series: the value at 1 s is not a finite number."
    )
    assert message(lambda: damage_equivalent_load(([], []), 4)) == (
        "the series: the record has 0 points, at least 3 are needed."
    )
    assert message(lambda: damage_equivalent_load((t, values[:-1]), 4)).startswith(
        "the series: an analysis takes one value per point of time;"
    )
    assert message(lambda: damage_equivalent_load(sine(), 4, discard=100)) == (
        "the series: discarding 100 s leaves nothing of a record of 25 s."
    )
    assert message(lambda: damage_equivalent_load(sine(), 4, frequency=0)) == (
        "the series: a frequency of 0 Hz cannot stand for a load; give a number above 0."
    )
    assert message(lambda: damage_equivalent_load(sine(), 4, equivalent_cycles=-1)) == (
        "the series: -1 equivalent cycles cannot stand for a load; give a number above 0."
    )
    assert message(lambda: damage_equivalent_load(Series(t, values, "kN", "thrust"), 4, ultimate=9)) == (
        "thrust: the load reaches 10 kN, and with an ultimate load of 9 kN it would have failed; "
        "Goodman's correction takes an ultimate load above all loads."
    )
    assert message(lambda: damage_equivalent_load(sine(), 4, bins=0)) == (
        "the series: cycles are sorted into 1, 2, 3 ... bins, not into 0."
    )
    assert message(lambda: damage_equivalent_load(rainflow_cycles(sine()), 4, discard=5)) == (
        "the series: the cycles are counted; discard and repeating belong to the counting."
    )
