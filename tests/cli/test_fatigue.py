"""`fowt fatigue`: equivalent loads of a result with known cycles, and mistakes."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from fowtlib.cli.app import main
from fowtlib.solving.results import Result


@pytest.fixture(autouse=True)
def run(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """25 s with cycles of 1 Hz, from crest to crest, in run.nc."""
    monkeypatch.chdir(tmp_path)
    t = np.arange(25 * 40 + 1) / 40.0
    wave = np.cos(2 * np.pi * t)
    values = {"thrust": 3 * wave, "tension": np.stack([wave, 2 * wave], axis=1), "surge": 5 * wave}
    Result(t, values, {"thrust": "kN", "tension": "N", "surge": "m"}).save("run.nc")


def rows(capsys, *argv: str) -> list[dict]:
    assert main(["fatigue", "run.nc", *argv, "--json"]) == 0
    return json.loads(capsys.readouterr().out)


def test_all_loads_of_a_result(capsys):
    found = rows(capsys)
    assert [(row["result"], row["unit"]) for row in found] == [
        ("thrust", "kN"),
        ("tension[0]", "N"),
        ("tension[1]", "N"),
    ]
    for row, wanted in zip(found, (6.0, 2.0, 4.0), strict=True):
        assert [row["m = 4"], row["m = 10"]] == pytest.approx([wanted] * 2)


def test_names_exponents_frequency_and_the_beginning(capsys):
    (one, two) = rows(
        capsys, "surge", "thrust", "--exponent", "3", "5", "--frequency", "0.5", "--discard", "5", "--bins", "7"
    )
    assert (one["result"], two["result"]) == ("surge", "thrust")
    assert [one["m = 3"], one["m = 5"]] == pytest.approx([10 * 2 ** (1 / 3), 10 * 2 ** (1 / 5)])
    assert two["m = 3"] == pytest.approx(6 * 2 ** (1 / 3))


def test_files_of_openfast(capsys):
    """Names and units change on the way, and numbers have 16 bits."""
    t = np.arange(25 * 40 + 1) / 40.0
    units = {"tower_base_fore_aft_moment": "N m", "fairlead_tension_1": "kN", "surge": "m"}
    Result(t, {name: 3 * np.cos(2 * np.pi * t) for name in units}, units).save("run.outb")
    assert main(["fatigue", "run.outb", "--json"]) == 0
    found = {row["result"]: row for row in json.loads(capsys.readouterr().out)}
    size = {"N m": 6.0, "kN m": 6e-3, "kN": 6.0, "N": 6e3}
    assert set(found) == {"tower_base_fore_aft_moment", "fairlead_tension_1"}
    for row in found.values():
        assert row["m = 4"] == pytest.approx(size[row["unit"]], rel=1e-3)


def test_for_people_and_into_a_file(capsys):
    assert main(["fatigue", "run.nc", "thrust", "--discard", "5", "-o", "loads.csv"]) == 0
    shown = capsys.readouterr()
    assert shown.out.startswith("ranges of 1 Hz that do the damage of 5 to 25 s\n")
    head, one = Path("loads.csv").read_text().splitlines()
    assert head == "result,unit,m = 4,m = 10"
    assert one.startswith("thrust,kN,6.0")
    assert main(["fatigue", "run.nc", "-o", "loads.csv"]) == 2
    assert "loads.csv is there already" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("argv", "said"),
    [
        (["run.nc", "thurst"], "run.nc: there is no result 'thurst'; did you mean 'thrust'?\n"),
        (["run.nc", "--discard", "30"], "run.nc: thrust: discarding 30 s leaves nothing of a record of 25 s.\n"),
        (["none.nc"], "none.nc: there is no such file.\n"),
        (["run.nc", "-o", "loads.txt"], "loads.txt: the file must end in '.csv' or '.json'.\n"),
    ],
)
def test_mistakes(capsys, argv, said):
    assert main(["fatigue", *argv]) == 2
    assert capsys.readouterr().err == f"fowt fatigue: {said}"


def test_a_result_without_loads(capsys):
    Result([0.0, 1.0, 2.0], {"surge": [1.0, 2.0, 1.0]}, {"surge": "m"}).save("motion.csv")
    assert main(["fatigue", "motion.csv"]) == 2
    assert capsys.readouterr().err == (
        "fowt fatigue: motion.csv: no series of it is a force, a moment or a stress; name the series that you mean.\n"
    )


@pytest.mark.parametrize(
    ("argv", "said"),
    [
        (["--exponent", "0"], "--exponent: '0' is not a positive number"),
        (["--exponent", "four"], "--exponent: 'four' is not a positive number"),
        (["--discard", "-1"], "--discard: '-1' is below 0"),
        (["--bins", "0.5"], "--bins: '0.5' is not a number of classes (1, 2, ...)"),
        (["--frequency", "0"], "--frequency: '0' is not a positive number"),
    ],
)
def test_refused_values(capsys, argv, said):
    with pytest.raises(SystemExit) as caught:
        main(["fatigue", "run.nc", *argv])
    assert caught.value.code == 2
    assert said in capsys.readouterr().err
