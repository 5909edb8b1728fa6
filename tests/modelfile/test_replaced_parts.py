"""A part that a class makes gets another class in a model file: it is replaced, or the file is refused."""

import pytest

import fowtlib as fw
from fowtlib.components.mechanics import FixedTranslation
from fowtlib.components.mooring import CatenaryLine
from fowtlib.language import RealInput, RealOutput, eq, port
from fowtlib.language.errors import ModelFileError, ParameterError
from fowtlib.modelfile import dump

TURBINE = """
fowtlib: 1
world: {class: World}
wind: {class: Wind, kind: steady, mean_speed: 50 m/s}
parts:
  top: {class: FixedTranslation, r: [-5, 0, 90]}
  turbine:
    use: turbines/nrel5mw_rigid
    rotor_speed_start: 0 rpm
    blade_pitch_start: 85 deg
    CHANGES
connect:
  - [world.frame, top.frame_a]
  - [top.frame_b, turbine.frame]
"""
MOORED = """
fowtlib: 1
world: {class: World, water_depth: 320 m}
parts:
  held: {class: FixedTranslation, r: [0, 0, 0]}
  mooring:
    class: MooringSystem
    headings: [60 deg, 180 deg, 300 deg]
    fairlead_radius: 5.2 m
    fairlead_depth: 70 m
    anchor_radius: 853.87 m
    anchor_depth: 320 m
    length: 902.2 m
    axial_stiffness: 384243000 N
    mass_per_length: 77.7066 kg/m
    diameter: 0.09 m
    parts: {line_1: {LINE}}
connect:
  - [world.frame, held.frame_a]
  - [held.frame_b, mooring.frame]
"""


def turbine(changes):
    return TURBINE.replace("CHANGES", changes)


def moored(line):
    return MOORED.replace("LINE", line)


def refusal(write, text):
    with pytest.raises(ModelFileError) as error:
        fw.load(write(text))
    return str(error.value)


def test_a_class_that_does_not_fit_is_refused_with_its_line(write):
    message = refusal(write, turbine("parts: {control: {parts: {pitch: {class: Constant, value: 85 deg}}}}"))
    assert message == (
        "model.yaml:11: turbine.control.pitch: Constant cannot take the place of BaselineController.pitch, a "
        "PitchController: it has no port 'speed', 'blade_pitch' and 'collective'."
    )
    message = refusal(write, turbine("parts: {control: {class: Constant, value: 1}}"))
    assert message == (
        "model.yaml:11: Constant cannot take the place of turbine.control, a TurbineController: it has no port "
        "'generator_speed', 'blade_pitch' and 'generator_torque'."
    )
    message = refusal(write, moored("class: PointMass, mass: 3 t"))
    assert message.startswith("model.yaml:17: mooring.line_1: PointMass cannot take the place of MooringSystem.line_1")


def test_a_part_made_in_build_is_replaced(write):
    numbers = "class: CatenaryLine, length: 850 m, axial_stiffness: 1 GN, mass_per_length: 500 kg/m"
    model = fw.load(write(moored(f"{numbers}, anchor_position: [300, 520, -320]")))
    lines = [model.root.find(f"mooring.line_{i}") for i in (1, 2)]
    assert [line.parameter_value("length") for line in lines] == [850.0, 902.2]
    state, plain = model.compile().initial_state(), fw.load(write(moored(""))).compile().initial_state()
    # 600 m away and 250 m below, a line of 850 m is slack: it hangs straight down with its own weight
    assert state["mooring.line_1.tension"] == pytest.approx(500 * 9.80665 * 250, rel=1e-3)
    assert state["mooring.line_2.tension"] == pytest.approx(plain["mooring.line_2.tension"])
    again = fw.load(write(dump(model), "again.yaml")).compile().initial_state()
    assert again["mooring.line_1.tension"] == pytest.approx(state["mooring.line_1.tension"], rel=1e-9)


def test_values_of_a_part_made_in_build_still_act(write):
    model = fw.load(write(moored("length: 850 m")))
    assert [model.root.find(f"mooring.line_{i}").parameter_value("length") for i in (1, 2)] == [850.0, 902.2]


