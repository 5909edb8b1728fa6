"""The torque law against the definition of the NREL 5 MW turbine, and the controllers that follow it."""

import numpy as np
import pytest

import fowtlib as fw
from fowtlib.components.blocks import Constant, Ramp, Step
from fowtlib.components.mechanics import Inertia
from fowtlib.components.servo import Generator, SampledTorqueController, TorqueController, TorqueLaw, torque_of
from fowtlib.components.servo.torque_law import larger, region_2_end, smaller
from fowtlib.language import Assembly

RPM = np.pi / 30
CONSTANT_TORQUE, CONSTANT_POWER = TorqueLaw(), TorqueLaw(region_3="constant_power")


@pytest.mark.parametrize("law", [CONSTANT_TORQUE, CONSTANT_POWER])
def test_regions(law):
    """NREL/TP-500-38060, table 7-2 and section 7.2; speeds in rpm, torque in N m."""
    torque = {rpm: float(torque_of(rpm * RPM, law)) for rpm in (0, 600, 800, 900, 1000, 1100, 1173.7, 1250)}
    assert torque[0] == torque[600] == 0
    assert torque[800] == pytest.approx(0.0255764 * 871**2 * (800 - 670) / (871 - 670), rel=1e-9)
    for rpm in (900, 1000, 1100):
        assert torque[rpm] == pytest.approx(0.0255764 * rpm**2, rel=1e-9)
    assert torque[1173.7] == pytest.approx(43093.55, rel=1e-9)
    above = 43093.55 * (1173.7 / 1250 if law is CONSTANT_POWER else 1)
    assert torque[1250] == pytest.approx(above, rel=1e-9)


def test_region_2_5():
    """A straight line from the synchronous speed, 10 % below the start of region 3."""
    rpm = np.array([1145.0, 1150.0, 1155.0])
    start, synchronous = 1161.963, 1161.963 / 1.1
    for law, end in ((CONSTANT_TORQUE, 43093.55), (CONSTANT_POWER, 43093.55 * 1173.7 / start)):
        line = end * (rpm - synchronous) / (start - synchronous)
        assert torque_of(rpm * RPM, law) == pytest.approx(line, rel=1e-9)
    assert region_2_end(CONSTANT_POWER) == pytest.approx(119.0137, abs=2e-3)  # rad/s, from the same four numbers
    meeting = region_2_end(CONSTANT_TORQUE) / RPM
    assert 0.0255764 * meeting**2 == pytest.approx(43093.55 * (meeting - synchronous) / (start - synchronous))


def test_optimal_torque_constant():
    """K = 1/2 rho pi R^5 C_p / tip_speed_ratio^3 / gear^3 with the peak of the definition, 0.482 at 7.55."""
    constant = 1.225 / 2 * np.pi * 63.0**5 * 0.482 / 7.55**3 / 97**3
    assert constant == pytest.approx(CONSTANT_TORQUE.region_2_constant, rel=5e-3)
    assert pytest.approx(2.332287, rel=1e-6) == CONSTANT_TORQUE.region_2_constant
    assert TorqueController().parameter_value("region_2_constant") == pytest.approx(2.332287, rel=1e-6)


def test_defaults_of_the_controller_are_those_of_the_law():
    controller = TorqueController()
    for name, value in vars(CONSTANT_TORQUE).items():
        assert controller.parameter_value(name) == (value if isinstance(value, str) else pytest.approx(value))


@pytest.mark.parametrize(("rpm", "share"), [(0.0, 0.0), (-50.0, 0.0), (600.0, 0.0), (871.0, 1.0), (1000.0, 1.0)])
@pytest.mark.parametrize("pitch", ["2 deg", "30 deg"])
def test_region_3_is_held_above_a_pitch_while_the_generator_turns(rpm, share, pitch):
    """A torque at standstill would drive a parked rotor backwards."""
    root = Assembly()
    root.torque = TorqueController()
    root.speed, root.pitch = Constant(value=rpm * RPM), Constant(value=pitch)
    root.connect(root.speed.y, root.torque.speed)
    root.connect(root.pitch.y, root.torque.collective)
    state = fw.load(root).compile().initial_state()
    assert float(state["torque.torque"]) == pytest.approx(share * 43093.55, abs=1e-9)


def test_the_law_is_smooth():
    speed = np.linspace(0, 160, 80_001)
    torque = torque_of(speed, CONSTANT_POWER)
    slope = np.gradient(torque, speed)
    assert np.abs(np.diff(torque)).max() < 10
    assert np.abs(np.diff(slope)).max() < 150  # a corner would change the slope by 4000 N m s


