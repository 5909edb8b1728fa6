"""What a user reads who made a mistake in a model file: the exact text."""

from __future__ import annotations

from pathlib import Path

import pytest

import fowtlib as fw
from fowtlib.language.errors import ConnectionFault, ModelError, ModelFileError
from fowtlib.modelfile import load

# what stands below "fowtlib: 1" (a "!" in front: the whole file), and the message
CASES = {
    "no_version": (
        "!title: x\n",
        "model.yaml:1: the key 'fowtlib' is missing; a model file begins with 'fowtlib: 1'.",
    ),
    "misspelt_version": (
        "!fowtlb: 1\n",
        "model.yaml:1: the key 'fowtlib' is missing ('fowtlb' is not that key); a model file begins with 'fowtlib: 1'.",
    ),
    "other_version": (
        "!fowtlib: 2\n",
        "model.yaml:1: got 'fowtlib: 2'; this version of the program reads 'fowtlib: 1'.",
    ),
    "version_in_quotes": (
        '!fowtlib: "1"\n',
        "model.yaml:1: write 'fowtlib: 1', without quotes: the version is a number.",
    ),
    "version_in_other_quotes": (
        "!fowtlib: '1 '\n",
        "model.yaml:1: write 'fowtlib: 1', without quotes: the version is a number.",
    ),
    "other_version_in_quotes": (
        '!fowtlib: "2"\n',
        "model.yaml:1: got 'fowtlib: 2'; this version of the program reads 'fowtlib: 1'.",
    ),
    "version_true": (
        "!fowtlib: true\n",
        "model.yaml:1: got true or false behind 'fowtlib:'; this version of the program reads 'fowtlib: 1'.",
    ),
    "version_list": (
        "!fowtlib: [1]\n",
        "model.yaml:1: got a list behind 'fowtlib:'; this version of the program reads 'fowtlib: 1'.",
    ),
    "not_a_mapping": (
        "!- a\n",
        "model.yaml:1: a model file is a mapping; its first line is 'fowtlib: 1', not a list.",
    ),
    "unknown_key": (
        "ouputs: {}\n",
        "model.yaml:2: 'ouputs' is not a key of a model file; did you mean 'outputs'? A part needs 'class' or 'use'.",
    ),
    "part_without_class_at_the_top": (
        "wrold: {water_depth: 3}\n",
        "model.yaml:2: 'wrold' is not a key of a model file. A part needs 'class' or 'use'.",
    ),
    "unknown_class": (
        "parts:\n  body: {class: RigidBdy}\n",
        "model.yaml:3: body: there is no class 'RigidBdy'; did you mean 'RigidBody'? See `fowt parts`.",
    ),
    "unknown_parameter": (
        "parts:\n  world: {class: World}\n  link: {class: FixedTranslation, r: [1, 0, 0], lenght: 2}\n",
        "model.yaml:4: link: FixedTranslation has no parameter 'lenght'; there are 'r' and 'diameter'.",
    ),
    "missing_parameter": (
        "parts:\n  body: {class: RigidBody, mass: 3 t}\n",
        "model.yaml:3: body: RigidBody needs a value for 'inertia' [kg*m^2] (inertia tensor about the centre "
        "of mass, resolved in frame_a).",
    ),
    "wrong_dimension": (
        "parts:\n  body:\n    class: PointMass\n    mass: 3 m\n",
        "model.yaml:5: body.mass: got '3 m', which is a length; a mass in kg is expected, e.g. '7466.33 t'.",
    ),
    "unknown_unit": (
        "parts:\n  body:\n    class: PointMass\n    mass: 3 tt\n",
        "model.yaml:5: body.mass: got '3 tt'; unknown unit 'tt'; did you mean 't'?",
    ),
    "text_for_a_number": (
        "parts:\n  body: {class: PointMass, mass: heavy}\n",
        "model.yaml:3: body.mass: 'heavy' is neither a quantity nor a parameter; a mass in kg is expected, "
        "e.g. '7466.33 t'.",
    ),
    "bool_for_a_number": (
        "parts:\n  body: {class: PointMass, mass: true}\n",
        "model.yaml:3: body.mass: got true; a mass in kg is expected, e.g. '7466.33 t'.",
    ),
    "nothing_for_a_number": (
        "parts:\n  body: {class: PointMass, mass: }\n",
        "model.yaml:3: body.mass: got nothing; a mass in kg is expected, e.g. '7466.33 t'.",
    ),
    "mapping_for_a_number": (
        "parts:\n  body: {class: PointMass, mass: {a: 1}}\n",
        "model.yaml:3: body.mass: got a mapping; a mass in kg is expected, e.g. '7466.33 t'.",
    ),
    "fraction_for_a_whole_number": (
        "parts:\n  sum: {class: Sum, n: 2.5}\n",
        "model.yaml:3: sum.n: got 2.5; a whole number is expected (number of inputs).",
    ),
    "text_for_a_whole_number": (
        "parts:\n  sum: {class: Sum, n: two}\n",
        "model.yaml:3: sum.n: 'two' is neither a quantity nor a parameter; a number without a unit is "
        "expected, e.g. 0.5.",
    ),
    "unknown_choice": (
        "parts:\n  world: {class: World}\n  sea: {class: Sea, spectrum: jonswp}\n",
        "model.yaml:4: sea.spectrum: 'jonswp' is not possible; did you mean 'jonswap'? (kind of sea state)",
    ),
    "formula_of_wrong_dimension": (
        "parameters: {span: 3 m}\nparts:\n  body: {class: PointMass, mass: 2*span}\n",
        "model.yaml:4: body.mass: '2*span' is a length; a mass in kg is expected, e.g. '7466.33 t'.",
    ),
    "unknown_name_in_a_formula": (
        "parameters: {span: 3 m}\nparts:\n  link: {class: FixedTranslation, r: [2*spam, span, 0]}\n",
        "model.yaml:4: link.r: '2*spam': there is no parameter 'spam'; did you mean 'span'?",
    ),
    "unused_parameter": (
        "parameters: {span: 3 m}\nparts:\n  world: {class: World}\n",
        "model.yaml:2: nothing uses the parameter 'span'.",
    ),
    "parameter_called_like_a_unit": (
        "parameters: {t: 3 m}\nparts:\n  world: {class: World, water_depth: t}\n",
        "model.yaml:2: a parameter cannot be called 't', which is the name of a unit; choose a longer name.",
    ),
    "parameters_in_a_ring": (
        "parameters: {a: 2*b, b: a + 1}\nparts:\n  world: {class: World, water_depth: b}\n",
        "model.yaml:2: b: the parameters are defined by each other: a -> b -> a.",
    ),
    "part_without_class": (
        "parts:\n  body: {mass: 3 t}\n",
        "model.yaml:3: the model has no part 'body'. A new part needs 'class' or 'use'.",
    ),
    "class_without_mapping": (
        "parts:\n  world: World\n",
        "model.yaml:3: a part is a mapping; write 'world: {class: World}', or 'use' for a definition file.",
    ),
    "class_and_use": (
        "parts:\n  body: {class: World, use: x}\n",
        "model.yaml:3: give 'class' or 'use', not both; 'use' takes the class from the definition.",
    ),
    "unknown_definition": (
        "parts:\n  body: {use: parts/lnk}\n",
        "model.yaml:3: body: there is no definition 'parts/lnk'; did you mean 'parts/link'?",
    ),
    "definition_in_itself": (
        "parts:\n  body: {use: parts/ring}\n",
        "parts/ring.yaml:3: the definition 'ring' includes itself.",
    ),
    "outputs_in_a_definition": (
        "parts:\n  body: {use: parts/out}\n",
        "parts/out.yaml:2: 'outputs' belongs into the model file, not into a definition.",
    ),
    "unknown_value_for_a_definition": (
        "parts:\n  body: {use: parts/link, lenght: 3}\n",
        "model.yaml:3: body: FixedTranslation has no parameter 'lenght'; did you mean 'length'?",
    ),
    "unknown_part_of_a_definition": (
        "parts:\n  body: {use: parts/two, parts: {c: {r: [0, 0, 1]}}}\n",
        "model.yaml:3: body has no part 'c'; there are 'a' and 'b'. A new part needs 'class' or 'use'.",
    ),
    "wrong_unit_for_a_definition": (
        "parts:\n  body: {use: parts/two, length: 3 kg}\n",
        "model.yaml:3: body.length: got '3 kg', which is a mass; a length in m is expected, e.g. '853.87 m'.",
    ),
    "unknown_port": (
        "parts:\n  world: {class: World}\n  body: {use: parts/two}\nconnect:\n  - [world.frame, body.rot]\n",
        "model.yaml:6: 'body.rot': body has no port 'rot'; did you mean 'root'?",
    ),
    "connection_of_one": (
        "parts:\n  world: {class: World}\nconnect:\n  - [world.frame]\n",
        "model.yaml:5: a connection is a list of two ports (or more): [body.frame_b, tower.frame_a].",
    ),
    "part_instead_of_port": (
        "parts:\n  world: {class: World}\n  b: {class: PointMass, mass: 1}\nconnect:\n  - [world, bb.frame_a]\n",
        "model.yaml:6: 'world' is a part, not a port; did you mean 'world.frame'?",
    ),
    "unknown_part_in_a_connection": (
        "parts:\n  world: {class: World}\n  b: {class: PointMass, mass: 1}\nconnect:\n  - [world.frame, bb.frame_a]\n",
        "model.yaml:6: 'bb': the model has no part 'bb'; did you mean 'b'?",
    ),
    "index_too_large": (
        "parts:\n  sum: {class: Sum}\nconnect:\n  - [sum.u[0], sum.u[2]]\n",
        "model.yaml:5: sum.u[2]: the array has 2 ports, counted from 0.",
    ),
    "index_on_a_single_port": (
        "parts:\n  sum: {class: Sum}\nconnect:\n  - [sum.y[0], sum.u]\n",
        "model.yaml:5: sum.y is one port, not an array of ports; connect it without an index.",
    ),
    "each_without_for": (
        "each:\n  - parts: {}\n",
        "model.yaml:3: the block has no 'for'; write 'for: [{name: left}, {name: right}]'.",
    ),
    "different_keys_in_for": (
        "each:\n  - for: [{name: a}, {nam: b}]\n    parts:\n      x_{name}: {class: World}\n",
        "model.yaml:3: the mappings of 'for' have different keys: nam and name.",
    ),
    "unused_variable_of_for": (
        "each:\n  - for: [{name: a, side: 1}]\n    parts:\n      x_{name}: {class: World}\n",
        "model.yaml:3: nothing in the block uses 'side'.",
    ),
    "unknown_variable_of_for": (
        "each:\n  - for: [{name: a}]\n    parts:\n      x_{nam}: {class: World}\n",
        "model.yaml:5: 'x_{nam}': there is no variable 'nam' here; did you mean 'name'?",
    ),
    "part_twice": (
        "each:\n  - for: [{name: a}, {name: a}]\n    parts:\n      x_{name}: {class: World}\n",
        "model.yaml:5: the part 'x_a' is given twice; the first is in line 5.",
    ),
    "bad_name": (
        "each:\n  - for: [{name: a b}]\n    parts:\n      x_{name}: {class: World}\n",
        "model.yaml:5: 'x_a b' is not a name for a part; use letters, digits and underscores.",
    ),
    "output_of_nothing": (
        "world: {class: World}\nbody: {class: PointMass, mass: 1}\noutputs:\n  v: body.vv\n",
        "model.yaml:5: output 'v': 'body.vv': body has no variable 'vv'; did you mean 'v'?",
    ),
    "output_in_a_wrong_unit": (
        "world: {class: World}\nbody: {class: PointMass, mass: 1}\noutputs:\n  v: {of: 'body.v[0]', unit: kg}\n",
        "model.yaml:5: output 'v': 'body.v[0]' is a speed in m/s, and cannot be given in 'kg'.",
    ),
    "unknown_key_of_an_output": (
        "world: {class: World}\nbody: {class: PointMass, mass: 1}\noutputs:\n  v: {path: 'body.v[0]'}\n",
        "model.yaml:5: 'path' is not a key of output 'v'; there are 'of', 'unit' and 'description'.",
    ),
    "unknown_member_of_a_connector": (
        "world: {class: World}\noutputs:\n  v: world.frame.q\n",
        "model.yaml:4: output 'v': 'world.frame.q': Frame has no member 'q'; there are 'r', 'R', 'w', 'f' and 't'.",
    ),
    "step_of_zero": (
        "world: {class: World}\nsimulation: {step: 0 ms}\n",
        "model.yaml:3: simulation.step is 0; a number above zero is expected.",
    ),
    "duration_below_zero": (
        "world: {class: World}\nsimulation:\n  duration: -30 s\n",
        "model.yaml:4: simulation.duration is -30; a number above zero is expected.",
    ),
    "no_tolerance": (
        "world: {class: World}\nsimulation:\n  tolerance: 0\n",
        "model.yaml:4: simulation.tolerance is 0; a number above zero is expected.",
    ),
    "output_of_a_parameter": (
        "world: {class: World}\nbody: {class: PointMass, mass: 1}\noutputs:\n  v: body.mass\n",
        "model.yaml:5: output 'v': 'body.mass' is a parameter, and results are variables; `fowt parameters` has it.",
    ),
    "output_of_a_parameter_of_the_file": (
        "parameters: {heavy: 3}\nworld: {class: World}\nbody: {class: PointMass, mass: heavy}\noutputs:\n  v: heavy\n",
        "model.yaml:6: output 'v': 'heavy' is a parameter, and results are variables; `fowt parameters` has it.",
    ),
    "output_of_a_part": (
        "world: {class: World}\noutputs:\n  v: world\n",
        "model.yaml:4: output 'v': 'world' is a part, not a variable; there is 'frame'.",
    ),
    "unknown_setting": (
        "world: {class: World}\nsimulation: {durations: 3 s}\n",
        "model.yaml:3: 'durations' is not a key of 'simulation'; did you mean 'duration'?",
    ),
    "setting_in_a_wrong_unit": (
        "world: {class: World}\nsimulation: {duration: 3 m}\n",
        "model.yaml:3: simulation.duration: got '3 m', which is a length; a time in s is expected, e.g. '12.5 s'.",
    ),
    "unknown_shipped_data": (
        "parts:\n  wind: {class: Wind, kind: file, file: 'data:oc3_hywnd/hydrodynamics.nc'}\n",
        "model.yaml:3: wind.file: there is no shipped data file 'oc3_hywnd/hydrodynamics.nc'; did you mean "
        "'oc3_hywind/hydrodynamics.nc'?",
    ),
    "division_by_zero": (
        "parameters: {k: 0}\nparts:\n  world: {class: World, water_depth: 1/k}\n",
        "model.yaml:4: world.water_depth: World cannot be built from these values: float division by zero.",
    ),
    "cycles_in_a_formula": (
        "parameters: {f: 0.25 Hz}\nparts:\n  s: {class: Revolute, w_start: 2*pi*f}\n",
        "model.yaml:4: s.w_start: '2*pi*f' is a frequency in Hz, and rad/s is expected; a formula does not "
        "turn cycles into radians. Give the parameter in it 'unit: rad/s'.",
    ),
    "part_that_begins_with_a_digit": (
        "parts:\n  2body: {class: World}\n",
        "model.yaml:3: '2body' is not a name for a part; use letters, digits and underscores.",
    ),
    "part_with_a_reserved_name": (
        "parts:\n  origins: {class: World}\n",
        "model.yaml:3: a part cannot be called 'origins', which has a meaning in every component.",
    ),
    "parameter_with_a_reserved_name": (
        "parameters: {path: 3}\nworld: {class: World, water_depth: path}\n",
        "model.yaml:2: the parameter 'path' has a name that is taken already.",
    ),
    "port_with_the_name_of_a_parameter": (
        "parameters: {top: 3 m}\nworld: {class: World, water_depth: top}\nports: {top: world.frame}\n",
        "model.yaml:4: the port 'top' has a name that is taken already, by a parameter of this file; choose another.",
    ),
    "unknown_key_of_a_parameter": (
        "parameters: {depth: {value: 3 m, minimum: 1}}\nworld: {class: World, water_depth: depth}\n",
        "model.yaml:2: 'minimum' is not a key of parameter 'depth'; did you mean 'min'?",
    ),
}


