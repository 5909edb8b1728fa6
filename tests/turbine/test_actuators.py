"""Bearings with drives: rate limits of pitch and yaw."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import fowtlib as fw
from fowtlib.components.blocks import Sine, Step, Sum
from fowtlib.components.mechanics import Fixed, RigidBody, World
from fowtlib.components.turbine import ActuatedBearing, Hub, Nacelle


def bearing(source, **drive):
    model = fw.Assembly("bearing")
    model.world, model.base = World(), Fixed()
    model.bearing, model.source = ActuatedBearing(**drive), source
    model.body = RigidBody(mass=1.0, inertia=np.diag([1.0, 1.0, 3.0]))
    model.connect(model.base.frame, model.bearing.frame_a)
    model.connect(model.bearing.frame_b, model.body.frame_a)
    model.connect(model.source.y, model.bearing.command)
    return fw.load(model).compile()


def run(plant, t_end, step, **options):
    result = plant.simulate(t_end, output_step=step, tolerance=1e-9, **options)
    return [np.asarray(result[f"bearing.{name}"]) for name in ("angle", "w", "torque", "limited")]


@pytest.mark.parametrize("height", [0.5, -0.5])
def test_a_large_command_is_followed_at_the_limit(height):
    """0.5 rad at 0.1 rad/s: the rate stays at the limit, and never above, until (command - angle) w0 = 2 zeta rate."""
    rate, w0, zeta, sign = 0.1, 2 * np.pi * 3, 0.7, np.sign(height)
    plant = bearing(Step(height=height, start_time=0.5), natural_frequency=3, damping_ratio=zeta, rate_limit=rate)
    angle, w, torque, limited = run(plant, 7.0, 0.01)
    t = np.arange(0, 7.005, 0.01)
    assert np.abs(w).max() <= rate * (1 + 1e-8)
    reached = 0.5 - 2 * zeta * rate / w0  # the angle at which it begins to slow down
    on = (np.abs(angle) > 0.01) & (np.abs(angle) < reached - 0.01)
    assert on.sum() > 400 and np.all(limited[on] == sign)
    assert w[on] == pytest.approx(sign * rate, abs=1e-9) and torque[on] == pytest.approx(0.0, abs=1e-6)
    assert angle[-1] == pytest.approx(height, abs=1e-6) and limited[-1] == 0
    leave = 0.5 + (reached - 0.5 * rate**2 / (w0**2 * 0.5)) / rate  # acceleration at first: w0^2 height
    assert t[on][-1] == pytest.approx(leave, abs=0.15)


def test_the_way_from_limit_to_limit_is_the_saturated_equation():
    """A sine that asks for three times the limit, against a solution with the rate held by a stiff wall."""
    rate, w0, zeta = 0.1, 2 * np.pi * 1.5, 0.3
    plant = bearing(
        Sine(amplitude=0.3, frequency=0.16), natural_frequency=1.5, damping_ratio=zeta, rate_limit=rate
    )
    angle, w, _, limited = run(plant, 10.0, 0.02)
    wall = 1e6  # its give is 1e-6 of the acceleration that is wanted

    def slope(t, y):
        wanted = w0 * (w0 * (0.3 * np.sin(2 * np.pi * 0.16 * t) - y[0]) - 2 * zeta * y[1])
        return [y[1], wanted - wall * (max(y[1] - rate, 0) + min(y[1] + rate, 0))]

    t = np.arange(0, 10.01, 0.02)
    exact = solve_ivp(slope, (0, 10), [0, 0], t_eval=t, method="Radau", rtol=1e-9, atol=1e-10).y
    assert {-1.0, 0.0, 1.0} == set(np.round(limited, 12))
    assert angle == pytest.approx(exact[0], abs=1e-4) and w == pytest.approx(exact[1], abs=5e-4)


def test_a_small_command_is_followed_as_before():
    drive = {"natural_frequency": 3, "damping_ratio": 0.02}
    plants = [bearing(Step(height=0.004, start_time=0.1), **drive, **more) for more in ({}, {"rate_limit": 0.1})]
    free, limited = (run(plant, 1.0, 0.02) for plant in plants)
    assert limited[0] == pytest.approx(free[0], abs=1e-8) and not limited[3].any()
    matrices = [np.asarray(p.linearize(p.initial_state()).A) for p in plants]
    assert matrices[0] == pytest.approx(matrices[1], rel=1e-9)


def test_a_command_that_turns_back_while_limited():
    """The drive turns at once: the limit holds only against more of the same."""
    model = fw.Assembly("command up and down")
    model.up, model.down = Step(height=0.5, start_time=0.1), Step(height=-1.0, start_time=2.0)
    model.world, model.base = World(), Fixed()
    model.bearing = ActuatedBearing(natural_frequency=3, damping_ratio=0.7, rate_limit=0.1)
    model.body = RigidBody(mass=1.0, inertia=np.eye(3))
    model.sum = Sum(n=2)
    for a, b in ((model.up.y, model.sum.u[0]), (model.down.y, model.sum.u[1]), (model.sum.y, model.bearing.command)):
        model.connect(a, b)
    model.connect(model.base.frame, model.bearing.frame_a)
    model.connect(model.bearing.frame_b, model.body.frame_a)
    angle, w, _, limited = run(fw.load(model).compile(), 10.0, 0.01)
    assert w[195] == pytest.approx(0.1, abs=1e-9) and w[205] == pytest.approx(-0.1, abs=1e-9)
    assert limited[250] == -1 and angle[-1] == pytest.approx(-0.5, abs=1e-6)


def test_nacelle_and_hub_pass_their_limits_on():
    assert Nacelle(yaw_rate="0.3 deg/s").yaw.rate_limit == pytest.approx(np.radians(0.3))
    hub = Hub(radius=1.5, pitch_rate="8 deg/s")
    assert [hub.parts[f"bearing_{k}"].rate_limit for k in (1, 2, 3)] == pytest.approx([np.radians(8)] * 3)
    assert Nacelle().yaw.rate_limit is None


def faulty(events, t_end, height=0.5, **options):
    """Angle and rate of a drive of 3 Hz, whose command steps at 0.5 s."""
    plant = bearing(Step(height=height, start_time=0.5), natural_frequency=3, damping_ratio=0.7)
    result = plant.simulate(t_end, 0.01, events=events, **{"tolerance": 1e-9, **options})
    return [np.asarray(result[f"bearing.{name}"]) for name in ("angle", "w")]


def test_a_slow_drive_is_the_drive_of_its_new_frequency_and_damping():
    """A small step, without the limit of the rate: the closed form of the second order."""
    w0, zeta = 2 * np.pi * 0.5, 0.6
    angle, _ = faulty(["bearing.slow at 0.2 s, frequency=0.5 Hz, damping=0.6, rate=10"], 6.0, height=0.1)
    t = np.maximum(np.arange(0, 6.005, 0.01) - 0.5, 0)
    wd = w0 * np.sqrt(1 - zeta**2)
    exact = 0.1 * (1 - np.exp(-zeta * w0 * t) * (np.cos(wd * t) + zeta * w0 / wd * np.sin(wd * t)))
    np.testing.assert_allclose(angle, exact, atol=1e-6)


def test_a_slow_drive_comes_to_its_rate_and_arrives():
    angle, w = faulty(["bearing.slow at 0.2 s, frequency=2 Hz, damping=0.9, rate=0.1"], 9.0)
    decay = 2 * 0.9 * 2 * np.pi * 2  # the rate follows a first order of this corner, as long as the way is long
    t = np.arange(0, 9.005, 0.01) - 0.5
    far = (t > 0) & (angle < 0.5 - 0.1 * 2 * 0.9 / (4 * np.pi) - 1e-3)
    np.testing.assert_allclose(w[far], 0.1 * (1 - np.exp(-decay * t[far])), atol=1e-6)
    assert far.sum() > 400 and w.max() <= 0.1 * (1 + 1e-9)
    assert angle[-1] == pytest.approx(0.5, abs=1e-6)


def test_a_slow_drive_that_is_released_is_as_fast_as_ever():
    angle, w = faulty(["bearing.slow at 0.2 s, rate=0.02", "bearing.released at 3 s"], 5.0)
    assert angle[300] == pytest.approx(0.02 * 2.5, abs=0.01) and w.max() > 1.0
    assert angle[-1] == pytest.approx(0.5, abs=1e-6)


@pytest.mark.parametrize(("solver", "options"), [("fixed", {"step": 2e-3}), ("idas", {})])
def test_a_drive_that_is_slow_gets_stuck_and_runs_away_too(solver, options):
    events = ["bearing.slow at 0.2 s, rate=0.1", "bearing.stuck at 2 s",
              "bearing.runaway at 3 s, to=-0.5, rate=1"]  # fmt: skip
    angle, w = faulty(events, 6.0, solver=solver, **options)
    np.testing.assert_allclose(angle[201:300], angle[200], atol=1e-9)
    assert 0.1 < angle[200] < 0.15 and not w[201:300].any()
    assert w.min() == pytest.approx(-0.1, rel=1e-4)  # it has no strength for the rate of the fault


@pytest.mark.parametrize("rate_limit", [None, 0.4])
def test_a_slow_drive_within_its_limit_is_slow_alike(rate_limit):
    plant = bearing(
        Step(height=0.5, start_time=0.5), natural_frequency=3, damping_ratio=0.7, rate_limit=rate_limit
    )
    angle, w, *_ = run(plant, 4.0, 0.01, events=["bearing.slow at 0.2 s, frequency=0.5 Hz, rate=0.2"])
    assert w.max() == pytest.approx(0.2, rel=1e-3) and angle[-1] == pytest.approx(0.5, abs=0.05)
