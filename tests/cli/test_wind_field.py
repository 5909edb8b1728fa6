"""`fowt wind-field` and `--wind field:FILE`: a field for two rotors, and what is said of one that is too small."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

import fowtlib as fw
from fowtlib.cli.app import main
from fowtlib.components.environment import read_field
from fowtlib.components.environment.field_lookup import FieldLookup

SMALL = ["--speed", "11.4", "--width", "300", "--height", "150", "--spacing", "50", "--time", "20", "--step", "0.25"]


@pytest.fixture(autouse=True)
def empty_folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)


def test_a_field_for_two_rotors(capsys):
    options = ["--class", "A", "--spectrum", "von_karman", "--lateral", "iec", "--shear", "0.14", "--seed", "3"]
    assert main(["wind-field", "two.bts", *SMALL, *options, "--json"]) == 0
    shown = capsys.readouterr()
    assert shown.err == "saved two.bts\n"
    rows = json.loads(shown.out)
    assert [(row["axis"], row["from"], row["to"], row["points"]) for row in rows] == [
        ("y", -150, 150, 7), ("z", 15, 165, 4), ("time", 0, 20, 80),
    ]  # fmt: skip
    field = read_field("two.bts")
    assert field.grid.description == "fowtlib: von_karman, V = 11.4 m/s, shear 0.14, seed 3"
    assert field.grid.periodic
    assert main(["run", "two_rotor_spar_rigid", "--wind", "field:two.bts", "--time", "0.5", "--output", "r.nc"]) == 0
    result = fw.Result.open("r.nc")
    lookup = FieldLookup(field)
    for name, y in (("wind_speed_left", 69.3), ("wind_speed_right", -69.3)):
        expected = lookup.velocity([(0, y, 90)] * len(result.time), result.time)[:, 0]
        np.testing.assert_allclose(result[name], expected, atol=1e-9)


def test_a_field_that_does_not_reach_the_rotors(capsys):
    narrow = [word if word != "300" else "100" for word in SMALL]
    assert main(["wind-field", "narrow.bts", *narrow]) == 0
    capsys.readouterr()
    assert main(["run", "two_rotor_spar_rigid", "--wind", "field:narrow.bts", "--time", "0.5"]) == 2
    assert "narrow.bts: the wind field is too small: point 0 is at y = 69.3 m" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["two.csv", *SMALL], "fowt wind-field: two.csv: the file must end in '.bts'."),
        (["none/two.bts", *SMALL], "none/two.bts: the folder none does not exist; make it first"),
        (["two.bts", *SMALL, "--hub-height", "50"], "the lowest row is at -25 m, where the power law has no wind"),
        (["two.bts", *SMALL, "--class", "D"], "unknown A+|A|B|C 'D'"),
        (["two.bts", *SMALL, "--speed", "-1"], "'-1' is not a positive number"),
        (["two.bts", "--speed", "8"], "the following arguments are required: --width, --height"),
        (["two.bts", *SMALL, "--seed", "-1"], "seed and turbulence_intensity begin at 0."),
    ],
)
def test_mistakes(capsys, words, message):
    try:
        status = main(["wind-field", *words])
    except SystemExit as error:
        status = error.code
    assert status == 2
    assert message in capsys.readouterr().err
    assert not list(Path().iterdir())
