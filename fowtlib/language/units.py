"""Units at the edge: inside, every number is in SI; a quantity with another unit is a string such as "12.1 rpm".

Declared units are products of SI units: "1", "m", "rad/s", "N*m/rad", "kg*m^2" (grammar: unit_grammar.py).

An angle has no dimension, but it is counted, and so is a cycle, because the SI alone would take 0.25 Hz for 0.25 rad/s:
where one side of a conversion counts cycles and the other radians, a cycle is 2 pi radians. So "0.25 Hz" is
1.571 rad/s, "12 rpm" is 0.2 Hz, and "1 m^2/Hz" is 0.159 m^2*s/rad.
"""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from dataclasses import replace
from fractions import Fraction
from functools import cache
from numbers import Real
from typing import Any

import numpy as np

from fowtlib.language.errors import UnitError
from fowtlib.language.unit_grammar import BASE, Dimension, Unit, parse_unit

# What a quantity is called, and an example of it as a person writes it, by its SI unit.
_KINDS = {
    "1": ("a number without a unit", "0.5"), "rad": ("an angle", "6 deg"), "m": ("a length", "853.87 m"),
    "m^2": ("an area", "12 m^2"), "m^3": ("a volume", "8029 m^3"), "kg": ("a mass", "7466.33 t"),
    "s": ("a time", "12.5 s"), "m/s": ("a speed", "11.4 m/s"), "m/s^2": ("an acceleration", "9.81 m/s^2"),
    "rad/s": ("a rotational speed", "12.1 rpm"), "rad/s^2": ("a rotational acceleration", "2 deg/s^2"),
    "Hz": ("a frequency", "0.25 Hz"), "N": ("a force", "1200 kN"), "N*m": ("a torque or an energy", "43.1 kN*m"),
    "Pa": ("a pressure", "210 GPa"), "W": ("a power", "5 MW"), "K": ("a temperature", "288 K"),
    "kg/m": ("a mass per length", "77.7 kg/m"), "kg/m^3": ("a density", "1025 kg/m^3"),
    "kg*m^2": ("a moment of inertia", "534.1 kg*m^2"), "N/m": ("a stiffness", "41.2 kN/m"),
    "N*s/m": ("a damping", "100 kN*s/m"),
}  # fmt: skip

_NUMBER = r"[+-]?(?:\d+(?:\.\d*)?|\.\d+)(?:[eE][+-]?\d+)?"
_QUANTITY = re.compile(rf"\s*({_NUMBER}|[+-]?inf\b)(?![\d.])\s*(.*?)\s*$", re.DOTALL)


def to_si(value: Any, unit: str, where: str = "") -> float | np.ndarray:
    """`value` in the SI unit `unit`.

    value: a number (taken as it is), a string "12.1 rpm", or a sequence of those (also nested); a string without a
        unit is a number. Sequences become arrays of floats.
    unit: the declared unit, a product of SI units.
    where: the path of the parameter, put in front of the message of an error.
    Raises UnitError: not a quantity, an unknown unit, or the wrong dimension.
    """
    try:
        return _to_si(value, unit)
    except UnitError as error:
        error.at(where)
        raise


def from_si(value: Any, unit: str, unit_out: str, where: str = "") -> Any:
    """`value`, a number or an array in the SI unit `unit`, expressed in `unit_out` ("deg", "rpm", "kW")."""
    try:
        if dimension(unit_out) != dimension(unit):
            raise UnitError(f"{_quantity(unit)} cannot be given in '{unit_out}', the unit of {kind_of(unit_out)}.")
        return value if unit == unit_out else value * _factor(unit, unit_out)
    except UnitError as error:
        error.at(where)
        raise


def conversion(one: Unit, out: Unit) -> float:
    """What a number in the unit `one` is multiplied with to be one in `out`; their dimensions must agree."""
    cycles = one.cycle - out.cycle  # cycles that become radians, or the reverse
    turned = cycles if cycles == out.angle - one.angle else Fraction(0)
    return one.factor / out.factor * (2 * math.pi) ** float(turned)


def quantity(text: str) -> tuple[float, str] | None:
    """The number and the unit ("" if there is none) of a text like "12.1 rpm"; None if it does not look like one."""
    match = _QUANTITY.match(text)
    return (float(match[1]), match[2]) if match else None


def si_unit(unit: str) -> str:
    """The SI unit for quantities given in `unit`: `rad/s` for `rpm`, `N*m` for `kN*m`; an SI unit stays as it is."""
    given = parse_unit(unit)
    return unit if given.factor == 1.0 else unit_text(given)


