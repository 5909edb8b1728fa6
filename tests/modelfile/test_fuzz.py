"""A model file may be broken in any way: what is raised is a ModelFileError."""

from __future__ import annotations

from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from fowtlib.language.errors import ModelError, ModelFileError
from fowtlib.modelfile import load
from fowtlib.modelfile.catalogue import classes
from fowtlib.modelfile.reader import MODEL_KEYS
from fowtlib.modelfile.yaml_text import to_text

GOOD = """\
fowtlib: 1
title: two masses
parameters: {half_span: 69.3 m, n: 2}
world: {class: World, water_depth: 320 m}
sea: {class: Sea, spectrum: regular, wave_height: 6 m, wave_period: 10 s}
parts:
  motion: {class: FreeMotion}
  sum: {class: Sum, n: n}
each:
  - for: [{name: left, side: 1}, {name: right, side: -1}]
    parts:
      arm_{name}: {class: FixedTranslation, r: [0, "{side}*half_span", 3 m]}
      rotor_{name}: {class: PointMass, mass: 350 t}
    connect:
      - [motion.frame_b, arm_{name}.frame_a]
      - [arm_{name}.frame_b, rotor_{name}.frame_a]
connect:
  - [world.frame, motion.frame_a]
outputs: {surge: motion.surge, yaw: {of: motion.yaw, unit: deg}}
simulation: {solver: idas, duration: 600 s, output_step: 0.1 s}
"""
FEW = settings(deadline=None, max_examples=60, suppress_health_check=[HealthCheck.function_scoped_fixture])


def attempt(text: str, folder: Path) -> None:
    path = folder / "model.yaml"
    path.write_text(text, encoding="utf-8")
    try:
        load(path)
    except ModelFileError as error:
        assert str(error)


def test_the_good_file_loads(tmp_path):
    (tmp_path / "model.yaml").write_text(GOOD)
    assert len(load(tmp_path / "model.yaml").root.parts) == 8


@FEW
@given(at=st.integers(0, len(GOOD)), length=st.integers(0, 12), put=st.text(max_size=6))
def test_pieces_cut_out_and_put_in(tmp_path, at, length, put):
    attempt(GOOD[:at] + put + GOOD[at + length :], tmp_path)


@FEW
@given(st.data())
def test_lines_moved_and_lost(tmp_path, data):
    lines = GOOD.splitlines()
    order = data.draw(st.lists(st.sampled_from(range(len(lines))), max_size=len(lines)))
    attempt("\n".join(["fowtlib: 1", *(lines[i] for i in order if i)]), tmp_path)


WORDS = ["for", "name", "mass", "r", "value", "unit", "of", "n", "a", "b", "x_{name}", "path"]
KEYS = st.sampled_from([*MODEL_KEYS, *WORDS])
TEXT = st.sampled_from(
    ["m", "3 m", "2*half_span", "{name}", "a.b", "a.frame_a", "World", "PointMass", "deg", "1/0", "x[0]", ""]
)
ODD = st.recursive(
    st.none() | st.booleans() | st.integers(-3, 3) | st.floats() | TEXT | st.text(max_size=4),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(KEYS, inner, max_size=4),
    max_leaves=12,
)


@FEW
@given(st.dictionaries(KEYS, ODD, max_size=6))
def test_any_data_under_the_known_keys(tmp_path, document):
    attempt(to_text({"fowtlib": 1, **document}), tmp_path)


@FEW
@given(name=st.sampled_from(sorted(classes())), data=st.data())
def test_any_value_for_any_parameter(tmp_path, name, data):
    parameters = list(classes()[name].parameters)
    values = data.draw(st.dictionaries(st.sampled_from(parameters), ODD, max_size=4)) if parameters else {}
    attempt(to_text({"fowtlib": 1, "parts": {"thing": {"class": name, **values}}}), tmp_path)


@FEW
@given(path=st.text(max_size=6) | st.sampled_from(["world", "world.water_depth", "arm_left.r", "sum.n"]), value=ODD)
def test_any_value_set(tmp_path, path, value):
    (tmp_path / "model.yaml").write_text(GOOD)
    try:
        load(tmp_path / "model.yaml", set={path: value})
    except ModelFileError as error:
        assert str(error)


@pytest.mark.parametrize("content", [b"\xff\xfe", b"fowtlib: 1\x00", b"\xef\xbb\xbffowtlib: 1\n"])
def test_bytes(tmp_path, content):
    (tmp_path / "model.yaml").write_bytes(content)
    try:
        load(tmp_path / "model.yaml")
    except ModelError as error:
        assert "model.yaml" in str(error)


def test_a_folder_is_no_model(tmp_path):
    with pytest.raises(ModelFileError):
        load(tmp_path)
