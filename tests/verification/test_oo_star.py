"""Two rotors on the OO-Star Wind Floater (oo_star_rigid, oo_star) against O. El Beshbichi, PhD thesis, Stavanger (2023).

Tables 7.4 (dimensions), 7.5 (hydrostatics) and 7.7 (periods). models/SOURCES.md has the rules for what is not printed
there, docs/floaters.md the tables and why periods differ. Walls and ballast are fitted to mass, centre and inertia of the
floater; nothing was fitted to its volume, centre of buoyancy, or to a period.
"""

from __future__ import annotations

import numpy as np
import pytest
import verification_cases as cases
from scipy.optimize import fsolve

import fowtlib as fw
from fowtlib.solving.modes import natural_modes

RHO, G = 1025.0, 9.80665
EXTRA = 688e3  # kg, ballast for two rotors


@pytest.fixture(scope="module")
def model():
    return fw.load("oo_star_rigid", set=cases.CALM)


@pytest.fixture(scope="module")
def plant(model):
    return model.compile()


@pytest.fixture(scope="module")
def rest(plant):
    return plant.equilibrium()


@pytest.fixture(scope="module")
def periods(plant, rest):
    return {mode.name.removeprefix("platform "): mode.period for mode in natural_modes(plant, rest) if mode.motion}


def test_hydrostatics(model):
    """Table 7.5: V 2.35e4 m^3, CoB 14.2 m, A_wp 548.8 m^2, I_wp 2.95e5 m^4, C33 5.51e6 N/m."""
    water = model.root.platform.hull.hull().buoyancy
    assert water.volume == pytest.approx(2.35e4, rel=0.01)
    assert water.centre == pytest.approx([0, 0, -14.2], abs=0.01)
    assert water.waterplane[2, 2] == pytest.approx(548.8, rel=1e-3)
    for axis in (3, 4):
        assert water.waterplane[axis, axis] == pytest.approx(2.95e5, rel=0.01)
    assert water.stiffness()[2, 2] == pytest.approx(5.51e6, rel=0.01)


def test_mass(model):
    """Table 7.5: floater 2.17e7 kg at 15.2 m, I44 9.43e9, I66 1.63e10 kg m^2; whole 2.36e7 kg at 10.24 m; 688 t extra.

    C44 from V, CoB and I_wp: 2.03e9 N m. The 2.16e9 printed take CoG - CoB as 3.42 m, and 10.24 - 14.2 is -3.96 m.
    """
    hull = model.root.platform.hull.hull()
    extra = hull.fills["platform.hull.middle_column.extra"]
    assert extra.mass == pytest.approx(EXTRA, rel=1e-3)
    mass = hull.mass.mass - extra.mass
    centre = (hull.mass.mass * hull.mass.centre[2] - extra.mass * extra.centre[2]) / mass
    assert mass == pytest.approx(2.17e7, rel=0.01)
    assert centre == pytest.approx(-15.2, rel=0.01)
    # about its own centre, without the extra ballast, which is on the axis
    roll = hull.mass.inertia[0, 0] - extra.inertia[0, 0]
    roll -= mass * (centre - hull.mass.centre[2]) ** 2 + extra.mass * (extra.centre[2] - hull.mass.centre[2]) ** 2
    assert roll == pytest.approx(9.43e9, rel=0.01)
    assert hull.mass.inertia[2, 2] - extra.inertia[2, 2] == pytest.approx(1.63e10, rel=0.01)

    tower, rotors = 536.9e3, 700e3
    whole = hull.mass.mass + tower + rotors
    height = (hull.mass.mass * hull.mass.centre[2] + tower * 66.3 + rotors * 91) / whole
    assert whole == pytest.approx(2.36e7, rel=0.01)
    assert height == pytest.approx(-10.24, rel=0.01)
    water = hull.buoyancy
    righting = water.waterplane[3, 3] + water.volume * (water.centre[2] - height)
    assert RHO * G * righting == pytest.approx(2.03e9, rel=0.01)


def test_the_line_pulls_as_the_chain_with_its_clump_weight(rest):
    """703 m of 650 kg/m stand for 585 m and 118 m of 375.38 kg/m with 50 t in water between: 3 catenaries in numpy."""
    EA, diameter, span, rise = 1.506e9, 0.137, 647.0, 139.5

    def section(H, below, weight, length):
        above = below + weight * length
        x = H / weight * (np.arcsinh(above / H) - np.arcsinh(below / H)) + H * length / EA
        z = (np.hypot(H, above) - np.hypot(H, below)) / weight + (above**2 - below**2) / (2 * EA * weight)
        return x, z, above

    def chain(unknown):
        H, hung = unknown * [1e6, 100.0]
        weight = (375.38 - RHO * np.pi / 4 * diameter**2) * G
        x, z, pull = section(H, 0.0, weight, hung)
        x_upper, z_upper, _ = section(H, pull + 50e3 * G, weight, 118.0)
        return [x + x_upper + (585.0 - hung) * (1 + H / EA) - span, z + z_upper - rise]

    horizontal = fsolve(chain, [0.9, 1.5])[0] * 1e6
    assert float(rest["platform.mooring.line_1.horizontal_tension"]) == pytest.approx(horizontal, rel=0.01)


def test_it_rests_near_the_drawn_draft(model, rest):
    """Weight and lines are 0.6 MN more than the buoyancy: divided by the stiffness."""
    hull = model.root.platform.hull.hull()
    lines = sum(float(rest[f"platform.mooring.line_{k}.vertical_tension"]) for k in (1, 2, 3))
    surplus = RHO * G * hull.buoyancy.volume - G * (hull.mass.mass + 1236.9e3) - lines
    assert float(rest["heave"]) == pytest.approx(surplus / hull.buoyancy.stiffness()[2, 2], rel=0.02)
    assert -0.15 < float(rest["heave"]) < 0
    for motion in ("surge", "sway", "roll", "pitch", "yaw"):
        assert float(rest[motion]) == pytest.approx(0.0, abs=5e-3)
