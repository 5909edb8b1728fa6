"""Python <-> model file: what is written loads to the same model."""

from __future__ import annotations

import numpy as np
import pytest

import fowtlib as fw
from fowtlib.components.blocks import ButterworthLowPass, Gain, Sum
from fowtlib.components.environment.world import World
from fowtlib.components.mechanics import FixedTranslation, FreeMotion, PointMass, Revolute, RigidBody
from fowtlib.components.mooring import MooringSystem
from fowtlib.language import Component, Scalar, eq, param, part, var
from fowtlib.language import math as m
from fowtlib.language.errors import ModelFileError
from fowtlib.modelfile import dump, load, shipped_models


class Boom(Component):
    """A composite of the user: two links in a row."""

    length: Scalar = param(default=2.0, unit="m", min=0.1, doc="length of the boom")
    first: FixedTranslation = part(FixedTranslation, r=[length / 2, 0, 0])

    def build(self):
        self.second = FixedTranslation(r=[self.length / 2, 0, m.sqrt(self.length) * 0.0])
        self.connect(self.first.frame_b, self.second.frame_a)


def boat() -> fw.Assembly:
    root = fw.Assembly("a boat")
    root.world = World(water_depth=320.0)
    root.motion = FreeMotion(pitch_start="5 deg")
    root.hull = RigidBody(mass="8000 t", inertia=1e9 * np.eye(3), r_cm=(0, 0, -78))
    root.boom = Boom(length=3.0)
    root.top = PointMass(mass=root.hull.mass / 20 + 5.0)
    angles = np.radians([60, 180, 300])
    lines = {"length": 902.2, "axial_stiffness": 384.243e6, "mass_per_length": 77.7}
    radii = {"fairlead_radius": 5.2, "fairlead_depth": 70, "anchor_radius": 853.87, "anchor_depth": 320}
    root.mooring = MooringSystem(headings=angles, **lines, **radii)
    root.mooring.line_2.length = 900.0
    root.connect(root.world.frame, root.motion.frame_a)
    for frame in (root.hull.frame_a, root.boom.first.frame_a, root.mooring.frame):
        root.connections.append((root.motion.frame_b, frame, ""))
    root.connections.append((root.boom.second.frame_b, root.top.frame_a, ""))
    return root


def same(a: Component, b: Component) -> None:
    """The same parts, values and connections."""
    for one, other in zip(a.walk(), b.walk(), strict=True):
        assert one.path == other.path
        for name in set(one.parameters) & set(other.parameters):
            if name not in one.parameters or one.parameters[name].required and name not in one._values:
                continue
            first, second = one.parameter_value(name), other.parameter_value(name)
            np.testing.assert_array_equal(first, second, err_msg=f"{one.path}.{name}")
    assert ends(a) == ends(b)


def ends(root: Component) -> set[frozenset[str]]:
    return {frozenset((x.path, y.path)) for part in root.walk() for x, y, _ in part.connections}


def test_a_model_from_python(write):
    root = boat()
    text = dump(root)
    model = load(write(text))
    same(root, model.root)
    assert dump(model) == text
    assert "line_2: {length: 900.0}" in text
    assert "mass: ((hull.mass / 20.0) + 5.0)" in text
    assert "r: [length / 2.0, 0, sqrt(length) * 0.0 * 1 m^0.5]" in text
    assert "length: {value: 3.0, unit: m, description: length of the boom, min: 0.1}" in text


def test_the_flat_model_is_the_same(write):
    one, other = fw.load(boat()).compile().dae, load(write(dump(boat()))).compile().dae
    assert [x.path for x in one.states] == [x.path for x in other.states]
    assert set(one.parameters) == set(other.parameters)
    for path, item in one.parameters.items():
        np.testing.assert_array_equal(item.value, other.parameters[path].value, err_msg=path)


def test_a_written_formula_still_follows_its_parameter(write):
    model = load(write(dump(boat())))
    model.root.hull.mass = 100.0
    model.root.boom.length = 8.0
    assert model.root.top.parameter_value("mass") == 10.0
    np.testing.assert_array_equal(model.root.boom.second.parameter_value("r"), [4, 0, 0])


def test_a_model_file_is_written_as_one_file(write):
    write(
        """
        fowtlib: 1
        parameters: {length: 2 m, twice: 2*length}
        parts: {a: {class: FixedTranslation, r: [length, twice, 0]}}
        """,
        "link.yaml",
    )
    path = write("""
        fowtlib: 1
        title: links
        parameters: {span: {value: 3 m, description: span of the thing}, n: 3}
        parts: {links: {use: link, length: "-span**2 / 2 m"}, sum: {class: Sum, n: n}}
        outputs: {x: {of: "links.a.frame_b.r[0]", unit: km, description: far}, z: "links.a.frame_b.r[2]"}
        simulation: {solver: idas, duration: 10 s}
    """)
    model = load(path)
    text = dump(model)
    again = load(write(text, "again.yaml"))
    same(model.root, again.root)
    assert (again.title, again.outputs, again.settings) == (model.title, model.outputs, model.settings)
    assert dump(again) == text
    assert again.with_parameters({"span": 4}).root.links.a.parameter_value("r")[0] == -8
    assert again.root.sum.n == 3


@pytest.mark.parametrize("name", shipped_models())
def test_shipped_models(name, write):
    model = load(name)
    again = load(write(dump(model)))
    same(model.root, again.root)
    assert (again.outputs, again.settings) == (model.outputs, model.settings)


def test_what_a_file_cannot_say():
    class Mine(Component):
        """A class with an equation, which is in no catalogue."""

        x: Scalar = var()

        def equations(self):
            return [eq(self.x, 1)]

    root = fw.Assembly("mine")
    root.mine = Mine()
    with pytest.raises(ModelFileError) as error:
        dump(root)
    assert str(error.value) == (
        "mine is of the class Mine, which has equations and is not in the catalogue, so a model file cannot name it."
    )
    other = fw.Assembly("forward")
    other.b = Gain(gain=1.0)
    other.a = Gain(gain=2.0)
    other.b.gain = other.a.gain * 2
    with pytest.raises(ModelFileError) as error:
        dump(other)
    assert str(error.value) == "b.gain depends on a.gain, which a formula there cannot name."
    wrong = fw.Assembly("function")
    wrong.a = Gain(gain=2.0)
    wrong.b = Gain(gain=m.if_else(wrong.a.gain, 1.0, 2.0))
    with pytest.raises(ModelFileError) as error:
        dump(wrong)
    assert str(error.value) == "b.gain: a model file has no function 'if_else'."


def test_units_that_python_does_not_know_are_put_right(write):
    root = fw.Assembly("units")
    root.hinge = Revolute()
    root.filter = ButterworthLowPass(cutoff_frequency=0.25)
    root.other = Revolute(w_start=2 * m.pi * root.filter.cutoff_frequency, phi_start=root.filter.cutoff_frequency)
    again = load(write(dump(root))).root
    assert again.other.parameter_value("w_start") == root.other.parameter_value("w_start")
    assert again.other.parameter_value("phi_start") == 0.25


def test_defaults_are_not_written():
    root = fw.Assembly("sum")
    root.sum = Sum()
    assert dump(root) == "fowtlib: 1\ntitle: sum\nparts:\n  sum: {class: Sum}\n"
