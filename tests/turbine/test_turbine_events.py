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


@pytest.fixture(scope="module")
def pair():
    return fw.load("two_rotor_spar_rigid").compile()


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


def test_sensors_that_show_more_a_share_or_nothing(spar):
    names = [*spar.outputs, "turbine.safety.sensor.measured"]
    events = ("sensor.offset at 2 s, by=20 rpm", "sensor.scaled at 4 s, by=0.9",
              "sensor.drop_out at 6 s, value=900 rpm", "turbine.sensor.restored at 8 s")  # fmt: skip
    result = run(spar, *events, end=10, outputs=names)
    seen, true = column(result, names[-1]) * 30 / np.pi, column(result, "generator_speed")
    for part, expected in ((slice(0, 20), true), (slice(20, 40), true + 20), (slice(40, 60), 0.9 * true + 20),
                           (slice(60, 80), 0 * true + 900), (slice(80, 101), true)):  # fmt: skip
        np.testing.assert_allclose(seen[part], expected[part], rtol=1e-12)


def test_a_sensor_that_shows_too_much_lowers_the_speed_by_that(spar):
    """Above rated speed the integral holds what is measured, so the rotor turns slower by the offset."""
    result = run(spar, "sensor.offset at 5 s, by=30 rpm", end=400, wind=18.0)
    assert column(result, "generator_speed")[-200:].mean() == pytest.approx(1173.7 - 30, abs=1.5)


def test_a_sensor_that_drops_out_lets_the_rotor_run_away(spar):
    """The controller sees standstill: no torque, blades to their lower limit, and the rotor accelerates freely."""
    names = [*spar.outputs, *TORQUES]
    result = run(spar, "sensor.drop_out at 2 s", end=14, every=0.02, outputs=names, step=0.02)
    torque, speed, pitch = column(result, TORQUES[0]), column(result, TORQUES[1]), column(result, "blade_pitch")
    assert column(result, "generator_torque")[-1] < 1 and pitch[-1] == pytest.approx(0, abs=0.1)
    assert speed[-1] * 30 / np.pi > 15
    gone = slice(350, 701)  # the generator torque has fallen to nothing by then, at 15 kN m/s
    assert np.all(np.abs(column(result, "generator_torque")[gone]) < 5)
    assert INERTIA * (speed[700] - speed[350]) == pytest.approx(impulse(result, torque, 350, 700), rel=1e-3)


def test_a_sensor_of_the_yaw_angle_drives_the_yaw_control(pair):
    """The pitch of one rotor follows yaw_gain times what its sensor shows, and the platform turns to the other's."""
    names = [*pair.outputs, *(f"turbine_{side}.control.pitch.yaw_part" for side in ("left", "right"))]
    result = run(pair, "turbine_left.yaw_sensor.drop_out at 2 s, value=-4 deg", end=40, outputs=names)
    left, right = (np.degrees(column(result, name)) for name in names[-2:])
    np.testing.assert_allclose(left[20:], 6.0, atol=1e-9)  # yaw_gain is 1.5
    assert left[19] < 0.3 and column(result, "thrust_left")[60] < 0.9 * column(result, "thrust_right")[60]
    yaw = column(result, "yaw")
    assert yaw.max() > 2
    np.testing.assert_allclose(right[yaw > 0.2], 1.5 * yaw[yaw > 0.2], atol=1e-6)


def test_a_star_stops_every_turbine_and_each_may_stop_at_its_time(pair):
    t = np.arange(0, 15.05, 0.1)
    together = run(pair, "*.emergency_shutdown at 5 s, rate=6 deg/s", end=15)
    later = run(pair, "turbine_left.emergency_shutdown at 5 s, rate=6 deg/s",
                "turbine_right.emergency_shutdown at 5 s, rate=6 deg/s, delay=2 s", end=15)  # fmt: skip
    assert together.attributes["events"].splitlines() == [
        f"t = 5 s: turbine_{side}.safety.emergency_shutdown" for side in ("left", "right")
    ]
    for result, delay in ((together, 0), (later, 2)):
        pitch = column(result, "blade_pitch_right")
        origin = pitch[50]  # the controller itself may ask for more in the time of the delay
        np.testing.assert_allclose(pitch[75:140], origin + 6 * (t[75:140] - 5 - delay), atol=1e-6)
        assert not column(result, "generator_torque_right")[50:].any()
    np.testing.assert_allclose(column(later, "blade_pitch_left"), column(together, "blade_pitch_left"), atol=0.2)
    assert abs(column(together, "yaw")[:150]).max() < 0.5 < column(later, "yaw")[50:].max()


def test_a_trip_of_the_generator_does_nothing_by_itself(spar):
    names = [*spar.outputs, *TORQUES]
    tripped = run(spar, "generator.trip at 2 s", "turbine.emergency_shutdown when generator_speed > 1300 rpm", end=12,
                  every=0.02, outputs=names, step=0.02)  # fmt: skip
    t, torque, speed, pitch = (column(tripped, name) for name in ("time", *TORQUES[:2], "blade_pitch"))
    instant = float(tripped.attributes["events"].splitlines()[-1].split()[2])
    assert INERTIA * (speed[150] - speed[100]) == pytest.approx(impulse(tripped, torque, 100, 150), rel=5e-4)
    assert 3 < instant < 8 and np.degrees(np.interp(instant, t, speed)) / 6 * GEAR == pytest.approx(1300, abs=0.1)
    assert speed.max() * 30 / np.pi * GEAR > 1301 and pitch[-1] > 20


def test_the_brake_alone_slows_the_rotor_by_its_torque(spar):
    """On an idling turbine, whose air torque is small: up in its time, and half where half of it has failed."""
    names = [*spar.outputs, *TORQUES]
    idle = {"turbine.safety.idling": 1.0, "turbine.rotor_speed_start": 1.0}

    def braked(*more):
        return run(spar, *more, "brake.apply at 2 s, torque=5 kN*m, delay=0.5 s", end=6, every=0.01, outputs=names,
                   step=0.01, parameters=idle)  # fmt: skip
    for result, share in ((braked(), 1.0), (braked("brake.failure at 1 s, left=0.5"), 0.5)):
        torque, speed, brake = (column(result, TORQUES[k]) for k in (0, 1, 3))
        t = column(result, "time")
        fast = GEAR * speed / np.hypot(GEAR * speed, 1)  # around standstill the brake is viscous
        np.testing.assert_allclose(brake, fast * share * 5e3 * np.clip((t - 2.5) / 0.6, 0, 1), rtol=1e-9, atol=1e-6)
        net = torque - GEAR * brake
        assert INERTIA * (speed[400] - speed[250]) == pytest.approx(impulse(result, net, 250, 400), rel=1e-4)


def test_blocked_blades_heed_no_shutdown(spar):
    events = ("safety.pitch.stuck at 5 s", "turbine.emergency_shutdown at 6 s, brake_torque=0")
    result = run(spar, *events, end=15)
    pitch, speed = column(result, "blade_pitch"), column(result, "rotor_speed")
    np.testing.assert_allclose(pitch[50:], pitch[50], atol=1e-12)
    assert speed[-1] > 1.15 * speed[60]  # without pitch, generator and brake it runs away


def test_blades_that_run_away_together_go_at_their_rate(spar):
    result = run(spar, "safety.pitch.runaway at 5 s, to=-2 deg, rate=3 deg/s", end=15, wind=18.0)
    pitch, t = column(result, "blade_pitch"), column(result, "time")
    np.testing.assert_allclose(pitch[50:], np.maximum(pitch[50] - 3 * (t[50:] - 5), -2), atol=1e-9)
