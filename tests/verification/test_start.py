"""The shipped models start at rest or in steady operation: what is read from a run is not the way there."""

from __future__ import annotations

import numpy as np
import pytest

import fowtlib as fw
from fowtlib.cli.app import main
from fowtlib.solving.turning import AZIMUTHS, FEW, Average, turns_of

STEADY = {"sea.spectrum": "still", "wind.kind": "steady"}


@pytest.mark.parametrize("name", [
    "two_rotor_spar", "two_rotor_spar_rigid", "oc3_spar_rigid", "oc3_spar", "oc4_semi_rigid",
])  # fmt: skip
def test_a_floater_starts_at_its_depth_of_rest(name):
    plant = fw.load(name, set={"sea.spectrum": "still", "wind.kind": "none"}).compile()
    assert plant.initial_state()["heave"] == pytest.approx(plant.equilibrium()["heave"], abs=0.02)


def test_the_two_rotor_spar_does_not_fall():
    """Two metres in half a period of heave, when it started where its hull is drawn."""
    plant = fw.load("two_rotor_spar_rigid", set={"sea.spectrum": "still", "wind.kind": "none"}).compile()
    heave = plant.simulate(40.0, 0.5)["heave"].values
    assert np.ptp(heave) < 0.02


@pytest.mark.parametrize("speed", [8.0, 11.4, 16.0])
def test_the_mean_state_is_the_mean_of_a_run(speed):
    """Rigid blades in shear: the loads change with the azimuth, and the spar stays where the mean state has it."""
    plant = fw.load("oc3_spar_rigid_bem", set={**STEADY, "wind.mean_speed": speed}).compile()
    state = fw.mean_state(plant)
    result = plant.simulate(60.0, 0.1, start=state)
    allowed = {"surge": 0.02, "heave": 0.005, "pitch": 0.01, "roll": 0.01, "yaw": 0.02, "rotor_speed": 0.01}
    for name, size in allowed.items():
        assert np.abs(result[name].values - state[name]).max() < size, name


def test_the_mean_state_of_flexible_blades():
    """The platform and the tower stay; the blades swing once in a revolution, and each begins where its swing is then.

    Forces are averaged, not accelerations: with the latter the heave would be wrong by half a metre.
    """
    plant = fw.load("oc3_spar", set={**STEADY, "wind.mean_speed": 16.0}).compile()
    state = fw.mean_state(plant)
    late = plant.simulate(35.0, 0.05, start=state).dataset.sel(time=slice(15.2, None))  # four revolutions
    allowed = {"surge": 0.05, "heave": 0.02, "pitch": 0.02, "rotor_speed": 0.01, "blade_pitch": 0.02,
               "tower_top_fore_aft_displacement": 0.005}  # fmt: skip
    for name, size in allowed.items():
        assert float(late[name].mean()) == pytest.approx(state[name], abs=size), name
    up = np.flatnonzero(np.diff(late["azimuth"].values % 360.0) < -180.0)  # blade 1 is up, as at the start
    assert len(up) >= 3
    # the dam of the tower goes on in harmonics that the mean has not: 0.02 m each of the second to the fourth
    for direction, size in (("out_of_plane", 0.09), ("in_plane", 0.04)):
        for blade in (1, 2, 3):
            name = f"blade_tip_{direction}_{blade}"
            np.testing.assert_allclose(late[name].values[up], state[name], atol=size, err_msg=name)


def test_without_a_turning_rotor_it_is_the_equilibrium():
    plant = fw.load("oc3_spar_rigid", set={**STEADY, "wind.mean_speed": 9.0}).compile()
    np.testing.assert_allclose(fw.mean_state(plant).x, plant.equilibrium().x, rtol=1e-9, atol=1e-12)


