"""The triangle that turns into the wind: what is printed of it, where it floats, its periods, how it turns."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

import fowtlib as fw
from fowtlib.components.environment.waves import wave_number
from fowtlib.components.hydro.linear_loads import stiffness_with_buoyancy
from fowtlib.frequency import rotor_formulas

CALM = {"wind.kind": "none", "sea.spectrum": "still"}
NAMES = ("front", "left", "right")
MOTIONS = ("surge", "sway", "heave", "roll", "pitch", "yaw")


def steady(speed, **more):
    return {"wind.kind": "steady", "wind.mean_speed": speed, "sea.spectrum": "still", **more}


@cache
def plant():
    return fw.load("wind_tracing_rigid").compile()


@cache
def mean(speed):
    return fw.mean_state(plant(), parameters=steady(speed) if speed else CALM)


def test_distances_are_those_that_are_printed():
    hubs = [mean(0)[f"turbine_{name}.frame.r"].ravel() for name in NAMES]
    for k in range(3):
        assert np.linalg.norm(hubs[k] - hubs[k - 1]) == pytest.approx(277.2, abs=1e-3)
    turret = mean(0)["platform.turret.frame_a.r"].ravel()
    assert turret[2] == pytest.approx(-64, abs=0.01)
    single = hubs[0] + [5, 0, 0]  # the hub is 5 m before its tower
    assert turret[0] - single[0] == pytest.approx(40.05, abs=0.02)


def test_it_floats_as_it_is_drawn_without_wind():
    assert abs(mean(0)["platform.motion.heave"]) < 0.01
    assert abs(np.degrees(mean(0)["platform.motion.pitch"])) < 0.01


def test_periods_lie_outside_of_the_waves():
    modes = fw.natural_modes(plant(), parameters=CALM)
    found = {name: mode.period for mode in modes for name in MOTIONS if f"platform {name}" in str(mode)}
    assert found["surge"] > 100
    for name in ("heave", "roll", "pitch"):
        assert 25.5 < found[name] < 60, name


def test_yaw_in_steady_wind_is_where_the_drag_of_the_towers_holds_the_tilted_torque():
    """The thrust of the rotors goes through the turret at any yaw; the torque leans by the tilt of 5 deg."""
    state = mean(11.4)
    torque = sum(float(state[f"turbine_{name}.rotor.torque"]) for name in NAMES) * np.sin(np.radians(5))
    force = 3 * 0.5 * 1.225 * 1.0 * 11.4**2 * np.dot([6.06, 5.185, 4.31], [25.87, 25.87, 25.86])
    arm = 277.2 / np.sqrt(3) - 40.05
    yaw = float(state["platform.motion.yaw"])
    assert np.sin(yaw) == pytest.approx(-torque / (force * arm), rel=0.05)


@pytest.mark.parametrize("speed", [8.0, 11.4, 18.0])
def test_yaw_is_stable_with_the_friction_of_its_turret(speed):
    slow = np.linalg.eigvals(np.asarray(plant().linearize(mean(speed)).A))
    slow = slow[(np.abs(slow) > 1e-6) & (np.abs(slow) < 0.012)]
    assert len(slow) >= 3
    assert slow.real.max() < -3e-4


def test_without_friction_yaw_grows_above_rated_wind_where_the_control_takes_its_damping():
    growth = {}
    for speed in (11.4, 14.0):
        state = fw.mean_state(plant(), parameters=steady(speed, **{"platform.friction_torque": 0.0}))
        slow = np.linalg.eigvals(np.asarray(plant().linearize(state).A))
        growth[speed] = slow[(np.abs(slow) > 1e-6) & (np.abs(slow) < 0.0035)].real.max()
    assert growth[11.4] < -5e-4
    assert 1e-4 < growth[14.0] < 5e-4


def test_it_follows_a_wind_that_turns_by_thirty_degrees_in_five_minutes():
    turn = steady(11.4, **{"wind.kind": "veer", "wind.turn": np.radians(30), "wind.turn_duration": 300})
    result = plant().simulate(3600.0, output_step=10.0, parameters=turn, start=mean(11.4))
    yaw = np.asarray(result["yaw"])
    before = np.degrees(mean(11.4)["platform.motion.yaw"])
    assert yaw[0] == pytest.approx(before, abs=0.05)
    assert yaw[-1] == pytest.approx(before + 30, abs=0.5)
    assert np.all(np.diff(yaw) > -0.05)  # it comes from one side
    turret = yaw + np.asarray(result["turret_angle"])
    assert np.abs(turret).max() < 5  # the lines hold the turret, the hull turns about it


def test_without_one_of_the_outer_rotors_it_turns_out_of_the_wind():
    off = {"turbine_left.air_loads": 0.0}
    yaw = np.degrees(float(fw.mean_state(plant(), parameters=steady(11.4, **off))["platform.motion.yaw"]))
    assert yaw > 60
    front = {"turbine_front.air_loads": 0.0}
    assert abs(np.degrees(float(fw.mean_state(plant(), parameters=steady(11.4, **front))["platform.motion.yaw"]))) < 6


def masses():
    """Mass (6, 6) and stiffness of weight of hull, towers and turbines about the frame, from their numbers alone."""
    hull = fw.load("wind_tracing_rigid").root.find("platform.hull").hull().mass
    M = six(hull.mass, hull.centre, hull.inertia)
    turbine = fw.load("wind_tracing_rigid").root.find("turbine_left")
    own, r_cm = (np.asarray(turbine.parameter_value(name), dtype=float) for name in ("inertia", "centre_of_mass"))
    for x, y in ((-160.0415, 0), (80.0207, 138.6), (80.0207, -138.6)):
        M = M + six(249718, np.array([x, y, 43.348]), np.diag([120252000, 120252000, 1818460]))
        M = M + six(350e3, np.array([x - 5, y, 90]) + r_cm, own)
    return M + six(200e3, np.array([-119.9915, 0, -64]), np.zeros((3, 3)))


def six(mass, centre, inertia):
    x, y, z = centre
    S = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.block([[mass * np.eye(3), -mass * S], [mass * S, inertia - mass * S @ S]])


def test_formulas_without_wind_are_the_linear_model():
    """Mass, water and lines by hand against the model: head waves, calm air, above the resonance of pitch."""
    root = plant().root
    hull, data = root.find("platform.hull"), root.find("platform.hull").database
    M, water = masses(), hull.hull().buoyancy
    C = stiffness_with_buoyancy(
        1025 * 9.80665 * np.asarray(water.waterplane), 1025 * 9.80665 * water.volume, water.centre
    )
    C = C - 9.80665 * np.array([[0] * 6] * 3 + [[0] * 3 + [M[0, 4], 0, 0], [0] * 4 + [M[0, 4], 0], [0] * 6])
    lines, arm = root.find("platform.mooring"), np.array([[0, -64.0, 0], [64.0, 0, 119.9915], [0, -119.9915, 0]])
    K = -np.array([
        (lines.static_load(d + np.array([0, 0, -64]))[0] - lines.static_load(-d + np.array([0, 0, -64]))[0]) / 0.2
        for d in 0.1 * np.eye(3)
    ])  # fmt: skip
    J = np.hstack([np.eye(3), arm])
    C = C + J.T @ K @ J
    pull = lines.static_load((0, 0, -64))[0][2]
    C[3, 3] += pull * -64
    C[4, 4] += pull * -64
    omega = data.omega[(data.omega > 0.34) & (data.omega < 1.0)]
    at = np.isin(data.omega, omega)
    X = data.excitation_at(omega, 0.0) * np.exp(-1j * wave_number(omega, 200.0) * 119.9915)[:, None]
    found = rotor_formulas.motions(omega, M, data.A[at], data.B[at], C, X)
    rao = fw.linear_rao(plant(), omega / 2 / np.pi, outputs=["surge", "heave", "pitch"], heading=0.0, state=mean(0))
    full = np.asarray(rao.response) * [1, 1, np.pi / 180]
    for k, j in enumerate((0, 2, 4)):
        np.testing.assert_allclose(found[:, j], full[:, k], atol=0.02 * np.abs(full[:, k]).max())


def test_damping_and_phase_of_the_formulas():
    damping = rotor_formulas.thrust_damping(1.225, np.pi * 63**2, 0.8, 10.0)
    assert damping == pytest.approx(1.225 * np.pi * 63**2 * 8)
    B = rotor_formulas.rotor_damping(damping, [(0, 0, 90), (0, 100, 90), (0, -100, 90)])
    np.testing.assert_allclose(B[[0, 0, 4, 5, 0], [0, 4, 4, 5, 5]] / damping, [3, 270, 3 * 8100, 2e4, 0], atol=1e-9)
    # a thin column: J1' -> 1/2 and Y1' -> 2/(pi x^2), so that delta -> -pi/2
    assert rotor_formulas.wave_phase(0.01, 1.935) == pytest.approx(-np.pi / 2, abs=1e-3)


def turned(by: float, name: str = "platform.motion") -> dict[str, float]:
    """Start of the platform in calm air, turned about its turret by an angle [rad]; the turret stays as it is."""
    arm = 277.2 / np.sqrt(3) - 40.05
    place = {"surge": arm * np.cos(by), "sway": arm * np.sin(by), "yaw": by}
    return {**{f"{name}.{motion}": value for motion, value in place.items()}, "platform.bearing.phi": -by}


def test_turned_by_ninety_degrees_it_moves_as_one_that_was_built_at_this_heading():
    """Waves from 50 deg aside of each, calm air, four lines that are alike from either side: 0.2 % of the largest."""
    found = []
    for angle in (0.0, np.pi / 2):
        sea = {"spectrum": "jonswap", "significant_wave_height": 3.1, "peak_period": 10.1, "heading": angle + 0.87}
        waves = {"wind.kind": "none", **{f"sea.{name}": value for name, value in sea.items()}}
        waves["platform.hull.yaw_at_rest"] = angle
        result = plant().simulate(120.0, output_step=0.5, parameters=waves, start=turned(angle))
        motion = np.array([result[name] for name in MOTIONS]).T
        c, s = np.cos(angle), np.sin(angle)
        motion[:, :2] = motion[:, :2] @ np.array([[c, -s], [s, c]])  # along the axes of the hull as it was built
        motion[:, 5] -= np.degrees(angle)
        found.append(motion)
    built, after = found
    size = np.abs(built - built[0]).max(axis=0)
    assert (size[[0, 1, 2]] > 0.05).all() and (size[3:] > 0.02).all()
    np.testing.assert_allclose(after / size, built / size, rtol=0, atol=2e-3)
