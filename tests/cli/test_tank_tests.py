"""Commands for tests in a tank: decay of a record, scaling, calibration."""

from __future__ import annotations

import json
import math
from pathlib import Path

import numpy as np
import pytest

from fowtlib.cli.app import main

TIME = np.arange(0.0, 60.0, 0.05)


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    w = 2 * math.pi / 4.0
    heave = 0.01 + 0.05 * np.exp(-0.02 * w * TIME) * np.cos(w * math.sqrt(1 - 0.02**2) * TIME)
    rows = "".join(f"{t:.3f},{x:.9f}\n" for t, x in zip(TIME, heave, strict=True))
    Path("test.csv").write_text("time [s],heave [m]\n" + rows)
    return tmp_path


def printed(capsys: pytest.CaptureFixture[str], *argv: str):
    """What a command prints as JSON."""
    assert main([*argv, "--json"]) == 0, capsys.readouterr().err
    return json.loads(capsys.readouterr().out)


@pytest.mark.parametrize("way", ["sinusoid", "line", "equation"])
def test_the_decay_of_a_record(capsys, way):
    table = printed(capsys, "decay", "test.csv", "--dof", "heave", "--fit", way, "--plot", "d.png")
    rows = {row["quantity"]: row for row in table}
    assert rows["damping ratio"]["value"] == pytest.approx(0.02, rel=1e-3)
    assert rows[f"natural frequency ({way})"]["value"] == pytest.approx(math.pi / 2, rel=1e-4)
    linear = rows[f"damping ratio, linear part ({way})"]
    assert linear["value"] == pytest.approx(0.02, rel=1e-3)
    assert linear["from"] <= linear["value"] <= linear["to"]
    assert Path("d.png").exists()


def test_the_beginning_of_a_record_is_left_out(capsys):
    assert main(["decay", "test.csv", "--dof", "heave", "--discard", "8"]) == 0
    assert capsys.readouterr().out.startswith("without the first 8 s")


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["test.csv", "--dof", "heave", "--offset", "1"], "--offset is for a model; test.csv is a record."),
        (["test.csv", "--dof", "surge"], "surge"),
        (["oc3_spar_rigid", "--dof", "surge"], "--offset: say how far from rest the motion begins"),
        (["oc3_spar_rigid", "--dof", "surge", "--offset", "1", "--discard", "1"], "--discard is for records"),
    ],
)
def test_what_a_decay_needs(capsys, options, message):
    assert main(["decay", *options]) == 2
    assert message in capsys.readouterr().err


def test_a_model_in_another_scale(capsys):
    import fowtlib as fw

    argv = ["scale", "oc3_spar_rigid", "--wind", "none", "--by", "1/45", "--density-ratio", "1000/1025"]
    rows = {row["quantity"]: row["new / old"] for row in printed(capsys, *argv, "-o", "tank.yaml")}
    assert rows["mass"] == pytest.approx(1 / (1.025 * 45**3))
    assert fw.load("tank.yaml").root.world.parameter_value("water_depth") == pytest.approx(320 / 45)
    assert Path("tank_platform_water_database.nc").exists()


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--by", "0"], "'0' is no ratio above 0"),
        (["--by", "1/45"], "wind: the turbulence of the standard has lengths and speeds of full scale"),
        (["--by", "1/45", "--wind", "none", "--unit", "x"], "--unit: 'x' is not PATH=UNIT"),
    ],
)
def test_what_a_scale_needs(capsys, options, message):
    try:
        assert main(["scale", "oc3_spar_rigid", *options]) == 2
    except SystemExit as stop:
        assert stop.code == 2
    assert message in capsys.readouterr().err


OSCILLATOR = """fowtlib: 1
title: heave on a spring
parts:
  world: {class: World, gravity: 0.001 m/s^2}
  slide: {class: Prismatic, n: [0, 0, 1]}
  body: {class: RigidBody, mass: 393 kg, inertia: [[1, 0, 0], [0, 1, 0], [0, 0, 1]]}
  above: {class: FixedTranslation, r: [0, 0, 10]}
  spring: {class: SpringDamper, stiffness: 850 N/m, damping: 30 N*s/m, natural_length: 10 m}
connect:
  - [world.frame, slide.frame_a]
  - [world.frame, above.frame_a]
  - [slide.frame_b, body.frame_a]
  - [slide.frame_b, spring.frame_b]
  - [above.frame_b, spring.frame_a]
outputs: {heave: slide.s}
simulation: {solver: fixed, duration: 40 s, output_step: 0.1 s, step: 0.02 s}
"""


def test_a_calibration(capsys):
    """The damping of the record comes back: 2 zeta w m."""
    Path("spring.yaml").write_text(OSCILLATOR)
    argv = ["calibrate", "spring.yaml", "test.csv", "--release", "heave", "--plot", "fit.png"]
    rows = {row["parameter"]: row for row in printed(capsys, *argv, "--fit", "spring.damping,spring.stiffness")}
    w = math.pi / 2
    assert rows["spring.damping"]["before"] == 30.0
    assert rows["spring.damping"]["value"] == pytest.approx(2 * 0.02 * w * 393, rel=2e-3)
    assert rows["spring.stiffness"]["value"] == pytest.approx(w**2 * 393, rel=1e-3)
    assert Path("fit.png").exists()
    assert main([*argv, "--force", "--fit", "spring.stiffness,spring.damping,body.mass"]) == 2
    assert "cannot be told apart by this record" in capsys.readouterr().err
    assert main([*argv, "--force", "--fit", "spring.dampin"]) == 2
    assert "no tunable parameter 'spring.dampin'; did you mean 'spring.damping'" in capsys.readouterr().err
