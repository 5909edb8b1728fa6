"""Load matrices: the published one is built again from its own rows, and the rules of its structure hold for any."""

from __future__ import annotations

import csv
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from fowtlib.analysis.case_statistics import case_statistics
from fowtlib.analysis.load_matrix import LoadMatrix, LoadRow, ultimate_loads
from fowtlib.language.errors import ModelError
from fowtlib.solving.results import Result

CHANNELS = ("Mx", "My", "Mz", "Fx", "Fy", "Fz")
# Tower base of the 7 MW turbine at Levenmouth, kN m and kN, factored: Serret (2019), table 3.4.
PUBLISHED = """
Mx max,6.2,1.10,42625,15345,-226,653,-543,-8689
Mx min,6.2,1.10,-40689,34122,-3832,985,518,-8701
My max,2.2c,1.10,23573,149050,1166,1745,-275,-9050
My min,2.3b,1.10,10315,-248270,-8159,-2522,-103,-9022
Mz max,1.3b,1.35,14540,79582,19062,1033,59,-11155
Mz min,1.3b,1.35,10500,77125,-19346,1018,-153,-11069
Fx max,1.3c,1.35,-5107,177795,11883,2430,191,-11356
Fx min,2.3b,1.10,10315,-248270,-8159,-2522,-103,-9022
Fy max,6.2,1.10,-40678,34738,-4039,996,527,-8686
Fy min,6.2,1.10,42625,15345,-226,653,-543,-8689
Fz max,6.2,1.10,-599,33319,-619,852,20,-8514
Fz min,1.3c,1.35,341,146610,3237,1898,135,-11421
"""


def published() -> list[tuple[str, str, float, tuple[float, ...]]]:
    rows = [line.split(",") for line in PUBLISHED.strip().splitlines()]
    return [(extreme, case, float(factor), tuple(map(float, values))) for extreme, case, factor, *values in rows]


def points_of_the_table(without: tuple[str, ...] = ()) -> tuple[dict[str, dict[str, np.ndarray]], dict[str, float]]:
    """The cases of the table with its rows as points of time, unfactored."""
    points: dict[str, list[tuple[float, ...]]] = {}
    factors = {}
    for extreme, case, factor, values in published():
        if extreme not in without:
            points.setdefault(case, []).append(tuple(value / factor for value in values))
            factors[case] = factor
    return {case: dict(zip(CHANNELS, np.array(rows).T, strict=True)) for case, rows in points.items()}, factors


def test_the_published_matrix_is_built_from_its_own_rows():
    """But for one cell: the moment My of the row Fx max, 177795, is beyond the row My max, 149050."""
    cases, factors = points_of_the_table()
    matrix = ultimate_loads(cases, CHANNELS, factors)
    for (extreme, case, factor, values), row in zip(published(), matrix.rows, strict=True):
        assert row.extreme == extreme
        if extreme == "My max":
            assert (row.case, row.values[1]) == ("1.3c", pytest.approx(177795))
            continue
        assert (row.load_case, row.safety_factor) == (case, factor)
        assert row.values == pytest.approx(values, rel=1e-12)
    assert matrix.broken_rules() == []
    assert matrix.row("My", "min").values == matrix.row("Fx", "min").values
    assert matrix.row("Mx", "max").values == matrix.row("Fy", "min").values


def test_the_rules_find_what_is_wrong_in_the_published_matrix():
    rows = tuple(LoadRow(*extreme.split(), case, case, factor, sum(values), values)
                 for extreme, case, factor, values in published())  # fmt: skip
    printed = LoadMatrix(CHANNELS, ("kN m",) * 3 + ("kN",) * 3, rows)
    assert printed.broken_rules() == ["My max is 149050, but the row Fx max has 177795."]
    changed = replace(rows[9], values=(42625.0, 15345.0, 0.0, 653.0, -543.0, -8689.0))
    broken = replace(printed, rows=(*rows[:9], changed, *rows[10:])).broken_rules()
    assert any("Mx max and Fy min are of 6.2" in sentence and "differ" in sentence for sentence in broken)


@given(
    arrays(float, (3, 20, 4), elements=st.floats(-1e3, 1e3, allow_subnormal=False)),
    st.lists(st.floats(0.5, 2.0), min_size=3, max_size=3),
)
def test_the_rules_hold_for_any_cases(loads, factors):
    names = ("A", "B", "C", "D")
    cases = {f"case {k}": dict(zip(names, loads[k].T, strict=True)) for k in range(3)}
    factors = dict(zip(cases, factors, strict=True))
    matrix = ultimate_loads(cases, names, factors)
    assert matrix.broken_rules() == []
    everything = np.concatenate([factors[case] * loads[k] for k, case in enumerate(cases)])
    np.testing.assert_allclose(matrix.values[::2].diagonal(), everything.max(axis=0), rtol=1e-12)
    np.testing.assert_allclose(matrix.values[1::2].diagonal(), everything.min(axis=0), rtol=1e-12)
    for row in matrix.rows:  # each row has been at one time of its case
        here = factors[row.case] * loads[int(row.case[-1])][int(row.time)]
        np.testing.assert_allclose(row.values, here, rtol=1e-12)


def results() -> dict[str, Result]:
    time, rng = np.arange(0.0, 100.0, 0.5), np.random.default_rng(3)
    units = {"M": "kN m", "F": "kN"}
    return {
        f"run {i}": Result(time, {"M": rng.normal(i, 5.0, 200), "F": rng.normal(0.0, 1.0, 200)}, units)
        for i in range(6)
    }


