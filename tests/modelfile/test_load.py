"""Model files -> component trees: definitions and overrides, repetition, formulas, connections, outputs, settings."""

from __future__ import annotations

import math
import os
from pathlib import Path

import numpy as np
import pytest

import fowtlib as fw
from fowtlib.components.blocks import Sum
from fowtlib.components.mechanics import FixedTranslation, PointMass, RigidBody
from fowtlib.language.errors import ModelFileError
from fowtlib.modelfile import load

SPAR = """
    fowtlib: 1
    title: a spar
    parameters:
      slope: 2*draft                # the order of parameters does not matter
      draft: 120 m
      mass: {value: 7466.33, unit: t, description: mass of the hull, min: 1 t}
    parts:
      hull:
        class: RigidBody
        mass: mass
        inertia: [[4.2e9, 0, 0], [0, 4.2e9, 0], [0, 0, 1.6e8]]
        r_cm: [0, 0, -0.75*draft]
      arm: {class: FixedTranslation, r: [0, 0, slope/20]}
    connect: [[hull.frame_a, arm.frame_a]]
    ports: {top: arm.frame_b, bottom: hull.frame_a}
"""

MODEL = """
    fowtlib: 1
    title: two rotors
    parameters: {half_span: 69.3 m, rotors: 2}
    world: {class: World, water_depth: 320 m}
    motion: {class: FreeMotion}
    parts:
      platform: {use: parts/spar, draft: half_span + 50 m}
    each:
      - for: [{name: left, side: 1}, {name: right, side: -1}]
        parts:
          arm_{name}: {class: FixedTranslation, r: [0, "{side}*half_span", 3 m]}
          rotor_{name}: {class: PointMass, mass: 350 t}
        connect:
          - [platform.top, arm_{name}.frame_a]
          - [arm_{name}.frame_b, rotor_{name}.frame_a]
        outputs:
          height_{name}: rotor_{name}.frame_a.r[2]
    connect:
      - [world.frame, motion.frame_a]
      - [motion.frame_b, platform.bottom]
    outputs:
      yaw: {of: motion.yaw, unit: deg, description: yaw of the platform}
    simulation: {solver: idas, duration: 10 min, output_step: 0.1 s, tolerance: 1e-6}
"""
TOTALS = "\n    total: {class: Sum, n: rotors}\n"


@pytest.fixture
def model(write) -> fw.Model:
    write(SPAR, "parts/spar.yaml")
    return load(write(MODEL.replace(", rotors: 2", "")))


def value(component, name: str):
    return component.parameter_value(name)


def test_parts_and_values(model):
    assert model.title == "two rotors"
    names = ["world", "motion", "platform", "arm_left", "rotor_left", "arm_right", "rotor_right"]
    assert list(model.root.parts) == names
    assert isinstance(model.root.platform.hull, RigidBody)
    assert isinstance(model.root.rotor_left, PointMass)
    assert model.root.world.water_depth == 320
    assert value(model.root.rotor_left, "mass") == 350e3


def test_definition_with_values_from_outside(model):
    platform = model.root.platform
    assert value(platform, "draft") == pytest.approx(119.3)
    assert value(platform, "slope") == pytest.approx(238.6)
    assert value(platform, "mass") == pytest.approx(7466.33e3)
    np.testing.assert_allclose(value(platform.hull, "r_cm"), [0, 0, -0.75 * 119.3])
    np.testing.assert_allclose(value(platform.arm, "r"), [0, 0, 11.93])
    assert (platform.parameters["mass"].unit, platform.parameters["mass"].min) == ("kg", 1000.0)


def test_each_repeats_with_names_and_numbers(model):
    np.testing.assert_allclose(value(model.root.arm_left, "r"), [0, 69.3, 3])
    np.testing.assert_allclose(value(model.root.arm_right, "r"), [0, -69.3, 3])