def test_rounded_corners():
    a = np.linspace(-3, 3, 601)
    assert larger(a, 0.0, 1.0) == pytest.approx(np.maximum(a, 0), abs=3 / 16 + 1e-12)
    assert larger(a, 0.0, 1.0)[np.abs(a) >= 1] == pytest.approx(np.maximum(a, 0)[np.abs(a) >= 1], abs=1e-15)
    assert smaller(a, 0.0, 1.0) == pytest.approx(-larger(-a, 0.0, 1.0))
    assert np.abs(np.diff(larger(a, 0.0, 1.0), 3)).max() < 1e-4  # a corner would give 1e-2, a jump of curvature 1e-3


def controlled(speed, collective=0.0, kind=TorqueController, **parameters):
    model = Assembly()
    model.speed, model.pitch = speed, Constant(value=collective)
    model.control = kind(**parameters)
    model.connect(model.speed.y, model.control.speed)
    model.connect(model.pitch.y, model.control.collective)
    return fw.load(model).compile()


@pytest.mark.parametrize(("rpm", "pitch_deg", "expected"), [
    (1000, 0.0, 0.0255764 * 1000**2), (1000, 0.4, 0.0255764 * 1000**2), (1000, 1.6, 43093.55), (1200, 0.0, 43093.55),
])  # fmt: skip
def test_region_3_holds_while_the_blades_are_pitched(rpm, pitch_deg, expected):
    state = controlled(Constant(value=rpm * RPM), np.radians(pitch_deg)).initial_state()
    assert float(state["control.torque"]) == pytest.approx(expected, rel=1e-9)


def test_torque_limit():
    """Constant power at low speed would ask for more than the generator has."""
    plant = controlled(Constant(value=1000 * RPM), np.radians(5), region_3="constant_power")
    assert float(plant.initial_state()["control.torque"]) == pytest.approx(47402.91)


@pytest.mark.parametrize("kind", [TorqueController, SampledTorqueController])
def test_torque_rate_limit(kind):
    start = {"speed_start": 1000 * RPM} if kind is SampledTorqueController else {}
    jump = Step(offset=1000 * RPM, height=170 * RPM, start_time=0.95)
    result = controlled(jump, kind=kind, **start).simulate(4.0, 0.1, outputs=["control.torque"])
    torque = result["control.torque"].to_numpy()
    assert torque[0] == pytest.approx(0.0255764 * 1000**2, rel=1e-6)
    assert np.diff(torque).max() == pytest.approx(1500, rel=1e-3)
    assert np.diff(torque).max() <= 1500 * (1 + 1e-6)
    assert torque[-1] == pytest.approx(43093.55, rel=1e-3)


def test_torque_follows_a_slow_speed():
    result = controlled(Ramp(offset=600 * RPM, height=700 * RPM, duration=700.0)).simulate(
        700.0, 1.0, outputs=["control.torque", "speed.y"]
    )
    law = torque_of(result["speed.y"].to_numpy(), CONSTANT_TORQUE)
    assert result["control.torque"].to_numpy() == pytest.approx(law, abs=100)


def test_generator():
    """J dw/dt = shaft torque - torque; electrical power after losses."""
    model = Assembly()
    model.generator, model.flywheel = Generator(inertia=2.0, efficiency=0.9), Inertia(inertia=3.0, w_start=10.0)
    model.torque = Constant(value=5.0)
    model.connect(model.flywheel.flange_a, model.generator.shaft)
    model.connect(model.torque.y, model.generator.torque)
    plant = fw.load(model).compile()
    result = plant.simulate(2.0, 1.0, outputs=["generator.speed", "generator.power"])
    assert result["generator.speed"].to_numpy() == pytest.approx([10.0, 9.0, 8.0])
    assert result["generator.power"].to_numpy() == pytest.approx([45.0, 40.5, 36.0])


@pytest.mark.parametrize(("rpm", "pitch_deg", "velocity", "expected"), [
    (1173.7, 5.0, 0.5, 43093.55 - 1000), (1173.7, 5.0, -0.5, 43093.55 + 1000), (1173.7, 5.0, -10.0, 47402.91),
    (1173.7, 5.0, 40.0, 0.0), (0.0, 5.0, -5.0, 0.0), (1000, 0.0, 1.0, 0.0255764 * 1000**2 - 2000),
])  # fmt: skip
def test_torque_is_taken_off_while_the_nacelle_moves_downwind(rpm, pitch_deg, velocity, expected):
    """Within the limits of the generator; none at standstill."""
    model = Assembly()
    model.speed, model.pitch = Constant(value=rpm * RPM), Constant(value=np.radians(pitch_deg))
    model.velocity, model.control = Constant(value=velocity), TorqueController(velocity_gain=2000.0)
    for name, port in (("speed", "speed"), ("pitch", "collective"), ("velocity", "velocity")):
        model.connect(getattr(model, name).y, getattr(model.control, port))
    state = fw.load(model).compile().initial_state()
    assert float(state["control.torque"]) == pytest.approx(expected, rel=1e-9, abs=1e-9)
