"""`fowt events` and `fowt run --event`, on a step."""

import json
from pathlib import Path

import pytest

import fowtlib as fw
from fowtlib.cli.app import main

STEP = """fowtlib: 1
parts:
  step: {class: Step, height: 3, start_time: 1000 s}
  flow: {class: FirstOrder, time_constant: 2 s}
connect:
  - [step.y, flow.u]
outputs: {flow: flow.y}
simulation: {solver: idas, duration: 4 s, output_step: 0.5 s}
"""


@pytest.fixture(autouse=True)
def model(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("step.yaml").write_text(STEP)


def test_what_a_model_offers_is_listed(capsys):
    assert main(["events", "step.yaml", "--json"]) == 0
    assert json.loads(capsys.readouterr().out) == [
        {"event": "step.trigger", "what happens": "the step comes now, whatever start_time says", "values": ""}
    ]
    Path("still.yaml").write_text("fowtlib: 1\nparts: {one: {class: Constant, value: 1}}\n")
    assert main(["events", "still.yaml"]) == 0
    assert capsys.readouterr().out == "no part of this model offers any event.\n"


def test_values_are_shown_with_unit_and_default(capsys):
    assert main(["events", "oc3_spar_rigid"]) == 0
    shown = capsys.readouterr().out
    assert "turbine.safety.grid_loss" in shown and "delay = 0.2 s" in shown and "rate = 8 deg/s" in shown


def test_an_event_of_the_command_line_happens_is_said_and_saved(capsys):
    assert main(["run", "step.yaml", "--event", "trigger at 1 s", "--output", "run.nc"]) == 0
    assert "event at t = 1 s: step.trigger" in capsys.readouterr().out
    saved = fw.Result.open("run.nc")
    assert saved.attributes["events"] == "t = 1 s: step.trigger" and saved["flow"][-1] > 2
    assert main(["run", "step.yaml", "--event", "trigger at 9 s"]) == 0
    assert "the event step.trigger did not happen: the run ends before 9 s" in capsys.readouterr().err


def test_a_run_of_the_command_line_goes_on_across_an_event(capsys):
    event = ["--event", "trigger at 3 s"]
    assert main(["run", "step.yaml", *event, "--output", "whole.nc"]) == 0
    assert main(["run", "step.yaml", *event, "--time", "2", "--output", "part.nc"]) == 0
    assert main(["run", "step.yaml", *event, "--resume", "part.nc", "--output", "both.nc"]) == 0
    whole, both = fw.Result.open("whole.nc"), fw.Result.open("both.nc")
    assert both["flow"].values.tolist() == whole["flow"].values.tolist()
    assert both.attributes["events"] == whole.attributes["events"]


@pytest.mark.parametrize(
    ("event", "message"),
    [
        ("triger at 1 s", "there is no event 'triger'; did you mean 'step.trigger'? The model offers step.trigger."),
        ("trigger", "--event: 'trigger' is no event; write 'turbine.grid_loss at 100 s' or"),
        ("trigger at 1 kg", "--event: the event 'trigger': at"),
        ("trigger when flaw > 3", "there is no result or variable 'flaw'; did you mean 'flow'"),
    ],
)
def test_mistakes_are_a_sentence(capsys, event, message):
    assert main(["run", "step.yaml", "--event", event]) == 2
    shown = capsys.readouterr()
    assert message in shown.err and not shown.out and not list(Path().glob("*.nc*"))
