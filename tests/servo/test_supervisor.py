"""The supervision of a turbine: each transition, on a stand where wind and speed are given, and in a whole turbine."""

from importlib.util import find_spec

import numpy as np
import pytest

import fowtlib as fw
from fowtlib.components.blocks import Constant
from fowtlib.components.environment.wind import SteadyWind
from fowtlib.components.mechanics import World
from fowtlib.components.servo import FLOATING_GAINS, BaselineController, Supervisor
from fowtlib.components.servo.supervisor import STATES
from fowtlib.language import Array, Component, RealOutput, eq, param, port
from fowtlib.language import math as m
from fowtlib.language.errors import ModelError
from fowtlib.language.native import compiler

RPM = np.pi / 30
RATED = 1173.7
END = 260.0
STEADY = [0, END], [10.0, 10.0]
AT_RATED = [0, END], [RATED, RATED]
NAMES = ["state", "entered", "generator.connected", "brake.torque", "pitch.output", "yaw_allowed", "overspeeds"]


class Given(Component):
    """Straight lines between six points."""

    times: Array = param(default=tuple(range(6)), unit="s", doc="times of the points")
    values: Array = param(default=(0.0,) * 6, unit="rad/s", doc="values there")
    y: RealOutput = port(unit="rad/s", doc="speed")

    def equations(self):
        t, v = self.times, self.values
        ways = [m.fmin(m.fmax((self.time - t[k]) / (t[k + 1] - t[k]), 0), 1) * (v[k + 1] - v[k]) for k in range(5)]
        return [eq(self.y, v[0] + sum(ways))]


@pytest.fixture(scope="module")
def stand():
    """A supervised controller under given wind and speed."""
    model = fw.Assembly("stand")
    model.world, model.wind, model.speed, model.yaw = World(), SteadyWind(mean_speed=10.0), Given(), Constant(value=0.0)
    model.control, model.safety = BaselineController(**FLOATING_GAINS), Supervisor(averaging_time=1e-2)
    for a, b in model.safety.around(model.control, model.speed.y, model.yaw.y):
        model.connect(a, b)
    return fw.load(model).compile()


@pytest.fixture
def watched(stand, tmp_path):
    """Its result for wind [m/s] and speed [rpm] over time, as (times, values)."""

    def run(wind=STEADY, speed=AT_RATED, events=(), end=END, solver="fixed", **parameters):
        path, t = tmp_path / "wind.csv", np.arange(0, end + 2)
        path.write_text("time [s],speed [m/s]\n" + "\n".join(f"{a:g},{b:.12g}" for a, b in zip(
            t, np.interp(t, *wind), strict=True)))  # fmt: skip
        times, values = (list(part) for part in speed)
        while len(times) < 6:
            times, values = [*times, times[-1] + 1], [*values, values[-1]]
        given = {"wind.kind": "file", "wind.interpolation": "linear", "wind.file": str(path),
                 "speed.times": times, "speed.values": np.multiply(values, RPM).tolist()}  # fmt: skip
        parameters = given | {f"safety.{name}": value for name, value in parameters.items()}
        options = {"step": 0.02} if solver == "fixed" else {"tolerance": 1e-8}
        return stand.simulate(end, 0.5, solver=solver, events=events, parameters=parameters,
                              outputs=[f"safety.{name}" for name in NAMES], **options)  # fmt: skip

    return run


def at(result, name, time):
    return float(np.asarray(result[f"safety.{name}"])[int(round(2 * time))])


def history(result):
    """(time, state) of each transition that an output point sees."""
    state, entered = (np.asarray(result[f"safety.{name}"]) for name in ("state", "entered"))
    new = np.flatnonzero(np.diff(state, prepend=state[0]))
    return [(round(float(entered[k]), 1), STATES[int(state[k])]) for k in new]


def falling(at, rate=20.0, start=RATED, to=0.0):
    """Speed that falls from a time on."""
    return [0, at, at + (start - to) / rate, END], [start, start, to, to]


@pytest.mark.parametrize("solver", ["fixed", "idas"])
def test_from_idling_over_a_start_up_into_production(watched, solver):
    result = watched(speed=([0, 20, 40], [0, 0, 1000]), end=60, idling=1, solver=solver)
    assert history(result) == [(10, "start-up"), (34, "production")]
    assert at(result, "pitch.output", 9) == pytest.approx(np.pi / 2) and at(result, "generator.connected", 9) == 0
    assert at(result, "pitch.output", 30) == pytest.approx(np.radians(90 - 2 * 20)) and at(
        result, "generator.connected", 10.5) == 1  # fmt: skip


