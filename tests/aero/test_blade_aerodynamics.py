"""Blades and airfoils: the shipped ones, and the messages for bad ones."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.interpolate import PchipInterpolator

from fowtlib.components.aero import Airfoil, read_airfoils, read_blade
from fowtlib.components.aero.monotone_cubics import monotone_cubics
from fowtlib.language.errors import ParameterError

ANGLES = np.radians([-180, -90, 0, 90, 180])
FLAT = np.zeros((5, 3))
AIRFOIL_HEAD = "airfoil,angle_of_attack_deg,lift_coefficient,drag_coefficient,moment_coefficient"
BLADE_HEAD = "span_m,length_m,chord_m,twist_deg,curve_m,sweep_m,airfoil"


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
        (ANGLES, np.linspace([0, 0, 0], [0, 1, 0], 5), "one angle, and their drag coefficients are 0 and 1; make them"),
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
        ({"chord": -blade.chord}, "the chord of an element must be positive, and at 2.8667 m it is -3.542 m"),
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
    path = tmp_path / "columns.csv"
    path.write_text("span,chord\n1,2\n")
    with pytest.raises(ParameterError, match="the columns span_m, .* are needed"):
        read_blade(str(path), "", 1.5, 63.0)


def message_of(function, *arguments):
    with pytest.raises(ParameterError) as caught:
        function(*arguments)
    return str(caught.value)


@pytest.mark.parametrize(
    ("rows", "line", "message"),
    [
        (["-180,0,0,0", "0,0,0,0", "170,0,0,0"], 5,
         "airfoil a: the angles of attack must span -180 deg to 180 deg, and these span -180 deg to 170 deg; continue "
         "the polar, by the method of Viterna and Corrigan for instance."),
        (["-90,0,0,0", "0,0,0,0", "180,0,0,0"], 3,
         "airfoil a: the angles of attack must span -180 deg to 180 deg, and these span -90 deg to 180 deg; continue "
         "the polar, by the method of Viterna and Corrigan for instance."),
        (["-180,0.5,0,0", "0,0,0,0", "180,-0.5,0,0"], 5,
         "airfoil a: -180 deg and 180 deg are one angle, and their lift coefficients are 0.5 and -0.5; make them the "
         "same."),
        (["-180,0,0,0", "10,0,0,0", "5,0,0,0", "180,0,0,0"], 5,
         "airfoil a: the angles must increase; 10 deg is followed by 5 deg."),
        (["-180,0,0,0", "0,0,0,0", "0,1,0,0", "180,0,0,0"], 5,
         "airfoil a: the angles must increase; 0 deg is followed by 0 deg."),
        (["-180,0,0,0", "0,nan,0,0", "180,0,0,0"], 4, "airfoil a: angles and coefficients must be finite numbers."),
        (["-180,0,0,0", "180,0,0,0"], 3,
         "airfoil a: 3 angles or more, and lift, drag and moment at each, make an airfoil."),
        (["-180,zero,0,0"], 3, f"'a,-180,zero,0,0' is not a row of {AIRFOIL_HEAD.replace(',', ', ')}."),
        (["-180,0,0"], 3, f"'a,-180,0,0' is not a row of {AIRFOIL_HEAD.replace(',', ', ')}."),
    ],
)  # fmt: skip
def test_a_file_of_airfoils_is_told_its_line(tmp_path, rows, line, message):
    path = tmp_path / "airfoils.csv"
    path.write_text("\n".join(["# mine", AIRFOIL_HEAD, *(f"a,{row}" for row in rows)]) + "\n")
    assert message_of(read_airfoils, str(path)) == f"{path}:{line}: {message}"


@pytest.mark.parametrize(
    ("rows", "line", "message"),
    [
        (["10,4,2,5,0,0,plate", "8,4,2,5,0,0,plate"], 4,
         "the elements must go outward; 12 m is followed by 10 m."),
        (["2,4,-3,5,0,0,plate", "6,4,2,5,0,0,plate"], 3,
         "the chord of an element must be positive, and at 4 m it is -3 m."),
        (["2,4,3,5,0,0,plate", "6,0,2,5,0,0,plate"], 4,
         "the length of an element must be positive, and at 8 m it is 0 m."),
        (["2,4,3,5,0,0,plate", "6,4,2,5,0,0,flat"], 4, "there is no airfoil 'flat'; did you mean 'plate'?"),
        (["2,4,3,5,0,0,plate", "6,4,inf,5,0,0,plate"], 4, "chord must be 2 finite numbers, one for each element."),
        (["-1,4,3,5,0,0,plate", "6,4,3,5,0,0,plate"], 3,
         "the elements lie from 1 m to 8 m, which must be inside of the hub radius 2 m and the tip radius 10 m."),
        (["2,4,3,5,0,0,plate", "8,4,3,5,0,0,plate"], 4,
         "the elements lie from 4 m to 10 m, which must be inside of the hub radius 2 m and the tip radius 10 m."),
        (["2,4,3,5,0,0,plate", "6,x,3,5,0,0,plate"], 4,
         f"'6,x,3,5,0,0,plate' is not a row of {BLADE_HEAD.replace(',', ', ')}."),
    ],
)  # fmt: skip
def test_a_file_of_a_blade_is_told_its_line(tmp_path, rows, line, message):
    airfoils, path = tmp_path / "airfoils.csv", tmp_path / "blade.csv"
    airfoils.write_text("\n".join([AIRFOIL_HEAD, *(f"plate,{a},0,1,0" for a in (-180, 0, 180))]))
    path.write_text("\n".join(["# mine", BLADE_HEAD, *rows]))
    assert message_of(read_blade, str(path), str(airfoils), 2.0, 10.0) == f"{path}:{line}: {message}"


def test_a_blade_of_the_wrong_length_is_told_its_file(tmp_path):
    airfoils, path = tmp_path / "airfoils.csv", tmp_path / "blade.csv"
    airfoils.write_text("\n".join([AIRFOIL_HEAD, *(f"plate,{a},0,1,0" for a in (-180, 0, 180))]))
    path.write_text("\n".join([BLADE_HEAD, "2,4,3,5,0,0,plate", "6,2,3,5,0,0,plate"]))
    message = "the elements are 6 m long together, and the blade is 8 m."
    assert message_of(read_blade, str(path), str(airfoils), 2.0, 10.0) == f"{path}: {message}"


def test_monotone_cubics_are_those_of_scipy():
    """Own code for what every polar needs, since the import of SciPy's takes longer: the same to the last bit."""
    rng = np.random.default_rng(4)
    for count in (3, 4, 17, 150):
        x = np.cumsum(rng.uniform(0.01, 1.0, count))
        for y in (rng.normal(size=(count, 3)), np.round(rng.normal(size=(count, 2)), 1), np.zeros((count, 1))):
            known = np.moveaxis(PchipInterpolator(x, y, axis=0).c[::-1], 0, -1)
            np.testing.assert_array_equal(monotone_cubics(x, y), known)
