"""The DTU 10-MW turbine against HAWC2, HAWCStab2, printed numbers and calculations of its own.

Sources: benchmarks/verification_dtu10mw.py; docs/dtu10mw.md has the tables and where the differences come from.
"""

from dataclasses import replace

import numpy as np
import pytest
import verification_dtu10mw as dtu

import fowtlib as fw
from fowtlib.components.aero.bem_steady import RigidRotor
from fowtlib.components.mechanics.beam_division import divide
from fowtlib.components.mechanics.beam_properties import read_beam
from fowtlib.modelfile import data_path

# --- the rotor ---


@pytest.mark.parametrize("wind", dtu.HAWC2_RIGID)
def test_rigid_rotor_of_hawc2(wind):
    """Within 1.1 % with HAWC2's sections along the blade and its induction; these two make up to 9 % of power."""
    rpm, degrees, power, thrust = dtu.HAWC2_RIGID[wind]
    given = wind, rpm * dtu.RPM, np.radians(degrees)
    here, theirs = dtu.coned(*given), dtu.as_hawc2(*given)
    assert theirs[1] * given[1] / 1e3 == pytest.approx(power, rel=0.011)
    assert theirs[0] / 1e3 == pytest.approx(thrust, rel=0.011)
    assert here[1] * given[1] / 1e3 == pytest.approx(power, rel=0.09)
    assert here[0] / 1e3 == pytest.approx(thrust, rel=0.01 if wind < 12 else 0.075)


@pytest.mark.parametrize(("wind", "rpm", "power", "thrust"), dtu.HAWCSTAB2)
def test_rigid_rotor_of_hawcstab2(wind, rpm, power, thrust):
    """Over the tip speed ratio, 6 to 9."""
    theirs = dtu.as_hawc2(wind, rpm * dtu.RPM, 0.0)
    assert theirs[1] * rpm * dtu.RPM / 1e3 == pytest.approx(power, rel=0.011)
    assert theirs[0] / 1e3 == pytest.approx(thrust, rel=0.005)


@pytest.mark.parametrize(("wind", "rpm", "degrees"), [(5.0, 6.0, 1.9), (10.0, 8.43, 0.0), (20.0, 9.6, 17.4)])
def test_an_independent_calculation_of_the_rotor(wind, rpm, degrees):
    """The same theory in other unknowns, both without the loss at the hub, which is 0.1 % here."""
    given = rpm * dtu.RPM, np.radians(degrees)
    rotor = RigidRotor(replace(dtu.straight_rotor().rotor, hub_loss=False))
    assert dtu.annuli(wind, *given, dtu.buhl) == pytest.approx(rotor.thrust_and_torque([wind, 0, 0], *given), rel=1e-4)


@pytest.mark.parametrize("wind", dtu.REFERENCE)
def test_loads_and_slopes_of_the_reference(wind):
    """Loads within 2.7 %. Slopes: the reference has one airfoil, without stall delay, from 9.8 m to 27.4 m.

    With that airfoil in place all slopes but one were within 1.5 % (docs/dtu10mw.md). From 12 m/s to 15 m/s the inner
    sections matter least.
    """
    printed = dict(zip(dtu.QUANTITIES, dtu.REFERENCE[wind][2:], strict=True))
    own = dtu.derivatives(wind)
    near = 12 <= wind <= 15
    for name in ("T", "P"):
        assert own[name] == pytest.approx(printed[name], rel=0.027), name
    for name in ("T_v", "T_pitch", "Q_v", "M_v"):
        assert own[name] == pytest.approx(printed[name], rel=0.03 if near else 0.095), name
    assert own["Q_speed"] == pytest.approx(printed["Q_speed"], rel=0.095 if near else 0.125)
    assert own["T_speed"] == pytest.approx(printed["T_speed"], abs=0.28)
    if wind >= 12:
        assert own["Q_pitch"] == pytest.approx(printed["Q_pitch"], rel=0.055)
    else:  # near its best pitch a rotor hardly answers to it
        assert 0 < own["Q_pitch"] < printed["Q_pitch"]


@pytest.mark.parametrize("wind", [8.0, 13.0, 25.0])
def test_slopes_are_of_second_degree(wind):
    """Loads are homogeneous of degree 2 in wind and speed: v T_v + w T_w = 2 T, and Q alike. Both sources keep it."""
    rpm, _, *printed = dtu.REFERENCE[wind]
    speed = rpm * dtu.RPM
    for one in (dict(zip(dtu.QUANTITIES, printed, strict=True)), dtu.derivatives(wind)):
        assert wind * one["T_v"] / 1e3 + speed * one["T_speed"] == pytest.approx(2 * one["T"], rel=3e-3)
        assert wind * one["Q_v"] + speed * one["Q_speed"] == pytest.approx(2 * one["P"] / speed, rel=6e-3)


# --- operation ---


@pytest.fixture(scope="module")
def steady():
    return fw.load("dtu10mw_land_rigid").root.turbine.steady_turbine()


@pytest.mark.parametrize("wind", [11.5, 12.0, 13.0, 15.0, 19.0, 25.0])
def test_power_above_rated(steady, wind):
    """10 MW at 9.6 rpm, with the pitch of the reference within 0.6 deg (its air is 1.25 kg/m^3, here 1.225)."""
    point = steady.operating_point(wind)
    assert point.aero_power == pytest.approx(10e6, rel=5e-3)
    assert point.rotor_speed / dtu.RPM == pytest.approx(9.6, rel=1e-3)
    if wind in dtu.REFERENCE:
        assert np.degrees(point.blade_pitch) == pytest.approx(dtu.REFERENCE[wind][1], abs=0.6)


