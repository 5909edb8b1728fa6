"""The sheet of a model: masses by hand, a floating body of published numbers, and tables of other programs."""

from __future__ import annotations

import numpy as np
import pytest

import fowtlib as fw
from fowtlib.analysis import Sheet, model_sheet
from fowtlib.components.environment import World
from fowtlib.components.mechanics import AxialWire, Fixed, FixedRotation, FixedTranslation, PointMass, RigidBody
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
