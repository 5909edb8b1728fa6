"""Loads on slender hulls: MacCamy and Fuchs, long waves, a panel method, hydrostatics, what does not matter."""

from __future__ import annotations

import re
import warnings
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

import fowtlib as fw
import fowtlib.models
from fowtlib.components.environment import World
from fowtlib.components.environment.waves import unit_waves
from fowtlib.components.hydro import (
    HydrodynamicDatabase,
    Hydrostatics,
    SlenderHullLoads,
    diffraction_coefficient,
)
from fowtlib.components.hydro.hull_part import diffraction_slope, hull_strips
from fowtlib.components.hydro.hull_waves import WaterAtStrips
from fowtlib.components.mechanics import Fixed, FreeMotion, RigidBody
from fowtlib.components.platform import CircularMember, Floater
from fowtlib.language.errors import ModelError

RHO, G = 1025.0, 9.80665
OC3 = {"heights": [-120.0, -12.0, -4.0, 10.0], "diameters": [9.4, 9.4, 6.5, 6.5]}
DATA = Path(fowtlib.models.__file__).parent / "data"


def hull(joint=None, *, depth=320.0, world=None, strips=24, **settings):
    root = fw.Assembly("hull")
    root.world = World(water_depth=depth, water_density=RHO, gravity=G)
    root.joint = joint or FreeMotion()
    root.hull = SlenderHullLoads(**{**OC3, "strips": strips, **settings})
    if isinstance(root.joint, Fixed):
        root.connect(root.joint.frame, root.hull.frame)
    else:
        root.connect(root.world.frame, root.joint.frame_a)
        root.connect(root.joint.frame_b, root.hull.frame)
    return root


@pytest.mark.parametrize(
    "radius, omega, force, angle",
    [(6, 0.3, 2.0946e4, 0.14), (6, 0.5, 5.8965e4, 1.06), (6, 1.0, 2.2087e5, 14.0), (4.15, 0.5, 2.8018e4, 0.51),
     (10, 0.6, 2.3892e5, 5.95)],
)  # fmt: skip
def test_the_force_of_maccamy_and_fuchs(radius, omega, force, angle):
    # N/m per m of amplitude at the surface of deep water; computed beside this project from the Bessel functions
    k = omega**2 / G
    coefficient = diffraction_coefficient(k * radius)
    assert RHO * np.pi * radius**2 * omega**2 * abs(coefficient) == pytest.approx(force, rel=3e-5)
    assert -np.degrees(np.angle(coefficient)) == pytest.approx(angle, abs=0.01)


def test_the_coefficient_is_two_in_long_waves_and_smooth_there():
    assert diffraction_coefficient([0.0, 1e-6, 0.999e-3, 1.001e-3]) == pytest.approx([2, 2, 2, 2], abs=1e-5)
    assert diffraction_coefficient(1e-2) == pytest.approx(2.0, abs=1e-3)


def test_the_slope_of_the_coefficient():
    # against differences of its logarithm with an error of the fourth power of the step
    x = np.array([2e-3, 0.03, 0.3, 1.0, 3.0, 20.0])
    logs = [np.log(diffraction_coefficient(x * (1 + part * 1e-3))) for part in (2, 1, -1, -2)]
    wanted = (8 * (logs[1] - logs[2]) - (logs[0] - logs[3])) / (12e-3 * x)
    assert diffraction_slope(x) == pytest.approx(wanted, rel=1e-9, abs=1e-10)
    assert diffraction_slope([0.0, 0.999e-3]) == pytest.approx([0, 0], abs=0)


@pytest.mark.parametrize("depth", [130.0, np.inf])
@pytest.mark.parametrize("what", ["velocity", "acceleration"])
def test_slopes_of_the_water_at_the_strips(what, depth):
    """Along a change of all sizes, the place and the coefficient: extrapolated differences of the signals."""
    waves, signals = unit_waves(np.array([0.2, 0.5, 1.1, 2.0]), depth, 0.4, G), WaterAtStrips(what)
    part = hull(low=-60.0, high=10.0, keel=False, position=(3.0, -2.0, -60.0), strips=5).hull
    beside = dict(zip((2, 1, -1, -2), (_moved(part.numbers(), share * 1e-3) for share in (2, 1, -1, -2)), strict=True))

    def difference(of):
        found = {share: of(one) for share, one in beside.items()}
        return (8 * (found[1] - found[-1]) - (found[2] - found[-2])) / 12e-3

    moved = difference(signals.numbers)
    wanted = difference(lambda one: signals(waves, one))
    found = signals.slopes(waves, part, np.stack([moved, -2 * moved]))
    assert np.abs(found[0] - wanted).max() < 1e-8 * np.abs(wanted).max()
    assert found[1] == pytest.approx(-2 * found[0], rel=1e-12)