@pytest.mark.parametrize(("wind", "starts"), [(3.4, False), (3.6, True), (21.9, True), (22.1, False)])
def test_it_starts_between_two_winds(watched, wind, starts):
    result = watched(([0, END], [wind, wind]), ([0, END], [0, 0]), end=20, idling=1)
    assert history(result) == ([(10, "start-up")] if starts else [])


@pytest.mark.parametrize("solver", ["fixed", "idas"])
def test_it_stops_in_calm_and_idles_when_it_stands_at_feather(watched, solver):
    """The wind falls to 3 m/s at 17 s; the pitch from 0 reaches 90 deg less 0.01 rad 44.7 s later."""
    calm = [0, 10, 18, END], [10.0, 10.0, 2.0, 2.0]
    result = watched(calm, falling(20, start=1000), end=100, solver=solver)
    assert history(result) == [(17, "normal stop"), (pytest.approx(61.7, abs=0.1), "idling")]
    slow = watched(calm, falling(20, rate=10, start=1000), end=110, solver=solver)  # 200 rpm at 100 s
    assert history(slow) == [(17, "normal stop"), (100, "idling")]
    assert at(result, "generator.connected", 40) == 1  # it brakes on, down to the speed of its start-up


def test_a_storm_stops_it_until_the_wind_is_below_that_of_a_restart(watched):
    storm = [0, 10, 20, 100, 110, END], [20.0, 20.0, 30.0, 30.0, 20.0, 20.0]  # 25 m/s at 15 s, 22 m/s at 108 s
    speed = [0, 20, 70, 130, 160], [RATED, RATED, 0, 0, RATED]
    expected = [(15, "storm"), (108, "start-up"), (pytest.approx(130 + 30 * 700 / RATED, abs=0.1), "production")]
    assert history(watched(storm, speed)) == expected
    later = history(watched(storm, speed, restart_delay=110))
    assert later == [(15, "storm"), (125, "start-up"), (pytest.approx(147.9, abs=0.1), "production")]
    turning = history(watched(storm, ([0, 20, 70, 180, 200], [RATED, RATED, 300, 300, 100])))  # 200 rpm at 190 s
    assert turning == [(15, "storm"), (190, "start-up")]


def test_a_storm_ends_a_start_up(watched):
    rising = [0, 15, 20, END], [20.0, 20.0, 30.0, 30.0]
    assert history(watched(rising, ([0, END], [0, 0]), end=40, idling=1)) == [(10, "start-up"), (17.5, "storm")]


def test_a_start_up_that_does_not_come_to_speed_is_given_up_and_tried_again(watched):
    result = watched(speed=([0, END], [0, 0]), idling=1, start_time=30)
    assert history(result)[:4] == [
        (10, "start-up"), (40, "normal stop"), (pytest.approx(40 + (60 - np.degrees(0.01)) / 2, abs=0.1), "idling"),
        (pytest.approx(50 + (60 - np.degrees(0.01)) / 2, abs=0.1), "start-up"),
    ]  # fmt: skip


@pytest.mark.parametrize("solver", ["fixed", "idas"])
def test_after_overspeed_it_stops_waits_and_starts_again(watched, solver):
    """1408.4 rpm at 10 s + 234.7/100 s; 200 rpm at 40 s; the pitch arrives before; then 60 s."""
    speed = [0, 10, 13, 15, 40, 42], [RATED, RATED, RATED + 300, RATED + 300, 200, 0]
    result = watched(speed=speed, solver=solver, end=150)
    assert history(result) == [(12.3, "overspeed"), (40, "restart"), (100, "start-up")]
    assert at(result, "overspeeds", 50) == 1 and at(result, "generator.connected", 20) == 1
    rise = at(result, "pitch.output", 20) - at(result, "pitch.output", 15)
    assert rise == pytest.approx(np.radians(4 * 5), rel=1e-6) and not at(result, "brake.torque", 20)


def test_no_restart_in_too_little_or_too_much_wind(watched):
    speed = [0, 10, 13, 15, 40, 42], [RATED, RATED, RATED + 300, RATED + 300, 200, 0]
    for blows, start in (([10.0, 3.2, 3.2, 10.0], 100), ([20.0, 24.0, 24.0, 20.0], 100)):
        result = watched(([0, 30, 120, 130], blows), speed, restart_delay=20)
        assert start < history(result)[2][0] < 130 and history(result)[2][1] == "start-up"


def test_the_last_of_several_overspeeds_is_an_emergency(watched):
    speed = [0, 10, 13, 15, 40, 42], [RATED, RATED, RATED + 300, RATED + 300, 200, 0]
    result = watched(speed=speed, most_overspeeds=0)
    assert history(result) == [(12.3, "emergency stop")]


