"""Design maps: quantities over parameters against formulas, limits, and what is wrong with a map."""

from __future__ import annotations

import math

import numpy as np
import pytest

import fowtlib as fw
from fowtlib.analysis import parameter_map
from fowtlib.analysis.maps import Limit
from fowtlib.components.environment import World
from fowtlib.components.mechanics import AxialWire, PointMass, Prismatic
from fowtlib.language import ModelError

GRAVITY = 9.80665


@pytest.fixture(scope="module")
def plant():
    """A mass that hangs on a wire and slides along it: stretch m g l / EA, period 2 pi sqrt(m l / EA)."""
    top = fw.Assembly("hanging")
    top.world, top.guide = World(), Prismatic(n=(0, 0, -1), s_start=2.0)
    top.wire, top.bob = AxialWire(axial_stiffness=1e4, length=2.0), PointMass(mass=3.0)
    top.connect(top.world.frame, top.guide.frame_a)
    top.connect(top.guide.frame_b, top.bob.frame_a)
    top.connect(top.world.frame, top.wire.frame_a)
    top.connect(top.bob.frame_a, top.wire.frame_b)
    return fw.load(top).compile()


def test_two_parameters_against_formulas(plant):
    mass, stiffness = np.array([1.0, 2.0, 5.0]), ["5 kN", "10 kN"]
    name = next(mode.name for mode in fw.natural_modes(plant))
    period = f"period of {name}"
    found = parameter_map(
        plant, {"bob.mass": mass, "wire.axial_stiffness": stiffness}, ["guide.s", period, "mass"],
        limits=["wire.tension < 0.03 kN", "mass > 1.5"],
    )  # fmt: skip
    EA = np.array([5e3, 1e4])
    np.testing.assert_allclose(found["guide.s"], 2 + 2 * mass[:, None] * GRAVITY / EA, rtol=1e-9)
    np.testing.assert_allclose(found[period], 2 * math.pi * np.sqrt(2 * mass[:, None] / EA), rtol=1e-6)
    np.testing.assert_allclose(found["mass"], mass[:, None] + 0 * EA)
    np.testing.assert_allclose(found["wire.tension"], mass[:, None] * GRAVITY + 0 * EA, rtol=1e-9)
    assert found.feasible.tolist() == [[False, False], [True, True], [False, False]]
    assert (found.units["guide.s"], found.units[period], found.units["mass"]) == ("m", "s", "kg")
    data = found.dataset
    assert data["mass"].dims == ("bob.mass", "wire.axial_stiffness") and data["feasible"].sum() == 2
    rows = list(found.rows())
    assert found.heads()[:2] == ["bob.mass [kg]", "wire.axial_stiffness [N]"] and len(rows) == 6
    assert rows[3][:3] == pytest.approx([2.0, 1e4, 2 + 4 * GRAVITY / 1e4]) and rows[3][-1] == 1


def test_a_point_starts_from_its_neighbour_and_is_the_same(plant):
    """Within the tolerance of Newton, and also where the neighbour is far."""
    for mass in (3.1, 40.0, 0.1):
        alone = plant.equilibrium({"bob.mass": mass})
        near = plant.equilibrium({"bob.mass": mass}, near=plant.equilibrium({"bob.mass": 3.0}))
        np.testing.assert_allclose(near.x, alone.x, rtol=1e-10, atol=1e-12)
        np.testing.assert_allclose(near.z, alone.z, rtol=1e-10, atol=1e-9)


def test_the_spar_over_the_wind():
    """The mean pitch is that of an equilibrium alone; also behind rated wind, where the blades pitch."""
    plant = fw.load("oc3_spar_rigid", set={"wind.kind": "steady", "sea.spectrum": "still"}).compile()
    found = fw.parameter_map(plant, {"wind.mean_speed": [8.0, 11.0, 16.0]}, ["pitch", "blade_pitch"])
    for wind, pitch, blades in zip((8.0, 11.0, 16.0), found["pitch"], found["blade_pitch"], strict=True):
        alone = plant.equilibrium({"wind.mean_speed": wind})
        assert (pitch, blades) == pytest.approx((alone["pitch"], alone["blade_pitch"]), rel=1e-7, abs=1e-7)
    assert found["pitch"].argmax() == 1 and found.feasible.all()


