"""The pitch controller: gain schedule, limits, anti-windup, yaw control, and its sampled version."""

import numpy as np
import pytest

import fowtlib as fw
from fowtlib.components.blocks import Constant, Step
from fowtlib.components.servo import (
    FLOATING_GAINS,
    ONSHORE_GAINS,
    NacelleVelocity,
    PitchController,
    SampledPitchController,
)
from fowtlib.language import Assembly

RATED = 1173.7 * np.pi / 30
K_P, K_I = ONSHORE_GAINS["proportional_gain"], ONSHORE_GAINS["integral_gain"]


def controlled(speed, yaw=0.0, kind=PitchController, **parameters):
    model = Assembly()
    model.speed, model.yaw = speed, Constant(value=yaw)
    model.control = kind(**{**ONSHORE_GAINS, **parameters})
    model.connect(model.speed.y, model.control.speed)
    model.connect(model.yaw.y, model.control.yaw)
    return fw.load(model).compile()


def run(plant, t_end, step=0.1, output="control.pitch"):
    result = plant.simulate(t_end, step, tolerance=1e-8, outputs=[output])
    return result[output].time.to_numpy(), result[output].to_numpy()


def test_gains():
    """K_P = 2 I w zeta w_n / (N S), K_I = I w w_n^2 / (N S), S = 25.52 MW/rad: NREL/TP-500-38060, section 7.3."""
    inertia, speed, gear, sensitivity = 43784725.0, 12.1 * np.pi / 30, 97.0, 25.52e6
    for gains, frequency in ((ONSHORE_GAINS, 0.6), (FLOATING_GAINS, 0.2)):
        expected = 2 * inertia * speed * 0.7 * frequency / (gear * sensitivity)
        assert gains["proportional_gain"] == pytest.approx(expected, rel=1e-3)
        assert gains["integral_gain"] == pytest.approx(inertia * speed * frequency**2 / (gear * sensitivity), rel=1e-3)


@pytest.mark.parametrize("pitch_deg", [0.5, 6.302336, 20.0])
def test_gain_schedule(pitch_deg):
    """At a constant speed error the pitch obeys pitch (1 + pitch / doubling_pitch) = K_P e + x, x rising by K_I e."""
    error, start, doubling = 0.5, np.radians(pitch_deg), 0.1099965
    plant = controlled(Constant(value=RATED + error), pitch_start=start, response_time=1e-3)
    time, pitch = run(plant, 2.0)
    integral = start * (1 + start / doubling) + K_I * error * time
    assert (pitch * (1 + pitch / doubling))[2:] == pytest.approx((K_P * error + integral)[2:], rel=2e-3)


K1, CURVATURE = np.radians(11.4), 1 / np.radians(np.sqrt(402.9)) ** 2


@pytest.mark.parametrize("kind", [PitchController, SampledPitchController])
@pytest.mark.parametrize("pitch_deg", [0.5, 6.0, 20.0])
def test_scheduled_gains(kind, pitch_deg):
    """At a constant speed error the pitch is G K_P e + x with x' = G K_I e."""
    error, start = 0.5, np.radians(pitch_deg)
    given = {"schedule_curvature": CURVATURE, "doubling_pitch": K1, "scheduled": "gains", "pitch_start": start}
    lags = {"speed_start": RATED + error, "period": 1e-3} if kind is SampledPitchController else {"response_time": 1e-3}
    time, pitch = run(controlled(Constant(value=RATED + error), kind=kind, **given, **lags), 2.0)
    inverse = 1 + pitch / K1 + CURVATURE * pitch**2
    x = pitch - K_P * error / inverse
    assert x[2:] == pytest.approx((start + K_I * error * np.cumsum(np.append(0, 0.1 / inverse[1:])))[2:], rel=5e-3)
    assert x[-1] > x[2] + 1e-4


@pytest.mark.parametrize("kind", [PitchController, SampledPitchController])
@pytest.mark.parametrize("scheduled", ["pitch", "gains"])
def test_start_at_rest_under_any_schedule(kind, scheduled):
    given = {"schedule_curvature": CURVATURE, "scheduled": scheduled, "pitch_start": "14.9 deg"}
    speed = {"speed_start": RATED} if kind is SampledPitchController else {}
    _, pitch = run(controlled(Constant(value=RATED), kind=kind, **given, **speed), 10.0)
    assert pitch == pytest.approx(np.radians(14.9), abs=1e-12)


