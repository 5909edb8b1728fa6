"""A set point of the rotor speed that moves with the platform: damping in closed form, poles, runs, FMU."""

from __future__ import annotations

import importlib.util

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.linalg import expm

import fowtlib as fw
from fowtlib.components.blocks import Constant
from fowtlib.components.environment import World
from fowtlib.components.mechanics import (
    FixedFlange,
    FixedTranslation,
    Frame,
    Revolute,
    RigidBody,
    TorsionSpringDamper,
)
from fowtlib.components.servo import PitchController, SampledPitchController, SetPointFeedback
from fowtlib.language import Assembly, Component, RealInput, RealOutput, Scalar, der, eq, param, port, var
from fowtlib.language import math as m
from fowtlib.language.native import compiler

# a 10-MW rotor at 17 m/s on a spar of 30 s, about the water line; the speed is that of the rotor
T_V, T_W, T_TH, Q_V, Q_W, Q_TH = 1.59e5, -1.2e6, -8.8e6, 3.0e6, -3.0e7, -1.3e8
HEIGHT, INERTIA, STIFFNESS, SHAFT = 119.0, 4.0e10, 1.7e9, 1.6e8
SPEED, PITCH, K_P, K_I, LAG = 1.0053, 0.23, 0.1794, 0.0165, 0.05
STRATEGIES = {
    "CS1": {},
    "CS2": {"pitch_rate_gain": -8.0},
    "CS3": {"velocity_gain": -0.07},
    "CS4": {"filtered_gain": -0.12, "filter_frequency": 0.15},
}


class LinearRotor(Component):
    """Thrust and torque as straight lines about a state of rest; a shaft without a load."""

    inertia: Scalar = param(default=SHAFT, unit="kg*m^2", doc="of the shaft")

    frame: Frame = port(doc="hub")
    blade_pitch: RealInput = port(unit="rad", doc="blade pitch")
    speed: RealOutput = port(unit="rad/s", doc="rotor speed")

    w: Scalar = var(unit="rad/s", start=SPEED, state="prefer", doc="rotor speed")

    def equations(self):
        wind, faster, pitched = -der(self.frame.r)[0], self.w - SPEED, self.blade_pitch - PITCH
        thrust = T_V * wind + T_W * faster + T_TH * pitched
        return [
            eq(self.inertia * der(self.w), Q_V * wind + Q_W * faster + Q_TH * pitched),
            [eq(self.frame.f, -m.vertcat(thrust, 0, 0)), eq(self.frame.t, m.zeros(3)), eq(self.speed, self.w)],
        ]


def rocking(integrated=0.0, response_time=LAG, inertia=SHAFT, **gains):
    """A rotor on an arm that rocks about y on a spring, with its pitch controller and the feedback."""
    model = Assembly()
    model.world, model.ground = World(gravity=0.0), FixedFlange()
    model.spring, model.rocker = TorsionSpringDamper(stiffness=STIFFNESS), Revolute(n=(0, 1, 0))
    model.body = RigidBody(mass=1.0, inertia=[[0, 0, 0], [0, INERTIA, 0], [0, 0, 0]])
    model.arm, model.rotor = FixedTranslation(r=(0, 0, HEIGHT)), LinearRotor(inertia=inertia)
    model.control = PitchController(
        proportional_gain=K_P, integral_gain=K_I, scheduled="gains", rated_speed=SPEED, pitch_start=PITCH,
        response_time=response_time, integrated_change=integrated, doubling_pitch=2.0,
    )  # fmt: skip
    model.feedback = SetPointFeedback(**gains)
    for a, b in (
        (model.ground.flange, model.spring.flange_a), (model.spring.flange_b, model.rocker.flange),
        (model.world.frame, model.rocker.frame_a), (model.rocker.frame_b, model.body.frame_a),
        (model.rocker.frame_b, model.arm.frame_a), (model.arm.frame_b, model.rotor.frame),
        (model.rocker.frame_b, model.feedback.platform), (model.arm.frame_b, model.feedback.nacelle),
        (model.feedback.change, model.control.set_point_change), (model.rotor.speed, model.control.speed),
        (model.control.blade_pitch, model.rotor.blade_pitch),
    ):  # fmt: skip
        model.connect(a, b)
    return fw.load(model).compile()


def by_hand(integrated=0.0, pitch_rate_gain=0.0, velocity_gain=0.0, filtered_gain=0.0, filter_frequency=0.2):
    """The closed loop of angle, its rate, rotor speed, blade pitch, integral and filtered velocity."""
    gain, h = 1 / (1 + PITCH / 2.0), HEIGHT
    change = np.array([0, pitch_rate_gain + velocity_gain * h, 0, 0, 0, filtered_gain])
    speed, pitch, integral = np.eye(6)[2:5]
    return np.array([
        [0, 1, 0, 0, 0, 0],
        np.array([-STIFFNESS, -h * h * T_V, h * T_W, h * T_TH, 0, 0]) / INERTIA,
        np.array([0, -Q_V * h, Q_W, Q_TH, 0, 0]) / SHAFT,
        (gain * K_P * (speed - SPEED * change) + integral - pitch) / LAG,
        gain * K_I * (speed - integrated * SPEED * change),
        [0, filter_frequency * h, 0, 0, 0, -filter_frequency],
    ])  # fmt: skip