def test_results_and_their_statistics_give_the_same_matrix():
    runs = results()
    factors = {name: 1.35 if i % 2 else 1.1 for i, name in enumerate(runs)}
    one = ultimate_loads(runs, ("M", "F"), factors, discard=20.0)
    told = {name: case_statistics(run, 20.0) for name, run in runs.items()}
    other = ultimate_loads(told, ("M", "F"), factors)
    assert one == other
    assert one.units == ("kN m", "kN")
    series = {name: {"time": run.time, "M": run.array("M"), "F": run.array("F")} for name, run in runs.items()}
    assert ultimate_loads(series, ("M", "F"), factors, discard=20.0).rows == one.rows


def test_the_mean_over_realisations():
    runs = results()
    extremes = np.array([run.array("M").max() for run in runs.values()])
    nearest = int(np.argmin(np.abs(extremes - extremes.mean())))
    row = ultimate_loads(runs, ("M", "F"), 1.35, realisations=dict.fromkeys(runs, "DLC 1.2"),
                         characteristic="mean").row("M", "max")  # fmt: skip
    assert row.values[0] == pytest.approx(1.35 * extremes.mean())
    assert row.case == f"run {nearest}"
    chosen = runs[row.case]
    at = int(chosen.array("M").argmax())
    assert row.scale == pytest.approx(extremes.mean() / extremes[nearest])
    assert row.values[1] == pytest.approx(1.35 * row.scale * chosen.array("F")[at])
    upper = ultimate_loads(runs, ("M", "F"), realisations=dict.fromkeys(runs, "DLC 2.2"),
                           characteristic={"DLC 2.2": "upper half"}).row("M", "max")  # fmt: skip
    assert upper.values[0] == pytest.approx(np.sort(extremes)[3:].mean())


def test_loads_that_change_sign_are_not_scaled():
    cases = {"a": {"M": [0.05, -5.0], "F": [7.0, 0.0]}, "b": {"M": [0.06, 0.0], "F": [8.0, 1.0]},
             "c": {"M": [-0.5, -3.0], "F": [9.0, 1.0]}}  # fmt: skip
    one = dict.fromkeys(cases, "one condition")
    row = ultimate_loads(cases, ("M", "F"), realisations=one, characteristic="mean").row("M", "max")
    assert (row.case, row.scale) == ("a", 1.0)
    assert row.values == pytest.approx((-0.13, 7.0))


def test_files(tmp_path):
    cases, factors = points_of_the_table()
    matrix = ultimate_loads(cases, CHANNELS, factors, load_cases={"6.2": "DLC 6.2"})
    text = matrix.save(tmp_path / "loads.md").read_text().splitlines()
    assert len(text) == 14
    assert text[2] == "| Mx max | DLC 6.2 | 1.10 | **42625** | 15345 | -226 | 653 | -543 | -8689 | 6.2 |"
    assert {line.count("|") for line in text} == {11}
    rows = list(csv.reader((matrix.save(tmp_path / "loads.csv")).open()))
    assert rows[0][:4] == ["extreme", "load case", "safety factor", "Mx [1]"]
    assert [float(value) for value in rows[4][3:9]] == pytest.approx(published()[3][3])


INFINITE = Result([0, 1, 2], {"M": [1, np.inf, 2]})
SIMPLE = {"one": {"M": [1.0, 2.0], "F": [0.0, 1.0]}}


@pytest.mark.parametrize(
    ("action", "words"),
    [
        (lambda: ultimate_loads({}, ["M"]), "no cases"),
        (lambda: ultimate_loads(SIMPLE, []), "one or more channels"),
        (lambda: ultimate_loads(SIMPLE, ["N"]), "one: has no channel 'N'"),
        (lambda: ultimate_loads(SIMPLE, ["M"], {"two": 1.1}), "no safety factor for the case 'one'"),
        (lambda: ultimate_loads(SIMPLE, ["M"], -1.0), "must be above 0 and finite, not -1"),
        (lambda: ultimate_loads(SIMPLE, ["M"], load_cases={"on": "1.2"}), "there is no case 'on'"),
        (lambda: ultimate_loads(SIMPLE, ["M"], characteristic="best"), "several realisations is .*, not 'best'"),
        (lambda: ultimate_loads(SIMPLE, ["M"], discard=3.0), "has no 'time'"),
        (lambda: ultimate_loads({"one": {"time": [0, 1], "M": [1, np.nan]}}, ["M"]), "M at 1 s is not a finite"),
        (lambda: ultimate_loads({"one": {"time": [0, 1], "M": [1, 2, 3]}}, ["M"]), "one value for each of 2 points"),
        (lambda: ultimate_loads({"a": Result([0, 1], {"M": [1, 2]}, {"M": "N m"}),
                                 "b": Result([0, 1], {"M": [1, 2]}, {"M": "kN m"})}, ["M"]), "N m in a, and in kN m"),
        (lambda: ultimate_loads({"a": case_statistics(INFINITE)}, ["M"]), "a: M: the value at 1 s"),
        (lambda: ultimate_loads(SIMPLE, ["M"]).save("loads.txt"), "saved as .csv or .md"),
        (lambda: ultimate_loads(SIMPLE, ["M"]).row("F", "max"), "no row 'F max'"),
    ],
)  # fmt: skip
def test_errors(action, words):
    with pytest.raises(ModelError, match=words):
        action()