@pytest.mark.parametrize("solver", ["fixed", "idas"])
def test_above_the_emergency_speed_the_generator_is_off_and_the_brake_on_for_good(watched, solver):
    speed = [0, 10, 14, 20, 60], [RATED, RATED, RATED + 400, RATED + 400, 0]  # 1525.8 rpm at 13.5 s
    result = watched(speed=speed, solver=solver, brake_torque=28e3)
    assert history(result) == [(12.3, "overspeed"), (13.5, "emergency stop")]
    assert at(result, "generator.connected", 14) == 0
    assert at(result, "brake.torque", 19) == pytest.approx(28e3, rel=1e-4)
    rise = at(result, "pitch.output", 20) - at(result, "pitch.output", 15)
    assert rise == pytest.approx(np.radians(8 * 5), rel=1e-6)
    assert at(result, "yaw_allowed", 10) == 1 and at(result, "yaw_allowed", 20) == 0
    again = watched(speed=speed, solver=solver, events=["safety.start_up at 100 s"])
    assert history(again)[2:] == [(100, "start-up")] and at(again, "brake.torque", 101) == 0


def test_the_emergency_does_not_need_the_sensor_of_the_controller(watched):
    speed = [0, 10, 14, 20, 60], [RATED, RATED, RATED + 400, RATED + 400, 0]
    result = watched(speed=speed, events=["safety.sensor.stuck at 5 s"])
    assert history(result) == [(13.5, "emergency stop")]


@pytest.mark.parametrize("event", ["normal_shutdown", "grid_loss", "emergency_shutdown"])
def test_after_an_event_that_stops_it_it_waits_for_its_start(watched, event):
    first = "emergency stop" if event == "emergency_shutdown" else "normal stop"
    quick = {"events": [f"safety.{event} at 5 s", "safety.start_up at 150 s"], "speed": falling(5, start=1000)}
    states = history(watched(**quick))
    assert states[0] == (5, first) and states[-1] == (150, "start-up")
    assert [name for _, name in states[1:-1]] == ([] if first == "emergency stop" else ["idling"])


def test_both_solvers_agree_on_every_instant(watched):
    storm = [0, 10, 20, 100, 110, END], [20.0, 20.0, 30.0, 30.0, 20.0, 20.0]
    speed = [0, 20, 70, 130, 160], [RATED, RATED, 0, 0, 1500]
    results = [watched(storm, speed, solver=solver) for solver in ("fixed", "idas")]
    entered = [np.asarray(result["safety.entered"]) for result in results]
    assert len(np.unique(np.round(entered[0], 3))) == 5
    np.testing.assert_allclose(entered[0], entered[1], atol=2e-3)


@pytest.mark.skipif(not (find_spec("fmpy") and compiler()), reason="needs fmpy and a compiler")
def test_an_fmu_makes_the_same_decisions(stand, tmp_path):
    import fmpy

    given = {"speed.times": [0, 10, 13, 15, 40.3, 42],
             "speed.values": [value * RPM for value in (RATED, RATED, 1473.7, 1473.7, 200, 0)]}  # fmt: skip
    names = [f"safety.{name}" for name in ("state", "entered", "pitch.origin", "generator.cut_out_speed")]
    run = stand.simulate(120, 0.5, solver="fixed", step=0.02, parameters=given, outputs=names)
    path = fw.export_fmu(stand, tmp_path / "stand.fmu", step=0.02)
    start = {f"{name}[{k}]": value for name, values in given.items() for k, value in enumerate(values)}
    for kind, close in (("CoSimulation", 1e-9), ("ModelExchange", 1e-4)):
        rows = fmpy.simulate_fmu(str(path), stop_time=120, output_interval=0.5, fmi_type=kind, start_values=start,
                                 output=names)  # fmt: skip
        picked = [np.flatnonzero(rows["time"] <= t + 1e-9)[-1] for t in run.time]
        for name in names:
            np.testing.assert_allclose(rows[name][picked], np.asarray(run[name]), atol=close)
    assert history(run) == [(12.3, "overspeed"), (40.3, "restart"), (100.3, "start-up")]


@pytest.mark.parametrize(
    ("given", "says"),
    [
        ({"start_wind": 30.0}, "storm_wind must go up in this order; they are 3, 30, 22, 25 m/s"),
        ({"storm_wind": 2.0}, "must go up in this order; they are 3, 3.5, 22, 2 m/s"),
        ({"overspeed": 5.0}, "production_speed, overspeed, emergency_speed must go up in this order"),
    ],
)
def test_limits_out_of_order_are_refused(watched, given, says):
    with pytest.raises(ModelError, match=rf"^safety: .*{says}"):
        watched(end=4.0, **given)