@pytest.mark.parametrize("integrated", [0.0, 1.0])
@pytest.mark.parametrize("name", STRATEGIES)
def test_poles_are_those_of_the_equations_by_hand(name, integrated):
    plant = rocking(integrated, **STRATEGIES[name])
    poles = np.linalg.eigvals(np.asarray(plant.linearize(plant.equilibrium()).A))
    wanted = np.linalg.eigvals(by_hand(integrated, **STRATEGIES[name]))
    assert_allclose(np.sort_complex(poles), np.sort_complex(wanted), rtol=1e-6, atol=1e-9)


def test_damping_of_the_platform_in_closed_form():
    """Of a shaft that keeps its speed and blades that follow at once: h^2 T_V + h T_TH G K_P W (a + b h)."""
    plant = rocking(response_time=1e-3, inertia=1e14)
    for a, b in ((0, 0), (-8.0, 0), (0, -0.07), (-8.0, -0.07), (8.0, 0)):
        given = {"feedback.pitch_rate_gain": a, "feedback.velocity_gain": b, "control.integral_gain": 1e-9}
        A = np.asarray(plant.linearize(plant.equilibrium(given)).A)
        pole = next(p for p in np.linalg.eigvals(A) if p.imag > 0.1)
        gain = K_P / (1 + PITCH / 2.0)
        damping = HEIGHT**2 * T_V + HEIGHT * T_TH * gain * SPEED * (a + b * HEIGHT)
        assert -2 * pole.real == pytest.approx(damping / INERTIA, rel=2e-3)


def test_a_negative_gain_damps_and_a_positive_one_takes_damping():
    found = {}
    plant = rocking()
    for path in ("pitch_rate_gain", "velocity_gain", "filtered_gain"):
        size = 5.0 if path == "pitch_rate_gain" else 0.05
        for gain in (-size, 0.0, size):
            A = np.asarray(plant.linearize(plant.equilibrium({f"feedback.{path}": gain})).A)
            found[gain] = max(p.real for p in np.linalg.eigvals(A) if 0.15 < abs(p) < 0.3 and p.imag > 0)
        assert found[-size] < found[0.0] < found[size]


def test_a_fast_filter_is_no_filter():
    direct = np.linalg.eigvals(by_hand(velocity_gain=-0.07))
    errors = []
    for frequency in (20.0, 200.0):
        plant = rocking(filtered_gain=-0.07, filter_frequency=frequency)
        A = np.asarray(plant.linearize(plant.equilibrium()).A)
        slow = [p for p in np.linalg.eigvals(A) if abs(p) < 1.0]
        errors.append(max(min(abs(p - q) for q in slow) for p in direct if abs(p) < 1.0 and abs(p + 0.2) > 1e-9))
    assert errors[1] < 0.15 * errors[0] < 1e-3


@pytest.mark.parametrize("solver", ["idas", "fixed"])
@pytest.mark.parametrize("name", STRATEGIES)
def test_small_motions_of_a_run_are_those_of_the_linear_model(name, solver):
    plant = rocking(1.0, **STRATEGIES[name])
    rest = {"rocker.phi": 0.0, "rocker.w": 0.0, "rotor.w": SPEED, "control.pitch": PITCH, "control.integral": PITCH}
    choice = {"solver": "fixed", "step": 0.02} if solver == "fixed" else {"solver": "idas", "tolerance": 1e-9}
    run = plant.simulate(60.0, 0.5, start=rest | {"rocker.phi": 2e-3}, **choice)
    step = expm(0.5 * by_hand(1.0, **STRATEGIES[name]))
    states = [np.array([2e-3, 0, 0, 0, 0, 0])]
    for _ in range(120):
        states.append(step @ states[-1])
    expected = np.array(states)
    assert np.abs(np.asarray(run["rocker.phi"]) - expected[:, 0]).max() < 4e-6
    assert (
        np.abs(np.asarray(run["rotor.w"]) - SPEED - expected[:, 2]).max() < 2e-3 * np.abs(expected[:, 2]).max() + 1e-6
    )


