"""The IEA 15-MW turbine on the VolturnUS-S (volturnus_iea15_rigid and volturnus_iea15) against published numbers.

Sources: benchmarks/verification_iea15.py; docs/verification.md has the tables and where the differences come from.
"""

import numpy as np
import pytest
import verification_cases as cases
import verification_iea15 as iea15

import fowtlib as fw
from fowtlib.components.hydro import HydrodynamicDatabase
from fowtlib.components.mechanics.beam_division import divide
from fowtlib.components.mechanics.beam_properties import read_beam
from fowtlib.modelfile import data_path

RHO, G = 1025.0, 9.80665


@pytest.fixture(scope="module")
def model():
    return fw.load("volturnus_iea15_rigid", set=cases.CALM)


@pytest.fixture(scope="module")
def hull(model):
    return model.root.platform.hull.hull()


@pytest.fixture(scope="module")
def calm(model):
    return model.compile()


@pytest.fixture(scope="module")
def rest(calm):
    return calm.equilibrium()


def test_water_of_the_members(hull):
    """HydroDyn and WAMIT: 20,206.35 m^3, -13.628 m; stiffness of the panels, which are inside of the round columns."""
    panels = HydrodynamicDatabase.read(data_path("volturnus/hydrodynamics.nc")).C
    own = hull.buoyancy.stiffness(RHO, G)
    assert hull.buoyancy.volume == pytest.approx(20206.35, rel=1e-5)
    assert hull.buoyancy.centre == pytest.approx([0, 0, -13.628], abs=3e-3)
    assert 1.0 < own[2, 2] / panels[2, 2] < 1.01
    weight_at_origin = own[3, 3], own[4, 4]
    assert weight_at_origin == pytest.approx((panels[3, 3], panels[4, 4]), rel=0.02)


def test_mass_of_the_members(hull):
    """Fitted: steel, water, yaw inertia. Not fitted: mass and centre of the ElastoDyn file, and the inertia in roll."""
    mass = hull.mass
    water = sum(fill.mass for name, fill in hull.fills.items() if name.endswith("water"))
    concrete = sum(fill.mass for name, fill in hull.fills.items() if name.endswith("concrete"))
    assert hull.structure.mass == pytest.approx(3914e3 + 100e3, rel=1e-3)  # printed, with the interface of the tower
    assert water == pytest.approx(11300e3, rel=1e-3)  # printed
    assert mass.inertia[2, 2] == pytest.approx(2.3667e10, rel=1e-3)  # printed
    assert concrete == pytest.approx(2540e3, rel=0.01)  # printed
    assert mass.mass == pytest.approx(1.7838e7, rel=1e-3)
    assert mass.centre == pytest.approx([0, 0, -14.40], abs=0.03)
    assert mass.inertia[0, 0] == pytest.approx(1.2507e10, rel=0.03)


def test_draft_and_trim_at_rest(calm, rest):
    """Hand sums: weight less buoyancy over the stiffness of water and lines; rotor and nacelle beside the axis.

    Masses: nacelle with bearing 673,106 kg, hub 69,131 kg, blades 3 x 66,912 kg; tower 1,483,464 kg at 56.49 m.
    """
    hub_at = -12.098 * np.cos(np.radians(6.0))
    platform, tower, nacelle, rotor = 1.78356e7, 1.483464e6, 673106.0, 69131.0 + 3 * 66911.7
    one = float(rest["platform.mooring.line_1.tension"])
    in_water = 685.0 - RHO * np.pi / 4 * 0.333**2  # kg/m
    level = one - in_water * G * 186.0  # catenary: the tension falls by the weight over the depth
    hanging = 3 * np.sqrt(one**2 - level**2) / G
    surplus = platform + tower + nacelle + rotor + hanging - RHO * 20206.39
    assert rest["platform.motion.heave"] == pytest.approx(-surplus * G / (4.49e6 + 6.07e4), abs=0.06)
    # the centre of a blade, 27.3 m from its root, is off the plane of the hub by the cone
    along_shaft = (3.97 + 27.33) * np.sin(np.radians(4.0))
    arm = nacelle * 4.9099 - 69131 * hub_at + 3 * 66911.7 * (-hub_at + along_shaft * np.cos(np.radians(6.0)))
    upright = 2.2287e9 + 2.592e8 + G * (platform * 14.4156 - tower * 56.49 - (nacelle + rotor) * 148.9)
    assert rest["platform.motion.pitch"] == pytest.approx(-arm * G / upright, rel=0.03)
    for motion in ("sway", "roll", "yaw"):
        assert rest[f"platform.motion.{motion}"] == pytest.approx(0.0, abs=5e-3)
    assert calm.initial_state()["heave"] == pytest.approx(rest["heave"], abs=0.02)  # where the model starts


