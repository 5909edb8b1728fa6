"""`fowt map`: a grid of parameters on the command line."""

from __future__ import annotations

from pathlib import Path

import pytest

from fowtlib.cli.app import main

ROD = """fowtlib: 1
world: {class: World}
guide: {class: Prismatic, n: [0, 0, -1], s_start: 2}
wire: {class: AxialWire, axial_stiffness: 10 kN, length: 2 m}
bob: {class: PointMass, mass: 3 kg}
connect: [[world.frame, guide.frame_a], [guide.frame_b, bob.frame_a], [world.frame, wire.frame_a],
  [bob.frame_a, wire.frame_b]]
"""


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("rod.yaml").write_text(ROD)


def test_a_map_with_limits_and_a_picture(capsys):
    words = ["--over", "bob.mass=1:3:1", "--over", "wire.axial_stiffness=5,10 kN", "--of", "guide.s, mass"]
    assert main(["map", "rod.yaml", *words, "--limit", "mass < 2500 g", "--csv", "--plot", "map.png"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[0] == "bob.mass [kg],wire.axial_stiffness [N],guide.s [m],mass [kg],feasible"
    assert lines[1].startswith("1.0,5000.0,2.0039") and lines[1].endswith(",1.0,1") and lines[6].endswith(",3.0,0")
    assert Path("map.png").exists()
    assert main(["map", "rod.yaml", *words, "--limit", "mass < 0.5"]) == 1


def test_a_parameter_that_follows_from_a_condition(capsys):
    """The wire is as stiff as the stretch of 10 mm asks for; the axis of the map stands in the table once."""
    words = ["--over", "bob.mass=1:3:2", "--free", "wire.axial_stiffness", "--target", "guide.s=2.01 m"]
    of = ["--of", "wire.axial_stiffness", "--limit", "bob.mass < 2 kg", "--csv"]
    assert main(["map", "rod.yaml", *words, *of]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[0] == "bob.mass [kg],wire.axial_stiffness [N],feasible"
    rows = [[float(cell) for cell in line.split(",")] for line in lines[1:]]
    assert [row[0] for row in rows] == [1.0, 3.0] and [row[2] for row in rows] == [1, 0]
    assert [row[1] for row in rows] == pytest.approx([mass * 9.80665 * 2 / 0.01 for mass in (1, 3)], rel=1e-6)


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (["--over", "bob.mass=1,2", "--of", "mass", "--target", "guide.s"], "'guide.s' is not name=value"),
        (["--over", "bob.mass=1,2", "--of", "mass", "--free", "wire.axial_stiffness"], "as many conditions as freed"),
        (["--over", "bob.mass", "--of", "mass"], "'bob.mass' is not path=first:last:step"),
        (["--over", "bob.mass=often", "--of", "mass"], "'bob.mass=often' is not path=first:last:step"),
        (["--over", "bob.mass=1:3:1 m", "--of", "mass"], "bob.mass"),
        (["--over", "bob.mass=1:3:1", "--over", "bob.mass=1", "--of", "mass"], "bob.mass is given twice"),
        (["--over", "bob.mass=1:3:1"], "a map needs quantities"),
        (["--over", "bob.mass=1:3:1", "--of", "mas"], "the model has no quantity 'mas'"),
        (["--over", "bob.mass=1:3:1", "--of", "mass", "--plot", "map.doc"], "map.doc"),
    ],
)
def test_mistakes_are_sentences(words, says, capsys):
    try:
        status = main(["map", "rod.yaml", *words])
    except SystemExit as left:
        status = left.code
    shown = capsys.readouterr().err
    assert status == 2 and says in shown and "Traceback" not in shown
