"""A rotor without its air: by a word from the start, and at an instant."""

import numpy as np
import pytest

import fowtlib as fw

CALM = {"wind.kind": "steady", "wind.mean_speed": 10.0, "sea.spectrum": "still"}


@pytest.fixture(scope="module")
def two():
    return fw.load("two_rotor_spar_rigid", set=CALM).compile()


def test_one_rotor_has_no_air_by_one_word(two):
    """It stands still from the start; the other one has the loads it has always had, and turns the spar."""
    both = two.initial_state()
    alone = {side: two.initial_state({f"turbine_{side}.air_loads": 0}) for side in ("left", "right")}
    for off, on in (("left", "right"), ("right", "left")):
        state = alone[off]
        for name in ("thrust", "aero_power", "rotor_speed"):
            assert float(state[f"{name}_{off}"]) == 0
            assert float(state[f"{name}_{on}"]) == pytest.approx(float(both[f"{name}_{on}"]), rel=1e-12)
    at_rest = two.equilibrium({"turbine_left.air_loads": 0, "yaw_gain": 0})
    arm = float(at_rest["thrust_right"]) * 1e3 * 69.3
    yaw = np.radians(float(at_rest["yaw"]))
    assert yaw > np.radians(5)  # the right rotor is pushed downwind
    # yaw spring of 9.8e7 N m/rad, and what the lines have beside
    assert arm * np.cos(yaw) / yaw == pytest.approx(9.8e7, rel=0.35)


def test_the_air_goes_at_an_instant_and_comes_back(two):
    """Up to then nothing is different; then there is no load; the shaft is braked; afterwards there is load again."""
    whole = two.simulate(4.0, 0.1)
    run = two.simulate(4.0, 0.1, events=["turbine_left.air_off at 1.05 s", "turbine_left.air_on at 3.05 s"])
    time = np.asarray(run.time)
    for name in ("thrust_left", "surge", "rotor_speed_left"):
        assert np.array_equal(np.asarray(run[name])[time < 1.05], np.asarray(whole[name])[time < 1.05])
    off = (time > 1.05) & (time < 3.05)
    assert np.all(np.asarray(run["thrust_left"])[off] == 0) and np.all(np.asarray(run["aero_power_left"])[off] == 0)
    assert np.all(np.asarray(run["thrust_left"])[time > 3.05] > 200)
    assert np.all(np.diff(np.asarray(run["rotor_speed_left"])[off]) < 0)
    at = int(np.flatnonzero(off)[0])  # the spar has not yet begun to yaw
    assert float(run["thrust_right"][at]) == pytest.approx(float(whole["thrust_right"][at]), rel=0.01)


def test_blade_elements_without_air_are_those_in_a_vacuum():
    """The same motion as with air of density zero, turning: the word takes the loads and nothing else."""
    rigid = {
        "turbine.assembly.blade_hinges": 0, "wind.kind": "steady", "wind.mean_speed": 9.0, "tower_drag.active": False,
        "turbine.rotor_speed_start": 1.0, "turbine.blade_pitch_start": 0.1,
    }  # fmt: skip
    plant = fw.load("nrel5mw_land", set=rigid).compile()
    names = ("rotor_speed", "tower_base_fore_aft_moment", "blade_root_edgewise_moment_1")
    vacuum = plant.simulate(3.0, 0.1, parameters={"world.air_density": 0.0})
    word = plant.simulate(3.0, 0.1, parameters={"turbine.air_loads": 0.0})
    for name in names:
        scale = np.abs(np.asarray(vacuum[name])).max()
        assert np.abs(np.asarray(word[name]) - np.asarray(vacuum[name])).max() < 1e-6 * scale
    assert np.all(np.asarray(word["thrust"]) == 0)
