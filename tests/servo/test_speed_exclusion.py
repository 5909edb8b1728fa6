"""A band of speeds that the torque law leaves out."""

import numpy as np
import pytest

import fowtlib as fw
from fowtlib.components.blocks import Constant
from fowtlib.components.servo import SampledTorqueController, TorqueController, TorqueLaw, torque_of
from fowtlib.language import Assembly
from fowtlib.language.errors import ParameterError, SimulationError

RPM = np.pi / 30
MIDDLE, HALF = 1020 * RPM, 60 * RPM
BAND = {"excluded_speed": MIDDLE, "excluded_range": HALF}
LAW, EXCLUDING = TorqueLaw(), TorqueLaw(**BAND)


def steady_speeds(power):
    """Speeds [rad/s] at which a rotor of this power [W] turns, and whether it stays there."""
    speeds = np.linspace(900, 1150, 50001) * RPM
    surplus = power / speeds - torque_of(speeds, EXCLUDING)
    at = np.flatnonzero(np.diff(np.sign(surplus)))
    return speeds[at], surplus[at] > 0


def test_the_law_is_another_only_within_the_band():
    speeds = np.linspace(700, 1300, 2001) * RPM
    changed = torque_of(speeds, EXCLUDING) != torque_of(speeds, LAW)
    assert changed.any() and np.all(np.abs(speeds[changed] - MIDDLE) < HALF)
    assert torque_of(MIDDLE, EXCLUDING) == pytest.approx(torque_of(MIDDLE, LAW), rel=1e-12)


@pytest.mark.parametrize("over", [0.85, 0.95, 1.0, 1.05, 1.15])
def test_no_speed_within_is_steady(over):
    """Whatever the power near that at the middle: where a rotor stays is in the outer quarters, or beyond."""
    speeds, stays = steady_speeds(over * EXCLUDING.region_2_constant * MIDDLE**3)
    assert stays.any()
    assert np.all(np.abs(speeds[stays] - MIDDLE) >= 0.75 * HALF)
    assert np.all(np.abs(speeds[~stays] - MIDDLE) <= 0.75 * HALF)


def test_a_rotor_waits_at_the_edge_and_then_passes():
    """At the power of the middle both edges hold; well below and well above it, none does."""
    K = EXCLUDING.region_2_constant
    speeds, stays = steady_speeds(K * MIDDLE**3)
    assert stays.sum() == 2 and stays[0] and stays[-1]
    for speed in (MIDDLE - 1.1 * HALF, MIDDLE + 1.1 * HALF):
        speeds, stays = steady_speeds(K * speed**3)
        assert speeds[stays] == pytest.approx([speed], rel=1e-4)


@pytest.mark.parametrize("kind", [TorqueController, SampledTorqueController])
@pytest.mark.parametrize("rpm", [960, 990, 1020, 1040])
def test_both_controllers_ask_for_it(kind, rpm):
    model = Assembly()
    model.speed, model.control = Constant(value=rpm * RPM), kind(**BAND)
    if kind is SampledTorqueController:
        model.control.speed_start = rpm * RPM
    model.connect(model.speed.y, model.control.speed)
    state = fw.load(model).compile().initial_state()
    assert float(state["control.command"]) == pytest.approx(float(torque_of(rpm * RPM, EXCLUDING)), rel=1e-12)


def banded(**parameters):
    model = Assembly()
    model.speed, model.control = Constant(value=1000 * RPM), TorqueController(**parameters)
    model.connect(model.speed.y, model.control.speed)
    return fw.load(model).compile()


@pytest.mark.parametrize("name", list(BAND))
def test_half_of_a_band_is_refused(name):
    with pytest.raises(ParameterError, match=f"control.{name} needs "):
        banded(**{name: BAND[name]})


@pytest.mark.parametrize("middle", [900, 1040, 1150])
def test_a_band_outside_region_2_is_refused(middle):
    with pytest.raises(
        SimulationError, match="the excluded band is from .* and region 2, where it has to lie, from 91"
    ):
        banded(excluded_speed=middle * RPM, excluded_range=HALF).simulate(1.0, 0.5)