def test_a_point_without_equilibrium_is_told_and_the_others_stay(plant, monkeypatch):
    real = type(plant).equilibrium

    def sometimes(self, parameters=None, **options):
        if parameters["bob.mass"] == 2.0:
            raise ModelError("no equilibrium found")
        return real(self, parameters, **options)

    monkeypatch.setattr(type(plant), "equilibrium", sometimes)
    told = []
    found = parameter_map(plant, {"bob.mass": [1.0, 2.0, 3.0]}, ["mass"], progress=lambda *done: told.append(done))
    assert np.isnan(found["mass"][1]) and found["mass"][[0, 2]].tolist() == [1.0, 3.0]
    assert found.failures == {(1,): "no equilibrium found"} and found.feasible.tolist() == [True, False, True]
    assert told == [(1, 3), (2, 3), (3, 3)]
    with pytest.raises(ModelError, match="no point of the map has an equilibrium; the first one: no equilibrium"):
        parameter_map(plant, {"bob.mass": [2.0]}, ["mass"])


@pytest.mark.parametrize(
    ("over", "of", "limits", "says"),
    [
        ({}, ["mass"], [], "over one or two parameters, not over 0"),
        ({"bob.mass": [1.0]}, [], [], "a map needs quantities"),
        ({"bob.mas": [1.0]}, ["mass"], [], "no tunable parameter 'bob.mas'; did you mean 'bob.mass'"),
        ({"bob.mass": []}, ["mass"], [], "over numbers, one or more"),
        ({"bob.mass": ["1 m"]}, ["mass"], [], "bob.mass.*length"),
        ({"bob.mass": [-1.0]}, ["mass"], [], "below its minimum"),
        ({"bob.mass": [1.0]}, ["guide.speed"], [], "no quantity 'guide.speed'"),
        ({"bob.mass": [1.0]}, ["period of surge"], [], "no point .* all that was asked for; .* no 'period of surge'"),
        ({"bob.mass": [1.0]}, ["bob.v"], [], "bob.v is an array of shape"),
        ({"bob.mass": [1.0]}, ["mass"], ["mass"], "'mass' is not a limit"),
        ({"bob.mass": [1.0]}, ["mass"], ["mass < 3 m"], "mass"),
    ],
)
def test_what_is_wrong_with_a_map(plant, over, of, limits, says):
    with pytest.raises(ModelError, match=says):
        _ = parameter_map(plant, over, of, limits=limits).feasible


def test_a_parameter_takes_the_value_at_which_a_condition_holds(plant):
    """The wire is as stiff as its stretch asks for: EA = m g l / stretch; so is each point after its neighbour."""
    found = parameter_map(plant, {"bob.mass": [2.0, 3.0, 9.0], "wire.length": [1.9, 2.0]},
                          ["wire.axial_stiffness", "bob.mass", "guide.s"],
                          limits=["wire.axial_stiffness < 5 kN", "wire.length > 1.95 m"],
                          free=["wire.axial_stiffness"], targets={"guide.s": 2.01})  # fmt: skip
    mass, length = np.array([2.0, 3.0, 9.0])[:, None], np.array([1.9, 2.0])
    np.testing.assert_allclose(found["wire.axial_stiffness"], mass * GRAVITY * length / (2.01 - length), rtol=1e-8)
    np.testing.assert_allclose(found["guide.s"], 2.01)
    assert found["bob.mass"][:, 0].tolist() == [2.0, 3.0, 9.0] and found.units["wire.axial_stiffness"] == "N"
    assert found.feasible.tolist() == [[False, True], [False, False], [False, False]]
    assert found.heads() == ["bob.mass [kg]", "wire.length [m]", "wire.axial_stiffness [N]", "guide.s [m]", "feasible"]
    assert len(next(found.rows())) == 5 and found.dataset["bob.mass"].dims == ("bob.mass",)
    titles = [axis.get_title(loc="left") for axis in found.plot().axes if axis.get_visible()]
    assert titles[:2] == ["wire.axial_stiffness [N]", "guide.s [m]"]  # no panels of the axes themselves


