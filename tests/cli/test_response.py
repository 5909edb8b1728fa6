"""`fowt response` on the command line."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import pytest

from fowtlib.cli.app import main
from fowtlib.frequency import many


def test_response_prints_statistics_and_saves_spectra(tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    spectra, picture = tmp_path / "spectra.csv", tmp_path / "spectra.png"
    asked = ["response", "oc3_spar_rigid", "--wind", "none", "--waves", "jonswap:Hs=4,Tp=10", "--outputs", "heave,yaw"]
    assert main([*asked, "--json", "--spectra", str(spectra), "--plot", str(picture)]) == 0
    rows = {row["result"]: row for row in json.loads(capsys.readouterr().out.partition("]\n")[0] + "]")}
    heave = rows["heave [m]"]
    assert heave["largest"] - heave["mean"] == pytest.approx(heave["mean"] - heave["smallest"])
    assert 3 * heave["std"] < heave["largest"] - heave["mean"] < 5 * heave["std"]
    assert picture.stat().st_size > 10_000
    with spectra.open() as file:
        table = list(csv.reader(file))
    assert table[0] == ["frequency [Hz]", "heave [(m)^2/Hz]", "yaw [(deg)^2/Hz]"]
    assert len(table) > 200


def test_a_response_that_reaches_over_a_corner_of_a_control_law_warns(capsys: pytest.CaptureFixture[str]):
    assert main(["response", "oc3_spar_rigid", "--wind", "kaimal:12,class=B", "--outputs", "pitch"]) == 0
    told = capsys.readouterr().err
    assert told.startswith("fowt: warning: the response reaches over corners of control laws")
    assert "turbine.control.torque.actual is another one in" in told
    assert main(["response", "oc3_spar_rigid", "--wind", "kaimal:18,class=B", "--outputs", "pitch"]) == 0
    assert "corners" not in capsys.readouterr().err


def test_mistakes_of_response(capsys: pytest.CaptureFixture[str]):
    assert main(["response", "oc3_spar_rigid", "--outputs", "heavy"]) == 2
    assert "the model has no result 'heavy'; did you mean 'heave'?" in capsys.readouterr().err
    assert main(["response", "oc3_spar_rigid", "--wind", "none", "--waves", "still"]) == 2
    assert "takes anything from random waves or wind" in capsys.readouterr().err
    assert main(["response", "oc3_spar_rigid_bem", "--linearisation", "quadratic"]) == 2
    assert "does not know the products in rotors of blade elements that turn" in capsys.readouterr().err
    assert main(["response", "oc3_spar_rigid", "--wind", "turbulence:8", "--varying-speed"]) == 2
    assert "no rotor of blade elements turns through a field of turbulence" in capsys.readouterr().err


def test_a_speed_that_varies_widens_what_blades_meet(capsys: pytest.CaptureFixture[str]):
    """In 8 m/s three times a turn, 0.45 Hz, is near the tower's first side-side mode; thrust is far below."""
    asked = ["response", "nrel5mw_land", "--wind", "turbulence:8,class=B", "--json"]
    asked += ["--outputs", "thrust,tower_base_side_side_moment"]
    found = []
    for options in ([], ["--varying-speed"]):
        assert main([*asked, *options]) == 0
        out = capsys.readouterr().out
        found.append([row["std"] for row in json.loads(out[out.index("[") :])])
    steady, varying = found
    assert varying[0] == pytest.approx(steady[0], rel=0.01)
    assert abs(varying[1] / steady[1] - 1) > 0.02