def test_connections_and_ports_under_other_names(model):
    ends = [(a.path, b.path) for a, b, _ in model.root.connections]
    assert ("platform.arm.frame_b", "arm_left.frame_a") in ends
    assert ("motion.frame_b", "platform.hull.frame_a") in ends
    assert len(ends) == 6
    assert model.root.connections[0][2] == "model.yaml:15"
    assert model.root.platform.top.path == "platform.arm.frame_b"


def test_outputs_and_settings(model):
    assert list(model.outputs) == ["yaw", "height_left", "height_right"]
    assert model.outputs["yaw"] == fw.Output("motion.yaw", "deg", "yaw of the platform")
    assert model.outputs["height_right"].of == "rotor_right.frame_a.r[2]"
    assert model.settings == {"solver": "idas", "duration": 600.0, "output_step": 0.1, "tolerance": 1e-6}


def test_formulas_follow_their_parameters_in_the_built_model(model):
    model.root.half_span = 100.0
    np.testing.assert_allclose(value(model.root.arm_right, "r"), [0, -100, 3])
    assert value(model.root.platform, "draft") == pytest.approx(150)
    np.testing.assert_allclose(value(model.root.platform.hull, "r_cm"), [0, 0, -112.5])


def test_parameters_of_the_file_are_tunable_in_the_plant(model):
    plant = model.compile()
    assert plant.dae.parameters["half_span"].unit == "m"
    assert "arm_left.r" not in plant.dae.parameters  # it depends on half_span
    state = plant.initial_state(parameters={"half_span": "80 m"})
    assert state["rotor_left.frame_a.r[1]"] == pytest.approx(80)


def test_a_parameter_that_shapes_the_model_becomes_structural(write):
    write(SPAR, "parts/spar.yaml")
    model = load(write(MODEL + TOTALS))
    assert model.root.total.n == 2
    assert not model.root.parameters["rotors"].tunable
    assert model.root.parameters["half_span"].tunable
    three = model.with_parameters({"rotors": 3})
    assert three.root.total.n == 3
    assert model.root.total.n == 2


def test_set_replaces_values_before_the_model_is_built(model):
    changed = model.with_parameters(
        {"half_span": "100 m", "platform.hull.mass": "9000 t", "platform.draft": 5, "world.water_depth": "2*half_span"}
    )
    assert value(changed.root.platform.hull, "mass") == 9e6
    assert value(changed.root.platform, "draft") == 5
    assert changed.root.world.water_depth == 200
    again = changed.with_parameters({"world.water_depth": 300})
    assert again.root.world.water_depth == 300
    assert value(again.root.platform.hull, "mass") == 9e6
    assert value(model.root.platform.hull, "mass") == pytest.approx(7466.33e3)


def test_later_keys_override_a_definition_in_depth(write):
    write(SPAR, "parts/spar.yaml")
    model = load(
        write("""
        fowtlib: 1
        parts:
          a: {use: parts/spar, parts: {hull: {mass: 8e6}, pole: {class: FixedTranslation, r: [1, 0, 0]}}}
          b: {use: parts/spar, parts: {arm: {class: FixedRotation, angle: 6 deg}}}
        connect: [[a.top, a.pole.frame_a]]
    """)
    )
    assert value(model.root.a.hull, "mass") == 8e6
    assert list(model.root.a.parts) == ["hull", "arm", "pole"]
    assert type(model.root.b.arm).__name__ == "FixedRotation"
    assert value(model.root.b.hull, "mass") == pytest.approx(7466.33e3)


def test_a_definition_may_be_one_class_and_may_be_based_on_another(write):
    write("fowtlib: 1\nparameters: {length: 2 m}\nclass: FixedTranslation\nr: [length, 0, 0]\n", "link.yaml")
    write("fowtlib: 1\nuse: link\nlength: 3 m\n", "long_link.yaml")
    parts = "  a: {use: long_link}\n  b: {use: link, length: 4}\n  c: {use: long_link, length: 5}\n"
    model = load(write(f"fowtlib: 1\nparts:\n{parts}"))
    assert [value(part, "r")[0] for part in model.root.parts.values()] == [3, 4, 5]
    assert all(isinstance(part, FixedTranslation) for part in model.root.parts.values())


