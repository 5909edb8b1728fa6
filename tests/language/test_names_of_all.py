"""A class of components cannot use, for something else, a name that all components have."""

from __future__ import annotations

import pytest

import fowtlib as fw
from fowtlib.components.support import PileInClay
from fowtlib.language import Component, RealInput, Scalar, der, eq, param, part, port, var
from fowtlib.language.errors import ModelError, StructureError


def a_variable():
    class Walker(Component):
        walk: Scalar = var(unit="m", doc="way")


def a_parameter():
    class Walker(Component):
        find: Scalar = param(default=1.0, doc="number")


def a_port():
    class Walker(Component):
        resolve: RealInput = port(doc="number")


def a_part():
    class Walker(Component):
        current: PileInClay = part(PileInClay)


def a_function():
    class Walker(Component):
        def shape_of(self):
            return 3


def a_number():
    class Walker(Component):
        connections = 3


def a_variable_that_authors_write_as_a_function():
    class Walker(Component):
        drawing: Scalar = var(unit="m", doc="way")


def of_a_base():
    class Walker:
        path: Scalar = var(unit="m", doc="way")

    Walker.path.name = "path"
    Walker.__annotations__ = {"path": Scalar}

    class Runner(Walker, Component):
        pass


@pytest.mark.parametrize(("make", "name"), [
    (a_variable, "walk"), (a_parameter, "find"), (a_port, "resolve"), (a_part, "current"), (a_function, "shape_of"),
    (a_number, "connections"), (a_variable_that_authors_write_as_a_function, "drawing"), (of_a_base, "path"),
])  # fmt: skip
def test_refused_with_class_file_and_line(make, name):
    with pytest.raises(StructureError, match=rf"^(Walk|Runn)er \(\w+/test_names_of_all.py:\d+\): '{name}' is a name "):
        make()


def test_a_file_of_python_in_a_model_file(tmp_path):
    (tmp_path / "parts.py").write_text(
        "from fowtlib.language import Component, Scalar, var\n\nclass Walker(Component):\n"
        "    label: Scalar = var(doc='way')\n"
    )
    (tmp_path / "model.yaml").write_text("fowtlib: 1\npython: parts.py\none: {class: Walker}\n")
    with pytest.raises(ModelError, match=r"parts.py:3\): 'label' is a name that every component has already"):
        fw.load(tmp_path / "model.yaml", allow_python=True)


def test_shape_is_free():
    """As a parameter; the shipped pile in clay has one of this name."""

    class Weibull(Component):
        shape: Scalar = param(default=2.0, min=0, doc="of a distribution")
        x: Scalar = var(start=1.0, unit="m", doc="way")

        def equations(self):
            return [eq(der(self.x), -self.shape * self.x)]

    model = fw.Assembly("decay")
    model.add("law", Weibull(shape=3.0))
    plant = fw.load(model).compile()
    assert plant.linearize(plant.initial_state()).matrices["A"] == pytest.approx(-3.0)
