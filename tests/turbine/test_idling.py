"""Rotors that idle and are parked in storms: loads at any angle of attack, the idling speed, starts, and the brake."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.interpolate import PchipInterpolator
from scipy.optimize import brentq

import fowtlib as fw
from fowtlib.components.aero import RigidRotor
from fowtlib.components.turbine.idling import idling_speed
from fowtlib.language.errors import SimulationError
from fowtlib.language.native import compiler
from tests.aero.conftest import blade, rotor  # noqa: F401

pytestmark = pytest.mark.skipif(not compiler(), reason="needs a C compiler")
FEATHER, RPM = np.pi / 2, np.pi / 30
STORM = 50.0
ANGLES = np.radians(2.5), np.radians(5)  # precone, tilt


def blowing(yaw, speed=STORM):
    return speed * np.cos(np.radians(yaw)), speed * np.sin(np.radians(yaw)), 0.0


def torque_by_hand(rotor, wind, speed, azimuth):  # noqa: F811
    """Of three upright blades at feather without cone and tilt, about x, by the polars at the geometric angle.

    Blade axis z = (0, -sin a, cos a) at the azimuth a, clockwise seen from upwind; t, against which the blade turns, is
    (0, cos a, sin a). A section at pitch and twist b has its chord at b from t, towards the wind.
    """
    blade, total = rotor.blade, 0.0  # noqa: F811
    x = np.array([1.0, 0, 0])
    for k in range(3):
        a = azimuth + 2 * np.pi * k / 3
        against = np.array([0, np.cos(a), np.sin(a)])
        for r, chord, twist, length, name in zip(
            blade.radius, blade.chord, blade.twist, blade.length, blade.airfoil, strict=True
        ):
            flow_x, flow_t = np.dot(wind, x), np.dot(wind, against) + speed * r
            inflow, beta, fast = np.arctan2(flow_x, flow_t), FEATHER + twist, np.hypot(flow_x, flow_t)
            foil = blade.airfoils[name]
            angle = (inflow - beta + np.pi) % (2 * np.pi) - np.pi
            lift, drag, _ = PchipInterpolator(foil.angle, foil.coefficients)(angle)
            driving = lift * np.sin(inflow) - drag * np.cos(inflow)
            total += r * 0.5 * 1.225 * fast**2 * chord * length * driving
    return total


def straight(rotor):  # noqa: F811
    return replace(rotor, blade=replace(rotor.blade, curve=None, sweep=None))


@pytest.mark.parametrize("yaw", [0, 8, 20, 30, -30, 75])
def test_the_idling_speed_is_that_of_a_torque_balance_by_hand(rotor, yaw):  # noqa: F811
    plain, wind = straight(rotor), blowing(yaw)
    azimuths = 2 * np.pi / 3 * np.arange(5) / 5
    found = idling_speed(plain, wind, FEATHER)

    def torque(speed):
        return np.mean([torque_by_hand(plain, wind, speed, a) for a in azimuths])

    assert 0.02 < abs(found) / RPM < 1.0
    assert found == pytest.approx(brentq(torque, found - 0.1 * abs(found), found + 0.1 * abs(found)), rel=1e-4)


def test_the_idling_speed_goes_with_the_wind_and_a_brake_lowers_it(rotor):  # noqa: F811
    storm = idling_speed(rotor, blowing(30), FEATHER)
    assert idling_speed(rotor, blowing(30, 25.0), FEATHER) == pytest.approx(storm / 2, rel=1e-6)  # no Reynolds number
    weak, strong = (idling_speed(rotor, blowing(30), FEATHER, brake=(t, 0.0103)) for t in (1e6, 1e7))
    assert 0 < strong < weak < storm
    air = np.mean([RigidRotor(rotor).thrust_and_torque(blowing(30), strong, FEATHER, azimuth=2 * np.pi / 15 * k)[1]
                   for k in range(5)])  # fmt: skip
    assert air == pytest.approx(1e7 * strong / np.hypot(strong, 0.0103), rel=1e-4)
    assert idling_speed(rotor, (0.0, 0.0, 0.0), FEATHER) == 0


@pytest.mark.parametrize(("pitch", "speed"), [(90, 0.2), (80, 0.6), (0, 0.0)])
def test_loads_have_no_jump_over_all_yaw_angles(rotor, pitch, speed):  # noqa: F811
    """Halving the step of the yaw angle halves the greatest change of the loads: they are continuous."""
    rigid = RigidRotor(rotor, np.radians(2.5), np.radians(5))

    def greatest(step):
        yaws = np.arange(-180, 180 + step / 2, step)
        loads = [rigid.loads(rigid.inputs(blowing(yaw), speed * RPM, np.radians(pitch), 0.4)) for yaw in yaws]
        assert np.all(np.isfinite(loads))
        assert loads[0] == pytest.approx(loads[-1], rel=1e-9, abs=1e-3)
        return np.abs(np.diff(loads, axis=0)).max(axis=(0, 1))

    wide, narrow = greatest(2.0), greatest(0.5)
    assert np.all(narrow[:3] < 0.4 * wide[:3] + 1.0), (wide, narrow)


STORMY = {"wind.kind": "steady", "wind.mean_speed": STORM, "turbine.safety.idling": 1.0, "sea.spectrum": "still"}


@pytest.fixture(scope="module")
def spar():
    return fw.load("oc3_spar_rigid_bem").compile()


def test_a_floating_turbine_idles_from_its_mean(spar, rotor):  # noqa: F811
    """From the start on at the speed of the balance, and the platform where it stays."""
    result = spar.simulate(30, 0.1, solver="fixed", start="turning", parameters=STORMY)
    speed = np.asarray(result["rotor_speed"])
    rigid = idling_speed(rotor, blowing(0), FEATHER, *ANGLES) / RPM
    assert -0.3 < rigid < -0.1 and speed.mean() == pytest.approx(rigid, rel=0.1)
    for name, most in (("surge", 0.3), ("pitch", 0.2), ("sway", 0.3), ("yaw", 1.0)):
        moved = np.asarray(result[name])
        assert abs(moved - moved[0]).max() < most, name


@pytest.mark.parametrize("askew", [30, -30])
def test_in_wind_from_the_side_an_idling_rotor_comes_to_rest(spar, rotor, askew):  # noqa: F811
    """Its inertia is spent in a second, and it stays at an azimuth to which the torque of the air drives it back."""
    result = spar.simulate(
        45, 0.1, solver="fixed", start="turning", parameters=STORMY | {"wind.direction": f"{askew} deg"}
    )
    late = np.asarray(result.time) > 30
    speed, azimuth, yaw = (np.asarray(result[name])[late] for name in ("rotor_speed", "azimuth", "yaw"))
    assert abs(speed).max() < 0.15 and np.ptp(azimuth) < 3
    wind, there = blowing(askew - yaw.mean()), np.radians(azimuth.mean())
    before, behind = (idling_speed(rotor, wind, FEATHER, *ANGLES, azimuth=there + side) for side in (-0.15, 0.15))
    assert before > 0 > behind


def test_a_parked_turbine_creeps_and_its_brake_holds_what_the_air_does(spar):
    names = ["turbine.aerodynamics.torque", "turbine.safety.brake.torque", "rotor_speed"]
    parameters = STORMY | {"turbine.safety.braked": 1.0, "turbine.safety.brake_torque": 1e5}
    result = spar.simulate(20, 0.1, solver="fixed", start="turning", parameters=parameters, outputs=names)
    air, brake, speed = (np.asarray(result[name])[50:].mean() for name in names)
    assert abs(air) > 1e6 and brake * 97 == pytest.approx(air, rel=0.02)
    assert 0 < abs(speed) < 0.1


def test_a_brake_without_torque_is_refused(spar):
    with pytest.raises(SimulationError, match="its torque is 0"):
        spar.simulate(1, 0.1, solver="fixed", parameters=STORMY | {
            "turbine.safety.braked": 1.0, "turbine.safety.brake_torque": 0.0})  # fmt: skip