@pytest.mark.parametrize(("scheduled", "share"), [("pitch", 2.0), ("gains", 1.0)])
def test_gains_for_small_changes(scheduled, share):
    """Of the linear model at 10 deg: K_P and K_I over 1 + share pitch / K1, without curvature."""
    pitch = np.radians(10.0)
    given = {"doubling_pitch": K1, "scheduled": scheduled, "pitch_start": pitch, "response_time": 1e-3}
    plant = controlled(Constant(value=RATED), **given)
    linear = plant.linearize(plant.initial_state(), inputs=[], outputs=["control.pitch"])
    names = list(linear.states)
    assert sorted(names) == ["control.integral", "control.pitch"]
    k = names.index("control.pitch")
    A = linear.A[k] * 1e-3
    gain = 1 / (1 + pitch / K1)
    own = {"pitch": gain, "gains": 1.0}[scheduled]
    assert A[names.index("control.integral")] == pytest.approx(own, rel=1e-6)
    assert own / -A[k] == pytest.approx(1 / (1 + 2 * pitch / K1) if share == 2 else 1.0, rel=1e-6)


def test_start_at_rest():
    plant = controlled(Constant(value=RATED), pitch_start="14.9 deg")
    _, pitch = run(plant, 20.0)
    assert pitch == pytest.approx(np.radians(14.9), abs=1e-12)


@pytest.mark.parametrize("kind", [PitchController, SampledPitchController])
def test_rate_and_limits(kind):
    start = {"speed_start": RATED + 60.0} if kind is SampledPitchController else {}
    plant = controlled(Constant(value=RATED + 60.0), kind=kind, greatest_pitch="30 deg", **start)
    time, pitch = run(plant, 6.0)
    assert np.diff(pitch).max() <= np.radians(0.8) * (1 + 1e-6)
    assert pitch[(time > 1) & (time < 3)] == pytest.approx(np.radians(8) * time[(time > 1) & (time < 3)], rel=0.02)
    assert pitch[-1] == pytest.approx(np.radians(30), abs=1e-9)


@pytest.mark.parametrize("kind", [PitchController, SampledPitchController])
def test_no_windup_at_the_lower_limit(kind):
    """After a time below rated speed the pitch rises as that of a controller which is switched on there."""
    sampled = kind is SampledPitchController
    jump = Step(offset=RATED - 20, height=25.0, start_time=20.0)
    before = {"speed_start": RATED - 20, "filter_frequency": 50.0} if sampled else {}
    after = {"speed_start": RATED + 5, "filter_frequency": 50.0} if sampled else {}
    time, waited = run(controlled(jump, kind=kind, **before), 23.0)
    fresh_time, fresh = run(controlled(Constant(value=RATED + 5), kind=kind, **after), 3.0)
    assert waited[time < 20] == pytest.approx(0.0, abs=1e-9)
    late = time > 20.05
    assert waited[late] == pytest.approx(np.interp(time[late] - 20, fresh_time, fresh), abs=np.radians(0.15))
    assert fresh[-1] > np.radians(5)


def test_no_windup_at_the_upper_limit():
    jump = Step(offset=RATED + 30, height=-60.0, start_time=100.0)
    time, waited = run(controlled(jump, greatest_pitch="30 deg"), 105.0)
    _, fresh = run(controlled(Constant(value=RATED - 30), greatest_pitch="30 deg", pitch_start="30 deg"), 5.0)
    assert waited[(time > 50) & (time < 100)] == pytest.approx(np.radians(30), abs=1e-6)
    assert waited[time > 99.95] == pytest.approx(fresh, abs=np.radians(0.2))
    assert fresh[-1] < np.radians(20)


def test_the_integral_rests_at_the_lower_limit():
    plant = controlled(Constant(value=RATED - 10.0), pitch_start="2 deg")
    state = plant.equilibrium()
    assert float(state["control.pitch"]) == pytest.approx(0.0, abs=1e-9)
    assert float(state["control.integral"]) == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize(
    ("gain", "yaw_deg", "expected_deg"),
    [(1.5, 4.0, 0.0), (1.5, -4.0, 6.0), (-1.5, 4.0, 6.0), (-1.5, -4.0, 0.0), (0, 9, 0)],
)
def test_yaw_control_pitches_the_rotor_that_moves_downwind(gain, yaw_deg, expected_deg):
    """Positive yaw turns counter-clockwise from above: the left rotor (y > 0) moves upwind, the right one downwind."""
    plant = controlled(Constant(value=RATED - 20.0), yaw=np.radians(yaw_deg), yaw_gain=gain)
    state = plant.equilibrium()
    assert float(state["control.blade_pitch"]) == pytest.approx(np.radians(expected_deg), abs=1e-9)
    assert float(state["control.collective"]) == pytest.approx(0.0, abs=1e-9)


