"""What can happen to a turbine and its mooring, against what mechanics says about it."""

import numpy as np
import pytest

import fowtlib as fw
from fowtlib.language.errors import NotFoundError

CALM = {"wind.kind": "steady", "wind.mean_speed": 12.0, "sea.spectrum": "still"}
GEAR, INERTIA = 97.0, 38759227 + 97.0**2 * 534.116  # of the whole drive train, about the rotor's axis [kg m^2]
TORQUES = ["turbine.rotor.torque", "turbine.rotor.w", "turbine.safety.generator.output", "turbine.safety.brake.torque"]


@pytest.fixture(scope="module")
def spar():
    return fw.load("oc3_spar_rigid").compile()


@pytest.fixture(scope="module")
def bladed():
    return fw.load("oc3_spar_rigid_bem").compile()


def run(plant, *events, end=20.0, every=0.1, wind=12.0, **options):
    parameters = {**CALM, "wind.mean_speed": wind, **options.pop("parameters", {})}
    return plant.simulate(end, every, parameters=parameters, events=events, **options)


def column(result, name):
    return np.asarray(result[name] if name != "time" else result.time, dtype=float)


def impulse(result, values, first, last):
    """Integral over time by the trapezoidal rule, and between which indices."""
    return np.trapezoid(values[first : last + 1], column(result, "time")[first : last + 1])


@pytest.mark.parametrize(("solver", "options"), [("fixed", {"step": 0.01}), ("idas", {"tolerance": 1e-7})])
def test_after_a_loss_of_the_grid_the_rotor_accelerates_by_its_torque_over_its_inertia(spar, solver, options):
    names = [*spar.outputs, *TORQUES]
    events = "turbine.grid_loss at 2 s, delay=1 s"
    result = run(spar, events, end=4, every=0.01, solver=solver, outputs=names, **options)
    torque, speed = column(result, TORQUES[0]), column(result, TORQUES[1])
    assert column(result, "generator_torque")[199] > 40e3 and np.all(column(result, "generator_torque")[200:] == 0)
    assert INERTIA * (speed[300] - speed[200]) == pytest.approx(impulse(result, torque, 200, 300), rel=2e-4)
    at_once = (speed[205] - speed[200]) / 0.05
    assert at_once == pytest.approx(torque[200] / INERTIA, rel=0.02)
    pitch = column(result, "blade_pitch")
    start = int(np.argmax(np.diff(pitch) > 0.079)) + 1  # the controller itself pitches a little before
    assert 300 <= start < 320
    np.testing.assert_allclose(np.diff(pitch[start:]), 0.08, rtol=1e-6)


def test_an_emergency_shutdown_pitches_at_its_rate_and_brakes(spar):
    names = [*spar.outputs, *TORQUES]
    event = "turbine.emergency_shutdown at 5 s, rate=6 deg/s, brake_delay=1 s"
    result = run(spar, event, end=40, every=0.02, outputs=names, step=0.02)
    t, pitch, brake = (column(result, name) for name in ("time", "blade_pitch", TORQUES[3]))
    np.testing.assert_allclose(pitch[250:950], np.minimum(pitch[250] + 6 * (t[250:950] - 5), 90), atol=1e-9)
    up = 28116.2 * np.clip((t - 6) / 0.6, 0, 1)
    fast = column(result, TORQUES[1]) * GEAR > 20
    np.testing.assert_allclose(brake[fast], up[fast], rtol=2e-3)
    torque, speed = column(result, TORQUES[0]), column(result, TORQUES[1])
    net = torque - GEAR * brake - GEAR * column(result, TORQUES[2])
    assert INERTIA * (speed[600] - speed[250]) == pytest.approx(impulse(result, net, 250, 600), rel=1e-3)
    assert abs(speed[-1]) < 0.01 and pitch[-1] == pytest.approx(90)


