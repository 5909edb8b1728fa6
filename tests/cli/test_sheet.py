"""`fowt sheet`: a model on one page, beside another and beside numbers of a report."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from fowtlib.cli.app import main

ROD = """fowtlib: 1
world: {class: World}
hinge: {class: Revolute, n: [0, 1, 0]}
rod: {class: FixedTranslation, r: [0, 0, -1]}
bob: {class: PointMass, mass: 2 kg}
connect: [[world.frame, hinge.frame_a], [hinge.frame_b, rod.frame_a], [rod.frame_b, bob.frame_a]]
"""


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("rod.yaml").write_text(ROD)
    Path("heavy.yaml").write_text(ROD.replace("2 kg", "3 kg"))


def test_a_sheet_and_its_file(capsys):
    assert main(["sheet", "rod.yaml", "--json", "-o", "rod.csv"]) == 0
    told = {row["quantity"]: (row["value"], row["unit"]) for row in json.loads(capsys.readouterr().out)}
    assert told["mass"] == (2.0, "kg") and told["bob: centre of mass z"] == (-1.0, "m")
    period = next(value for name, (value, _) in told.items() if name.startswith("period of"))
    assert period == pytest.approx(2 * 3.14159265 / 9.80665**0.5)
    assert main(["sheet", "heavy.yaml", "--against", "rod.csv", "--csv"]) == 0
    rows = [line.split(",") for line in capsys.readouterr().out.splitlines()]
    assert rows[0] == ["quantity", "unit", "heavy", "rod.csv", "difference [%]"]
    assert rows[1] == ["mass", "kg", "3.0", "2.0", "50.0"]


def test_two_models_and_what_one_of_them_lacks(capsys):
    Path("few.csv").write_text("quantity,value,unit\nmass,2000,g\nkeel,1,m\n")
    assert main(["sheet", "rod.yaml", "--against", "heavy.yaml"]) == 0
    assert "-33.333" in capsys.readouterr().out
    assert main(["sheet", "rod.yaml", "--against", "few.csv"]) == 0
    shown = capsys.readouterr().out
    assert "only few.csv has: keel" in shown and "only rod has: centre of mass x" in shown


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (["rod.yaml", "--against", "none.csv"], "none.csv: cannot be read"),
        (["rod.yaml", "--against", "nothing"], "nothing"),
        (["rod.yaml", "--against", "other.csv"], "other.csv: has no quantity of this sheet"),
        (["rod.yaml", "--wind", "steady:8"], "this model has no part 'wind'"),
        (["rod.yaml", "-o", "sheet.txt"], ".csv"),
    ],
)
def test_mistakes_are_sentences(words, says, capsys):
    Path("other.csv").write_text("quantity,value\nkeel,1\n")
    assert main(["sheet", *words]) == 2
    shown = capsys.readouterr().err
    assert says in shown and "Traceback" not in shown
