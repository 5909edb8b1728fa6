"""`fowt contours` and `fowt extremes`."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import numpy as np
import pytest
import yaml

from fowtlib.cli.app import main
from fowtlib.metocean import bins, distance, radius, site, surface
from fowtlib.metocean.states import States


@pytest.fixture(autouse=True)
def empty_folder(monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)


def states_of(rows: list[dict]) -> States:
    return States(*([float(row[name]) for row in rows] for name in ("wind_speed [m/s]", "Hs [m]", "Tp [s]")))


def test_a_contour_with_picture_and_table(capsys):
    files = ["--plot", "contour.png", "--output", "contour.csv"]
    assert main(["contours", "norway_5", "--height", "90", "--cut-out", "25", *files]) == 0
    shown = capsys.readouterr()
    assert "wind at 90 m, shear exponent 0.1; states of 1 h; 50 years: beta 4.5839, 104.6 h, to 25 m/s" in shown.out
    assert shown.err == "saved contour.csv\nsaved contour.png\n"
    rows = list(csv.DictReader(Path("contour.csv").read_text().splitlines()))
    assert len(rows) == 48
    joint = site("norway_5").at(90)
    assert distance(joint, states_of(rows[:24])) == pytest.approx(radius(50), abs=1e-6)
    assert max(float(row["wind_speed [m/s]"]) for row in rows[24:]) == pytest.approx(25)
    assert Path("contour.png").read_bytes().startswith(b"\x89PNG")
    assert main(["contours", "norway_5", "--plot", "contour.png"]) == 2  # it is there already


def test_rings_and_inflation(capsys):
    options = ["--wind", "8:24:8", "--points", "7", "--upper", "--fractile", "0.9", "--json", "--duration", "3h"]
    assert main(["contours", "northern_north_sea", *options]) == 0
    rows = json.loads(capsys.readouterr().out)
    assert [row["wind_speed [m/s]"] for row in rows[::7]] == pytest.approx([8, 16, 24])
    assert rows[0]["contour"] == "50 years, inflated for 90 %"
    far = distance(site("northern_north_sea"), states_of(rows))
    assert far.min() == pytest.approx(far.max())
    assert far.min() > radius(50, 3 * 3600) * 1.1


def test_bins_of_all_states(capsys):
    assert main(["extremes", "norway_5", "--json"]) == 0
    shown = capsys.readouterr()
    assert "1142 of 8160 bins occur at least once in 1000 years, and hold 92.472 % of the time" in shown.err
    rows = json.loads(shown.out)
    assert len(rows) == 1142
    assert sum(row["probability"] for row in rows) == pytest.approx(0.92472, abs=1e-5)


def test_a_cases_file_for_a_batch(capsys):
    files = ["--cases", "cases.yaml", "--model", "two_rotor_spar_rigid", "--seeds", "2"]
    assert main(["extremes", "norway_5", "--method", "mecm", "--cut-out", "25", "--points", "5", *files]) == 0
    written = yaml.safe_load(Path("cases.yaml").read_text())
    assert written["fowtlib_cases"] == 1 and written["model"] == "two_rotor_spar_rigid"
    assert written["defaults"]["seeds"] == 2 and written["defaults"]["duration"] == "4000 s"
    below, above = written["sets"]
    assert (below["group"], above["group"]) == ("MECM", "MECM above cut-out")
    assert max(below["vary"]["zip"]["wind_speed"]) == pytest.approx(25)
    assert min(above["vary"]["zip"]["wind_speed"]) == 26
    counts = [len({len(column) for column in part["vary"]["zip"].values()}) for part in written["sets"]]
    assert counts == [1, 1]
    assert main(["extremes", "norway_5", "--cases", "all.yaml", "--model", "oc3_spar_rigid"]) == 0
    (everything,) = yaml.safe_load(Path("all.yaml").read_text())["sets"]
    assert everything["weight"] == "probability"
    assert sum(everything["vary"]["zip"]["probability"]) == pytest.approx(0.92472, abs=1e-5)


def test_a_sample_with_random_turbulence(capsys):
    words = ["extremes", "norway_5", "--method", "sample", "--count", "50", "--turbulence", "B"]
    tables = []
    for more in (["--seed", "3"], ["--seed", "3"], ["--seed", "4"]):
        assert main([*words, *more, "--json"]) == 0
        tables.append(json.loads(capsys.readouterr().out))
    assert tables[0] == tables[1] != tables[2]
    assert len(tables[0]) == 50 and tables[0][0]["probability"] == 0.02
    assert main([*words, "--cases", "cases.yaml", "--model", "oc3_spar_rigid"]) == 0
    written = yaml.safe_load(Path("cases.yaml").read_text())
    assert written["defaults"]["wind"]["turbulence_intensity"] == "turbulence_intensity"
    assert len(written["sets"][0]["vary"]["zip"]["turbulence_intensity"]) == 50


def test_extremes_from_maxima(capsys):
    """Runs of a response that is the wave height itself, with hardly any scatter: all find the 50-year waves."""
    joint = site("norway_5").at(90)
    states = bins(joint, np.arange(0.5, 50, 2), np.arange(0.1, 20, 0.2), [10, 30], keep=None)
    ring = surface(joint, radius(50), wind_speeds=[30, 36, 38, 39, 40], points=3, upper=True)
    with open("maxima.csv", "w", newline="") as file:
        out = csv.writer(file)
        out.writerow(["wind_speed [m/s]", "Hs [m]", "Tp [s]", "probability", "seed", "height [m]"])
        for part in (states, ring):
            for index, (u, h, t) in enumerate(part):
                p = "" if part.probability is None else part.probability[index]
                out.writerows([u, h, t, p, seed, h * (1 + 1e-6 * seed)] for seed in (1, 2))
    assert main(["extremes", "norway_5", "--maxima", "maxima.csv", "--plot", "e.png", "--json"]) == 0
    shown = capsys.readouterr()
    (row,) = json.loads(shown.out)
    waves = float(joint.marginal("wave_height").isf(1 / (50 * 365.25 * 24)))
    assert row["FLTA"] == pytest.approx(waves, abs=0.11)  # half a bin
    assert row["ECM"] == pytest.approx(waves, rel=0.01)
    assert row["MECM"] is None and row["unit"] == "m"
    assert "saved e.png" in shown.err and "too high" not in shown.err


def test_the_worst_states_are_listed_for_more_seeds(capsys):
    joint = site("norway_5").at(90)
    ring = surface(joint, radius(50), wind_speeds=[10, 20, 30], points=5, upper=True)
    with open("fits.csv", "w", newline="") as file:
        out = csv.writer(file)
        out.writerow(["response", "wind_speed", "Hs", "Tp", "location", "scale"])
        for u, h, t in ring:  # two responses, one of the waves and one of calm
            out.writerows([["high", u, h, t, h, 0.1], ["low", u, h, t, 20 - h, 0.1]])
    words = ["extremes", "norway_5", "--fits", "fits.csv", "--cases", "worst.yaml", "--model", "oc3_spar_rigid"]
    assert main([*words, "--worst", "2", "--seeds", "20"]) == 0
    assert "4 states, the 2 worst of each contour and response" in capsys.readouterr().out
    (part,) = yaml.safe_load(Path("worst.yaml").read_text())["sets"]
    heights = np.sort(ring.wave_height)
    assert sorted(part["vary"]["zip"]["Hs"]) == pytest.approx([*heights[:2], *heights[-2:]])
    assert "probability" not in part["vary"]["zip"]
    assert main([*words, "--force"]) == 2
    assert "--cases and --worst belong together" in capsys.readouterr().err


def test_few_runs_are_named(capsys):
    states = bins(site("norway_5").at(90), [8, 12, 16, 20], [1, 2, 3, 4], [8, 10, 12])
    rng = np.random.default_rng(1)
    with open("maxima.csv", "w", newline="") as file:
        out = csv.writer(file)
        out.writerow(["wind_speed", "Hs", "Tp", "probability", "surge [m]"])
        for (u, h, t), p in zip(states, states.weights, strict=True):
            out.writerows([u, h, t, p, 5 + rng.gumbel()] for _ in range(3))
    assert main(["extremes", "norway_5", "--maxima", "maxima.csv"]) == 0
    assert "surge: its laws come from 3 runs a state, too few" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (["contours", "norway_6"], "there is no site 'norway_6'; did you mean 'norway_5'?"),
        (["contours", "norway_5", "--wind", "10,50"], "50 m/s is beyond the contour, whose wind speeds are"),
        (["contours", "norway_5", "--duration", "soon"], "'soon' is not a time, for example 10min or 1h"),
        (["contours", "norway_5", "--cut-out", "500"], "500 m/s of wind is never exceeded: no contour ends there."),
        (["contours", "cases.yaml"], "cases.yaml: this is no site: a file with 'fowtlib_cases' is of another kind."),
        (["contours", "norway_5", "--points", "2"], "a contour has 3 points or more, not 2."),
        (["contours", "norway_5", "--wind", "-4:4:1"], "--wind"),
        (["contours", "norway_5", "--return-period", "5000"], "Take the upper half of the contour"),
        (["extremes", "norway_5", "--method", "mecm"], "the modified method needs --cut-out"),
        (["extremes", "norway_5", "--cases", "c.yaml"], "--cases and --model belong together"),
        (["extremes", "norway_5", "--results", "surge"], "--results is about the runs of a batch: give --batch."),
        (["extremes", "norway_5", "--batch", "none.yaml"], "begin the batch with fowt batch run none.yaml"),
        (["extremes", "norway_5", "--turbulence", "B"], "--turbulence is drawn for the states of a sample alone"),
        (
            ["extremes", "norway_5", "--plot", "e.png"],
            "--plot and --worst are about extremes: give --batch, --fits or --maxima",
        ),
        (["extremes", "norway_5", "--fits", "none.csv"], "cannot read the table of fits"),
        (["extremes", "norway_5", "--method", "form"], "unknown NAME 'form' of --method; there are"),
        (["extremes", "norway_5", "--cases", "c.txt", "--model", "m"], "the file must end in"),
    ],
)
def test_mistakes_are_sentences(words, says, capsys):
    Path("cases.yaml").write_text("fowtlib_cases: 1\n")
    try:
        status = main(words)
    except SystemExit as left:
        status = left.code
    shown = capsys.readouterr().err
    assert status == 2
    assert says in shown and "Traceback" not in shown
    assert list(Path().iterdir()) == [Path("cases.yaml")]  # nothing else was written
