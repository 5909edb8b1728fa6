"""Units at the edge: conversion to SI, dimensions, messages, and what is imported when."""

from __future__ import annotations

import math
import subprocess
import sys
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fowtlib.language import Component, Scalar, var
from fowtlib.language.errors import UnitError
from fowtlib.language.unit_grammar import _COMMON, _SI, _from_pint, parse_unit
from fowtlib.language.units import check_si, dimension, dimension_text, from_si, kind_of, si_unit, to_si

DECLARED = ["1", "m", "m/s", "N*m", "N*m/rad", "kg*m^2", "rad/s", "N*s/m", "kg/m", "W", "Hz", "N/m", "Pa", "rad"]


@pytest.mark.parametrize(
    ("text", "unit", "value"),
    [
        ("12.1 rpm", "rad/s", 12.1 * 2 * math.pi / 60),
        ("853.87 m", "m", 853.87),
        ("6 deg", "rad", math.radians(6)),
        ("6°", "rad", math.radians(6)),
        ("7466.33 t", "kg", 7466330.0),
        ("-1.5e3 kN*m/deg", "N*m/rad", -1.5e6 * 180 / math.pi),
        ("98.3 MN m", "N*m", 98.3e6),
        ("98.3 MNm", "N*m", 98.3e6),
        ("10 knot", "m/s", 10 * 1852 / 3600),
        ("2 h", "s", 7200.0),
        ("94.4 %", "1", 0.944),
        ("0.944", "1", 0.944),
        ("12", "rad/s", 12.0),
        ("8 deg/s", "rad/s", math.radians(8)),
        ("3 m s^-2", "m/s^2", 3.0),
        ("3 kg/(m s**2)", "Pa", 3.0),
        ("2 m^0.5", "m^0.5", 2.0),
        ("+.5 m", "m", 0.5),
        ("inf", "m", math.inf),
    ],
)
def test_text_becomes_si(text, unit, value):
    assert to_si(text, unit) == pytest.approx(value, rel=1e-14)


@pytest.mark.parametrize(
    ("text", "unit", "value"),
    [
        ("0.25 Hz", "rad/s", math.pi / 2),
        ("12 rpm", "Hz", 0.2),
        ("1 m^2/Hz", "m^2*s/rad", 1 / (2 * math.pi)),
        ("0.25 Hz", "1/s", 0.25),
        ("3 1/s", "rad/s", 3.0),
        ("5 N*m", "N*m/rad", 5.0),
        ("0.25 kHz", "Hz", 250.0),
        ("3 cycle/s", "Hz", 3.0),
    ],
)
def test_cycles_become_radians(text, unit, value):
    assert to_si(text, unit) == pytest.approx(value, rel=1e-14)


def test_numbers_and_sequences():
    assert to_si(3, "m") == 3.0
    assert isinstance(to_si(np.float32(3), "m"), float)
    np.testing.assert_array_equal(to_si([0, "1 km", 2.5], "m"), [0, 1000, 2.5])
    np.testing.assert_array_equal(to_si(((0, "1 t"), (2, 3)), "kg"), [[0, 1000], [2, 3]])
    np.testing.assert_array_equal(to_si(np.arange(3), "m"), [0.0, 1.0, 2.0])
    assert to_si([], "m").shape == (0,)


@given(st.floats(-1e12, 1e12, allow_nan=False), st.sampled_from(["rpm", "deg/s", "Hz", "rad/s", "rpm"]))
def test_there_and_back(value, unit):
    text = f"{value!r} {unit}"
    assert from_si(to_si(text, "rad/s"), "rad/s", unit) == pytest.approx(value, rel=1e-12, abs=1e-300)


def test_from_si():
    np.testing.assert_allclose(from_si(np.array([0, math.pi]), "rad", "deg"), [0, 180])
    assert from_si(5e6, "W", "kW") == pytest.approx(5000)
    with pytest.raises(UnitError) as error:
        from_si(1.0, "rad/s", "deg", where="speed")
    assert str(error.value) == "speed: a rotational speed in rad/s cannot be given in 'deg', the unit of an angle."