def test_what_the_model_warns_of_is_left_out(plant):
    """A wire that pushes: its bob would lie below the fixed end."""
    top = fw.Assembly("pushing")
    top.world, top.guide = World(), Prismatic(n=(0, 0, 1), s_start=2.0)
    top.wire, top.bob = AxialWire(axial_stiffness=1e4, length=2.0, pretension=25.0), PointMass(mass=3.0)
    top.connect(top.world.frame, top.guide.frame_a)
    top.connect(top.guide.frame_b, top.bob.frame_a)
    top.connect(top.world.frame, top.wire.frame_a)
    top.connect(top.bob.frame_a, top.wire.frame_b)
    standing = fw.load(top).compile()
    with pytest.raises(ModelError, match="no point .* an equilibrium; .*compression"):
        parameter_map(standing, {"bob.mass": [2.0, 3.0]}, ["guide.s"])


def test_the_first_point_is_that_nearest_to_the_model(plant, monkeypatch):
    """The others are reached from their neighbours, also around one that fails."""
    real, order = type(plant).equilibrium, []

    def watched(self, parameters=None, near=None, **options):
        order.append((parameters["bob.mass"], parameters["wire.length"], near is None))
        if parameters["bob.mass"] == 2.0:
            raise ModelError("no equilibrium found")
        return real(self, parameters, near=near, **options)

    monkeypatch.setattr(type(plant), "equilibrium", watched)
    parameter_map(plant, {"bob.mass": [1.0, 2.0, 3.2], "wire.length": [1.0, 2.1, 3.0]}, ["guide.s"])
    assert order[0] == (3.2, 2.1, True)
    assert [item[:2] for item in order if item[2]] == [(3.2, 2.1), (1.0, 2.1)]  # (1.0, 2.1) lies behind the gap


def test_limits_are_texts():
    limit = Limit.parse("period of platform yaw >= 25 s")
    assert (limit.quantity, limit.below, limit.number("s")) == ("period of platform yaw", False, 25.0)
    assert str(limit) == "period of platform yaw > 25 s" and Limit.parse("pitch<5").number("deg") == 5.0
    assert Limit.parse("pitch < 0.1 rad").number("deg") == pytest.approx(math.degrees(0.1))


@pytest.mark.parametrize("over", [{"bob.mass": [1.0, 2, 3]}, {"bob.mass": [1.0, 2], "wire.length": [1.0, 2, 3]}])
def test_pictures(plant, over, tmp_path):
    found = parameter_map(plant, over, ["guide.s", "mass"], limits=["wire.tension < 25"])
    figure = found.plot(tmp_path / "map.png", "hanging")
    shown = [axis for axis in figure.axes if axis.get_visible() and axis.get_title(loc="left")]
    assert [axis.get_title(loc="left") for axis in shown] == ["guide.s [m]", "mass [kg]", "wire.tension [N]"]
    assert shown[0].get_xlabel() == "bob.mass [kg]" and (tmp_path / "map.png").stat().st_size > 10_000


def test_a_picture_of_one_point_shows_it_and_its_whole_title(plant):
    title = "a bob that hangs on a wire\nwind steady:11.4 (mean of the model's), waves still (mean of the model's)"
    figure = parameter_map(plant, {"bob.mass": [2.0]}, ["mass"]).plot(title=title)
    assert figure.axes[0].lines[0].get_marker() == "."
    figure.draw_without_rendering()
    assert figure._suptitle.get_window_extent().x1 <= figure.bbox.x1
    assert " ".join(figure._suptitle.get_text().split()) == " ".join(title.split())