def test_no_pitch_without_yaw():
    state = controlled(Constant(value=RATED - 20.0), yaw_gain=1.5).equilibrium()
    assert 0 <= float(state["control.blade_pitch"]) < np.radians(0.05)


def test_linear_model_at_zero_error():
    """The branches of the anti-windup meet at zero speed error with one slope, K_I."""
    plant = controlled(Constant(value=RATED), pitch_start="10 deg")
    linear = plant.linearize(plant.initial_state(), inputs=["speed.value"], outputs=["control.pitch"])
    row = [str(name) for name in linear.B.coords[linear.B.dims[0]].values].index("control.integral")
    assert float(np.array(linear.B)[row, 0]) == pytest.approx(K_I, rel=1e-9)


def test_sampled_pi_follows_the_continuous_one():
    jump = {"offset": RATED, "height": 4.0, "start_time": 1.0}
    _, continuous = run(controlled(Step(**jump), pitch_start="10 deg"), 11.0)
    sampled = controlled(
        Step(**jump), kind=SampledPitchController, pitch_start="10 deg", speed_start=RATED, filter_frequency=50.0
    )
    time, held = run(sampled, 11.0)
    late = time > 1.5
    assert held[late] == pytest.approx(np.interp(time[late], np.arange(len(continuous)) * 0.1, continuous), abs=2e-3)


@pytest.mark.parametrize("kind", [PitchController, SampledPitchController])
def test_floating_feedback_adds_pitch_while_the_nacelle_moves_downwind(kind):
    """At rated speed: pitch = x / (1 + pitch / doubling_pitch) + gain velocity, with the integral x of the start."""
    start, gain, doubling = np.radians(10), 0.02, 0.1099965
    sampled = {"speed_start": RATED} if kind is SampledPitchController else {}
    model = Assembly()
    model.speed, model.velocity = Constant(value=RATED), Constant(value=0.5)
    model.control = kind(**ONSHORE_GAINS, pitch_start=start, velocity_gain=gain, **sampled)
    model.connect(model.speed.y, model.control.speed)
    model.connect(model.velocity.y, model.control.velocity)
    plant = fw.load(model).compile()
    for velocity in (0.5, -0.5, -100.0):
        result = plant.simulate(10, 0.5, tolerance=1e-8, parameters={"velocity.value": velocity},
                                outputs=["control.blade_pitch"])  # fmt: skip
        pitch, x = float(result["control.blade_pitch"][-1]), start * (1 + start / doubling)
        expected = x / (1 + pitch / doubling) + gain * velocity
        assert pitch == pytest.approx(max(expected, 0), abs=1e-6)  # and never below the least pitch


def test_floating_feedback_damps_the_pitch_of_a_platform():
    """Of the OC3 spar at 18 m/s, by its linear model; without feedback the controller has taken most of it."""
    model = fw.load("oc3_spar_rigid")
    model.root.sensor = NacelleVelocity()
    model.root.connect(model.root.tower_to_hub.frame_b, model.root.sensor.frame)
    model.root.connect(model.root.sensor.velocity, model.root.turbine.control.velocity)
    plant, calm = model.compile(), {"wind.kind": "steady", "wind.mean_speed": 18.0, "sea.spectrum": "still"}
    found = []
    for pitch, torque in ((0, 0), (0.02, 0), (0.04, 0), (0, 2000.0)):
        gains = {"pitch_per_velocity": pitch, "torque_per_velocity": torque}
        given = calm | {f"turbine.control.{name}": value for name, value in gains.items()}
        eigen = np.linalg.eigvals(np.asarray(plant.linearize(plant.equilibrium(given)).A))
        slow = [w for w in eigen if 0.026 < w.imag / (2 * np.pi) < 0.0315]
        found.append(-slow[0].real / abs(slow[0]))
    none, some, more, torque = found
    assert 0.055 < none < 0.075 and some > 1.3 * none and more > 1.6 * none and torque > 1.1 * none
