"""What a run takes in: only what is computed from a changed parameter is computed anew, and it is the same."""

from __future__ import annotations

import numpy as np
import pytest

import fowtlib as fw
from fowtlib.language.errors import ModelError
from fowtlib.solving.binding import bind


@pytest.mark.parametrize("name", ["oc3_spar_rigid", "two_rotor_support"])
def test_what_is_computed_from_a_changed_parameter_is_that_of_a_binding_from_nothing(name):
    """For every tunable parameter of the model that takes a change of 0.1 %."""
    plant = fw.load(name).compile()
    tried = 0
    for path, item in plant.dae.parameters.items():
        given = {path: item.value * 1.001}
        try:
            whole = bind(plant.dae, plant.root, given)
        except ModelError:  # a limit, or a matrix that has to be symmetric
            continue
        part = plant.binding(given)
        tried += 1
        assert np.array_equal(part.p, whole.p, equal_nan=True), path
    assert tried > 50
    assert any(plant._bindings.needs.values())  # some are computed from others


@pytest.mark.parametrize(
    ("name", "steps"),
    [
        ("two_rotor_spar_rigid", [
            {"platform.mooring_mass": 210.0},
            {"platform.mooring_mass": 190.0, "platform.structure.mass": "11.2e6 kg"},
            {"platform.structure.mass": "11.2e6 kg"},
            {"yaw_gain": 2.0},
        ]),
        ("tlp_two_rotor_rigid", [
            {"platform.draft": 44.0, "platform.tendon_length": 86.0},
            {"platform.draft": 44.0, "platform.diameter": 15.8, "platform.tendon_length": 86.0},
            {"platform.ballast_level": -15.0},
        ]),
        ("oc3_spar_rigid", [
            {"wind.kind": "steady", "wind.mean_speed": 9.0, "sea.spectrum": "still"},
            {"wind.kind": "steady", "wind.mean_speed": 10.0, "sea.spectrum": "still"},
            {"wind.kind": "steady", "wind.mean_speed": 9.5, "sea.spectrum": "still", "tower.mass": 2.6e5},
        ]),
    ],
)  # fmt: skip
def test_a_binding_beside_another_is_that_of_a_binding_from_nothing(name, steps):
    """Also of parameters that others are computed from, that go back to the value of the model, and with bound ones."""
    plant = fw.load(name, set={"sea.spectrum": "still", "wind.kind": "none"}).compile()
    for given in steps:
        beside, whole = plant.binding(given), bind(plant.dae, plant.root, given)
        assert np.array_equal(beside.p, whole.p, equal_nan=True)
        assert list(beside.values) == list(whole.values) and beside.reads == whole.reads
        assert beside.structure == whole.structure and beside.steady == whole.steady
        for path in given:
            owner, _, own = path.rpartition(".")
            wanted = whole.root.find(owner).parameter_value(own)
            assert beside.root.find(owner).parameter_value(own) == wanted
            with beside.tree() as tree:
                assert tree.find(owner).parameter_value(own) == wanted
    assert beside.lend is not None  # it was made from the one before


def test_a_tree_that_is_lent_is_given_back():
    """Whoever looks at it next finds the values of the model, or of another run, also where something went wrong."""
    plant = fw.load("oc3_spar_rigid", set={"sea.spectrum": "still", "wind.kind": "none"}).compile()
    plant.binding({"tower.mass": 2.4e5})
    one, two = plant.binding({"tower.mass": 2.5e5}), plant.binding({"tower.mass": 2.6e5})
    with pytest.raises(ModelError, match="no part"), one.tree() as tree:
        assert tree is two.like and tree.tower.parameter_value("mass") == 2.5e5
        tree.find("nothing")
    with two.tree() as tree:
        assert tree.tower.parameter_value("mass") == 2.6e5
    own = one.root
    own.tower._values["mass"] = 1.0
    assert plant.root.tower.parameter_value("mass") == 249718 and two.root.tower.parameter_value("mass") == 2.6e5


def test_what_is_wrong_beside_another_is_said_as_from_nothing():
    plant = fw.load("tlp_two_rotor_rigid", set={"sea.spectrum": "still", "wind.kind": "none"}).compile()
    plant.binding({"platform.draft": 43.5})
    for given in ({"platform.draft": -1.0}, {"platform.ballast_level": 12.0}, {"platform.drift": 1.0},
                  {"platform.draft": "3 kg"}, {"platform.freeboard": np.nan}):  # fmt: skip
        with pytest.raises(ModelError) as beside:
            plant.binding(given)
        with pytest.raises(ModelError) as whole:
            bind(plant.dae, plant.root, given)
        assert str(beside.value) == str(whole.value)
    assert plant.binding({"platform.draft": 43.0}).values["platform.draft"] == 43.0
