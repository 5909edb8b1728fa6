"""The sheet of a model: masses by hand, a floating body of published numbers, and tables of other programs."""

from __future__ import annotations

import math

import numpy as np
import pytest

import fowtlib as fw
from fowtlib.analysis import Sheet, model_sheet
from fowtlib.components.blocks import Constant
from fowtlib.components.environment import World
from fowtlib.components.mechanics import (
    AxialWire,
    Fixed,
    FixedRotation,
    FixedTranslation,
    FreeMotion,
    PointMass,
    RigidBody,
    WorldForce,
)
from fowtlib.components.mooring import DeltaLine, SectionedLine, Tendon
from fowtlib.components.platform import Ballast, CircularMember, Floater, RectangularMember
from fowtlib.language import ModelError

HALF = np.sqrt(0.5)
STILL = {"wind.kind": "none", "sea.spectrum": "still"}


@pytest.fixture(scope="module")
def spar():
    return model_sheet(fw.load("oc3_spar_rigid", set=STILL).compile())


def test_masses_of_bodies_that_are_turned_and_hang():
    """Two bodies: one at the end of an arm that is turned by 45 deg about x, and a point mass on a wire with mass."""
    top = fw.Assembly("bodies")
    top.world, top.support = World(), Fixed(r=(1.0, 0.0, 5.0))
    top.turn = FixedRotation(n=(1, 0, 0), angle="45 deg")
    top.arm = FixedTranslation(r=(0.0, 0.0, 2.0))
    top.body = RigidBody(mass=3.0, r_cm=(0, 0, 1.0), inertia=((4, 0, 0), (0, 5, 0), (0, 0, 6)))
    top.ball, top.low = PointMass(mass=2.0), FixedTranslation(r=(0.0, 0.0, -4.0))
    top.wire = AxialWire(axial_stiffness=1e4, length=4.0, pretension=100.0, mass_per_length=0.5)
    top.connect(top.support.frame, top.turn.frame_a)
    top.connect(top.turn.frame_b, top.arm.frame_a)
    top.connect(top.arm.frame_b, top.body.frame_a)
    top.connect(top.support.frame, top.low.frame_a)
    top.connect(top.low.frame_b, top.ball.frame_a)
    top.connect(top.support.frame, top.wire.frame_a)
    top.connect(top.low.frame_b, top.wire.frame_b)
    sheet = model_sheet(fw.load(top).compile())

    half = 0.5 * 4.0 / 1.01 / 2  # of the wire, at each end; it is unstretched in its mass
    bodies = [(3.0, np.array([1.0, -3 * HALF, 5 + 3 * HALF])), (2.0 + half, np.array([1.0, 0, 1.0]))]
    bodies.append((half, np.array([1.0, 0, 5.0])))
    mass = sum(m for m, _ in bodies)
    centre = sum(m * r for m, r in bodies) / mass
    inertia = np.diag([4.0, 5.5, 5.5])  # of the body, about axes of the world: (5 + 6) / 2
    for m, r in bodies:
        inertia += m * ((r - centre) @ (r - centre) * np.eye(3) - np.outer(r - centre, r - centre))
    assert sheet["mass"] == pytest.approx(mass)
    assert [sheet[f"centre of mass {axis}"] for axis in "xyz"] == pytest.approx(centre.tolist())
    assert [sheet[f"inertia {axis}{axis}"] for axis in "xyz"] == pytest.approx(np.diag(inertia).tolist())
    assert sheet["weight"] == pytest.approx(mass * 9.80665)
    assert sheet["wire: mass"] == pytest.approx(2 * half)
    assert sheet["wire.tension"] == pytest.approx(100.0)


def test_the_spar_has_its_published_numbers(spar):
    """J. Jonkman, NREL/TP-500-47535 (2010): tables 3-1, 4-1 and section 4 (C33, C44, limits of the added mass)."""
    published = {
        "platform: mass": (7466330.0, 1e-9), "platform: centre of mass z": (-89.9155, 1e-5),
        "platform: inertia yy": (4229230000.0, 1e-9), "displaced volume": (8029.21, 1e-9),
        "C33": (332941.0, 1e-6), "C44": (-4999180000.0, 1e-6), "tower: mass": (249718.0, 1e-9),
        "platform.mooring.line_1.tension": (911000.0, 1e-3),
    }  # fmt: skip
    for quantity, (value, tolerance) in published.items():
        assert spar[quantity] == pytest.approx(value, rel=tolerance), quantity
    assert spar["mass"] == pytest.approx(7466330 + 249718 + 350000)
    assert spar.entry("A15(inf)").unit == "kg m" and spar.entry("C44").unit == "N m"
    assert spar["heave per wave amplitude at 0.04 Hz"] == pytest.approx(0.11358, rel=1e-3)
    assert "A12(inf)" not in spar  # zero by symmetry
    surge = next(m for m in fw.natural_modes(fw.load("oc3_spar_rigid", set=STILL).compile()) if "surge" in m.name)
    assert spar["period of platform surge"] == pytest.approx(surge.period)