def test_a_normal_shutdown_brakes_by_the_generator_down_to_a_speed(spar):
    result = run(spar, "turbine.normal_shutdown at 5 s, cut_out_speed=800 rpm", end=40)
    speed, torque, pitch = (column(result, name) for name in ("generator_speed", "generator_torque", "blade_pitch"))
    assert np.all(torque[speed < 800] == 0) and np.all(torque[(speed > 850) & (speed < 1400)] > 15e3)
    assert pitch[250] - pitch[50] == pytest.approx(40.0, abs=0.01)


def test_a_turbine_that_idles_starts_up(spar):
    idling = {"turbine.safety.idling": 1.0}
    result = run(spar, "turbine.start_up at 20 s", end=250, parameters=idling, wind=13.0)
    pitch, speed, power = (column(result, name) for name in ("blade_pitch", "rotor_speed", "generator_power"))
    assert pitch[0] == pytest.approx(90) == pitch[199] and abs(speed[:200]).max() < 0.5 and power[100] == 0
    np.testing.assert_allclose(np.diff(pitch[201:500]), -0.2, atol=1e-9)
    assert speed[-200:].mean() == pytest.approx(12.1, abs=0.5) and power[-200:].mean() == pytest.approx(5000, rel=0.06)


def test_a_later_event_counts_and_a_start_up_calls_a_shutdown_off(spar):
    result = run(spar, "turbine.grid_loss at 5 s", "turbine.start_up at 5.1 s", end=20)
    usual = run(spar, end=20)
    assert column(result, "generator_torque")[50] == 0 and column(result, "generator_torque")[52] > 40e3
    np.testing.assert_allclose(column(result, "blade_pitch"), column(usual, "blade_pitch"), atol=0.6)


def test_a_stuck_sensor_is_what_the_controller_sees_until_it_is_restored(spar):
    names = [*spar.outputs, "turbine.safety.sensor.measured"]
    result = run(spar, "sensor.stuck at 5 s", "sensor.restored at 10 s", outputs=names)
    seen, true = column(result, names[-1]), np.radians(6) * column(result, "generator_speed")
    np.testing.assert_allclose(seen[50:100], true[50], rtol=1e-12)
    np.testing.assert_allclose(np.delete(seen, slice(50, 100)), np.delete(true, slice(50, 100)), rtol=1e-12)
    assert true[50:100].std() > 0.1


def test_steps_of_the_commands(spar):
    before, after = run(spar), run(spar, "safety.pitch.step at 5 s, by=2 deg", "safety.generator.step at 5 s, by=-5e3")
    assert (column(after, "blade_pitch") - column(before, "blade_pitch"))[50] == pytest.approx(2.0, abs=1e-9)
    assert (column(after, "generator_torque") - column(before, "generator_torque"))[50] == pytest.approx(-5e3, rel=1e-9)


def test_an_event_at_a_crossing_of_a_result_comes_where_it_crosses(spar):
    result = run(spar, "turbine.emergency_shutdown when generator_speed > 1190 rpm", end=20)
    instant = float(result.attributes["events"].split()[2])
    before = run(spar, end=instant)
    assert 3 < instant < 19.5 and before["generator_speed"][-1] == pytest.approx(1190, abs=1e-4)
    speed, t = column(result, "generator_speed"), column(result, "time")
    assert np.all(speed[t <= instant] <= 1190) and speed.max() > 1190


def test_without_a_line_the_spar_is_driven_by_the_others(spar):
    """The upwind line, number 2, holds against the thrust: without it the spar drifts downwind."""
    names = [*spar.outputs, "platform.motion.velocity[0]"]
    whole, lost = run(spar, end=60, outputs=names), run(spar, "line_2.loss at 20 s", end=60, outputs=names)
    assert column(lost, "fairlead_tension_2")[199] > 500 and np.all(column(lost, "fairlead_tension_2")[200:] == 0)
    drift = column(lost, "surge") - column(whole, "surge")
    assert np.all(drift[:200] == 0) and np.all(np.diff(drift[205:]) > 0) and drift[-1] > 20
    assert not lost.attributes["warnings"]
    tension = whole["fairlead_tension_2"][200] * 1e3  # horizontal within 10 %: it is the force that is missing at once
    rate = np.diff(column(lost, names[-1]) - column(whole, names[-1]))[200:203].mean() / 0.1
    assert 0.4 < rate * 2 * 8.07e6 / tension < 1.2  # hull, turbine, tower, and added mass of about as much


