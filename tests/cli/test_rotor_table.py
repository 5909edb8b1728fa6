"""`fowt rotor-table` on the shipped turbine, with coarse grids."""

from __future__ import annotations

import csv
import json
import math
from pathlib import Path

import numpy as np
import pytest

import fowtlib.models
from fowtlib.cli.app import main
from fowtlib.components.aero import read_coefficients, read_load_slopes

COARSE = ["rotor-table", "nrel5mw_land", "--ratios", "4:12:1", "--pitch", "-2:22:2", "--winds", "8,11,20"]


@pytest.fixture(autouse=True)
def empty_folder(monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)


def test_table_curve_and_picture(capsys):
    files = ["--output", "rotor.csv", "--curve", "curve.csv", "--plot", "rotor.png"]
    assert main([*COARSE, *files]) == 0
    shown = capsys.readouterr()
    assert shown.err == "saved rotor.csv\nsaved curve.csv\nsaved rotor.png\n"
    assert shown.out.startswith("largest C_p of the table 0.49")
    table = read_coefficients("rotor.csv")
    assert table.tip_speed_ratio == pytest.approx(np.arange(4, 13))
    assert np.degrees(table.blade_pitch) == pytest.approx(np.arange(-2, 23, 2))
    rows = [line.split(",") for line in Path("rotor.csv").read_text().splitlines() if line[0] not in "#t"]
    ratio, _, power, _, torque = np.array(rows, dtype=float).T
    assert power == pytest.approx(ratio * torque * math.cos(math.radians(2.5)), abs=1e-5)  # 7 decimals
    below, rated, above = csv.DictReader(Path("curve.csv").read_text().splitlines())
    assert float(below["blade pitch [deg]"]) == float(rated["blade pitch [deg]"]) == 0
    assert float(above["rotor speed [rpm]"]) == pytest.approx(12.1)
    assert float(above["aero power [kW]"]) == pytest.approx(5296.6, rel=1e-4)
    assert Path("rotor.png").read_bytes().startswith(b"\x89PNG")


def test_slopes_for_a_rotor_in_effective_winds(capsys):
    assert main([*COARSE, "--slopes", "slopes.csv", "--curve", "curve.csv"]) == 0
    assert capsys.readouterr().err == "saved curve.csv\nsaved slopes.csv\n"
    slopes = read_load_slopes("slopes.csv")
    rows = list(csv.DictReader(Path("curve.csv").read_text().splitlines()))
    assert slopes.wind_speed == pytest.approx([8, 11, 20])
    assert slopes.rotor_speed * 30 / np.pi == pytest.approx([float(row["rotor speed [rpm]"]) for row in rows])
    shipped = read_load_slopes(str(Path(fowtlib.models.__file__).parent / "data/nrel5mw/load_slopes.csv"))
    assert slopes.thrust[2].sum() == pytest.approx(shipped.at(20.0).thrust.sum(), rel=0.01)  # another table of C_q
    assert "fowt rotor-table" in Path("slopes.csv").read_text()


def test_rows_agree_with_the_definition_of_the_coefficients(capsys):
    """Thrust and power of a row are C_t and C_p with the wind along the shaft and the area of the coned rotor."""
    assert main([*COARSE, "--json"]) == 0
    for row in json.loads(capsys.readouterr().out):
        wind = row["wind [m/s]"] * math.cos(math.radians(5))
        pressure = 0.5 * 1.225 * math.pi * (63 * math.cos(math.radians(2.5))) ** 2 * wind**2
        assert row["thrust [kN]"] * 1e3 == pytest.approx(row["C_t"] * pressure, rel=1e-9)
        assert row["aero power [kW]"] * 1e3 == pytest.approx(row["C_p"] * pressure * wind, rel=1e-9)
        assert row["tip speed ratio"] == pytest.approx(row["rotor speed [rpm]"] * math.pi / 30 * 63 / wind, rel=1e-9)


def test_the_table_serves_a_coefficient_rotor(capsys):
    assert main([*COARSE, "--output", "rotor.csv"]) == 0
    run = ["run", "oc3_spar_rigid", "--time", "0.1", "--wind", "steady:11", "--waves", "still", "--json"]
    capsys.readouterr()
    thrusts = []
    for more in ([], ["--set", "turbine.rotor.coefficients=rotor.csv"]):
        assert main([*run, *more]) == 0
        rows = {row["result"]: row for row in json.loads(capsys.readouterr().out)}
        thrusts.append(rows["thrust"]["max"])
    assert thrusts[1] != thrusts[0] and thrusts[1] == pytest.approx(704, rel=0.02)


@pytest.mark.parametrize(
    ("argv", "message"),
    [
        (
            ["oc3_spar_rigid"],
            "oc3_spar_rigid has no turbine with a blade-element rotor (class Turbine), whose coefficients could be "
            "computed.",
        ),
        (["nrel5mw_land", "--turbine", "turbin"], "--turbine: there is no turbine 'turbin'; did you mean 'turbine'?"),
        (["nrel5mw_land", "--ratios", "4:8:2"], "--ratios: a table needs 4 values or more, and these are 3."),
        (["nrel5mw_land", "--winds", "0:5:1"], "--winds: 0 is not above zero."),
        (["nrel5mw_land", "--pitch", "-200:0:50"], "--pitch: the angles are in degrees, from -180 to 180."),
        (["nrel5mw_land", "--output", "r.nc"], "r.nc: the file must end in '.csv'."),
        (
            ["nrel5mw_land", "--ratios", "4:7:1", "--pitch", "0:6:2", "--winds", "30"],
            "--winds: at 30 m/s there is no steady operation at tip speed ratios 4 to 7 and pitch 0 to 6 deg. Give "
            "other wind speeds, or wider --ratios and --pitch.",
        ),
    ],
)
def test_mistakes(capsys, argv, message):
    assert main(["rotor-table", *argv]) == 2
    assert capsys.readouterr().err == f"fowt rotor-table: {message}\n"


@pytest.mark.parametrize("text", ["5:1:1", "1:5:0", "a", "1:2", "3,2", "inf", "1:5:-1", "nan:5:1"])
def test_grids_that_are_none(capsys, text):
    with pytest.raises(SystemExit):
        main(["rotor-table", "nrel5mw_land", "--ratios", text])
    assert f"argument --ratios: '{text}' is not first:last:step, for example -5:30:1" in capsys.readouterr().err


def test_a_table_for_parked_rotors(capsys):
    """Through tip speed ratio 0 and to feathered blades: at rest in 50 m/s the NREL 5 MW has 93 kN, -3.15 MN m."""
    grids = ["--ratios", "-1:8:0.5", "--pitch", "0:90:5", "--winds", "9", "--output", "parked.csv"]
    assert main(["rotor-table", "nrel5mw_land", *grids]) == 0
    thrust, torque = read_coefficients("parked.csv")(0.0, np.radians(90))
    radius = 63 * np.cos(np.radians(2.5))
    pressure = 0.5 * 1.225 * np.pi * radius**2 * 50**2
    assert float(thrust) * pressure == pytest.approx(92.6e3, rel=2e-3)
    assert float(torque) * pressure * radius == pytest.approx(-3.152e6, rel=2e-3)
