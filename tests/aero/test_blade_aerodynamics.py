"""Blades and airfoils: the shipped ones, and the messages for bad ones."""

from dataclasses import replace

import numpy as np
import pytest

from fowtlib.components.aero import Airfoil, read_airfoils, read_blade
from fowtlib.language.errors import ParameterError

ANGLES = np.radians([-180, -90, 0, 90, 180])
FLAT = np.zeros((5, 3))


def test_shipped_blade(blade):
    assert len(blade.radius) == 17
    assert blade.length.sum() == pytest.approx(61.5, abs=1e-3)
    assert set(blade.airfoil) == set(blade.airfoils)
    assert blade.radius[0] == pytest.approx(2.8667)
    foil = blade.airfoils["NACA64_A17"]
    assert np.degrees(foil.angle[[0, -1]]) == pytest.approx([-180, 180])
    assert foil.cubics[:, :, 0] == pytest.approx(foil.coefficients[:-1])


def test_straight_lines_between_the_angles():
    lines = Airfoil("plate", ANGLES, np.outer([0, -1, 0, 1, 0], [1, 1, 1]), smooth=False).cubics
    assert lines[2, 0] == pytest.approx([0, 2 / np.pi, 0, 0])


def test_lengths_fill_the_blade(blade):
    filled = replace(blade, length=None)
    assert filled.length.sum() == pytest.approx(61.5)


@pytest.mark.parametrize(
    ("angles", "values", "message"),
    [
        (np.radians([-20, 0, 20]), np.zeros((3, 3)), "must span -180 deg to 180 deg, and these span -20 deg to 20 deg"),
        (ANGLES[[0, 2, 1, 3, 4]], FLAT, "must increase; 0 deg is followed by -90 deg"),
        (ANGLES, np.full((5, 3), np.nan), "must be finite"),
        (ANGLES, FLAT[:3], "lift, drag and moment at each"),
        (ANGLES, np.linspace([0, 0, 0], [1, 0, 0], 5), "are one angle, and their coefficients differ"),
    ],
)
def test_an_airfoil_that_cannot_be_used(angles, values, message):
    with pytest.raises(ParameterError, match=message):
        Airfoil("mine", angles, values)


def test_a_blade_that_cannot_be_used(blade):
    r = blade.radius.copy()
    r[[3, 4]] = r[[4, 3]]
    for change, message in (
        ({"radius": r}, "must go outward; 15.85 m is followed by 11.75 m"),
        ({"tip_radius": 60.0}, "inside of the hub radius 1.5 m and the tip radius 60 m"),
        ({"chord": -blade.chord}, "chord and length of every element must be positive"),
        ({"chord": blade.chord[:3]}, "chord must be 17 finite numbers"),
        ({"length": 2 * blade.length}, "the elements are 123 m long together, and the blade is 61.5 m"),
        ({"airfoil": ["NACA63_A17"] * 17}, "there is no airfoil 'NACA63_A17'; did you mean 'NACA64_A17'?"),
        ({"airfoil": ["NACA64_A17"]}, "17 elements and 1 names"),
    ):
        with pytest.raises(ParameterError, match=message.replace("?", r"\?")):
            replace(blade, **change)


def test_files_that_cannot_be_read(tmp_path):
    with pytest.raises(ParameterError, match="cannot read"):
        read_airfoils(str(tmp_path / "missing.csv"))
    head = "airfoil,angle_of_attack_deg,lift_coefficient,drag_coefficient,moment_coefficient\n"
    path = tmp_path / "short.csv"
    path.write_text(head + "a,-10,0,0,0\na,0,0,0,0\na,10,0,0,0\n")
    with pytest.raises(ParameterError, match="short.csv: airfoil a: the angles of attack must span"):
        read_airfoils(str(path))
    path = tmp_path / "word.csv"
    path.write_text(head + "a,-180,zero,0,0\n")
    with pytest.raises(ParameterError, match="word.csv:2: 'a,-180,zero,0,0' is not a row"):
        read_airfoils(str(path))
    path = tmp_path / "columns.csv"
    path.write_text("span,chord\n1,2\n")
    with pytest.raises(ParameterError, match="the columns span_m, .* are needed"):
        read_blade(str(path), "", 1.5, 63.0)
