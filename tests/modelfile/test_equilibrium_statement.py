"""The statement `equilibrium` of a model file: parameters that take the values at which conditions hold."""

import json

import pytest

import fowtlib as fw
from fowtlib.cli.app import main
from fowtlib.language.errors import ModelError

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
equilibrium:
"""
GOOD = "  free: [left.length, right.length]\n  targets: {tension: 600, surge: 2 m}\n"


def write(tmp_path, statement):
    path = tmp_path / "lines.yaml"
    path.write_text(MODEL + statement)
    return path


@pytest.mark.parametrize("statement", [GOOD, GOOD.replace("[left.length, right.length]",
                                                          "{left.length: 615 m, right.length: }")])  # fmt: skip
def test_what_is_compiled_has_what_was_found(tmp_path, statement):
    model = fw.load(write(tmp_path, statement))
    state = model.compile().equilibrium()
    assert [state["surge"], state["tension"]] == pytest.approx([2, 600])
    solved = model.solved()
    assert solved.root.find("right").parameter_value("length") < solved.root.find("left").parameter_value("length")
    assert "equilibrium" not in solved.settings and solved.solved() is solved
    again = fw.load(write(tmp_path, fw.dump(model).partition("equilibrium:\n")[2]))
    assert again.settings["equilibrium"] == model.settings["equilibrium"]


def test_parameters_of_the_state_alone(tmp_path):
    """The conditions hold with another mass hanging on it, and that mass is not in the model."""
    model = fw.load(write(tmp_path, GOOD + "  set: {right.weight_per_length: 1000 N/m}\n"))
    plant = model.compile()
    assert plant.equilibrium({"right.weight_per_length": 1000})["tension"] == pytest.approx(600)
    assert plant.equilibrium()["tension"] < 590


def test_the_command_says_what_was_found(tmp_path, capsys):
    assert main(["equilibrium", str(write(tmp_path, GOOD)), "--json"]) == 0
    rows = {row["result"]: row["value"] for row in json.loads(capsys.readouterr().out)}
    assert list(rows) == ["left.length", "right.length", "surge", "tension"]
    assert rows["tension"] == pytest.approx(600)


@pytest.mark.parametrize(
    ("statement", "message"),
    [
        ("  free: [left.length]\n", r"lines.yaml:17.*'equilibrium' has no targets: give as many targets as freed"),
        ("  fre: [left.length]\n", "'fre' is not a key of 'equilibrium'; did you mean 'free'"),
        ("  free: [left.length]\n  targets: 5\n", "equilibrium.targets is a mapping from paths to values"),
        ("  free: [left.length]\n  targets: {surge: [1]}\n", "equilibrium.targets: surge is one value"),
        ("  free: [left.lenght]\n  targets: {surge: 1}\n", r"lines.yaml, equilibrium: .*did you mean 'left.length'"),
        (
            "  free: [left.length]\n  targets: {surge: 1, tension: 5}\n",
            "1 parameter is freed .* 2 conditions are given",
        ),
    ],
)
def test_mistakes(tmp_path, statement, message):
    with pytest.raises(ModelError, match=message):
        fw.load(write(tmp_path, statement)).compile()