@pytest.fixture
def definitions(write):
    write("fowtlib: 1\nparameters: {length: 2 m}\nclass: FixedTranslation\nr: [length, 0, 0]\n", "parts/link.yaml")
    write(
        """
        fowtlib: 1
        parameters: {length: 2 m}
        parts:
          a: {class: FixedTranslation, r: [length, 0, 0]}
          b: {class: FixedTranslation, r: [0, length, 0]}
        connect: [[a.frame_b, b.frame_a]]
        ports: {root: a.frame_a}
        """.lstrip("\n"),
        "parts/two.yaml",
    )
    write("fowtlib: 1\nparts:\n  a: {use: ring}\n", "parts/ring.yaml")
    write("fowtlib: 1\noutputs: {a: b}\n", "parts/out.yaml")
    return write


@pytest.mark.parametrize("case", CASES)
def test_message(case, definitions):
    text, message = CASES[case]
    path = definitions(text[1:] if text.startswith("!") else f"fowtlib: 1\n{text}")
    with pytest.raises(ModelFileError) as error:
        load(path)
    assert str(error.value) == message


# found when the parts are put together
CONNECTIONS = {
    "part_not_connected": (
        "world: {class: World}\nparts:\n  link: {class: FixedTranslation, r: [1, 0, 0]}\n"
        "connect:\n  - [world.frame, link.frame_a]\n",
        "model.yaml:4: link.frame_b is not connected: side towards the tips. Connect a Frame to it.",
    ),
    "input_not_connected": (
        "parts:\n  inner:\n    parts:\n      gain: {class: Gain, gain: 2}\n",
        "model.yaml:5: inner.gain.u is not connected: input [1]. Connect an output to it.",
    ),
    "two_outputs": (
        "parts:\n  a: {class: Constant, value: 1}\n  b: {class: Constant, value: 1}\n  g: {class: Gain, gain: 1}\n"
        "connect:\n  - [a.y, g.u]\n  - [b.y, g.u]\n",
        "two outputs drive one signal: a.y (model.yaml:7) and b.y (model.yaml:8). "
        "Connect one of them, or add a Sum between.",
    ),
    "loose_ring": (
        "world: {class: World}\nparts:\n  l: {class: FixedTranslation, r: [1, 0, 0]}\n"
        "  k: {class: FixedTranslation, r: [1, 0, 0]}\n"
        "connect:\n  - [k.frame_b, l.frame_a]\n  - [k.frame_a, l.frame_b]\n",
        "model.yaml:4: the orientation of l.frame_a, l.frame_b is not tied to the world; "
        "join it by a joint, a fixed part or a FreeMotion to the World.",
    ),
    "fixed_twice": (
        "world: {class: World}\nparts:\n  l: {class: FixedTranslation, r: [1, 0, 0]}\n  k: {class: Fixed}\n"
        "connect:\n  - [world.frame, l.frame_a]\n  - [k.frame, l.frame_b]\n",
        "model.yaml:5: the orientation of k.frame is fixed by k, and so is that of a frame that it is joined to; "
        "one of them must leave it free.",
    ),
}