def test_response_over_many_states(tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    states, each = tmp_path / "states.csv", tmp_path / "each.csv"
    states.write_text("wind_speed [m/s],Hs [m],Tp [s],probability,sea.heading\n14,2,9,0.6,0\n14,4,10,0.3,0.5\n")
    asked = ["response", "oc3_spar_rigid", "--wind", "kaimal:14,class=C", "--outputs", "heave"]
    assert main([*asked, "--states", str(states), "--each", str(each), "--json"]) == 0
    out = capsys.readouterr().out
    (row,) = json.loads(out.partition("]\n")[0] + "]")
    with each.open() as file:
        rows = list(csv.DictReader(file))
    std = [float(row["std of heave [m]"]) for row in rows]
    assert row["std"] == pytest.approx((0.6 * std[0] + 0.3 * std[1]) / 0.9)
    assert (row["in state"], row["in state "]) == (2, 2)
    assert [row["sea.heading"] for row in rows] == ["0", "0.5"]


@pytest.mark.parametrize("done", [0, 1])
def test_a_list_of_states_that_is_stopped(done, tmp_path: Path, capsys, monkeypatch: pytest.MonkeyPatch):
    """Ctrl-C has the status 130; the table of what was found is shown and saved."""
    states, each = tmp_path / "states.csv", tmp_path / "each.csv"
    states.write_text("wind_speed [m/s],Hs [m],Tp [s],probability\n14,2,9,0.5\n14,3,9,0.3\n14,4,9,0.2\n")
    counted, real = [], many.response

    def stopped(*items, **options):
        if len(counted) == done:
            raise KeyboardInterrupt
        counted.append(1)
        return real(*items, **options)

    monkeypatch.setattr(many, "response", stopped)
    asked = ["response", "oc3_spar_rigid", "--wind", "kaimal:14,class=C", "--outputs", "heave", "--states", str(states)]
    assert main([*asked, "--each", str(each)]) == 130
    told = capsys.readouterr()
    assert (f"stopped after {done} of 3 states" if done else "stopped; nothing was saved") in told.err
    assert ("heave" in told.out, each.exists()) == (bool(done), bool(done))


def test_mistakes_of_response_over_many_states(tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    def said(*options: str) -> str:
        assert main(["response", "oc3_spar_rigid", *options]) == 2
        return capsys.readouterr().err

    assert "--bins belongs to many states" in said("--bins")
    assert "--plot is for one state" in said("--site", "northern_north_sea", "--plot", "x.png")
    assert "equivalent is for one state" in said("--site", "northern_north_sea", "--linearisation", "equivalent")
    assert "--varying-speed is for one state" in said("--site", "northern_north_sea", "--varying-speed")
    assert "there is no site 'nowhere'" in said("--site", "nowhere")
    states = tmp_path / "states.csv"
    states.write_text("wind_speed,Hs,Tp,probably\n8,2,9,0.4\n")
    assert "no column 'probably'; did you mean 'probability'" in said("--states", str(states))
    assert "--speeds, --height and --bins choose states of a --site" in said("--states", str(states), "--bins")
    assert "cannot read the list of states" in said("--states", str(tmp_path / "none.csv"))


@pytest.mark.parametrize(
    "text, why",
    [
        ("probability\n8,2,9,-0.4\n", ":2: a probability is 0 or more"),
        ("probability\n8,2,9,0.8\n10,2,9,0.7\n", "have the sum 1.5"),
        ("probability [%]\n8,2,9,50\n", "not in %"),
        ("probability,sea.headng\n8,2,9,0.5,3\n", "states.csv: the model has no parameter 'sea.headng'"),
        ("probability,sea.heading [kg]\n8,2,9,0.5,3\n", "which is a mass"),
    ],
)
def test_mistakes_in_a_file_of_states_name_the_file(text: str, why: str, tmp_path: Path, capsys):
    path = tmp_path / "states.csv"
    path.write_text("wind_speed,Hs,Tp," + text)
    assert main(["response", "oc3_spar_rigid", "--outputs", "heave", "--states", str(path)]) == 2
    assert why in capsys.readouterr().err


def test_a_column_of_states_is_in_the_unit_of_its_head(tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    found = []
    for head, value in (("sea.heading [deg]", "90"), ("sea.heading", "1.5707963267948966")):
        path = tmp_path / "states.csv"
        path.write_text(f"wind_speed,Hs,Tp,{head}\n8,2,9,{value}\n")
        asked = ["response", "oc3_spar_rigid", "--outputs", "sway"]
        assert main([*asked, "--states", str(path), "--json"]) == 0
        out = capsys.readouterr().out
        found.append(json.loads(out[out.index("[") :])[0]["std"])
    assert found[0] == pytest.approx(found[1], rel=1e-9) and found[0] > 0.01