def test_natural_frequencies(calm, rest):
    """As the definition of the platform prints them, in full thousandths of a hertz."""
    found = {motion: round(mode.frequency_hz, 3) for motion, mode in cases.modes_by_motion(calm, rest).items()}
    assert found == {motion: pytest.approx(printed) for motion, (printed, _) in iea15.FREQUENCIES.items()}


def test_steady_operation_above_rated():
    """OpenFAST of an earlier version: thrust 1 to 4 % lower there, pitch 0.27 to 0.55 deg higher here."""
    for wind, (speed, pitch, thrust, *_) in iea15.OPENFAST.items():
        if wind < 12:
            continue
        point = iea15.steady().operating_point(wind)
        assert point.rotor_speed * 30 / np.pi == pytest.approx(speed, rel=2e-3)
        assert 0.2 < np.degrees(point.blade_pitch) - pitch < 0.6, wind
        assert -0.015 < point.thrust / 1e3 / thrust - 1 < 0.04, wind
        assert iea15.EFFICIENCY * point.aero_power == pytest.approx(15e6, rel=1e-3)


def test_steady_operation_against_the_table():
    """The tabulated curves of the definition: thrust within 5 % from 7 m/s on, power within 6 % below rated wind."""
    for wind, (power, thrust) in iea15.TABULATED.items():
        if wind < 7:  # the definition pitches the blades to hold 5 rpm
            continue
        point = iea15.steady().operating_point(wind)
        assert point.thrust / 1e3 == pytest.approx(thrust, rel=0.05), wind
        assert iea15.EFFICIENCY * point.aero_power / 1e3 == pytest.approx(power, rel=0.06), wind


def test_rated_wind():
    """15 MW at 7.56 rpm from 10.59 m/s on, as printed; the pitch starts within 0.3 m/s of that."""
    point = iea15.steady().operating_point(10.59)
    assert point.rotor_speed * 30 / np.pi == pytest.approx(7.56, rel=1e-3)
    assert iea15.EFFICIENCY * point.aero_power == pytest.approx(15e6, rel=1e-3)
    assert iea15.steady().operating_point(10.2).rotor_speed * 30 / np.pi < 7.56


def test_mass_of_the_blade():
    parts = divide(read_beam(data_path("iea15/blade_structure.csv")), 6, "free_tip")
    mass = sum(segment.mass for segment in parts.segments)
    centre = sum(segment.mass * segment.centre for segment in parts.segments) / mass
    assert mass == pytest.approx(66911.7, rel=1e-4)
    assert centre[2] == pytest.approx(1828927 / 66911.7, rel=1e-4)


def test_modes_of_the_blade():
    """In pyBmodes 0.5585, 0.7281 and 1.5916 Hz at 7.55 rpm, from the ElastoDyn file; 0.555 Hz in the definition."""
    found = iea15.blade_frequencies(7.55, hinges=8)
    assert [name for name, _ in found[:4]] == ["flap", "edge", "flap", "edge"]
    flap, edge, second = (found[i][1] for i in range(3))
    assert flap == pytest.approx(0.5585, rel=0.03)
    assert edge == pytest.approx(0.7281, rel=0.03)
    assert second == pytest.approx(1.5916, rel=0.02)
    torsion = min(hertz for name, hertz in found if name == "torsion")
    assert 3.4 < torsion < 4.2