def _moved(part, share):
    """A part of a hull with other sizes, at another place."""
    changed = replace(part, diameters=part.diameters * (1 + share * np.arange(1.0, 5.0)), low=part.low * (1 - share),
                      position=part.position * (1 + 2 * share), added=part.added + share)  # fmt: skip
    return SimpleNamespace(numbers=lambda: changed)


def test_in_long_waves_the_load_is_morisons_with_an_inertia_coefficient_of_two():
    # a Floater of one member has C_a = 1, the acceleration of the water, and the same ends
    root = fw.Assembly("member")
    root.world, root.motion = World(water_depth=320.0, water_density=RHO, gravity=G), FreeMotion()
    root.floater = Floater(held_upright=True)
    stations = (np.array(OC3["heights"]) + 120) / 130
    root.floater.add("column", CircularMember(
        start=(0, 0, -120), end=(0, 0, 10), stations=stations, diameters=OC3["diameters"], wall_thickness=0.05,
        added_mass_coefficient=1.0, sections=120,
    ))  # fmt: skip
    root.connect(root.world.frame, root.motion.frame_a)
    root.connect(root.motion.frame_b, root.floater.frame)
    omega = np.array([0.05, 0.1, 0.2])
    wanted = root.floater.member_loads.wave_transfer(omega, 0.4)
    found = hull(end_added_mass=0.0).hull.wave_transfer(omega, 0.4)
    assert np.abs(found[:, :5] / wanted[:, :5] - 1).max() < 5e-3


def test_the_oc3_spar_against_its_panel_method():
    # strips have no end effect: 2.6 % more added mass in surge and 8 % in pitch, where the ends count most
    known = HydrodynamicDatabase.read(DATA / "oc3_hywind" / "hydrodynamics.nc")
    part = hull().hull
    omega = np.array([0.2, 0.3, 0.5, 0.7, 1.0])
    surge, heave, pitch = (part.wave_transfer(omega, 0.0)[:, ::2] / known.excitation_at(omega, 0.0)[:, ::2]).T
    assert np.abs(np.abs(surge) - 1).max() < 0.015
    assert np.abs(np.abs(pitch) - 1).max() < 0.025
    assert np.abs(np.abs(heave[:4]) - 1).max() < 0.01  # at 1 rad/s the pressure on the cone is diffracted
    assert np.abs(np.degrees(np.angle([surge, pitch]))).max() < 3
    wet = hull_strips(**OC3, low=-120.0, high=0.0, count=24)
    moments = [RHO * wet.volume @ wet.height**n for n in range(3)]
    k = np.argmin(np.abs(known.omega - 0.5))
    wanted = known.A[k, 0, 0], known.A[k, 0, 4], known.A[k, 4, 4]
    assert moments == pytest.approx(wanted, rel=0.08)
    assert moments[0] == pytest.approx(wanted[0], rel=0.03)
    assert wet.volume.sum() == pytest.approx(known.volume, rel=1e-6)


@pytest.mark.parametrize("pose", [(0, 0, 0.7, 0, 0, 0), (3, -2, -1.1, 0.06, -0.1, 0.5), (0, 5, 0, -0.2, 0.15, -2)])
def test_the_part_at_rest_is_lifted_as_hydrostatics_of_a_whole_hull(pose):
    fixed = Fixed(r=pose[:3], angles=pose[3:])
    model = hull(fixed)
    wet = hull_strips(**OC3, low=-120.0, high=0.0, count=24)
    plane, second = np.pi / 4 * 6.5**2, np.pi / 64 * 6.5**4
    model.known = Hydrostatics(
        volume=wet.volume.sum(), centre_of_buoyancy=(0, 0, wet.volume @ wet.height / wet.volume.sum()),
        stiffness=RHO * G * np.diag([0, 0, plane, second, second, 0]),
    )  # fmt: skip
    model.connect(fixed.frame, model.known.frame)
    state = fw.load(model).compile().initial_state()
    assert state["hull.force"] == pytest.approx(-state["known.frame.f"], rel=1e-9, abs=1e-3)
    assert state["hull.moment"] == pytest.approx(-state["known.frame.t"], rel=1e-9, abs=1.0)


