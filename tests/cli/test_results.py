"""Commands that read results: statistics, maxima, loads, compare; against numbers that are known."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import numpy as np
import pytest

from fowtlib.cli.app import main
from fowtlib.solving.results import Result

TIME = np.arange(0.0, 2000.0, 0.5)
FEW = ("--samples", "40")
UNITS = {"surge": "m", "thrust": "kN", "M": "kN m"}


@pytest.fixture(autouse=True)
def files(tmp_path, monkeypatch):
    """Three realisations of a process with noise, and one with another level."""
    monkeypatch.chdir(tmp_path)
    for seed in range(3):
        rng = np.random.default_rng(seed)
        # irregular frequencies: equal steps of 0.0025 Hz would come again after 400 s
        waves = [np.cos(2 * np.pi * rng.uniform(0.05, 0.15) * TIME + rng.uniform(0, 2 * np.pi)) for _ in range(40)]
        wave = sum(waves) / np.sqrt(20)
        values = {"surge": 10.0 + wave, "thrust": 500.0 + 50.0 * wave, "M": -100.0 * wave}
        Result(TIME, values, UNITS).save(f"seed_{seed}.nc")
    Result(TIME, {"PtfmSurge": 12.0 + 1.2 * wave, "Force": -0.5 - 0.05 * wave}, {"PtfmSurge": "m", "Force": "MN"}).save(
        "other.csv"
    )


def printed(capsys, *argv: str):
    assert main([*argv, "--json"]) == 0, capsys.readouterr().err
    return json.loads(capsys.readouterr().out)


def test_statistics_of_one_result(capsys):
    rows = {row["result"]: row for row in printed(capsys, "statistics", "seed_0.nc", "--percentiles", "50,99")}
    surge = Result.open("seed_0.nc").array("surge")
    assert rows["surge"]["mean"] == pytest.approx(surge.mean())
    assert rows["surge"]["99 %"] == pytest.approx(np.percentile(surge, 99))
    assert rows["thrust"]["unit"] == "kN"
    assert rows["surge"]["kurtosis"] == pytest.approx(rows["thrust"]["kurtosis"])
    rows = printed(capsys, "statistics", "seed_0.nc", "--of", "M", "--discard", "1000")
    assert [row["result"] for row in rows] == ["M"]
    assert rows[0]["max"] == pytest.approx(Result.open("seed_0.nc").array("M")[2000:].max())


def test_statistics_over_results(capsys):
    seeds = [f"seed_{i}.nc" for i in range(3)]
    (row,) = printed(capsys, "statistics", *seeds, "--of", "surge")
    maxima = [Result.open(seed).array("surge").max() for seed in seeds]
    assert row["max"] == max(maxima)
    assert row["max_case"] == f"seed_{int(np.argmax(maxima))}"
    assert row["mean_max"] == pytest.approx(np.mean(maxima))
    each = printed(capsys, "statistics", *seeds, "--of", "surge,thrust", "--each")
    assert [(row["case"], row["result"]) for row in each][:2] == [("seed_0", "surge"), ("seed_0", "thrust")]
    assert main(["statistics", *seeds]) == 0
    assert "3 results" in capsys.readouterr().out


def test_what_is_not_finite_is_said(capsys):
    Result(TIME, {"a": TIME, "b": np.where(TIME == 7, np.nan, TIME)}).save("bad.nc")
    assert main(["statistics", "bad.nc"]) == 0
    assert "bad: b is left out: the value at 7 s is not a finite number." in capsys.readouterr().err


def test_what_not_every_result_has_is_said(capsys):
    Result(TIME, {"surge": TIME, "extra": TIME}, UNITS).save("more.nc")
    (row,) = printed(capsys, "statistics", "seed_0.nc", "more.nc")
    assert row["result"] == "surge"
    assert main(["statistics", "seed_0.nc", "more.nc"]) == 0
    assert "left out, because not every result has them: M, extra, thrust" in capsys.readouterr().err
    assert main(["statistics", "seed_0.nc", "other.csv"]) == 2
    assert "these results have no series in common" in capsys.readouterr().err


def test_maxima(capsys):
    seeds = [f"seed_{i}.nc" for i in range(3)]
    rows = {row["method"]: row for row in printed(capsys, "maxima", *seeds, "--of", "surge", "--block", "200", *FEW)}
    assert list(rows) == ["gumbel", "likelihood", "pareto", "exponential", "crossings", "gaussian"]
    records = np.array([Result.open(seed).array("surge") for seed in seeds])
    blocks = records.reshape(30, 400).max(axis=1)
    scale = np.sqrt(6) * blocks.std(ddof=1) / np.pi
    location = blocks.mean() - np.euler_gamma * scale
    assert rows["gumbel"]["value"] == pytest.approx(location + scale * np.log(3600 / 200))
    assert rows["gumbel"]["low 95 %"] < rows["gumbel"]["value"] < rows["gumbel"]["high 95 %"]
    expected = 10.0 + np.sqrt(2 * np.log(0.1 * 3600))  # a Gaussian process of deviation 1 about 0.1 Hz
    # the mean excess of Rayleigh's peaks over 1.4 is 0.5396: exponential peaks lie higher, by theory
    higher = 10.0 + 1.4 + 0.5396 * np.log(0.1 * 3600 * np.exp(-(1.4**2) / 2))
    for method, row in rows.items():
        assert row["value"] == pytest.approx(higher if method == "exponential" else expected, abs=0.5), method
    (row,) = printed(
        capsys, "maxima", *seeds, "--of", "surge", "--method", "gaussian", "--side", "min", "--fractile", "0.9"
    )
    assert row["value"] == pytest.approx(10.0 - np.sqrt(2 * np.log(360 / -np.log(0.9))), abs=0.3)


def test_pictures_of_maxima(capsys):
    argv = ["maxima", "seed_0.nc", "--of", "surge", "--block", "100", *FEW]
    assert main([*argv, "--method", "gumbel", "--plot", "gumbel.png"]) == 0
    assert main([*argv, "--method", "crossings", "--plot", "rates.svg"]) == 0
    assert capsys.readouterr().err == "saved gumbel.png\nsaved rates.svg\n"
    assert "rate of outward passages" in Path("rates.svg").read_text() or Path("rates.svg").stat().st_size > 10000
    assert main([*argv, "--method", "pareto", "--plot", "p.png"]) == 2
    assert "no picture of the method pareto" in capsys.readouterr().err


def test_too_few_blocks_leave_the_other_methods(capsys):
    assert main(["maxima", "seed_0.nc", "--of", "surge", *FEW]) == 0
    shown = capsys.readouterr()
    assert "gumbel: surge, maxima of blocks: there are 1, and a fit takes 5 or more" in shown.err
    assert "crossings" in shown.out and "gumbel" not in shown.out
    assert main(["maxima", "seed_0.nc", "--of", "surge", "--method", "gumbel"]) == 2


def test_loads(capsys):
    seeds = [f"seed_{i}.nc" for i in range(3)]
    Path("cases.csv").write_text(
        "result,safety_factor,load_case,condition\nseed_0,1.35,1.2,A\nseed_1,1.35,1.2,A\nseed_2,1.1,6.2,\n"
    )
    argv = ["loads", *seeds, "--of", "thrust,M", "--cases", "cases.csv"]
    rows = {row["extreme"]: row for row in printed(capsys, *argv)}
    maxima = np.array([Result.open(seed).array("thrust").max() for seed in seeds])
    factored = maxima * (1.35, 1.35, 1.1)
    best = int(np.argmax(factored))
    row = rows["thrust max"]
    assert row["thrust [kN]"] == pytest.approx(factored[best])
    assert (row["case"], row["load case"]) == (f"seed_{best}", "6.2" if best == 2 else "1.2")
    assert row["M [kN m]"] == pytest.approx(-2.0 * row["safety factor"] * (maxima[best] - 500.0))
    assert main([*argv, "--characteristic", "mean", "-o", "loads.md"]) == 0
    mean = 1.35 * maxima[:2].mean()
    assert f"**{max(mean, factored[2]):.4g}**" in Path("loads.md").read_text()
    assert main([*argv, "-o", "loads.md"]) == 2
    assert "loads.md is there already" in capsys.readouterr().err


def test_compare(capsys):
    Path("map.csv").write_text("first,second,sign\nthrust,Force,-1\n")
    argv = ["compare", "other.csv", "seed_2.nc"]
    rows = {(row["result"], row["measure"]): row for row in printed(capsys, *argv)}
    assert {name for name, _ in rows} == {"PtfmSurge"}
    assert rows["PtfmSurge", "mean"]["other name"] == "surge"
    assert rows["PtfmSurge", "mean"]["difference [%]"] == pytest.approx(20.0, abs=0.01)
    assert rows["PtfmSurge", "std"]["light"] == "amber"
    argv = ["compare", "seed_2.nc", "other.csv", "--map", "map.csv"]
    rows = {(row["result"], row["measure"]): row for row in printed(capsys, *argv)}
    assert rows["thrust", "max"]["difference [%]"] == pytest.approx(0.0, abs=1e-4)
    assert main([*argv, "--plot", "lights.png", "-o", "lights.csv"]) == 0
    shown = capsys.readouterr()
    assert "2 channels, 8 values: 4 green, 4 amber" in shown.out and "only in A: M" in shown.out
    assert len(list(csv.reader(Path("lights.csv").read_text().splitlines()))) == 9
    assert main([*argv, "--strict"]) == 0
    assert main([*argv, "--strict", "--limits", "1,2"]) == 1


def test_compare_with_equivalent_loads(capsys):
    pytest.importorskip("fowtlib.analysis.fatigue")
    rows = printed(capsys, "compare", "seed_0.nc", "seed_0.nc", "--equivalent-loads", "4,10")
    assert {row["measure"] for row in rows} >= {"DEL 4", "DEL 10"}
    assert all(row["difference [%]"] == 0.0 and row["first"] > 0 for row in rows if row["measure"].startswith("DEL"))


@pytest.mark.parametrize(
    ("argv", "words"),
    [
        ("statistics none.nc", "none.nc: there is no such file"),
        ("statistics seed_0.nc --of srge", "seed_0: there is no result 'srge'; did you mean 'surge'"),
        ("statistics seed_0.nc --percentiles 200", "percentiles from 0 to 100"),
        ("statistics seed_0.nc --discard 5000", "leaves 0 points of a result of 1999.5 s"),
        ("statistics seed_0.nc --discard -1", "'-1' is negative"),
        ("statistics seed_0.nc seed_0.nc", "seed_0.nc: is named twice"),
        ("maxima seed_0.nc --of surge --samples 3", "20 or more"),
        ("maxima seed_0.nc --of surge --fractile 2", "not a probability"),
        ("maxima seed_0.nc --of surge --method best", "unknown METHOD 'best' of --method; there are"),
        ("maxima seed_0.nc other.csv --of surge", "other: there is no result 'surge'"),
        ("loads seed_0.nc --of N", "seed_0: there is no result 'N'"),
        ("loads seed_0.nc --of M --cases none.csv", "none.csv: cannot be read"),
        ("loads seed_0.nc --of M -o loads.txt", "must end in '.csv' or '.md'"),
        ("compare seed_0.nc other.csv --limits 30,10", "not two rising percentages"),
        ("compare seed_0.nc other.csv --map none.csv", "none.csv: cannot be read"),
        ("compare seed_0.nc", "are required: B"),
    ],
)
def test_errors(capsys, argv, words):
    try:
        status = main(argv.split())
    except SystemExit as stop:
        status = stop.code
    shown = capsys.readouterr().err
    assert status == 2
    assert words in shown, shown
    assert "Traceback" not in shown


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("result,factor\n", "cases.csv:1: there is no column 'factor'"),
        ("load_case\n", "cases.csv:1: the first line names the columns"),
        ("result\nseed_9\n", "cases.csv:2: no result is called 'seed_9'"),
        ("result\nseed_0\nseed_0\n", "cases.csv:3: 'seed_0' is named twice"),
        ("result,safety_factor\nseed_0,-1\n", "cases.csv:2: safety_factor: '-1' is not a positive number"),
        ("result\nseed_0,1\n", "cases.csv:2: has more cells"),
    ],
)
def test_errors_in_the_table_of_cases(capsys, text, words):
    Path("cases.csv").write_text(text)
    assert main(["loads", "seed_0.nc", "--of", "M", "--cases", "cases.csv"]) == 2
    assert words in capsys.readouterr().err
