"""Two results against each other: pairs by name, units, signs, lights."""

from __future__ import annotations

import csv

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fowtlib.analysis.comparison import Comparison, Pair, compare_results, read_pairs
from fowtlib.language.errors import ModelError
from fowtlib.solving.results import Result

TIME = np.arange(0.0, 100.0, 0.5)
WAVE = np.sin(0.3 * TIME)


def run(units=None, time=TIME, **values) -> Result:
    return Result(time, values, units)


def test_lights():
    """+5 % is green, +20 % amber, -50 % red; limits belong to the lower light."""
    first = run(a=1.05 * WAVE, b=1.2 * WAVE, c=0.5 * WAVE)
    comparison = compare_results(first, run(a=WAVE, b=WAVE, c=WAVE))
    assert [comparison[name, "std"].light for name in "abc"] == ["green", "amber", "red"]
    assert comparison["b", "max"].percent == pytest.approx(20.0)
    assert comparison["c", "min"].percent == pytest.approx(50.0)  # -0.5 against -1: half of it above
    assert comparison.count() == {"green": 4, "amber": 4, "red": 4, "none": 0}
    assert compare_results(first, run(b=WAVE), limits=(20.0001, 30.0))["b", "std"].light == "green"
    assert "3 channels, 12 values" in comparison.summary()


# percent differences of mean, deviation, minimum and maximum, FAST against Bladed, all cases together: Serret (2019),
# table 3.10, and the colours that the limits of its section 3.10 (10 % and 30 %) give them
@pytest.mark.parametrize(
    ("channel", "percent", "lights"),
    [("WindVelX", (1.67, 4.58, 10.67, 4.32), "green green amber green"),
     ("TwrBsFx", (15.78, 30.88, 56.16, 28.27), "amber red red amber"),
     ("TwrBsFz", (15.88, 26.78, 15.74, 16.51), "amber amber amber amber"),
     ("GenPwr", (9.37, 12.12, 28.86, 5.75), "green amber amber green")],
)  # fmt: skip
def test_the_published_comparison(channel, percent, lights):
    mean, std, low, high = (1.0 + value / 100.0 for value in percent)
    # three levels such that the statistics of the first are those of the second times the factors
    first = _with_statistics(10.0 * mean, 2.0 * std, 5.0 * low, 20.0 * high)
    second = _with_statistics(10.0, 2.0, 5.0, 20.0)
    comparison = compare_results(run(**{channel: first}), run(**{channel: second}))
    rows = comparison.rows
    assert [row.percent for row in rows] == pytest.approx(list(percent), rel=1e-6)
    assert " ".join(row.light for row in rows) == lights


def _with_statistics(mean: float, std: float, low: float, high: float) -> np.ndarray:
    """A series of 200 values with this mean, deviation, minimum and maximum."""
    n = TIME.size - 2
    rest = (TIME.size * mean - low - high) / n
    variance = (TIME.size * std**2 - (low - mean) ** 2 - (high - mean) ** 2) / n - (rest - mean) ** 2
    swing = np.sqrt(variance) * np.where(np.arange(n) % 2, 1.0, -1.0)
    return np.r_[low, high, rest + swing]


def test_names_and_units_of_openfast(tmp_path):
    """A result and its own .outb file agree within the 16 bits of that file, whatever its channels are called."""
    units = {"surge": "m", "pitch": "deg", "generator_torque": "N m", "tower_base_fore_aft_moment": "kN m", "own": "m"}
    result = run(units, surge=10 + WAVE, pitch=5 + WAVE, generator_torque=4e4 + 1e3 * WAVE,
                 tower_base_fore_aft_moment=1e4 * WAVE, own=WAVE)  # fmt: skip
    written = Result.open(result.save(tmp_path / "run.outb"))
    comparison = compare_results(result, written)
    assert len(comparison.names) == 5
    assert comparison.count()["green"] == 20
    assert max(abs(row.percent) for row in comparison.rows if row.percent) < 0.01
    raw = run({"PtfmSurge": "m", "GenTq": "kN m", "TwrBsMyt": "kN m"}, PtfmSurge=10 + WAVE, GenTq=40 + WAVE,
              TwrBsMyt=1e4 * WAVE)  # fmt: skip
    comparison = compare_results(result, raw)
    assert {row.name: row.other for row in comparison.rows} == {
        "surge": "PtfmSurge", "generator_torque": "GenTq", "tower_base_fore_aft_moment": "TwrBsMyt"}  # fmt: skip
    assert all(row.percent == pytest.approx(0.0, abs=1e-6) for row in comparison.rows)
    assert comparison.first_only == ("pitch", "own")


def test_pairs_with_sign_and_units(tmp_path):
    first = run({"force": "N", "surge": "m"}, force=1000 * WAVE, surge=WAVE)
    second = run({"Drag": "1", "PtfmSurge": "m", "Rest": "m"}, Drag=-WAVE, PtfmSurge=2 * WAVE, Rest=WAVE)
    (tmp_path / "map.csv").write_text(
        "# ours, theirs\nfirst,second,sign,second_unit\nforce,drag,-1,kN\n\nsurge,rest,,\n"
    )
    pairs = read_pairs(tmp_path / "map.csv")
    assert pairs == [Pair("force", "drag", -1.0, "", "kN"), Pair("surge", "rest")]
    comparison = compare_results(first, second, pairs)
    assert {row.percent for row in comparison.rows} == {0.0}
    assert comparison["force", "max"].second == pytest.approx(1000 * WAVE.max())
    assert comparison.second_only == ("PtfmSurge",)
    assert compare_results(first, second)["surge", "std"].percent == pytest.approx(-50.0)


