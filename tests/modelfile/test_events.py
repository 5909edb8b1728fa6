"""`events:` of a model file."""

import json

import pytest
import yaml

import fowtlib as fw
from fowtlib.cases import Case
from fowtlib.language.errors import ModelError
from fowtlib.modelfile.schema import schema

MODEL = """
    fowtlib: 1
    title: a step
    parts:
      step: {class: Step, height: 3, start_time: 1000 s}
      flow: {class: FirstOrder, time_constant: 2 s}
    connect:
      - [step.y, flow.u]
    outputs: {flow: flow.y}
    simulation: {solver: idas, duration: 4 s, output_step: 0.5 s}
"""
EVENT = """
    events:
      - {event: step.trigger, at: 1 s}
"""


def test_the_events_of_a_file_happen_unless_a_run_has_its_own(write):
    model = fw.load(write(MODEL + EVENT))
    plant = model.compile()
    result = plant.simulate(outputs=["step.y"])
    assert result["step.y"].values.tolist() == [0, 0, 3, 3, 3, 3, 3, 3, 3]
    assert result.attributes["events"] == "t = 1 s: step.trigger"
    assert not plant.simulate(outputs=["step.y"], events=())["step.y"].values.any()
    late = plant.simulate(outputs=["step.y"], events=["step.trigger at 3 s"])["step.y"].values.tolist()
    assert late == [0, 0, 0, 0, 0, 0, 3, 3, 3]


def test_a_single_event_needs_no_list_and_a_changed_model_keeps_it(write):
    model = fw.load(write(MODEL + "    events: {event: step.trigger, at: 1 s}\n"))
    changed = model.with_parameters({"step.height": 5}).compile().simulate(outputs=["step.y"])
    assert changed["step.y"][-1] == 5


def test_what_is_written_is_read_again(write):
    model = fw.load(write(MODEL + EVENT))
    text = fw.dump(model)
    assert yaml.safe_load(text)["events"] == [{"event": "step.trigger", "at": 1.0}]
    again = fw.load(write(text, "again.yaml"))
    assert again.settings == model.settings


@pytest.mark.parametrize(
    ("events", "message"),
    [
        (
            "{event: step.triger, at: 1 s}",
            r"model.yaml:11: there is no event 'step.triger'; did you mean 'step.trigger'",
        ),
        ("{event: step.trigger, at: 1 s, by: 3}", r"model.yaml:11: the event 'step.trigger': it has no value 'by'"),
        ("{event: step.trigger}", r"model.yaml:11: the event 'step.trigger' needs its time"),
        ("{event: step.trigger, at: 1 s, when: flow > 2}", r"model.yaml:11: .* one of them only"),
        ("{event: step.trigger, when: flow >> 2}", r"model.yaml:11: .* is no condition"),
        ("{event: step.trigger, when: flaw > 2}", r"model.yaml:11: .*'flaw'; did you mean 'flow'"),
        ("{event: step.trigger, at: [1, 2]}", r"model.yaml:11: 'at' of an event is a number or text"),
        ("{at: 1 s}", r"model.yaml:11: an event is a mapping with its name"),
        ("[step.trigger at 1 s]", r"model.yaml:11: an event is a mapping"),
    ],
)
def test_what_is_wrong_is_said_with_its_line_when_the_model_is_compiled(write, events, message):
    with pytest.raises(ModelError, match=message):
        fw.load(write(MODEL + f"    events: {events}\n")).compile()


def test_a_definition_has_no_events(write):
    write("fowtlib: 1\nclass: Step\nevents: [{event: trigger, at: 1}]\n", "part.yaml")
    with pytest.raises(ModelError, match="'events' belongs into the model file"):
        fw.load(write("fowtlib: 1\nparts: {step: {use: part}}\n"))


def test_a_case_has_the_events_of_a_file(write):
    plant = fw.load(write(MODEL)).compile()
    case = Case("late", "model.yaml", events=({"event": "step.trigger", "at": "2 s"},))
    assert Case.from_plain(json.loads(json.dumps(case.plain()))) == case
    assert plant.simulate(conditions=case.conditions(), outputs=["step.y"])["step.y"].values.tolist()[3:5] == [0, 3]
    assert case.digest() != Case("late", "model.yaml").digest()
    with pytest.raises(ModelError, match="case bad: an event is a mapping"):
        Case("bad", "model.yaml", events=({"at": 3},)).conditions()


def test_the_schema_knows_events():
    jsonschema = pytest.importorskip("jsonschema")
    good = {"fowtlib": 1, "events": [{"event": "a.b", "at": "3 s", "rate": "2 deg/s"}]}
    jsonschema.validate(good, schema())
    with pytest.raises(jsonschema.ValidationError):
        jsonschema.validate({"fowtlib": 1, "events": [{"at": 3}]}, schema())
