"""`fowt equilibrium --free --target`: what is printed, and what is said of mistakes."""

import json

import pytest

from fowtlib.cli.app import main

MODEL = """
fowtlib: 1
title: a weight between two lines
world: {class: World, water_depth: 220 m}
parts:
  slide: {class: Prismatic}
  base: {class: Fixed, r: [0, 0, -20]}
  body: {class: RigidBody, mass: 400 t, inertia: [[1, 0, 0], [0, 1, 0], [0, 0, 1]]}
  left: {class: CatenaryLine, length: 620 m, axial_stiffness: 500 MN, weight_per_length: 900 N/m,
         anchor_position: [-560, 0, -220]}
  right: {class: CatenaryLine, length: 620 m, axial_stiffness: 500 MN, weight_per_length: 900 N/m,
          anchor_position: [560, 0, -220]}
connect:
  - [base.frame, slide.frame_a]
  - [slide.frame_b, body.frame_a, left.fairlead, right.fairlead]
outputs: {surge: slide.s, tension: {of: left.tension, unit: kN}}
"""


@pytest.fixture
def model(tmp_path):
    path = tmp_path / "lines.yaml"
    path.write_text(MODEL)
    return str(path)


def test_a_length_for_a_tension_and_a_place(model, capsys):
    options = [
        "--free",
        "left.length",
        "--free",
        "right.length=615 m",
        "--target",
        "tension=600",
        "--target",
        "surge=2 m",
    ]
    assert main(["equilibrium", model, *options, "--json"]) == 0
    rows = {row["result"]: row for row in json.loads(capsys.readouterr().out)}
    assert list(rows)[:2] == ["left.length", "right.length"] and rows["left.length"]["unit"] == "m"
    assert rows["tension"]["value"] == pytest.approx(600) and rows["surge"]["value"] == pytest.approx(2)
    lengths = [f"{name}={rows[name]['value']!r}" for name in ("left.length", "right.length")]
    assert main(["equilibrium", model, "--json", "--set", lengths[0], "--set", lengths[1]]) == 0
    again = {row["result"]: row["value"] for row in json.loads(capsys.readouterr().out)}
    assert again == pytest.approx({"surge": 2, "tension": 600})


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--free", "left.length"], "1 parameter is freed (left.length) and no conditions are given (none)"),
        (["--free", "left.length", "--target", "tension"], "the condition on tension has no value"),
        (["--free", "left.length", "--free", "left.length=3"], "left.length is given twice"),
        (["--target", "=5"], "'=5': a name is expected, and a value behind '='"),
        (["--free", "left.lenght", "--target", "tension=600"], "did you mean 'left.length'"),
        (
            ["--free", "left.length", "--target", "tensio=600"],
            "there is no variable 'tensio'; did you mean 'tension'",
        ),
        (
            ["--free", "left.length", "--target", "surg=600 m"],
            "there is no variable 'surg'; did you mean 'surge'",
        ),
        (
            ["--free", "left.length", "--target", "tension=600 m"],
            "tension: got '600 m', which is a length; a force in N is expected",
        ),
    ],
)
def test_mistakes(model, options, message, capsys):
    assert main(["equilibrium", model, *options]) == 2
    assert message in capsys.readouterr().err