def unit_text(unit: Unit) -> str:
    """The text of the SI unit of a parsed one."""
    for known in (*_KINDS, "1/s"):
        if parse_unit(known) == replace(unit, factor=1.0):
            return known
    counted = {"rad": unit.angle, "Hz": unit.cycle}
    rest = (Unit(1.0, unit.dimension) * parse_unit("s") ** unit.cycle).dimension  # Hz stands for the cycles
    return "*".join([dimension_text(rest), *(_power(name, power) for name, power in counted.items() if power)])


def dimension(unit: str) -> Dimension:
    """The exponents of (m, kg, s, A, K, mol, cd); an angle has none, so "rad", "deg" and "1" are the same."""
    return parse_unit(unit).dimension


def dimension_text(exponents: Sequence[Fraction | int | float]) -> str:
    """A dimension as a unit: `kg*m/s^2`, `1` where there is none."""
    powers = [(name, Fraction(e).limit_denominator(1000)) for name, e in zip(BASE, exponents, strict=True) if e]
    above = "*".join(_power(name, e) for name, e in powers if e > 0) or "1"
    below = "".join("/" + _power(name, -e) for name, e in powers if e < 0)
    return above + below


def kind_of(unit: str | Unit) -> str:
    """What a quantity of this unit is called: "a mass", "a rotational speed"."""
    return _kind(parse_unit(unit) if isinstance(unit, str) else unit)


def expected(unit: str) -> str:
    """What a message says about the value that a declaration asks for, with an example."""
    example = _KINDS[unit][1] if unit in _KINDS else f"3.5 {unit}"
    return f"{_quantity(unit)} is expected, e.g. {example if unit == '1' else repr(example)}"


def check_si(unit: str, where: str = "") -> None:
    """Refuse a declared unit that is unknown or no product of SI units ("deg", "rpm", "kN")."""
    try:
        if parse_unit(unit).factor != 1.0:
            raise UnitError(f"the declared unit '{unit}' is not SI; declare the SI unit and let the user write {unit}.")
    except UnitError as error:
        error.at(where)
        raise


def _to_si(value: Any, unit: str) -> float | np.ndarray:
    if isinstance(value, str):
        return _from_text(value, unit)
    if isinstance(value, (bool, np.bool_)) or value is None:
        raise UnitError(f"got {value!r}; {expected(unit)}.")
    if isinstance(value, (Real, np.number)):
        return float(value)
    if isinstance(value, np.ndarray) and value.dtype.kind in "iuf":
        return value.astype(float)
    if isinstance(value, (Sequence, np.ndarray)):
        items = [_to_si(item, unit) for item in value]
        if len({np.shape(item) for item in items}) > 1:
            raise UnitError(f"got {_short(value)}, whose rows do not have the same length.")
        return np.array(items, dtype=float)
    try:
        return float(value)
    except (TypeError, ValueError):
        raise UnitError(f"got {_short(value)}; {expected(unit)}.") from None


def _from_text(text: str, unit: str) -> float:
    found = quantity(text)
    if found is None:
        raise UnitError(f"got '{text}'; {expected(unit)}.")
    number, name = found
    if not name:
        return number
    try:
        given = parse_unit(name)
    except UnitError as error:
        raise UnitError(f"got '{text}'; {error.message}") from None
    if given.dimension != parse_unit(unit).dimension:
        raise UnitError(f"got '{text}', which is {_kind(given)}; {expected(unit)}.")
    return number * _factor(name, unit)


def _quantity(unit: str) -> str:
    kind = _KINDS[unit][0] if unit in _KINDS else "a quantity"
    return kind if unit == "1" else f"{kind} in {unit}"


@cache
def _factor(unit: str, unit_out: str) -> float:
    return conversion(parse_unit(unit), parse_unit(unit_out))


def _kind(unit: Unit) -> str:
    """What a quantity of this unit is called, or its dimension."""
    same = [(kind, known) for known, (kind, _) in _KINDS.items() if parse_unit(known).dimension == unit.dimension]
    for kind, known in same:
        if (parse_unit(known).angle, parse_unit(known).cycle) == (unit.angle, unit.cycle):
            return kind
    return same[0][0] if same else f"a quantity in {dimension_text(unit.dimension)}"


def _power(name: str, exponent: Fraction) -> str:
    if exponent == 1:
        return name
    return f"{name}^{exponent}" if exponent.denominator == 1 else f"{name}^{float(exponent):g}"


def _short(value: Any) -> str:
    text = repr(value)
    return text if len(text) <= 60 else text[:57] + "..."
