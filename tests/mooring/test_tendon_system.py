"""TendonSystem: the same as tendons one by one, its layouts, lengths as drawn, and what it says of mistakes."""

from __future__ import annotations

import numpy as np
import pytest

import fowtlib as fw
from fowtlib.components.mechanics import Fixed, FixedTranslation, World
from fowtlib.components.mooring import Tendon, TendonSystem
from fowtlib.language import Assembly, ModelError

PLACE = (3.0, -2.0, 1.0)
LINE = {"axial_stiffness": 1.5e9, "weight_per_length": 300.0}


def held(place=PLACE, **system):
    """A system on a body that is held at a place."""
    model = Assembly("tendons")
    model.world, model.body = World(water_depth=200.0), Fixed(r=place)
    values = {"headings": [0.3, 2.0, 4.0], "radius": 27.0, "depth": 48.0, "anchor_depth": 200.0, **LINE, **system}
    model.tendons = TendonSystem(**values)
    model.connect(model.body.frame, model.tendons.frame)
    return model


def load(plant):
    state = plant.initial_state()
    return np.concatenate([np.ravel(state["body.frame.f"]), np.ravel(state["body.frame.t"])])


def test_it_pulls_as_tendons_one_by_one():
    """Two a leg, 4 m apart, with anchors further out and a pretension of each of its own."""
    pulls = 1e6 * np.arange(3.0, 9.0)
    one = fw.load(held(tendons_per_leg=2, spacing=4.0, anchor_radius=30.0, length=151.9, pretension=pulls)).compile()
    model = Assembly("one by one")
    model.world, model.body = World(water_depth=200.0), Fixed(r=PLACE)
    for k, pull in enumerate(pulls):
        heading, aside = (0.3, 2.0, 4.0)[k // 2], (-2.0, 2.0)[k % 2]
        turn = np.array([[np.cos(heading), -np.sin(heading)], [np.sin(heading), np.cos(heading)]])
        arm = model.add(f"arm_{k}", FixedTranslation(r=(*(turn @ [27.0, aside]), -48.0)))
        line = model.add(f"line_{k}", Tendon(anchor_position=(*(turn @ [30.0, aside]), -200.0), length=151.9,
                                             pretension=pull, **LINE))  # fmt: skip
        model.connect(model.body.frame, arm.frame_a)
        model.connect(arm.frame_b, line.fairlead)
    assert load(one) == pytest.approx(load(fw.load(model).compile()), rel=1e-12, abs=1e-3)


@pytest.mark.parametrize("foot", [None, 27.0, 40.0])
def test_without_a_length_the_pretension_is_that_of_the_drawn_draft(foot):
    plant = fw.load(held((0, 0, 0), anchor_radius=foot, pretension=4e6, weight_per_length=0.0)).compile()
    state = plant.initial_state()
    drawn = np.hypot(152.0, (foot or 27.0) - 27.0)
    for k in (1, 2, 3):
        assert state[f"tendons.tendon_{k}.tension"] == pytest.approx(4e6, rel=1e-6)
        assert state[f"tendons.tendon_{k}.distance"] == pytest.approx(drawn)
    deeper = plant.initial_state({"tendons.depth": 50.0})  # the drawn draft goes with it
    assert deeper["tendons.tendon_2.tension"] == pytest.approx(4e6, rel=1e-6)


def test_its_numbers_are_tunable_and_a_pretension_is_found():
    plant = fw.load(held((0, 0, 0), pretension=4e6)).compile()
    state = plant.equilibrium(free=["tendons.pretension"], targets={"tendons.tendon_1.tension": 5e6})
    assert state.parameters["tendons.pretension"] == pytest.approx(5e6, rel=1e-3)
    wider = plant.initial_state({"tendons.radius": 35.0})
    assert np.ravel(wider["tendons.tendon_2.fairlead.r"])[:2] == pytest.approx(35 * np.array([np.cos(2), np.sin(2)]))


def test_a_ring_of_one_leg_in_a_file(tmp_path):
    (tmp_path / "m.yaml").write_text(
        "fowtlib: 1\nworld: {class: World, water_depth: 200 m}\nparts:\n  body: {class: Fixed}\n"
        "  tendons: {class: TendonSystem, headings: 90 deg, tendons_per_leg: 2, radius: 27 m, depth: 48 m,\n"
        "            anchor_depth: 200 m, pretension: 4 MN, axial_stiffness: 1.5 GN, weight_per_length: 0}\n"
        "connect:\n  - [body.frame, tendons.frame]\n"
    )
    state = fw.load(tmp_path / "m.yaml").compile().initial_state()
    assert np.ravel(state["tendons.tendon_2.fairlead.r"]) == pytest.approx([0, 27, -48])


@pytest.mark.parametrize(
    ("values", "says"),
    [
        ({"pretension": [1e6, 2e6]}, r"TendonSystem.pretension has 2 values for 3 tendons"),
        ({"tendons_per_leg": 2, "length": [150.0] * 3}, r"TendonSystem.length has 3 values for 6 tendons"),
        ({"tendons_per_leg": 0}, r"TendonSystem.tendons_per_leg"),
        ({"headings": []}, r"TendonSystem.headings has no leg"),
    ],
)
def test_mistakes(values, says):
    with pytest.raises(ModelError, match=says):
        fw.load(held(**values)).compile()