@pytest.mark.parametrize("kind", [PitchController, SampledPitchController])
def test_the_controller_holds_the_moved_set_point(kind):
    """Speed at the moved set point: no proportional part. The integral sees its share of the change."""
    change, share = 0.05, 0.4
    sampled = {"speed_start": SPEED * (1 + change)} if kind is SampledPitchController else {}
    model = Assembly()
    model.speed, model.change = Constant(value=SPEED * (1 + change)), Constant(value=change)
    model.control = kind(proportional_gain=K_P, integral_gain=K_I, scheduled="gains", rated_speed=SPEED,
                         pitch_start=PITCH, integrated_change=share, doubling_pitch=1e9, **sampled)  # fmt: skip
    model.connect(model.speed.y, model.control.speed)
    model.connect(model.change.y, model.control.set_point_change)
    run = fw.load(model).compile().simulate(10.0, 1.0, tolerance=1e-9, outputs=["control.blade_pitch"])
    expected = PITCH + K_I * SPEED * change * (1 - share) * np.arange(11)
    assert_allclose(np.asarray(run["control.blade_pitch"])[1:], expected[1:], atol=5e-5)


def on_a_spar(**control):
    """The OC3 spar with the feedback; without gains at first."""
    model = fw.load("oc3_spar_rigid")
    root = model.root
    for name, value in control.items():
        setattr(root.turbine.control, name, value)
    root.feedback = SetPointFeedback()
    root.connect(root.platform.motion.frame_b, root.feedback.platform)
    root.connect(root.tower_to_hub.frame_b, root.feedback.nacelle)
    root.connect(root.feedback.change, root.turbine.control.set_point_change)
    return model.compile()


def test_on_a_spar_it_damps_pitch_in_the_linear_model_and_in_a_run():
    """OC3 spar at 16 m/s: each strategy raises the damping, and a decay from 0.2 deg is that of the linear model."""
    plant = on_a_spar()
    calm = {"wind.kind": "steady", "wind.mean_speed": 16.0, "sea.spectrum": "still"}
    ratios = {}
    for name, gains in (("CS1", {}), ("CS2", {"pitch_rate_gain": -10.0}), ("CS3", {"velocity_gain": -0.12}),
                        ("CS4", {"filtered_gain": -0.2, "filter_frequency": 0.2})):  # fmt: skip
        given = calm | {f"feedback.{path}": value for path, value in gains.items()}
        state = plant.equilibrium(given)
        linear = plant.linearize(state, outputs=["pitch"])
        poles = [p for p in np.linalg.eigvals(np.asarray(linear.A)) if 0.15 < p.imag < 0.26 and p.real < -1e-3]
        ratios[name] = max(-p.real / abs(p) for p in poles)
        if name != "CS3":
            continue
        at = list(linear.states).index("platform.motion.pitch")
        moved = np.zeros(len(linear.states))
        moved[at] = np.radians(0.2)
        pushed = {path: float(state[path]) for path in linear.states}
        pushed["platform.motion.pitch"] += moved[at]
        run = plant.simulate(80.0, 0.5, parameters=given, start=pushed, solver="fixed", step=0.05)
        step, C, expected = expm(0.5 * np.asarray(linear.A)), np.asarray(linear.C)[0], []
        for _ in range(161):
            expected.append(C @ moved)
            moved = step @ moved
        assert np.abs(np.asarray(run["pitch"]) - state["pitch"] - expected).max() < 0.01  # deg, of 0.2
    assert ratios["CS1"] < 0.9 * min(ratios["CS2"], ratios["CS3"], ratios["CS4"])


def test_the_baseline_controller_hands_both_on():
    plant = on_a_spar(integrated_change=0.25)
    given = {"feedback.velocity_gain": -0.1, "wind.mean_speed": 16.0, "wind.kind": "steady"}
    state = plant.initial_state(given, {"platform.motion.velocity[0]": 0.5})
    change, velocity = float(state["turbine.control.pitch.set_point_change"]), float(state["feedback.velocity"])
    assert velocity == pytest.approx(0.5, rel=1e-3) and change == pytest.approx(-0.1 * velocity)
    assert plant.parameter_values()["turbine.control.integrated_change"] == 0.25


@pytest.mark.skipif(not importlib.util.find_spec("fmpy") or not compiler(), reason="needs fmpy and a compiler")
def test_as_an_fmu_with_its_gains_as_parameters(tmp_path):
    import fmpy

    plant = rocking(velocity_gain=-0.01)
    path = str(fw.export_fmu(plant, tmp_path / "rocking.fmu"))
    parameters = {v.name for v in fmpy.read_model_description(path).modelVariables if v.causality == "parameter"}
    assert {"feedback.velocity_gain", "feedback.filter_frequency", "control.integrated_change"} <= parameters
    for gain in (-0.01, -0.07):
        rows = fmpy.simulate_fmu(path, stop_time=40.0, output_interval=0.5, output=["rocker.phi"],
                                 start_values={"feedback.velocity_gain": gain, "rocker.phi_start": 0.02})  # fmt: skip
        run = plant.simulate(40.0, 0.5, parameters={"feedback.velocity_gain": gain, "rocker.phi_start": 0.02})
        assert_allclose(rows["rocker.phi"], np.asarray(run["rocker.phi"]), atol=1e-4)
