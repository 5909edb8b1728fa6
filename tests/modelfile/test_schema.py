"""The JSON schema says the same as the loader, for the shipped models and for mistakes in the class blocks."""

from __future__ import annotations

import json

import pytest
import yaml

from fowtlib.modelfile import shipped_models
from fowtlib.modelfile.catalogue import classes
from fowtlib.modelfile.nodes import parse
from fowtlib.modelfile.reader import MODEL_KEYS, PART_KEYS
from fowtlib.modelfile.schema import schema

jsonschema = pytest.importorskip("jsonschema")
MODEL = """
fowtlib: 1
parameters: {half_span: 69.3 m, mass: {value: 3, unit: t, min: 1}}
world: {class: World, water_depth: 320 m}
parts:
  tower: {use: towers/steel, height: 90 m, parts: {top: {mass: 3 t}}}
each:
  - for: [{name: left, side: 1}]
    parts:
      arm_{name}: {class: FixedTranslation, r: [0, "{side}*half_span", 3 m]}
    connect:
      - [tower.top, arm_{name}.frame_a]
outputs: {yaw: {of: motion.yaw, unit: deg}}
simulation: {duration: 600 s}
"""


def errors(text: str) -> list[str]:
    validator = jsonschema.Draft7Validator(schema())
    return [error.message for error in validator.iter_errors(parse(text, "a.yaml").plain())]


def test_the_schema_is_one_and_is_json():
    jsonschema.Draft7Validator.check_schema(schema())
    text = json.dumps(schema(), allow_nan=False)
    assert all(f'"class {name}"' in text for name in classes())


def test_a_good_file_passes():
    assert errors(MODEL) == []


@pytest.mark.parametrize("path", shipped_models().values(), ids=list(shipped_models()))
def test_shipped_models_pass(path):
    assert errors(path.read_text()) == []
    yaml.safe_load(path.read_text())  # an editor has a reader of its own, which does not know our braces


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("water_depth", "water_deep"),
        ("class: World", "class: Wrld"),
        ("r: [0,", "q: [0,"),
        ("duration", "durations"),
        ("of: motion", "off: motion"),
        ("fowtlib: 1", "fowtlib: 2"),
        ("unit: t", "units: t"),
    ],
)
def test_mistakes_are_found(old, new):
    assert errors(MODEL.replace(old, new, 1))


def test_no_class_has_a_parameter_called_like_a_key():
    """A parameter `parts` or `use` could not be given in a file."""
    taken = {(name, key) for name, item in classes().items() for key in item.parameters if key in PART_KEYS}
    assert not taken
    assert set(PART_KEYS) <= set(MODEL_KEYS)