def floating(*members, density=1000.0):
    """A floater with these members, free in still water."""
    top = fw.Assembly("a floater")
    top.world, top.motion, top.floater = World(water_depth=200.0, water_density=density), FreeMotion(), Floater()
    for k, member in enumerate(members):
        top.floater.add(f"member_{k}", member)
    top.connect(top.world.frame, top.motion.frame_a)
    top.connect(top.motion.frame_b, top.floater.frame)
    return top


def test_a_floater_says_its_mass_volume_stiffness_and_the_mass_of_its_water():
    """A column of 10 m and 20 m draft without a wall, half full of ballast of twice the density of the light water."""
    density, gravity, area, across = 1000.0, 9.80665, math.pi * 25, 0.9
    column = CircularMember(start=(0, 0, -20), end=(0, 0, 10), diameters=10.0, added_mass_coefficient=across,
                            end_added_mass=(0.8, 0.0))  # fmt: skip
    column.stone = Ballast(density=2 * density, level=-10.0)
    sheet = model_sheet(fw.load(floating(column, density=density)).compile())
    mass, ball = density * 20 * area, 0.8 * density * 2 / 3 * math.pi * 125
    expected = {
        "mass": mass, "floater: mass": mass, "centre of mass z": -15.0, "weight": mass * gravity,
        "inertia zz": mass * 25 / 2, "inertia xx": mass * (25 / 4 + 100 / 12), "displaced volume": 20 * area,
        "centre of buoyancy z": -10.0, "C33": density * gravity * area,
        "C55": density * gravity * (math.pi * 5**4 / 4 - 200 * area),
        "A11(inf)": across * mass, "A15(inf)": -10 * across * mass, "A24(inf)": 10 * across * mass,
        "A55(inf)": across * mass * (100 + 400 / 12), "A33(inf)": ball,
        "period of heave": 2 * math.pi * math.sqrt((mass + ball) / (density * gravity * area)),
    }  # fmt: skip
    for quantity, value in expected.items():
        assert sheet[quantity] == pytest.approx(value, rel=2e-5), quantity


def test_added_mass_of_members_is_about_the_frame_whichever_way_they_run():
    """A box of 3 m by 2 m at y = 4 m, from x = 5 m to 20 m at z = -17 m, and a column with some at its end alone."""
    box = RectangularMember(start=(20, 4, -17), end=(5, 4, -17), widths=3.0, heights=2.0,
                            added_mass_coefficient=(0.8, 1.3))  # fmt: skip
    leaning = CircularMember(start=(0, 0, -10), end=(6, 0, -2), diameters=2.0, added_mass_coefficient=0.0,
                             end_added_mass=(0.0, 1.0))  # fmt: skip
    dry = CircularMember(start=(0, 0, 1), end=(0, 0, 9), diameters=2.0, added_mass_coefficient=1.0)
    (water,) = floating(box, dry).floater.member_loads.facts()
    side, lift, run = 0.8 * 6000, 1.3 * 6000, 20 - 5
    first, second = (20**2 - 5**2) / 2, (20**3 - 5**3) / 3  # integrals of x and x^2
    wanted = np.zeros((6, 6))
    wanted[1, 1], wanted[1, 3], wanted[1, 5] = side * run, 17 * side * run, side * first
    wanted[2, 2], wanted[2, 3], wanted[2, 4] = lift * run, 4 * lift * run, -lift * first
    wanted[3, 3], wanted[3, 4] = (17**2 * side + 4**2 * lift) * run, -4 * lift * first
    wanted[3, 5], wanted[4, 4], wanted[5, 5] = 17 * side * first, lift * second, side * second
    wanted = np.triu(wanted) + np.triu(wanted, 1).T
    assert water.matrix == pytest.approx(wanted, rel=1e-9, abs=1e-3)

    (water,) = floating(leaning).floater.member_loads.facts()
    along, ball = np.array([0.6, 0.0, 0.8]), 1000 * 2 / 3 * math.pi
    direction = np.array([*along, *np.cross((6.0, 0.0, -2.0), along)])
    assert water.matrix == pytest.approx(ball * np.outer(direction, direction), rel=1e-9, abs=1e-9)
    assert not floating(CircularMember(start=(0, 0, -9), end=(0, 0, 9), diameters=2.0)).floater.member_loads.facts()