def test_a_derived_class_on_top_keeps_what_the_part_had_and_another_begins_anew(write):
    hull = fw.load("wind_tracing").root.find("platform.hull")
    assert type(hull).__name__ == "ElasticFloater"
    assert hull.turning  # said below, of the Floater
    assert hull.column_1.parameter_value("wall_thickness") == 0.4
    write("fowtlib: 1\nparts: {one: {class: FixedTranslation, r: [1, 2, 3]}}", "pair.yaml")
    model = "fowtlib: 1\nparts: {pair: {use: pair, parts: {one: {class: PointMass, mass: 3 t}}}}"
    assert fw.load(write(model)).root.find("pair.one").parameter_value("mass") == 3000.0


def test_a_structural_value_of_a_part_that_its_owner_has_made():
    plain = fw.load("oc3_spar_rigid")
    changed = fw.load("oc3_spar_rigid", set={"platform.water.radiation.order": 2})
    assert len(changed.compile().dae.states) < len(plain.compile().dae.states)


def test_a_further_part_in_a_class_that_makes_its_own(write):
    root = fw.load(write(turbine("parts: {control: {parts: {extra: {class: Constant, value: 1}}}}"))).root
    assert list(root.turbine.control.parts) == ["speed_filter", "pitch", "torque", "extra"]
    root.turbine.control.pitch_start = 0.1
    assert fw.load(root).compile().initial_state()["turbine.control.extra.y"] == 1.0


class MyController(fw.Component):
    """Holds the pitch; the torque brakes in proportion to the speed."""

    generator_speed: RealInput = port(unit="rad/s", doc="generator speed")
    blade_pitch: RealOutput = port(unit="rad", doc="blade pitch")
    generator_torque: RealOutput = port(unit="N*m", doc="generator torque")

    def equations(self):
        return [eq(self.blade_pitch, 0.3), eq(self.generator_torque, 100 * self.generator_speed)]


def test_by_attribute_assignment_in_a_loaded_model(write):
    model = fw.load(write(turbine("generator_efficiency: 0.9")))
    model.root.turbine.control = MyController()
    model.root.turbine.gear = type(model.root.turbine.gear)(ratio=50)
    state = model.compile().initial_state()
    assert (state["turbine.blade_pitch"], state["turbine.generator.speed"]) == (0.3, 0.0)
    with pytest.raises(ParameterError, match="CatenaryLine cannot take the place of turbine.control, a TurbineContr"):
        model.root.turbine.control = CatenaryLine(
            length=1, axial_stiffness=1, mass_per_length=1, anchor_position=(0, 0, 0)
        )
    whole = fw.load("oc3_spar_rigid")
    whole.root.platform.mooring.fairlead_2 = FixedTranslation(r=(-9.0, 0.0, -70.0))
    assert whole.compile().initial_state()["platform.mooring.line_2.tension"] > 0


BASE = """
fowtlib: 1
title: a boom
parameters: {length: 20 m}
parts:
  link: {class: FixedTranslation, r: [0, length, 0]}
"""
FURTHER = """
fowtlib: 1
title: a boom with a mass
use: base
length: 30 m
parameters: {mass: 3 t}
world: {class: World}
parts:
  end: {class: PointMass, mass: mass}
connect:
  - [world.frame, link.frame_a]
  - [link.frame_b, end.frame_a]
outputs: {force: "link.frame_a.f[2]"}
"""


def test_a_file_that_goes_on_from_a_definition_has_parameters_of_its_own(write):
    write(BASE, "base.yaml")
    plant = fw.load(write(FURTHER)).compile()
    weight = [abs(plant.equilibrium(parameters=given)["force"]) for given in ({}, {"mass": "6 t", "length": "5 m"})]
    assert weight == pytest.approx([3000 * 9.80665, 6000 * 9.80665])


@pytest.mark.parametrize(
    "text",
    [
        FURTHER.replace("{mass: 3 t}", "{line: 3 t/m, length: 25 m}").replace(" mass: mass", " mass: line * length"),
        FURTHER.replace("length: 30 m\nparameters: {mass", "parameters: {length: 25 m, mass").replace(
            " mass: mass", " mass: mass / length * length"
        ),
        "fowtlib: 1\nworld: {class: World}\nparts:\n  boom:\n    use: base\n    parameters: {mass: 3 t}\n"
        "    parts: {end: {class: PointMass, mass: mass}}\n",
    ],
)
def test_what_the_definition_has_is_given_directly(write, text):
    write(BASE, "base.yaml")
    with pytest.raises(ModelFileError, match="beside 'use', give the parameters of the definition values directly"):
        fw.load(write(text))