@pytest.mark.parametrize(("name", "given"), [
    ("two_rotor_spar", {"wind.mean_speed": 12.0, "blade_hinges": 2}),
    ("two_rotor_spar_rigid_bem", {"wind.mean_speed": 11.4}),
])  # fmt: skip
def test_the_mean_state_of_two_rotors_near_rated_wind(name, given, monkeypatch):
    """Platforms do not drift to it, through regions of the controller; the search is short, and nothing moves there."""
    at_mean, visits = Average.at_mean, []
    monkeypatch.setattr(Average, "at_mean", lambda self, y: visits.append(self.azimuths) or at_mean(self, y))
    monkeypatch.setattr("fowtlib.solving.turning.cached", lambda kind, made_from, find: find())
    plant = fw.load(name, set={**STEADY, **given}).compile()
    state = fw.mean_state(plant)
    assert visits.count(FEW) < 30 and visits.count(AZIMUTHS) < 12
    at = plant.at(state.parameters)
    average = Average(at, state, turns_of(plant, at, state), AZIMUTHS)
    rates, slopes = average.at_state(average.multiblade.from_states(state.x))
    left = np.linalg.solve(slopes, rates)  # how far the state is from where nothing moves
    assert np.max(np.abs(left)) < 1e-5
    assert state["rotor_speed_left"] == pytest.approx(state["rotor_speed_right"], rel=1e-3)


def test_a_near_mean_state_is_near():
    plant = fw.load("oc3_spar_rigid_bem", set={**STEADY, "wind.mean_speed": 14.0}).compile()
    near, exact = fw.mean_state(plant, near=True), fw.mean_state(plant)
    for name, size in {"surge": 0.2, "heave": 0.05, "pitch": 0.1, "rotor_speed": 0.05}.items():
        assert near[name] == pytest.approx(exact[name], abs=size)


def heave_and_surge(text: str) -> dict[str, list[float]]:
    rows = (line.split(",") for line in text.splitlines())
    return {row[0]: [float(value) for value in row[2:]] for row in rows if row[0] in ("heave", "surge", "rotor_speed")}


@pytest.mark.parametrize(
    ("start", "surge", "speed"), [("turning", 13.7, 10.09), ("equilibrium", 13.7, 10.09), ("rest", 0.0, 0.0)]
)
def test_the_starts_of_the_command(capsys, start, surge, speed):
    argv = ["run", "oc3_spar_rigid", "--time", "0.5", "--wind", "steady:9", "--waves", "still", "--csv"]
    assert main([*argv, "--start", start]) == 0
    shown = capsys.readouterr()
    means = heave_and_surge(shown.out)
    assert means["surge"][0] == pytest.approx(surge, abs=0.02)
    assert means["rotor_speed"][2] == pytest.approx(speed, abs=0.02)
    assert shown.err.startswith("wind steady:9 (given), waves still (given); from ")


def test_a_start_from_a_file(capsys, monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)
    argv = ["run", "oc3_spar_rigid", "--wind", "steady:9", "--waves", "still"]
    assert main([*argv, "--time", "20", "--start", "file", "--output", "first.nc"]) == 0
    end = fw.Result.open("first.nc")
    capsys.readouterr()
    assert main([*argv, "--time", "0.1", "--start", "first.nc", "--output", "next.nc"]) == 0
    later = fw.Result.open("next.nc")
    assert later.time[0] == 0.0 and later["surge"].values[0] == pytest.approx(end["surge"].values[-1], rel=1e-9)
    plant = fw.load("oc3_spar_rigid", set={**STEADY, "wind.mean_speed": 9.0}).compile()
    plant.equilibrium().save("state.json")
    assert main([*argv, "--time", "0.1", "--start", "state.json"]) == 0
    capsys.readouterr()
    for word, message in (
        ("fast", "--start: 'fast' is not 'equilibrium', 'turning', 'stationary', 'rest' or 'file', nor a file"),
        ("absent.nc", "absent.nc: there is no such file"),
        ("absent.json", "absent.json: cannot be read"),
    ):
        assert main([*argv, "--time", "0.1", "--start", word]) == 2
        assert message in capsys.readouterr().err
    assert main([*argv, "--resume", "first.nc", "--start", "rest"]) == 2


def test_discarded_seconds_are_in_no_number_and_no_picture(capsys, monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)
    argv = ["run", "oc3_spar_rigid", "--wind", "steady:9", "--waves", "still", "--start", "file", "--time", "40"]
    assert main([*argv, "--discard", "30", "--output", "run.nc", "--plot", "run.png", "--csv"]) == 0
    shown = heave_and_surge(capsys.readouterr().out)["surge"]
    result = fw.Result.open("run.nc")
    late = result["surge"].sel(time=slice(30, None)).values
    assert shown[2] == pytest.approx(late.min(), rel=1e-4) and shown[3] == pytest.approx(late.max(), rel=1e-4)
    axis = result.plot(discard=30).axes[0]
    assert axis.lines[0].get_xdata()[0] == 30.0
