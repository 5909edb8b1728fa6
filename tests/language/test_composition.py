"""Composites are made anew when a parameter changes that decides about their parts; values set meanwhile stay."""

import pytest

import fowtlib as fw
from fowtlib.components.servo import BaselineController
from fowtlib.language import Array, Component, Scalar, eq, param, part, var
from fowtlib.language.errors import ParameterError

GAINS = {"proportional_gain": 0.006, "integral_gain": 0.0009}


class Leaf(fw.Component):
    """x = gain + offset."""

    gain: Scalar = param(default=1.0, doc="gain")
    offset: Scalar = param(default=0.0, doc="offset")

    x: Scalar = var(doc="sum")

    def equations(self):
        return [eq(self.x, self.gain + self.offset)]


class Row(fw.Component):
    """So many leaves; the gain of all, which build() gives them."""

    count: int = param(default=2, doc="number of leaves")
    gain: Scalar = param(default=2.0, doc="gain of all leaves")

    def build(self):
        for i in range(self.count):
            self.add(f"leaf_{i + 1}", Leaf(gain=self.gain))


class Bed(fw.Component):
    """A row whose count its owner decides."""

    count: int = param(default=3, doc="number of leaves")
    row: Row = part(Row)

    def build(self):
        self.row.count = self.count


def offset(leaf):
    return leaf.parameter_value("offset")


def test_a_value_given_to_an_inner_part_outlives_a_new_composition():
    row = Row()
    row.leaf_2.offset = 5.0
    old = row.leaf_2
    row.count = 3
    assert row.leaf_2 is not old and offset(row.leaf_2) == 5.0
    row.count = 4
    assert offset(row.leaf_2) == 5.0 and offset(row.leaf_4) == 0.0
    assert fw.load(row).compile().initial_state()["leaf_2.x"] == pytest.approx(7.0)


def test_it_outlives_the_owner_that_composes_its_part_anew():
    row = Row()
    row.leaf_1.offset = 5.0
    assert offset(Bed(row=row).row.leaf_1) == 5.0
    assert len(row.parts) == 3


def test_what_build_gives_follows_the_parameter():
    """A value of build() is none of the user's: it changes with its parameter."""
    row = Row(gain=3.0)
    row.leaf_1.offset = 5.0
    row.gain, row.count = 4.0, 3
    state = fw.load(row).compile().initial_state()
    assert [float(state[f"leaf_{i}.x"]) for i in (1, 2, 3)] == pytest.approx([9.0, 4.0, 4.0])


def test_a_value_whose_part_vanishes_is_an_error():
    row = Row()
    row.leaf_2.offset = 5.0
    with pytest.raises(ParameterError) as error:
        row.count = 1
    assert str(error.value) == (
        "Row.count decides how Row is built, and with its new value there is no 'leaf_2.offset', "
        "which was given a value before; set count first."
    )


def test_a_part_added_by_hand_to_an_inner_part_outlives_a_new_composition():
    bed = Bed()
    bed.row.leaf_1.add("own", Leaf(offset=7.0))
    bed.count = 4
    assert list(bed.row.parts) == ["leaf_1", "leaf_2", "leaf_3", "leaf_4"]
    assert offset(bed.row.leaf_1.own) == 7.0
    assert fw.load(bed).compile().initial_state()["row.leaf_1.own.x"] == pytest.approx(8.0)


def test_limits_of_a_controller_reach_the_turbine():
    """The turbine gives its controller start values, which makes the parts of the controller anew."""
    control = BaselineController(**GAINS)
    control.torque.greatest_torque = 10.0
    control.pitch_start = 0.1
    assert control.torque.parameter_value("greatest_torque") == 10.0
    assert control.pitch.parameter_value("pitch_start") == 0.1
    model = fw.load("oc3_spar", set={"turbine.control.torque.greatest_torque": 10.0})
    for changed in (model, model.with_parameters({"turbine.control.torque.cut_in_speed": 80.0})):
        torque = changed.root.find("turbine.control.torque")
        assert torque.parameter_value("greatest_torque") == 10.0


def test_a_structural_parameter_says_why():
    class Stack(Component):
        layers: int = param(default=2, doc="number of layers")
        open_top: bool = param(default=False, doc="whether the top is open")
        kind: str = param(default="flat", doc="kind of layers")
        thickness: Scalar = param(default=1.0, doc="thickness")
        heights: Array = param(default=(1, 2), structural="each height is a node", doc="heights")

    why = {name: field.why_structural for name, field in Stack.parameters.items()}
    assert why == {
        "layers": "it counts parts or states", "open_top": "it switches equations", "thickness": "",
        "kind": "it chooses equations or data", "heights": "each height is a node",
    }  # fmt: skip
    assert not Stack.parameters["heights"].tunable
