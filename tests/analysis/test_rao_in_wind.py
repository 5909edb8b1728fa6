"""The response to waves with rotors that turn: of blade elements, whose equations are periodic, and of coefficients."""

from __future__ import annotations

import numpy as np
import pytest

import fowtlib as fw
from fowtlib.analysis.plants import refuse_unstable
from fowtlib.cli import main
from fowtlib.solving import mean_linear_model, mean_state

MOTIONS = ("surge", "sway", "heave", "roll", "pitch", "yaw")


def in_wind(name: str, speed: float) -> fw.Model:
    return fw.load(name, set={"wind.kind": "steady", "wind.mean_speed": speed, "sea.spectrum": "still"})


@pytest.fixture(scope="module")
def spar():
    """The OC3 spar with rigid blades of blade elements."""
    return in_wind("oc3_spar_rigid_bem", 18.0)


@pytest.fixture(scope="module")
def plant(spar):
    return spar.compile()


def test_it_is_that_of_runs_in_small_waves(spar, plant):
    """Amplitude and phase, sway, roll and yaw too, which only the rotor makes: they share nothing but the equations."""
    linear = fw.linear_rao(plant, [0.1], outputs=MOTIONS)
    runs = fw.simulated_rao(spar, [0.1], outputs=MOTIONS, height=1.0, in_wind=True)
    for name in MOTIONS:
        assert abs(runs[name][0] - linear[name][0]) < 0.003 * abs(linear[name][0]) or name in ("sway", "roll"), name
        assert abs(runs[name][0] - linear[name][0]) < 0.03 * abs(linear[name][0]), name


def test_wind_changes_it(plant):
    """The aerodynamic damping and the gyroscopic moment: without wind there is no yaw, and pitch differs."""
    spars = plant, fw.load("oc3_spar_rigid_bem")
    in_it, still = (fw.linear_rao(model, [0.04], outputs=["pitch", "yaw"]) for model in spars)
    assert abs(still["yaw"][0]) < 1e-3 * abs(in_it["yaw"][0])
    assert abs(in_it["pitch"][0] / still["pitch"][0] - 1) > 0.1


@pytest.mark.parametrize("speed", [8.0, pytest.param(11.4, marks=pytest.mark.long)])
def test_an_azimuth_is_no_instability(plant, speed):
    """One azimuth has its angle among the states, with a stiffness that goes round; the mean has neither."""
    state = mean_state(plant, {"wind.mean_speed": speed})
    single, mean = plant.linearize(state, outputs=[]), mean_linear_model(plant, state, outputs=[])
    azimuth = set(single.states) - set(mean.states)
    assert any(path.endswith("bearing.phi") for path in azimuth), azimuth
    refuse_unstable(mean)
    slow = [mode for mode in mean.modes() if mode.frequency_hz < 0.2 and "motion" in mode.label]
    assert slow and all(mode.damping_ratio > 0 for mode in slow)


def test_it_does_not_depend_on_the_azimuth_of_the_start(plant):
    state, found = mean_state(plant), []
    paths = {item.path: value for item, value in zip(plant.dae.states, state.x.tolist(), strict=True)}
    (angle,) = (path for path in paths if path.endswith("bearing.phi"))
    for azimuth in (0.0, 0.4, 1.3):
        at = plant.initial_state(None, {**paths, angle: azimuth})
        found.append(fw.linear_rao(plant, [0.05], outputs=["pitch"], state=at)["pitch"][0])
    np.testing.assert_allclose(found, found[0], rtol=1e-4)


def test_a_rotor_of_coefficients_has_one_linear_model():
    plant = in_wind("oc3_spar_rigid", 11.4).compile()
    state = mean_state(plant)
    mean, single = mean_linear_model(plant, state, outputs=["pitch"]), plant.linearize(state, outputs=["pitch"])
    assert mean.states == single.states
    np.testing.assert_array_equal(mean.A, single.A)


def test_a_growing_motion_in_the_wind_of_the_model_is_answered_without_wind(capsys):
    """With the gains of the turbine on land the spar pitches more and more, which is why OC3 has others."""
    land = ("turbine.control.proportional_gain=0.01882681", "turbine.control.integral_gain=0.008068634")
    asked = ["rao", "oc3_spar_rigid", "--frequencies", "0.1", *(word for text in land for word in ("--set", text))]
    assert main([*asked, "--set", "wind.mean_speed=16"]) == 0
    said = capsys.readouterr()
    assert said.out.startswith("wind none (in place of steady:16 (mean of the model's)), waves still")
    assert "a mode of 0.03" in said.err and "What follows is without wind" in said.err and "--runs" in said.err
    assert main([*asked, "--wind", "steady:16"]) == 2
    said = capsys.readouterr()
    assert not said.out and "Take another wind, or --wind none" in said.err


def test_growing_without_wind_there_is_no_answer(capsys):
    """The mass of the hull raised by 30 m: the metacentric height is negative."""
    raised = ("platform.hull.mass=7.4e6", "platform.hull.r_cm=[0, 0, -59.9]")
    asked = ["rao", "oc3_spar_rigid", "--frequencies", "0.1", *(word for text in raised for word in ("--set", text))]
    assert main([*asked, "--wind", "none"]) == 2
    said = capsys.readouterr()
    assert not said.out and "the state is unstable" in said.err and "--runs" not in said.err


def test_runs_on_the_command_line(capsys):
    assert main(["rao", "oc3_spar_rigid", "--runs", "2"]) == 2
    assert "give them by --frequencies" in capsys.readouterr().err
    assert main(["rao", "oc3_spar_rigid", "--wind", "steady:18", "--frequencies", "0.1", "--runs", "2"]) == 0
    head, names, _, row = capsys.readouterr().out.splitlines()
    assert head == "wind steady:18 (given), waves regular, 2 m high (--runs)"
    frequency, surge, *_ = map(float, row.split())
    assert names.split()[2] == "surge" and frequency == 0.1 and 0.45 < surge < 0.55
