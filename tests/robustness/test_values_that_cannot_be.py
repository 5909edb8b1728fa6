"""Numbers that no part can have, angles that look like degrees, values without effect: each with what to do."""

from __future__ import annotations

import re
import subprocess
import sys

import pytest

import fowtlib as fw
from fowtlib.components.aero import CoefficientRotor
from fowtlib.components.blocks import Sampler
from fowtlib.components.flooding import FloatingPiston
from fowtlib.components.mechanics import EndStop, Fixed, Latch, PointMass, Prismatic, World
from fowtlib.components.mooring import CatenaryLine, DynamicLine, MooringSystem
from fowtlib.components.support.soil_springs import SandSpring
from fowtlib.language import Assembly
from fowtlib.language.errors import ModelError, ParameterError, UnusedParameterError
from fowtlib.modelfile import catalogue

LINE = {"length": 902.2, "axial_stiffness": 384e6, "mass_per_length": 77.7, "diameter": 0.09}
SAND = {
    "place": (0, 0, -5), "length": 2.0, "axial_stiffness": 5e8, "torsional_stiffness": 5e8, "depth": 2.0,
    "diameter": 2.0, "friction_angle": 0.6, "unit_weight": 1e4, "modulus_gradient": 2e7,
}  # fmt: skip


def held(part, port="frame"):
    model = Assembly("a part alone")
    model.world = World(water_depth=320)
    model.hull, model.part = Fixed(r=(0, 0, -70)), part
    model.connect(model.hull.frame, getattr(model.part, port))
    return fw.load(model).compile()


@pytest.mark.parametrize(("make", "said"), [
    (lambda: held(SandSpring(**SAND | {"modulus_gradient": 0})), "modulus_gradient = 0 N/m^3 is not above 0 N/m^3"),
    (lambda: held(SandSpring(**SAND | {"diameter": 0})), "diameter = 0 m is not above 0 m"),
    (lambda: held(SandSpring(**SAND | {"unit_weight": -1})), "unit_weight = -1 N/m^3 is not above 0 N/m^3"),
    (lambda: held(CatenaryLine(**LINE | {"length": 0}), "fairlead"), "length = 0 m is not above 0 m"),
    (lambda: held(DynamicLine(lengths=[100, 0], **{k: v for k, v in LINE.items() if k != "length"}), "fairlead"),
     "lengths = 0 m is not above 0 m"),
    (lambda: held(CatenaryLine(**LINE | {"axial_stiffness": 0}), "fairlead"), "axial_stiffness = 0 N is not above 0 N"),
])  # fmt: skip
def test_what_must_be_above_zero(make, said):
    with pytest.raises(ParameterError, match=re.escape(said)):
        make()


def test_zero_is_taken_where_it_means_none():
    """A stop that does not push, a latch that does not hold, a light rotor, a section without a limit."""
    assert EndStop.reference_force.min == Latch.stiffness.min == CoefficientRotor.inertia.min == 0
    assert DynamicLine.least_bending_radius.min == 0
    falls = Assembly("a mass falls through a stop and a latch that are none")
    falls.world, falls.slide = World(), Prismatic(n=(0, 0, -1))
    falls.mass = PointMass(mass=2.0)
    falls.stop = EndStop(side="above", place=0.1, reference_force=0)
    falls.latch = Latch(place=0.3, stiffness=0, ready_start=1)
    falls.connect(falls.world.frame, falls.slide.frame_a)
    falls.connect(falls.slide.frame_b, falls.mass.frame_a)
    for part in (falls.stop, falls.latch):
        falls.connect(falls.slide.axis, part.axis)
    result = fw.load(falls).compile().simulate(1.0, 0.5, outputs=["slide.s", "latch.closed"])
    assert float(result["slide.s"][-1]) == pytest.approx(9.80665 / 2, rel=1e-5)  # free fall
    assert float(result["latch.closed"][-1]) == 1.0