def test_nested_parts_see_the_parameters_around_them(write):
    model = load(
        write("""
        fowtlib: 1
        parameters: {span: 10 m}
        parts:
          wing:
            parameters: {half: span/2}
            parts:
              tip: {class: FixedTranslation, r: [half, span, 0]}
    """)
    )
    np.testing.assert_allclose(value(model.root.wing.tip, "r"), [5, 10, 0])


def test_a_formula_names_parameters_of_parts_above_it(write):
    model = load(
        write("""
        fowtlib: 1
        parts:
          first: {class: PointMass, mass: 3 t}
          second: {class: PointMass, mass: first.mass/2}
    """)
    )
    model.root.first.mass = 10.0
    assert value(model.root.second, "mass") == 5.0


def test_nested_each(write):
    model = load(
        write("""
        fowtlib: 1
        each:
          for: [{row: 1}, {row: 2}]
          each:
            for: [{side: left, y: -1 m}, {side: right, y: 1 m}]
            parts:
              link_{row}_{side}: {class: FixedTranslation, r: ["10*row", y, "{row}"]}
    """)
    )
    assert list(model.root.parts) == ["link_1_left", "link_1_right", "link_2_left", "link_2_right"]
    np.testing.assert_allclose(value(model.root.link_2_left, "r"), [20, -1, 2])


def test_lists_and_indices(write):
    model = load(
        write("""
        fowtlib: 1
        parameters: {headings: [60 deg, 180 deg, 300 deg]}
        parts:
          fixed: {class: Fixed, angles: [headings[1], 2*headings[0], 0]}
          sum: {class: Sum, n: 2}
          a: {class: Gain, gain: 2}
          b: {class: Gain, gain: 3}
        connect:
          - [a.y, sum.u[0]]
          - [b.y, sum.u[1]]
        outputs: {angle: "fixed.frame.r[0]"}
    """)
    )
    np.testing.assert_allclose(value(model.root.fixed, "angles"), [math.pi, 2 * math.pi / 3, 0])
    assert isinstance(model.root.sum, Sum)
    assert [b.path for _, b, _ in model.root.connections] == ["sum.u[0]", "sum.u[1]"]


def test_cycles_become_radians_only_where_it_is_clear(write):
    text = "fowtlib: 1\nparameters: {corner: 0.25 Hz}\nhinge: {class: Revolute, w_start: corner}\n"
    assert value(load(write(text)).root.hinge, "w_start") == pytest.approx(math.pi / 2)


def test_paths_of_files(write, tmp_path):
    write("t,u\n0,1\n", "series/wind.csv")
    path = write("fowtlib: 1\nwind: {class: Wind, kind: file, file: ../series/wind.csv}\n", "models/m.yaml")
    assert load(path, allow=tmp_path / "series").root.wind.file == str(tmp_path / "series" / "wind.csv")
    write("", "other.csv")
    assert load(path, set={"wind.file": "other.csv"}, allow=tmp_path).root.wind.file == str(tmp_path / "other.csv")
    shipped = load(path, set={"wind.file": "data:oc3_hywind/hydrodynamics.nc"}).root.wind.file
    assert Path(shipped).is_file()


def test_python_of_the_file_runs_only_when_allowed(write):
    write(
        """
        from __future__ import annotations
        from fowtlib.language import Component, Scalar, eq, param, var

        class Mine(Component):
            \"\"\"One equation.\"\"\"
            k: Scalar = param(doc="value")
            x: Scalar = var()

            def equations(self):
                return [eq(self.x, self.k)]
        """,
        "my_parts.py",
    )
    path = write("fowtlib: 1\npython: my_parts.py\nmine: {class: Mine, k: 3}\n")
    with pytest.raises(ModelFileError) as error:
        load(path)
    assert str(error.value) == (
        "model.yaml:2: the file wants to run the Python code in 'my_parts.py'; if you trust it, "
        "load it with allow_python=True, or --allow-python on the command line."
    )
    model = load(path, allow_python=True)
    assert value(model.root.mine, "k") == 3
    assert model.with_parameters({"mine.k": 4}).root.mine.k.value == 4