@pytest.mark.parametrize("case", CONNECTIONS)
def test_message_about_a_connection(case, write):
    text, message = CONNECTIONS[case]
    with pytest.raises(ConnectionFault) as error:
        fw.load(write(f"fowtlib: 1\n{text}")).compile()
    assert str(error.value).replace(f"{Path.cwd().name}/", "") == message


SETTINGS = {
    "wrld.water_depth": (3, "set: the model has no part 'wrld'; did you mean 'world'?"),
    "world.depth": (3, "set: world: World has no parameter 'depth'; did you mean 'water_depth'?"),
    "world.water_depth": (
        "3 kg",
        "set: world.water_depth: got '3 kg', which is a mass; a length in m is expected, e.g. '853.87 m'.",
    ),
    "body.length": (
        "x",
        "set: body.length: 'x' is neither a quantity nor a parameter; a length in m is expected, e.g. '853.87 m'.",
    ),
    "body.a.q": (3, "set: body.a: FixedTranslation has no parameter 'q'; there are 'r' and 'diameter'."),
    "body.c.r": (3, "set: body has no part 'c'; there are 'a' and 'b'."),
    "a.r": (3, "set: the model has no part 'a'; did you mean 'body.a'?"),
    "b.diameter": (3, "set: the model has no part 'b'; did you mean 'body.b'?"),
    "body.a": (3, "set: body.a is a part, not a parameter; give values to its parameters."),
    "world.": (3, "set: 'world.' is not the path of a parameter: a name, or names joined by dots."),
}