def test_a_rotor_without_inertia_is_as_fast_as_its_generator():
    """Light rotor, heavy generator: the same mean, and with all of the inertia at the generator the same run."""
    model = {"wind.kind": "steady", "wind.mean_speed": 9, "turbine.rotor.inertia": 0}
    light = fw.load("surrogate_7mw_foundation", set=model).compile()
    drive = {"turbine.generator_inertia": 1066.22 + 132772407 / 62.2526**2}
    whole = light.simulate(2.0, 0.5, start="turning", parameters=drive, solver="fixed", step=0.0125)
    usual = {"turbine.rotor.inertia": 132772407}
    beside = light.simulate(2.0, 0.5, start="turning", parameters=usual, solver="fixed", step=0.0125)
    assert float(whole["rotor_speed"][-1]) == pytest.approx(float(beside["rotor_speed"][-1]), rel=1e-9)


def test_a_compiled_model_does_not_take_it_either():
    plant = held(SandSpring(**SAND))
    with pytest.raises(ParameterError, match=r"part.modulus_gradient = 0 is not above 0 N/m\^3"):
        plant.simulate(1.0, parameters={"part.modulus_gradient": 0})
    assert CoefficientRotor.radius.min == FloatingPiston.diameter.min == Sampler.period.min > 0


def test_an_angle_in_degrees_is_told_so():
    with pytest.raises(ParameterError, match="= 35 rad is above its maximum 0.9 rad; did you mean '35 deg'"):
        held(SandSpring(**SAND | {"friction_angle": 35}))
    plant = held(SandSpring(**SAND))
    with pytest.raises(ParameterError, match="did you mean '35 deg'"):
        plant.simulate(1.0, parameters={"part.friction_angle": 35})
    for path in ("wind.direction", "sea.heading"):
        with pytest.raises(ModelError, match="more than a full turn; write '35 deg', or '35 rad' if it is meant"):
            fw.load("oc3_spar_rigid", set={path: "35"})
        assert fw.load("oc3_spar_rigid", set={path: "35 deg"})
    with pytest.raises(ModelError, match="platform.mooring.headings: got 180 without a unit, and angles are in rad"):
        fw.load("oc3_spar_rigid", set={"platform.mooring.headings": [180, 300, 60]})


@pytest.mark.parametrize("text", ["nan", "NAN", "NaN", "nan kg", "-Infinity", "2*inf", "INF"])
def test_what_is_no_number(text):
    with pytest.raises(ModelError, match="is not a finite number"):
        fw.load("oc3_spar_rigid", set={"platform.mooring.friction": text})


@pytest.mark.parametrize("name", ["drag_coefficient", "added_mass_coefficient"])
def test_drag_of_a_line_in_balance_has_no_effect_and_says_so(name):
    said = f"{name} is given and would do nothing, because the line is in balance"
    with pytest.raises(ModelError, match=said):
        fw.load("oc3_spar_rigid", set={f"platform.mooring.{name}": "2"})
    with pytest.raises(UnusedParameterError, match=said):
        CatenaryLine(**LINE, **{name: 2.0})
    for dynamics in ("coupled", "lumped"):
        ends = {"fairleads": ((0, 0, -70),), "anchors": ((850, 0, -320),)}
        assert MooringSystem(dynamics=dynamics, **ends, **LINE, **{name: 2})


def test_partial_classes_are_no_parts():
    names = catalogue.classes()
    for name in ("Rotor", "Tank", "SoilSpring", "TwoFrames", "HubWind"):
        assert name not in names
    assert {"BoxTank", "CoefficientRotor", "SandSpring", "Duct"} <= set(names)
    run = subprocess.run([sys.executable, "-m", "fowtlib.cli", "parts", "SoilSpring"], capture_output=True, text=True)
    assert run.returncode and "'SoilSpring' is a base of other classes, no part: see 'ClaySpring'" in run.stderr