def test_tensions_of_tendons_and_lines_with_legs_and_sections():
    """Of no weight, so that they are straight: a mass that is lifted off its tendon, and lines between fixed points."""
    stiffness, pull = 1e9, 1e7
    top = fw.Assembly("lines")
    top.world, top.support, top.motion = World(water_depth=200.0), Fixed(r=(0.0, 0.0, -50.0)), FreeMotion()
    top.body = RigidBody(mass=4e6, inertia=np.eye(3) * 1e9)
    top.lift, top.force = Constant(value=(0, 0, 4e7)), WorldForce()
    top.tendon = Tendon(length=150.0, axial_stiffness=stiffness, weight_per_length=0.0, pretension=1e6,
                        anchor_position=(0, 0, -150))  # fmt: skip
    leg, line = 50 / (1 + pull / stiffness), 800 / (1 + 1.6 * pull / stiffness)  # 3-4-5: the node is at x = 40 m
    top.delta = DeltaLine(fairleads=((0, 30, 0), (0, -30, 0)), leg_length=leg, length=line, weight_per_length=0.0,
                          axial_stiffness=stiffness, anchor_position=(840, 0, -50))  # fmt: skip
    soft = 300 + 500 * 2  # m of the first stiffness
    top.sections = SectionedLine(lengths=[300, 500], axial_stiffness=[stiffness, stiffness / 2],
                                 weight_per_length=0.0, anchor_position=(-820, 0, -50))  # fmt: skip
    top.connect(top.world.frame, top.motion.frame_a)
    top.connect(top.lift.y, top.force.force)
    for frame in (top.body.frame_a, top.force.frame, top.tendon.fairlead):
        top.connect(top.motion.frame_b, frame)
    for frame in (top.delta.frame, top.sections.fairlead):
        top.connect(top.support.frame, frame)
    sheet = model_sheet(fw.load(top).compile())
    assert sheet["mass"] == pytest.approx(4e6)
    for name in ("tendon.tension", "tendon.anchor_tension"):
        assert sheet[name] == pytest.approx(4e7 - 4e6 * 9.80665, rel=1e-5)
    for name in ("delta.delta.left_tension", "delta.delta.right_tension"):
        assert sheet[name] == pytest.approx(pull, rel=1e-5)
    assert sheet["delta.line.tension"] == pytest.approx(1.6 * pull, rel=1e-5)
    for name in ("sections.tension", "sections.anchor_tension"):
        assert sheet[name] == pytest.approx(20 * stiffness / soft, rel=1e-5)


def test_a_hull_that_does_not_stay_upright_has_all_but_its_response():
    """The mass of the hull raised by 30 m: the metacentric height is negative."""
    model = fw.load("oc3_spar_rigid", set={**STILL, "platform.hull.r_cm": [0, 0, -59.9], "platform.hull.mass": 7.4e6})
    plant = model.compile()
    with (pytest.warns(UserWarning, match="no response to waves: the state is unstable"),
          pytest.warns(UserWarning, match="cannot float upright.*without moorings, is -13.2 m")):  # fmt: skip
        sheet = model_sheet(plant)
    assert sheet["platform: mass"] == 7.4e6 and "C33" in sheet
    assert not any("per wave amplitude" in entry.quantity for entry in sheet)


def test_a_sheet_comes_back_from_its_file_and_meets_numbers_in_other_units(spar, tmp_path):
    again = Sheet.read(spar.save(tmp_path / "spar.csv"))
    assert again.rows() == spar.rows()
    assert all(d.first == d.second and d.percent == 0.0 for d in spar.against(again))
    (tmp_path / "report.csv").write_text("quantity, value, unit\nmass, 8000, t\nC44, -5.0, GN*m\nvalves, 3, 1\n")
    report = Sheet.read(tmp_path / "report.csv")
    first, second = spar.against(report)
    assert (first.quantity, first.unit, first.second) == ("mass", "kg", pytest.approx(8e6))
    assert first.percent == pytest.approx(0.8256) and second.percent == pytest.approx(0.016313, rel=1e-3)
    assert report.without(spar) == ["valves"] and len(spar.without(report)) == len(spar) - 2


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("name,number\nmass,1\n", "t.csv:1: a sheet needs the columns quantity and value"),
        ("quantity,value\nmass,much\n", "t.csv:2: the value 'much' is not a number."),
        ("quantity,value\nmass,inf\n", "t.csv:2: the value 'inf' is not a number."),
        ("quantity,value\nmass,1\nmass,2\n", "t.csv:3: 'mass' is there twice."),
    ],
)
def test_tables_that_are_no_sheet(tmp_path, text, says):
    (tmp_path / "t.csv").write_text(text)
    with pytest.raises(ModelError, match=says.replace("(", r"\(")):
        Sheet.read(tmp_path / "t.csv")


def test_what_a_sheet_does_not_know(spar, tmp_path):
    with pytest.raises(ModelError, match="has no 'C333'; did you mean 'C33'"):
        _ = spar["C333"]
    (tmp_path / "t.csv").write_text("quantity,value,unit\nmass,1,m\n")
    with pytest.raises(ModelError, match="t.csv: mass: .*length"):
        spar.against(Sheet.read(tmp_path / "t.csv"))
    with pytest.raises(ModelError, match="there is no file|cannot be read"):
        Sheet.read(tmp_path / "none.csv")
    with pytest.raises(ModelError, match="saved as .csv"):
        spar.save(tmp_path / "spar.txt")