@pytest.mark.parametrize("path", SETTINGS)
def test_message_about_a_value_that_is_set(path, definitions):
    value, message = SETTINGS[path]
    model = load(definitions("fowtlib: 1\nworld: {class: World}\nbody: {use: parts/two}\n"))
    with pytest.raises(ModelFileError) as error:
        model.with_parameters({path: value})
    assert str(error.value) == message


@pytest.mark.parametrize(
    ("source", "message"),
    [
        ("no_such_model", "there is no model 'no_such_model', nor a file of that name"),
        ("folder/model.yaml", "there is no file 'folder/model.yaml'."),
    ],
)
def test_message_about_a_model_that_is_not_there(source, message, write):
    with pytest.raises(ModelFileError) as error:
        load(source)
    assert str(error.value).startswith(message)


@pytest.mark.parametrize(("content", "message"), [
    ("fowtlib: 1\ntitle: fünf\n".encode("latin-1"), "model.yaml:2: this is not text in UTF-8; save the file"),
    ("fowtlib: 1\n".encode("utf-16"), "model.yaml: this is not text in UTF-8; save the file in this encoding."),
    (b"\x00\x01\xff\xfe" * 9, "model.yaml: this is not text in UTF-8; save the file in this encoding."),
])  # fmt: skip
def test_a_file_in_another_encoding_is_named_with_its_line(content, message, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("model.yaml").write_bytes(content)
    with pytest.raises(ModelFileError) as error:
        load("model.yaml")
    assert str(error.value).startswith(message)


def test_a_folder_is_no_model(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("model.yaml").mkdir()
    with pytest.raises(ModelFileError, match="^'model.yaml' is a folder; a file is expected."):
        load("model.yaml")


def test_a_part_that_another_one_makes_has_the_line_of_that_one(write):
    path = write("""fowtlib: 1
world: {class: World, water_depth: 100 m}
parts:
  motion: {class: FreeMotion}
  body: {class: PointMass, mass: 1}
  mooring: {class: MooringSystem, headings: [0], fairlead_radius: 5, fairlead_depth: 2, anchor_radius: 600,
            anchor_depth: 200, length: 700, axial_stiffness: 1e8, mass_per_length: 100}
connect:
  - [world.frame, motion.frame_a]
  - [motion.frame_b, body.frame_a, mooring.frame]
""")
    with pytest.raises(ModelError, match="model.yaml:6: mooring.line_1 has its anchor at z = -200 m, below"):
        load(path).compile()


def test_a_model_file_of_that_name_is_proposed(write, monkeypatch):
    monkeypatch.chdir(write("fowtlib: 1\n", "my_spar.yaml").parent)
    with pytest.raises(ModelFileError) as error:
        load("my_spar")
    assert str(error.value) == "there is no model 'my_spar', nor a file of that name; did you mean 'my_spar.yaml'?"


def test_a_folder_is_not_a_file(write):
    path = write("fowtlib: 1\nwind: {class: Wind, kind: file, file: .}\n")
    with pytest.raises(ModelFileError, match="wind.file: '.' is a folder; a file is expected."):
        load(path)
