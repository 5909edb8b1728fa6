"""Two rotors on the OO-Star Wind Floater (oo_star_rigid) against O. El Beshbichi, PhD thesis, Stavanger (2023).

Tables 7.4 (dimensions), 7.5 (hydrostatics) and 7.7 (periods). models/SOURCES.md has the rules for what is not printed
there, docs/floaters.md the tables and why periods differ. Walls and ballast are fitted to mass, centre and inertia of
the floater; nothing was fitted to its volume, centre of buoyancy, or to a period.
"""

from __future__ import annotations

import numpy as np
import pytest
import verification_cases as cases
from scipy.optimize import fsolve

import fowtlib as fw
from fowtlib.components.hydro.radiation_identification import identify_radiation
from fowtlib.modelfile.files import models_folder
from fowtlib.solving.modes import natural_modes

RHO, G = 1025.0, 9.80665


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
    """Table 7.5 within 1 %, with the C44 that its other numbers make: 2.03e9 N m, and not the 2.16e9 printed."""
    for name, (own, printed) in cases.oo_star_hydrostatics(model).items():
        assert own == pytest.approx(printed, rel=0.01), name
    extra = model.root.platform.hull.hull().fills["platform.hull.middle_column.extra"]
    assert extra.mass == pytest.approx(688e3, rel=1e-3)  # ballast for two rotors


def test_cones_follow_from_the_printed_waterplane(model):
    """All cones have the slope of the middle column, from 16.2 m at the pontoons to the diameter at the waterline."""
    outer = 3 * np.pi / 4 * 13.4**2
    slope = (16.2 - np.sqrt((548.8 - outer) * 4 / np.pi)) / 15.0
    platform = model.root.platform
    assert float(platform.parameter_value("middle_cone")) == pytest.approx((16.2 - 12.05) / slope, abs=0.01)
    assert float(platform.parameter_value("outer_cone")) == pytest.approx((15.8 - 13.4) / slope, abs=0.01)


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


def test_the_chain_itself(tmp_path):
    """LIFES50+: 1670 kN at the fairlead, and 181.8 s in surge (0.0055 Hz) with one turbine of about the same mass."""
    text = (models_folder() / "oo_star_rigid.yaml").read_text()
    text = text.replace("platforms/oo_star}", "platforms/oo_star_chain}")
    text = text.replace("platform.mooring.line", "platform.line")
    (tmp_path / "chain.yaml").write_text(text)
    plant = fw.load(tmp_path / "chain.yaml", set=cases.CALM).compile()
    rest = plant.equilibrium()
    assert float(rest["fairlead_tension_1"]) == pytest.approx(1670, rel=0.03)
    assert float(rest["heave"]) == pytest.approx(0, abs=0.03)
    surge = next(mode for mode in natural_modes(plant, rest) if mode.name == "platform surge")
    assert surge.period == pytest.approx(181.8, rel=0.04)


def test_it_rests_near_the_drawn_draft(model, rest):
    """Weight and lines are 0.6 MN more than the buoyancy: divided by the stiffness."""
    hull = model.root.platform.hull.hull()
    lines = sum(float(rest[f"platform.mooring.line_{k}.vertical_tension"]) for k in (1, 2, 3))
    surplus = RHO * G * hull.buoyancy.volume - G * (hull.mass.mass + 1236.9e3) - lines
    assert float(rest["heave"]) == pytest.approx(surplus / hull.buoyancy.stiffness()[2, 2], rel=0.02)
    assert -0.15 < float(rest["heave"]) < 0
    for motion in ("surge", "sway", "roll", "pitch", "yaw"):
        assert float(rest[motion]) == pytest.approx(0.0, abs=5e-3)


def test_periods(periods):
    """Table 7.7: surge 147.5, heave 18.5, pitch 23.8, yaw 108.6 s.

    Yaw within 3 %. Pitch is 5 % short (the printed one lies between pitch and roll), heave is 8 % and surge 12 % long:
    docs/floaters.md.
    """
    assert periods["yaw"] == pytest.approx(108.6, rel=0.03)
    assert periods["pitch"] < 23.8 < periods["roll"]
    assert periods["pitch"] == pytest.approx(23.8, rel=0.05)
    assert periods["heave"] == pytest.approx(18.5, rel=0.08)
    assert periods["surge"] == pytest.approx(147.5, rel=0.13)


def test_heave_and_yaw_by_hand(model, rest, periods):
    """One oscillator each: waterplane and lines by differences or by hand, added mass of the memory at that period.

    The memory of 4 states a motion has 2 % more added mass than the panel method in heave at 20 s, and 10 % in yaw,
    which is 2.2 % of the period of yaw; with 8 states it is 6 %.
    """
    root = model.root
    data, mooring = root.platform.hull.database, root.platform.mooring
    hull = root.platform.hull.hull()
    memory = identify_radiation(data.omega, data.B, data.A, data.A_inf, order=4)
    assert memory.passive

    def added(motion, period):
        omega = 2 * np.pi / period
        return data.A_inf[motion, motion] + memory.transfer([omega])[0, motion, motion].imag / omega

    heave = float(rest["heave"])
    lines = -(mooring.static_load((0, 0, heave + 0.5))[0][2] - mooring.static_load((0, 0, heave - 0.5))[0][2])
    mass = hull.mass.mass + 1236.9e3 + added(2, periods["heave"])
    by_hand = 2 * np.pi * np.sqrt(mass / (hull.buoyancy.stiffness()[2, 2] + lines))
    assert periods["heave"] == pytest.approx(by_hand, rel=0.005)

    H = float(rest["platform.mooring.line_1.horizontal_tension"])
    inertia = hull.mass.inertia[2, 2] + 2.345e8 + 700e3 * 69.3**2 + added(5, periods["yaw"])
    by_hand = 2 * np.pi * np.sqrt(inertia / (3 * H * 44 * 691 / 647))
    assert periods["yaw"] == pytest.approx(by_hand, rel=0.005)