def test_power_below_rated(steady):
    """The best tip speed ratio is 7.5 between the lowest speed, 6 rpm, and rated wind."""
    for wind in (8.5, 9.5, 10.5):
        assert steady.operating_point(wind).tip_speed_ratio == pytest.approx(7.5, rel=0.02)
    for wind in (4.0, 6.0):
        assert steady.operating_point(wind).rotor_speed / dtu.RPM == pytest.approx(6.0, abs=0.4)
    assert 8e6 < steady.operating_point(10.5).aero_power < 9.99e6


@pytest.mark.long
@pytest.mark.parametrize("wind", [12.0, 18.0, 24.0])
def test_flexible_operation(wind):
    """HAWC2 with its controller at 10.63 MW: thrust and root moment 2 %, pitch 0.3 deg, tip 5 % and 0.1 m."""
    _, degrees, _, thrust, moment, tip = dtu.HAWC2_FLEXIBLE[wind]
    mean = dtu.flexible_operation(wind)
    assert mean["thrust"] == pytest.approx(thrust, rel=0.02)
    assert mean["blade_pitch"] == pytest.approx(degrees, abs=0.3)
    assert np.mean([mean[f"blade_root_flapwise_moment_{k}"] for k in (1, 2, 3)]) / 1e6 == pytest.approx(
        moment, rel=0.04
    )
    assert np.mean([mean[f"blade_tip_out_of_plane_{k}"] for k in (1, 2, 3)]) == pytest.approx(tip, abs=0.1 + 0.05 * tip)


# --- masses and modes ---


def test_masses():
    """Printed: 230.7 t of rotor, 446.0 t of nacelle, 628.4 t of tower, 1.6e8 kg m^2; HAWCStab2: 1.5691e8, 1.6066e8."""
    parts = divide(read_beam(data_path("dtu10mw/blade_structure.csv")), 6, "free_tip")
    blade = sum(segment.mass for segment in parts.segments)
    turbine = fw.load("dtu10mw_land_rigid").root.turbine
    value = turbine.parameter_value
    rotor = 3 * blade + 105520
    assert rotor == pytest.approx(230.7e3, rel=1e-3)
    assert value("mass") == pytest.approx(rotor + 446036, rel=1e-5)
    inertia = turbine.rotor.parameter_value("inertia")
    drive = value("gear_ratio") ** 2 * value("generator_inertia")
    assert inertia == pytest.approx(1.569075e8, rel=5e-3)
    assert inertia + drive == pytest.approx(1.606585e8, rel=5e-3)
    assert inertia + drive == pytest.approx(160234250, rel=1e-3)  # of the reference
    tower = read_beam(data_path("dtu10mw/tower.csv"))
    assert np.trapezoid(tower.mass_per_length, tower.z) == pytest.approx(628.4e3, rel=1e-3)


def test_hub_height():
    model = fw.load("dtu10mw_land_rigid").root
    assert 115.63 + model.to_hub.parameter_value("r")[2] == pytest.approx(119.0, abs=0.01)


def test_blade_frequencies():
    """By finite elements without shear within 0.6 %, six hinges within 1.5 %; shear, left out, is 0.8 to 4 %."""
    for hinges, tolerance in ((20, 0.006), (6, 0.015)):
        found = dtu.blade_frequencies(hinges)
        for kind, values in dtu.WITHOUT_SHEAR.items():
            assert found[kind][: len(values)] == pytest.approx(values, rel=tolerance)
    for kind, values in dtu.WITH_SHEAR.items():
        lower = np.array(values) / dtu.WITHOUT_SHEAR[kind]
        assert np.all((lower > 0.96) & (lower < 0.993))


def test_tower_frequencies():
    """HAWCStab2 has no weight; its blades bend. The weight takes 1.7 % of it: m g / l over the stiffness."""
    found = dtu.tower_frequencies(0.0)
    assert found["tower fore-aft"] == pytest.approx(dtu.CAMPBELL["tower fore-aft"], rel=0.016)
    assert found["tower side-side"] == pytest.approx(dtu.CAMPBELL["tower side-side"], rel=0.012)
    heavy = dtu.tower_frequencies(9.80665)
    for name, hertz in heavy.items():
        top, tower, length = 676809.0, 628443.0, 115.63
        stiffness = (2 * np.pi * found[name]) ** 2 * (top + 0.24 * tower)
        softer = 1.2 * 9.80665 * (top + tower / 3) / length / stiffness
        assert 1 - hertz / found[name] == pytest.approx(softer / 2, rel=0.35)


@pytest.mark.long
def test_modes_of_the_turbine():
    """Standing, without weight, beside the means of backward and forward modes at 6 rpm; edgewise shear is missing."""
    calm = {"wind.kind": "none", "world.gravity": 0.0}
    plant = fw.load("dtu10mw_land", set=calm).compile()
    modes = {mode.name: mode.frequency for mode in fw.natural_modes(plant, plant.equilibrium())}
    for name in ("tower fore-aft", "tower side-side"):
        assert modes[f"1st {name}"] == pytest.approx(dtu.CAMPBELL[name], rel=0.012)
    for name, tolerance in (("blade flap", 0.015), ("blade edge", 0.03)):
        pair = [modes[f"1st {name} {phase}"] for phase in ("sine", "cosine")]
        assert np.mean(pair) == pytest.approx(dtu.CAMPBELL[name], rel=tolerance)