@pytest.mark.parametrize(
    ("value", "unit", "message"),
    [
        ("3 kg", "rad/s", "rated_speed: got '3 kg', which is a mass; "
         "a rotational speed in rad/s is expected, e.g. '12.1 rpm'."),
        ("3 rpm", "m/s", "rated_speed: got '3 rpm', which is a rotational speed; "
         "a speed in m/s is expected, e.g. '11.4 m/s'."),
        ("3 Hz", "m", "rated_speed: got '3 Hz', which is a frequency; a length in m is expected, e.g. '853.87 m'."),
        ("3 m", "1", "rated_speed: got '3 m', which is a length; a number without a unit is expected, e.g. 0.5."),
        ("3 kg/s", "N*m*s/rad", "rated_speed: got '3 kg/s', which is a damping; "
         "a quantity in N*m*s/rad is expected, e.g. '3.5 N*m*s/rad'."),
        ("12 rmp", "rad/s", "rated_speed: got '12 rmp'; unknown unit 'rmp'; did you mean 'rpm'?"),
        ("12 RPM", "rad/s", "rated_speed: got '12 RPM'; unknown unit 'RPM'; did you mean 'rpm'?"),
        ("12 kg/m3", "kg/m^3", "rated_speed: got '12 kg/m3'; unknown unit 'm3'; did you mean 'm^3'?"),
        ("12 metre/secnd", "m/s", "rated_speed: got '12 metre/secnd'; unknown unit 'secnd'; did you mean 'second'?"),
        ("12 qqqqq", "m", "rated_speed: got '12 qqqqq'; unknown unit 'qqqqq'; "
         "write units such as 'm', 'kN*m', 'deg', 'rpm' or 'm/s'."),
        ("12 m/", "m", "rated_speed: got '12 m/'; 'm/' is not a unit: a name of a unit is missing at the end."),
        ("12 (m", "m", "rated_speed: got '12 (m'; '(m' is not a unit: a parenthesis is not closed."),
        ("12 m^x", "m", "rated_speed: got '12 m^x'; 'm^x' is not a unit: "
         "an exponent is a small number, as in 'm^2' or 's^-1'."),
        ("12 m; s", "m", "rated_speed: got '12 m; s'; 'm; s' is not a unit: ';' has no meaning here."),
        ("20 degC", "K", "rated_speed: got '20 degC'; the unit 'degC' does not count from zero; "
         "give the value in SI (K for a temperature)."),
        ("fast", "rad/s", "rated_speed: got 'fast'; a rotational speed in rad/s is expected, e.g. '12.1 rpm'."),
        (True, "m", "rated_speed: got True; a length in m is expected, e.g. '853.87 m'."),
        (None, "m", "rated_speed: got None; a length in m is expected, e.g. '853.87 m'."),
        ({"a": 1}, "m", "rated_speed: got {'a': 1}; a length in m is expected, e.g. '853.87 m'."),
        ([[1, 2], [3]], "m", "rated_speed: got [[1, 2], [3]], whose rows do not have the same length."),
    ],
)  # fmt: skip
def test_messages(value, unit, message):
    with pytest.raises(UnitError) as error:
        to_si(value, unit, where="rated_speed")
    assert str(error.value) == message


@pytest.mark.parametrize(
    ("text", "unit", "meanings"),
    [
        ("350 ton", "kg", "'ton' is ambiguous (1000 kg, 907 kg or 1016 kg); write 't', 'short_ton' or 'long_ton'."),
        ("350 tons", "kg", "'tons' is ambiguous"),
        ("0.35 kton", "kg", "'kton' is ambiguous"),
        ("35 ton*m^2", "kg*m^2", "'ton' is ambiguous"),
        ("350 mt", "kg", "'mt' is ambiguous (a metric ton or a thousandth of one)"),
        ("5000 dwt", "kg", "'dwt' is ambiguous"),
        ("120 tonf", "N", "'tonf' is ambiguous"),
        ("120 ton_force", "N", "'ton_force' is ambiguous"),
        ("3 miles", "m", "'miles' is ambiguous (1609 m or 1852 m); write 'nmi'"),
        ("3 nm", "m", "'nm' is ambiguous (a nautical mile or a nanometre)"),
        ("20 fm", "m", "'fm' is ambiguous"),
        ("900 gal", "m^3", "'gal' is ambiguous (3.785 or 4.546 litres)"),
        ("900 gal/min", "m^3/s", "'gal' is ambiguous"),
        ("2 bbl", "m^3", "'bbl' is ambiguous"),
        ("3 pints", "m^3", "'pints' is ambiguous"),
        ("7000 hp", "W", "'hp' is ambiguous (735.5 W or 745.7 W); write 'kW'"),
        ("2 cps", "rad/s", "'cps' is ambiguous"),
    ],
)
def test_a_name_with_two_sizes_is_refused(text, unit, meanings):
    with pytest.raises(UnitError) as error:
        to_si(text, unit, where="mass")
    assert str(error.value).startswith(f"mass: got '{text}'; {meanings}")
    with pytest.raises(UnitError, match="is ambiguous"):
        from_si(1.0, unit, text.partition(" ")[2])


