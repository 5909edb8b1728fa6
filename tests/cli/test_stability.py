"""`fowt stability`: arms, damage and stages of a barge, and what a user may get wrong."""

from __future__ import annotations

import json
import math
from pathlib import Path

import pytest

from fowtlib.cli.app import main

BARGE = """fowtlib: 1
title: a barge
world: {class: World, water_depth: 50 m}
parts:
  motion: {class: FreeMotion}
  hull:
    class: Floater
    held_upright: true
    parts:
      box:
        class: RectangularMember
        start: [-30 m, 0, 0]
        end: [30 m, 0, 0]
        widths: 14 m
        heights: 8 m
        wall_thickness: 0 m
        density: 0
        parts:
          load: {class: LumpedMass, mass: 3000 t, place: [0, 0, 0 m]}
          water: {class: Ballast, level: -2 m, tank_start: 0 m, tank_end: 20 m}
connect: [[world.frame, motion.frame_a], [motion.frame_b, hull.frame]]
"""
STAGES = """stages:
  - name: empty
    masses: {crane: {mass: 100 t, place: [0, 0, 0]}}
  - name: ballasted
    levels: {box.water: -2 m}
clearance: 1 m
"""
WATER = 1025 * 20 * 14 * 2.0


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("barge.yaml").write_text(BARGE)
    Path("stages.yaml").write_text(STAGES)


def test_arms_of_a_barge_their_table_and_picture(capsys):
    assert main(["stability", "barge.yaml", "--heel", "0:30:5", "--towards", "90", "--json", "--plot", "a.png"]) == 0
    rows = json.loads(capsys.readouterr().out)
    assert [row["heel [deg]"] for row in rows] == pytest.approx(range(0, 31, 5)) and Path("a.png").is_file()
    mass = 3e6 + WATER
    draft = mass / (1025 * 60 * 14)
    held = main(["stability", "barge.yaml", "--heel", "0:30:5", "--towards", "90", "--hold-trim", "--csv"])
    table = [line.split(",") for line in capsys.readouterr().out.splitlines()]
    BM, z_G = 14**2 / 12 / draft, WATER * -3 / mass
    GM = BM - 4 + draft / 2 - z_G
    assert held == 0 and float(table[1][4]) == pytest.approx(draft, rel=1e-4)
    assert float(table[2][1]) == pytest.approx(
        math.sin(math.radians(5)) * (GM + BM / 2 * math.tan(math.radians(5)) ** 2), rel=1e-3
    )


def test_the_summary_with_slack_water_and_the_wind(capsys):
    command = ["stability", "barge.yaml", "--towards", "90", "--wind-moment", "1e6,10", "--flooding-angle", "30"]
    found = []
    for more in ([], ["--slack", "all"]):
        assert main([*command, *more]) == 0
        lines = capsys.readouterr().out.splitlines()
        found.append({line[:56].strip(): line[56:].split()[0] for line in lines if line[56:].strip()[:1].isdigit()})
    first, second = (float(one["GM in roll"]) for one in found)
    assert first - second == pytest.approx(20 * 14**3 / 12 / float(found[0]["displaced volume"]), rel=1e-3)
    assert any("1.3 are wanted" in key for key in found[0])


def test_damage_brings_it_deeper(capsys):
    drafts = []
    for more in ([], ["--flood", "box:40:60"]):
        assert main(["stability", "barge.yaml", "--csv", *more]) == 0
        drafts.append(float(capsys.readouterr().out.splitlines()[1].split(",")[4]))
    assert drafts[1] == pytest.approx(drafts[0] * 60 / 40, rel=1e-3)  # two thirds are left, held upright


def test_stages(capsys):
    assert main(["stability", "barge.yaml", "--stages", "stages.yaml", "--json"]) == 0
    rows = json.loads(capsys.readouterr().out)
    assert [row["stage"] for row in rows] == ["empty", "ballasted"]
    assert rows[0]["draft [m]"] == pytest.approx(3.1e6 / (1025 * 60 * 14), rel=1e-5)
    assert rows[0]["water depth [m]"] == pytest.approx(rows[0]["draft [m]"] + 1)
    assert rows[1]["heel [deg]"] > 0.3 and rows[1]["mass [kg]"] == pytest.approx(3.1e6 + WATER, rel=1e-9)


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (["--heel", "10:60:10"], "heels must be four angles or more that go up from 0"),
        (["--heel", "nonsense"], "are no four angles"),
        (["--wind-moment", "5"], "are not a force [N] and a lever [m]"),
        (["--flooding-angle", "20"], "ends the areas of --wind-moment"),
        (["--slack", "box.watr"], "hull has no ballast 'box.watr'; did you mean 'box.water'?"),
        (["--flood", "bx"], "hull has no member 'bx'; did you mean 'box'?"),
        (["--flood", "box:1"], "is not MEMBER or MEMBER:A:B"),
        (["--stages", "stages.yaml", "--slack", "all"], "what is slack the file says"),
        (["--stages", "none.yaml"], "none.yaml"),
    ],
)
def test_a_mistake_is_one_sentence(arguments, told, capsys):
    assert main(["stability", "barge.yaml", *arguments]) == 2
    error = capsys.readouterr().err
    assert told in error and "Traceback" not in error


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ("stages:", "steps:", "the file has no entry 'steps'; did you mean 'stages'?"),
        ("levels:", "level:", "stage 2 has no entry 'level'; did you mean 'levels'?"),
        ("mass: 100 t, ", "", "empty: crane has no mass"),
        ("[0, 0, 0]}}", "[0, 0]}}", "its place is three coordinates"),
        ("clearance: 1 m", "clearance: 1 kg", "clearance"),
        ("  - name: ballasted", "  - ballasted", "it is no YAML"),
    ],
)
def test_a_mistake_in_the_file_of_stages(old, new, told, capsys):
    assert old in STAGES
    Path("stages.yaml").write_text(STAGES.replace(old, new))
    assert main(["stability", "barge.yaml", "--stages", "stages.yaml"]) == 2
    assert told in capsys.readouterr().err


def test_a_model_without_members_is_told_so(capsys):
    Path("barge.yaml").write_text(BARGE.replace("class: Floater", "class: RigidBody, mass: 1 kg").split("  hull:")[0]
                                  + "  body: {class: PointMass, mass: 1 kg}\nconnect: [[world.frame, motion.frame_a], "
                                  "[motion.frame_b, body.frame_a]]\n")  # fmt: skip
    assert main(["stability", "barge.yaml"]) == 2
    assert "no parts of class Floater are in the model" in capsys.readouterr().err