@pytest.mark.parametrize("now", ["3.0", "5.0"])
def test_an_edited_python_file_is_run_as_it_is_now(write, now):
    """Of the same size and with the same time of change, by which Python knows its own compiled file again."""
    text = """
        from fowtlib.language import Component, Scalar, eq, var

        class Mine(Component):
            \"\"\"One equation.\"\"\"
            x: Scalar = var()

            def equations(self):
                return [eq(self.x, 2.0)]
        """
    path = write("fowtlib: 1\npython: my_parts.py\nmine: {class: Mine}\n")
    code = write(text, "my_parts.py")
    os.utime(code, (1e9, 1e9))
    assert load(path, allow_python=True).compile().equilibrium()["mine.x"] == 2
    code = write(text.replace("2.0", now), "my_parts.py")
    os.utime(code, (1e9, 1e9))
    assert load(path, allow_python=True).compile().equilibrium()["mine.x"] == float(now)
    assert not (code.parent / "__pycache__").exists()


def test_a_component_from_python_is_a_model(write):
    root = fw.Assembly("one mass")
    root.mass = PointMass(mass=2.0)
    model = load(root, set={"mass.mass": "3 t"})
    assert (model.title, value(model.root.mass, "mass"), value(root.mass, "mass")) == ("one mass", 3000, 2)
    assert value(model.with_parameters({"mass.mass": 5}).root.mass, "mass") == 5
    assert load(model) is model


def test_errors_while_flattening_name_the_line(write):
    text = "fowtlib: 1\nparts:\n  world: {class: World}\n  ball:\n    class: PointMass\n    mass: -3 t\n"
    with pytest.raises(fw.ModelError) as error:
        load(write(text + "connect: [[world.frame, ball.frame_a]]\n")).compile()
    assert str(error.value) == "model.yaml:6: ball.mass = -3000 kg is below its minimum 0 kg (mass)."


@pytest.mark.parametrize("kind", [[], {"a": 1}, 3])
def test_a_kind_that_is_no_name_is_refused(kind):
    with pytest.raises(ModelFileError, match="wind.kind"):
        load("oc3_spar_rigid").with_parameters({"wind.kind": kind})


def test_lists_that_a_part_is_built_with_take_quantities_and_formulas(tmp_path):
    path = tmp_path / "tower.yaml"
    text = """fowtlib: 1
title: diameters
parameters: {base: 6 m}
world: {class: World}
wind: {class: Wind, kind: steady, mean_speed: 12 m/s}
parts:
  foot: {class: Fixed}
  flow: {class: TowerPotentialFlow, diameters: [base, 550 cm, base - 2 m]}
  drag: {class: TowerDrag, diameters: [base, 5.5], lengths: [26 m, 26]}
  beam:
    class: TubeBeam
    heights: [0, 9 m]
    diameters: [1 m, 1 m]
    wall_thicknesses: [1 cm, 1 cm]
    node_points: [[0, 500 mm, base], 3 m, 4]
"""
    path.write_text(text)
    model = fw.load(path)
    assert model.root.flow.diameters == [6, 5.5, 4] and value(model.root.drag, "diameters").tolist() == [6, 5.5]
    assert model.root.beam.node_points == [[0, 0.5, 6], 3, 4]
    changed = fw.load(path, set={"base": "7 m", "flow.diameters": ["2 m", 3, "400 cm"]})
    assert changed.root.flow.diameters == [2, 3, 4] and value(changed.root.drag, "diameters").tolist() == [7, 5.5]
    for wrong, message in (("[26 kg, 26, 25.6]", "got '26 kg', which is a mass"), ("26 m", "a list is expected"),
                           ("base", "a list is expected")):  # fmt: skip
        path.write_text(text.replace("[base, 550 cm, base - 2 m]", wrong))
        with pytest.raises(fw.language.errors.ModelError, match=message):
            print(fw.load(path).root.flow.diameters)