@pytest.mark.parametrize(
    ("text", "unit", "value"),
    [
        ("350 t", "kg", 350e3),
        ("350 tonnes", "kg", 350e3),
        ("1 short_ton", "kg", 907.18474),
        ("1 long_ton", "kg", 1016.0469088),
        ("2 tf", "N", 2 * 9806.65),
        ("3 nmi", "m", 5556.0),
        ("1 fathom", "m", 1.8288),
        ("1 US_liquid_gallon", "m^3", 3.785411784e-3),
        ("1 imperial_gallon", "m^3", 4.54609e-3),
        ("1 oil_barrel", "m^3", 0.158987294928),
        ("1 imperial_barrel", "m^3", 0.16365924),
        ("1 metric_horsepower", "W", 735.49875),
        ("10 lb", "kg", 4.5359237),
        ("2 kt", "m/s", 2 * 1852 / 3600),
    ],
)
def test_the_names_that_are_proposed_instead(text, unit, value):
    assert to_si(text, unit) == pytest.approx(value, rel=3e-6)  # a fathom is one of the survey in pint


def test_declared_units_are_si():
    for unit in DECLARED:
        check_si(unit)
    with pytest.raises(UnitError) as error:
        check_si("deg", where="Joint.phi")
    assert str(error.value) == (
        "Joint.phi: the declared unit 'deg' is not SI; declare the SI unit and let the user write deg."
    )


def test_dimension():
    assert dimension("rad") == dimension("deg") == dimension("1") == (0,) * 7
    assert dimension("N*m") == dimension("J") == (2, 1, -2, 0, 0, 0, 0)
    assert dimension("m^0.5") == (Fraction(1, 2), 0, 0, 0, 0, 0, 0)
    assert hash(dimension("knot")) == hash(dimension("m/s"))
    assert dimension_text(dimension("N")) == "m*kg/s^2"
    assert dimension_text(dimension("m^1.5/s")) == "m^1.5/s"
    assert dimension_text(dimension("1")) == "1"
    assert kind_of("t") == "a mass"
    assert kind_of("rpm") == "a rotational speed"


@pytest.mark.parametrize("name", sorted({*_SI, *_COMMON} - {"Nm", "kNm", "MNm", "°", "%", "sr"}))
def test_known_names_agree_with_pint(name):
    known, other = parse_unit(name), _from_pint(name)
    assert known.factor == pytest.approx(other.factor, rel=1e-12)
    assert (known.dimension, known.angle, known.cycle) == (other.dimension, other.angle, other.cycle)


def test_pint_is_not_imported_for_declared_units():
    code = (
        "import sys; from fowtlib.language.units import to_si, dimension\n"
        f"for unit in {DECLARED!r}: dimension(unit), to_si(1.0, unit), to_si('1 ' + unit, unit)\n"
        "to_si('12.1 rpm', 'rad/s'), to_si('7466.33 t', 'kg')\n"
        "assert 'pint' not in sys.modules"
    )
    subprocess.run([sys.executable, "-c", code], check=True)


@settings(deadline=None)  # the first unknown word imports pint
@given(st.text(max_size=30), st.sampled_from(DECLARED))
def test_no_text_raises_anything_but_a_unit_error(text, unit):
    for candidate in (text, f"1 {text}"):
        try:
            to_si(candidate, unit)
        except UnitError as error:
            assert str(error)


@pytest.mark.parametrize(
    ("unit", "si"),
    [("rpm", "rad/s"), ("deg", "rad"), ("kN*m", "N*m"), ("t", "kg"), ("m", "m"), ("kN/mm", "N/m"), ("kHz", "Hz"),
     ("N*m/deg", "m^2*kg/s^2*rad^-1"), ("t*m/deg", "m*kg*rad^-1"), ("m^2/kHz", "m^2*Hz^-1"), ("%", "1")],
)  # fmt: skip
def test_si_unit(unit, si):
    assert si_unit(unit) == si
    assert parse_unit(si).factor == 1.0
    assert to_si(f"1 {unit}", si) == pytest.approx(parse_unit(unit).factor)


def test_a_declaration_with_a_wrong_unit_is_named():
    with pytest.raises(UnitError, match=r"Drum\.speed: 'm//s' is not a unit: a name of a unit is missing before '/'\."):

        class Drum(Component):
            """A declaration that says no unit."""

            speed: Scalar = var(unit="m//s", doc="speed")

    for unit in ("deg", "rpm", "kN m"):  # equations would take its numbers for SI
        with pytest.raises(UnitError, match=rf"Drum\.angle: the declared unit '{unit}' is not SI; declare the SI"):

            class Drum(Component):
                """A declaration in a unit that is not SI."""

                angle: Scalar = var(unit=unit, doc="angle")