def test_a_unit_that_does_not_fit_leaves_one_channel_out():
    comparison = compare_results(run({"a": "m", "b": "m"}, a=WAVE, b=WAVE), run({"a": "m", "b": "s"}, a=WAVE, b=WAVE))
    assert comparison.names == ["a"]
    assert "b is in m, and b in s" in comparison.refused["b"]


def test_a_name_of_openfast_in_a_pair_finds_the_result():
    comparison = compare_results(run({"surge": "m"}, surge=WAVE), run({"x": "m"}, x=WAVE), [Pair("PtfmSurge", "x")])
    assert comparison["surge", "max"].percent == 0.0


def test_more_measures_and_the_beginning():
    first = run(a=np.where(TIME < 10, 99.0, WAVE), b=WAVE)
    comparison = compare_results(
        first, run(a=WAVE, b=WAVE), discard=10.0, measures={"range": lambda s: np.ptp(s.values)}
    )
    assert comparison.measures == ["mean", "std", "min", "max", "range"]
    assert comparison["a", "range"].first == pytest.approx(np.ptp(WAVE[20:]))
    assert {row.percent for row in comparison.rows} == {0.0}


def test_what_has_no_scale():
    zero = np.zeros_like(TIME)
    comparison = compare_results(run(a=WAVE, b=1e-14 * WAVE), run(a=zero, b=zero))
    assert comparison["a", "std"].percent is None
    assert comparison["a", "std"].light == "none"
    assert comparison["b", "max"].percent == 0.0
    shifted = compare_results(run(a=WAVE + 0.1), run(a=WAVE - WAVE.mean()), relative_to="range")
    assert shifted["a", "mean"].percent == pytest.approx(100 * (WAVE.mean() + 0.1) / np.ptp(WAVE))


def test_a_channel_that_is_not_finite_is_named():
    comparison = compare_results(run(a=WAVE, b=np.where(TIME == 3, np.nan, WAVE)), run(a=WAVE, b=WAVE))
    assert comparison.names == ["a"]
    assert comparison.refused == {"b": "the value at 3 s is not a finite number."}


@given(st.floats(-3.0, 3.0), st.floats(0.01, 10.0), st.sampled_from([1.0, -1.0]))
def test_a_result_equals_itself_in_any_unit_and_sign(mean, size, sign):
    values = mean + size * WAVE
    comparison = compare_results(
        run({"x": "m"}, x=values), run({"x": "mm"}, x=1000 * sign * values), [Pair("x", "x", sign)]
    )
    assert all(row.percent == pytest.approx(0.0, abs=1e-6) for row in comparison.rows)
    assert {row.light for row in comparison.rows} == {"green"}


def test_files_and_picture(tmp_path):
    comparison = compare_results(run({"a": "m"}, a=1.2 * WAVE, b=WAVE), run({"a": "m"}, a=WAVE, b=WAVE))
    text = comparison.save(tmp_path / "lights.md").read_text()
    assert "| a | m |" in text
    assert "+20.0 amber" in text
    rows = list(csv.reader(comparison.save(tmp_path / "lights.csv").open()))
    assert rows[2][:4] == ["a", "a", "m", "std"]
    assert float(rows[2][6]) == pytest.approx(20.0)
    comparison.plot(tmp_path / "lights.png", title="a and b")
    assert (tmp_path / "lights.png").stat().st_size > 5000


def _map(text: str, tmp_path):
    (tmp_path / "map.csv").write_text(text)
    return read_pairs(tmp_path / "map.csv")


ONE = run({"a": "m"}, a=WAVE)


@pytest.mark.parametrize(
    ("action", "words"),
    [
        (lambda _: compare_results(ONE, run(b=WAVE)), "no channel in common"),
        (lambda _: compare_results(ONE, run({"a": "s"}, a=WAVE)), "a is in m, and a in s: these cannot be compared"),
        (lambda _: compare_results(ONE, ONE, [Pair("a", "q")]), "the second result has no 'q'"),
        (lambda _: compare_results(ONE, run(x=WAVE, y=WAVE), [Pair("a", "x"), Pair("a", "y")]), "names 'a' twice"),
        (lambda _: compare_results(ONE, ONE, limits=(30.0, 10.0)), "two rising numbers"),
        (lambda _: compare_results(ONE, ONE, relative_to="max"), "'value' or to the 'range'"),
        (lambda _: compare_results(ONE, ONE, discard=1e4), "discarding 10000 s leaves 0 points"),
        (lambda _: Comparison(())["a", "mean"], "no mean of 'a'"),
        (lambda _: Comparison(()).plot(), "nothing to draw"),
        (lambda path: _map("", path), "map.csv: is empty"),
        (lambda path: _map("first,secnd\n", path), "map.csv:1: there is no column 'secnd'"),
        (lambda path: _map("first,sign\n", path), "map.csv:1: .* columns first and second"),
        (lambda path: _map("first,second\na\n", path), "map.csv:2: a pair names"),
        (lambda path: _map("first,second,sign\na,b,2\n", path), "map.csv:2: the sign is 1 or -1, not '2'"),
        (lambda path: _map("first,second,first_unit\na,b,kfoo\n", path), "map.csv:2: .*kfoo"),
        (lambda path: read_pairs(path / "none.csv"), "none.csv: cannot be read"),
    ],
)  # fmt: skip
def test_errors(action, words, tmp_path):
    with pytest.raises(ModelError, match=words):
        action(tmp_path)
