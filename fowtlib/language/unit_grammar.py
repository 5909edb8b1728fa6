"""The grammar of units: a text such as "kN*m/rad" -> a `Unit`, a multiple of SI with counted angles and cycles.

Names are joined by `*`, `/` (left to right) or a space, with `^` and parentheses. The names below are known here; any
other name is looked up in pint, which takes half a second to import and is imported only then.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from fractions import Fraction
from functools import cache
from typing import Any

from fowtlib.language.errors import UnitError, closest, one_of

Dimension = tuple[Fraction, ...]
BASE = ("m", "kg", "s", "A", "K", "mol", "cd")
NONE: Dimension = (Fraction(0),) * len(BASE)


@dataclass(frozen=True)
class Unit:
    """A unit as a multiple of SI: the exponents of BASE, and how often an angle and a cycle are counted."""

    factor: float = 1.0
    dimension: Dimension = NONE
    angle: Fraction = Fraction(0)
    cycle: Fraction = Fraction(0)

    def __mul__(self, other: Unit) -> Unit:
        dimension = tuple(a + b for a, b in zip(self.dimension, other.dimension, strict=True))
        return Unit(self.factor * other.factor, dimension, self.angle + other.angle, self.cycle + other.cycle)

    def __pow__(self, exponent: Fraction) -> Unit:
        power = int(exponent) if exponent.denominator == 1 else float(exponent)
        dimension = tuple(a * exponent for a in self.dimension)
        return Unit(self.factor**power, dimension, self.angle * exponent, self.cycle * exponent)


def _si(m: int = 0, kg: int = 0, s: int = 0, A: int = 0, K: int = 0, mol: int = 0, cd: int = 0) -> Unit:
    return Unit(1.0, tuple(Fraction(e) for e in (m, kg, s, A, K, mol, cd)))


_RAD = Unit(angle=Fraction(1))
_HZ = Unit(1.0, _si(s=-1).dimension, cycle=Fraction(1))
_SI = {
    "m": _si(1), "kg": _si(0, 1), "s": _si(0, 0, 1), "A": _si(A=1), "K": _si(K=1), "mol": _si(mol=1), "cd": _si(cd=1),
    "rad": _RAD, "sr": Unit(), "Hz": _HZ, "N": _si(1, 1, -2), "Pa": _si(-1, 1, -2), "J": _si(2, 1, -2),
    "W": _si(2, 1, -3), "C": _si(s=1, A=1), "V": _si(2, 1, -3, -1), "F": _si(-2, -1, 4, 2), "ohm": _si(2, 1, -3, -2),
    "S": _si(-2, -1, 3, 2), "Wb": _si(2, 1, -2, -1), "T": _si(0, 1, -2, -1), "H": _si(2, 1, -2, -2),
}  # fmt: skip


def _scaled(factor: float, name: str) -> Unit:
    return Unit(factor) * _SI[name]


_TORQUE = _SI["N"] * _SI["m"]
_COMMON = {
    "deg": _scaled(math.pi / 180, "rad"), "°": _scaled(math.pi / 180, "rad"), "%": Unit(0.01),
    "rpm": Unit(2 * math.pi / 60) * _RAD * _si(s=-1),
    "km": _scaled(1e3, "m"), "cm": _scaled(1e-2, "m"), "mm": _scaled(1e-3, "m"), "t": _scaled(1e3, "kg"),
    "g": _scaled(1e-3, "kg"), "min": _scaled(60.0, "s"), "h": _scaled(3600.0, "s"), "ms": _scaled(1e-3, "s"),
    "kN": _scaled(1e3, "N"), "MN": _scaled(1e6, "N"), "kPa": _scaled(1e3, "Pa"), "MPa": _scaled(1e6, "Pa"),
    "GPa": _scaled(1e9, "Pa"), "kW": _scaled(1e3, "W"), "MW": _scaled(1e6, "W"), "kJ": _scaled(1e3, "J"),
    "Nm": _TORQUE, "kNm": Unit(1e3) * _TORQUE, "MNm": Unit(1e6) * _TORQUE,
}  # fmt: skip

# Names that stand for two sizes of one kind of quantity, so that no check of the dimension would find a mistake: as a
# pattern of the name, what they may mean, and how each meaning is written. ("lb" and "kt" are not among them: where
# the other meaning of those is meant, a force or a mass, the dimension is wrong.)
_AMBIGUOUS = (
    (r"(k|kilo|M|mega|m)?tons?", "1000 kg, 907 kg or 1016 kg", "'t', 'short_ton' or 'long_ton'"),
    (r"mts?", "a metric ton or a thousandth of one", "'t' or 'kg'"),
    (r"k?(tonf|tons?_force|force_tons?)", "the weight of 1000 kg, 907 kg or 1016 kg", "'kN' or 'tf' (of 1000 kg)"),
    (r"dwt", "a deadweight tonnage or a pennyweight", "'t' or 'kg'"),
    (r"cwts?|hundredweights?", "100 lb or 112 lb", "'kg' or 'lb'"),
    (r"miles?|mi", "1609 m or 1852 m", "'nmi' for the nautical one, or 'km'"),
    (r"nms?", "a nautical mile or a nanometre", "'nmi' or 'm'; a torque is in 'Nm'"),
    (r"fms?", "a fathom or a femtometre", "'fathom' or 'm'"),
    (r"gals?|gallons?", "3.785 or 4.546 litres", "'m^3', 'US_liquid_gallon' or 'imperial_gallon'"),
    (r"barrels?|bbls?", "of oil, US or imperial", "'m^3', 'oil_barrel' or 'imperial_barrel'"),
    (r"quarts?|qts?|pints?|cups?|fluid_ounces?|floz|gills?", "a US or an imperial one", "'m^3' or 'L'"),
    (r"k?(hp|horsepower)", "735.5 W or 745.7 W", "'kW', or 'metric_horsepower' for the smaller one"),
    (r"cps|counts_per_second", "cycles or counts in a second", "'Hz' or '1/s'"),
)

_TOKEN = re.compile(r"\s*(?:(\*\*|[*/^()·]|-)|(\d+(?:\.\d+)?)|([^\W\d]\w*|%|°))")


def is_common_name(name: str) -> bool:
    """True for a name in the tables above: "m", "t", "rpm"."""
    return name in _SI or name in _COMMON


@cache
def parse_unit(text: str) -> Unit:
    """Parse a unit. Grammar: product = power {(* | / | nothing) power}; power = (name | 1 | (product)) [^ exponent]."""
    if len(text) > 100:
        raise UnitError(f"'{text[:40]}...' is not a unit; it has {len(text)} characters.")
    tokens: list[str] = []
    position, end = 0, len(text.rstrip())
    while position < end:
        match = _TOKEN.match(text, position)
        if match is None:
            raise UnitError(f"'{text}' is not a unit: '{text[position:].strip()[0]}' has no meaning here.")
        tokens.append(match[0].strip())
        position = match.end()
    if not tokens:
        raise UnitError("the unit is empty; write '1' for a number without a unit.")
    try:
        unit, rest = _product(tokens, text)
    except OverflowError:
        raise UnitError(f"'{text}' is not a unit: the exponents are too large.") from None
    if rest:
        raise UnitError(f"'{text}' is not a unit: '{rest[0]}' has no meaning here.")
    return unit


def _product(tokens: list[str], text: str) -> tuple[Unit, list[str]]:
    unit, tokens = _powered(tokens, text)
    while tokens and tokens[0] != ")":
        divided = tokens[0] == "/"
        factor, tokens = _powered(tokens[1:] if tokens[0] in ("*", "·", "/") else tokens, text)
        unit = unit * factor ** Fraction(-1 if divided else 1)
    return unit, tokens


def _powered(tokens: list[str], text: str) -> tuple[Unit, list[str]]:
    head, tokens = (tokens[0], tokens[1:]) if tokens else ("", [])
    if head == "(":
        unit, tokens = _product(tokens, text)
        if not tokens:
            raise UnitError(f"'{text}' is not a unit: a parenthesis is not closed.")
        tokens = tokens[1:]
    elif head == "1":
        unit = Unit()
    elif head and (head[0].isalpha() or head[0] in "_%°"):
        unit = _named(head)
    else:
        place = f"before '{head}'" if head else "at the end"
        raise UnitError(f"'{text}' is not a unit: a name of a unit is missing {place}.")
    if tokens and tokens[0] in ("^", "**"):
        exponent, tokens = _exponent(tokens[1:], text)
        unit = unit**exponent
    return unit, tokens


def _exponent(tokens: list[str], text: str) -> tuple[Fraction, list[str]]:
    sign = -1 if tokens[:1] == ["-"] else 1
    tokens = tokens[1:] if sign < 0 else tokens
    if not tokens or not tokens[0][0].isdigit() or float(tokens[0]) > 20:
        raise UnitError(f"'{text}' is not a unit: an exponent is a small number, as in 'm^2' or 's^-1'.")
    return sign * Fraction(tokens[0]), tokens[1:]


def _named(name: str) -> Unit:
    known = _SI.get(name) or _COMMON.get(name)
    if known:
        return known
    for pattern, meanings, instead in _AMBIGUOUS:
        if re.fullmatch(pattern, name):
            raise UnitError(f"'{name}' is ambiguous ({meanings}); write {instead}.")
    return _from_pint(name)


@cache
def _registry() -> Any:
    import pint

    return pint.UnitRegistry()


_PINT_ANGLES = ("radian", "degree", "turn", "revolution", "arcminute", "arcsecond", "grade")


def _from_pint(name: str) -> Unit:
    registry = _registry()
    try:
        parsed = registry.parse_units(name)
    except Exception:  # pint raises errors of many kinds for text that is no unit
        known = [*_COMMON, *_SI]
        exact = [unit for unit in known if unit.lower() == name.lower()]
        digits = re.fullmatch(r"([A-Za-z]+)(\d)", name)
        close = [f"{digits[1]}^{digits[2]}"] if digits else exact or closest(name, known)
        close = close or closest(name, _words(registry))
        hint = f"did you mean {one_of(close)}?" if close else "write units such as 'm', 'kN*m', 'deg', 'rpm' or 'm/s'."
        raise UnitError(f"unknown unit '{name}'; {hint}") from None
    if registry.Quantity(0, parsed).to_base_units().magnitude != 0:
        raise UnitError(f"the unit '{name}' does not count from zero; give the value in SI (K for a temperature).")
    base = registry.Quantity(1, parsed).to_base_units()
    dimensions = dict(zip(("[length]", "[mass]", "[time]", "[current]", "[temperature]", "[substance]", "[luminosity]"),
                          range(len(BASE)), strict=True))  # fmt: skip
    exponents = list(NONE)
    for dimension_name, power in base.dimensionality.items():
        exponents[dimensions[dimension_name]] = Fraction(power).limit_denominator(1000)
    angle = any(pint_name.startswith(word) for pint_name in parsed._units for word in _PINT_ANGLES)
    cycle = any(pint_name.endswith("hertz") for pint_name in parsed._units)
    return Unit(float(base.magnitude), tuple(exponents), Fraction(int(angle)), Fraction(int(cycle)))


@cache
def _words(registry: Any) -> tuple[str, ...]:
    """The names of units worth proposing: written out, of at least three letters."""
    return tuple(name for name in registry._units if len(name) > 2 and name.isalpha())