def test_the_stiffness_of_a_floating_body_is_that_of_the_textbook():
    # rho g V z_B + rho g I about the water level, by a small angle; the volume stays at its place in the water
    angle = 1e-4
    wet = hull_strips(**OC3, low=-120.0, high=0.0, count=24)
    wanted = RHO * G * (wet.volume @ wet.height + np.pi / 64 * 6.5**4)
    state = fw.load(hull(Fixed(angles=(0, angle, 0)))).compile().initial_state()
    assert -state["hull.moment"][1] / angle == pytest.approx(wanted, rel=1e-6)


def test_parts_of_a_hull_add_up_to_the_whole():
    omega = np.array([0.3, 0.8, 1.6])
    whole = hull(strips=40).hull.wave_transfer(omega, 0.7)
    total = np.zeros_like(whole)
    for low, high in ((-120.0, -60.0), (-60.0, -8.0), (-8.0, 10.0)):
        origin = low  # each on a frame of its own
        part = hull(low=low, high=high, keel=low == -120, waterline=high > 0, position=(0, 0, origin)).hull
        load = part.wave_transfer(omega, 0.7)
        load[:, 3:] += np.cross([0, 0, origin], load[:, :3])
        total += load
    assert np.abs(total - whole).max(axis=0) == pytest.approx(0, abs=2e-4 * np.abs(whole).max())


def test_the_load_turns_with_the_waves():
    omega, part = np.array([0.4, 1.2]), hull().hull
    along, turned = part.wave_transfer(omega, 0.0), part.wave_transfer(omega, 0.5)
    c, s = np.cos(0.5), np.sin(0.5)
    R = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
    assert turned == pytest.approx(along @ np.kron(np.eye(2), R).T, rel=1e-12, abs=1e-6)


def test_a_hull_farther_on_meets_the_wave_later():
    omega = np.array([0.4, 1.2])
    here, there = hull().hull.wave_transfer(omega, 0.3), hull(position=(50, 20, 0)).hull.wave_transfer(omega, 0.3)
    k = omega**2 / G
    late = np.exp(-1j * k * (50 * np.cos(0.3) + 20 * np.sin(0.3)))
    assert there == pytest.approx(here * late[:, None], rel=1e-4, abs=1.0)


@pytest.mark.parametrize(
    "wrong, words",
    [
        ({"heights": [-120.0, -12.0, -15.0, 10.0]}, "must go up from the keel"),
        ({"diameters": [9.4, 6.5]}, "4 and 2"),
        ({"low": -130.0}, "must lie on the hull"),
        ({"low": 2.0}, "begin below the still water level"),
        ({"high": -20.0}, "waterline is true, and the part from -120 m to -20 m does not have it"),
        ({"low": -100.0}, "keel is true"),
        ({"depth": 100.0}, "below the seabed"),
    ],
)
def test_what_cannot_be_is_said(wrong, words):
    with pytest.raises(ModelError, match="hull") as error:
        fw.load(hull(Fixed(), **wrong)).compile().initial_state()
    assert words in str(error.value)


@pytest.mark.parametrize(("start", "said"), [
    ({"heave_start": 4.0}, None),  # the cone begins 4 m below the water level, and is 10 % wider 1.79 m further down
    ({"heave_start": 6.0}, "hull: the hull has risen by 6 m"),
    ({"heave_start": -9.9}, None),
    ({"heave_start": -10.1}, r"hull: the hull has risen by -10.1 m \(below zero: sunk\)"),
    ({"pitch_start": "44 deg"}, None),
    ({"pitch_start": "46 deg"}, "hull: the hull leans by more than 45 deg"),
])  # fmt: skip
def test_a_hull_that_floats_otherwise_than_at_rest_is_told(start, said):
    root = hull(FreeMotion(**start))
    root.body = RigidBody(mass=8e6, r_cm=(0, 0, -78), inertia=4e9 * np.eye(3))
    root.connect(root.joint.frame_b, root.body.frame_a)
    with warnings.catch_warnings(record=True) as found:
        warnings.simplefilter("always")
        fw.Model(root).compile().simulate(0.01, 0.01)
    told = [str(item.message) for item in found if "hull:" in str(item.message)]
    assert bool(told) == bool(said)
    assert said is None or re.search(said, told[0])