def test_one_plant_runs_with_and_without_events(spar, counted):
    first = run(spar)
    run(spar, "turbine.grid_loss at 5 s", "line_1.loss at 7 s", "turbine.emergency_shutdown when pitch > 1 deg")
    again = run(spar)
    assert not any(counted.values())
    np.testing.assert_array_equal(column(first, "pitch"), column(again, "pitch"))


def test_a_run_goes_on_across_a_shutdown_bit_for_bit(spar):
    events = "turbine.grid_loss at 5.03 s", "turbine.emergency_shutdown when rotor_speed < 8 rpm", "line_3.loss at 9 s"
    whole = run(spar, *events)
    with pytest.warns(UserWarning, match="did not happen"):
        first = run(spar, *events, end=8.0)
    joined = first.followed_by(run(spar, *events, start=first))
    for name in ("surge", "rotor_speed", "blade_pitch", "fairlead_tension_3"):
        np.testing.assert_array_equal(column(joined, name), column(whole, name))


def test_equilibrium_and_linear_model_are_those_of_a_turbine_in_operation(spar):
    state = spar.equilibrium(CALM)
    assert state["rotor_speed"] == pytest.approx(12.1, abs=0.01)
    linear = spar.linearize(state, outputs=["turbine.blade_pitch"])
    row = dict(zip(linear.states, np.asarray(linear.C)[0], strict=True))
    assert row.pop("turbine.control.pitch.pitch") == pytest.approx(1, rel=1e-9) and not any(row.values())


def test_a_rigid_turbine_has_no_blades_to_get_stuck(spar):
    with pytest.raises(NotFoundError, match="there is no event 'turbine.bearing_2.stuck'"):
        run(spar, "turbine.bearing_2.stuck at 5 s")


def test_one_blade_is_stuck_another_runs_away_and_the_third_follows(bladed):
    names = [*(f"turbine.assembly.hub.pitch[{k}]" for k in range(3)), "turbine.blade_pitch"]
    events = ("turbine.normal_shutdown at 1 s", "turbine.bearing_1.stuck at 2 s",
              "turbine.bearing_2.runaway at 2 s, to=-3 deg, rate=4 deg/s")  # fmt: skip
    result = run(bladed, *events, end=5, outputs=names)
    stuck, away, follows, asked = (np.degrees(column(result, name)) for name in names)
    np.testing.assert_allclose(stuck[20:], stuck[20], atol=1e-9)
    assert stuck[20] == pytest.approx(asked[20], abs=0.5)
    np.testing.assert_allclose(away[30], away[20] - 4, atol=0.6)  # with the ringing of its drive, 5 Hz, 2 %
    assert away[-1] == pytest.approx(-3, abs=0.3)
    np.testing.assert_allclose(follows[-1], asked[-1], atol=0.5)


def test_the_nacelle_yaws_by_a_step_and_a_turbine_with_blade_elements_shuts_down(bladed):
    names = ["turbine.assembly.nacelle.yaw.angle", "turbine.rotor_speed", "turbine.generator_torque"]
    result = run(
        bladed, "turbine.yaw.step at 1 s, by=5 deg", "turbine.emergency_shutdown at 2 s", end=14, outputs=names
    )
    yaw, speed, torque = (column(result, name) for name in names)
    assert np.degrees(yaw[-1]) == pytest.approx(5, abs=0.1) and np.all(torque[20:] == 0)
    assert speed[-1] < 0.2 * speed[20]
