"""Arithmetic on parameters in the values of a model file: `2 * half_span + 3 m`, `sqrt(area / pi)`, `headings[0]`.

The text is parsed here and is never run as Python. Operators are + - * / ** (or ^), with Python's precedence, and the
functions below. A value depends on parameters of the model, and stays an expression of them, so that a changed
parameter reaches it without building the model again.

Units are followed: a length cannot be added to a mass. A number without a unit takes the unit of what it meets.
"""

from __future__ import annotations

import math
import operator
import re
from collections.abc import Callable, Container
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Any

from fowtlib.language import math as symbolic
from fowtlib.language.errors import ModelFileError, did_you_mean
from fowtlib.language.unit_grammar import Unit, parse_unit
from fowtlib.language.units import kind_of

LONGEST = 500
NONE = Unit()

# name: (number of arguments, on numbers, on parameters, what becomes of the unit)
FUNCTIONS: dict[str, tuple[int, Callable[..., float], Callable[..., Any], str]] = {
    **{
        name: (1, getattr(math, name), getattr(symbolic, name), "none")
        for name in ("sin", "cos", "tan", "asin", "acos", "atan", "sinh", "cosh", "tanh", "asinh", "exp", "log")
    },
    "atan2": (2, math.atan2, symbolic.atan2, "ratio"),
    "sqrt": (1, math.sqrt, symbolic.sqrt, "root"),
    "abs": (1, abs, symbolic.abs, "same"),
    "min": (2, min, symbolic.fmin, "same"),
    "max": (2, max, symbolic.fmax, "same"),
}
CONSTANTS = {"pi": math.pi}

_TOKEN = re.compile(
    r"\s*(?:(?P<number>(?:\d+(?:\.\d*)?|\.\d+)(?:[eE][+-]?\d+)?)|(?P<name>[^\W\d]\w*(?:\.[^\W\d]\w*)*)|(?P<sign>\*\*|[-+*/^()\[\],°%]))"
)


@dataclass(frozen=True)
class Quantity:
    """A number or an expression of parameters, in SI; `unit` None: a number that takes any unit."""

    value: Any
    unit: Unit | None = None


Lookup = Callable[[str], Quantity]
Tree = Callable[[Lookup], Quantity]


@dataclass(frozen=True)
class Formula:
    """A parsed text: the names it uses, and its value for given values of the names."""

    text: str
    names: tuple[str, ...]
    tree: Tree

    def evaluate(self, lookup: Lookup) -> Quantity:
        """The value; `lookup` gives that of a name, or raises a ModelFileError."""
        try:
            result = self.tree(lookup)
        except RecursionError:
            raise ModelFileError(f"'{self.text[:40]}...' is nested too deeply.") from None
        except ZeroDivisionError:
            raise ModelFileError(f"'{self.text}' divides by zero.") from None
        except (ValueError, OverflowError, TypeError):  # TypeError: a complex number in a function
            raise ModelFileError(f"'{self.text}' has no real value.") from None
        if isinstance(result.value, complex) or isinstance(result.value, float) and not math.isfinite(result.value):
            raise ModelFileError(f"'{self.text}' has no real value.")
        return result


def parse(text: str, known: Container[str] = ()) -> Formula:
    """Parse a formula; ModelFileError (without a place) where it is none. A word of `known` is never a unit."""
    if len(text) > LONGEST:
        raise ModelFileError(f"'{text[:40]}...' is too long; a formula has {LONGEST} characters at most.")
    parser = _Parser(text, known)
    try:
        tree = parser.sum()
    except RecursionError:
        raise ModelFileError(f"'{text[:40]}...' is nested too deeply.") from None
    if parser.token:
        raise parser.error(f"'{parser.token}' is not expected")
    return Formula(text, tuple(dict.fromkeys(parser.names)), tree)


class _Parser:
    """Recursive descent; each method reads one level of the grammar and gives its tree."""

    def __init__(self, text: str, known: Container[str]):
        self.text = text
        self.known = known
        self.names: list[str] = []
        self.position = 0
        self.kind = self.token = ""
        self.advance()

    def error(self, what: str) -> ModelFileError:
        stop = "" if what.endswith(("?", ".")) else "."
        return ModelFileError(f"cannot read '{self.text}' as a quantity or a formula: {what}{stop}")

    def advance(self) -> str:
        """Give the current token and read the next one."""
        token = self.token
        match = _TOKEN.match(self.text, self.position)
        rest = self.text[self.position :].strip()
        if match is None and rest:
            raise self.error(f"'{rest[0]}' has no meaning here")
        self.kind, self.token = (match.lastgroup or "", match[match.lastgroup or 0]) if match else ("", "")
        self.position = match.end() if match else len(self.text)
        return token

    def expect(self, sign: str) -> None:
        if self.token != sign:
            raise self.error(f"'{sign}' is missing {f'before {self.token!r}' if self.token else 'at the end'}")
        self.advance()

    def sum(self) -> Tree:
        """Sum = product {(+ | -) product}."""
        tree = self.product()
        while self.token in ("+", "-"):
            sign = self.advance()
            tree = _operation(sign, tree, self.product())
        return tree

    def product(self) -> Tree:
        """Product = signed {(* | /) signed}."""
        tree = self.signed()
        while self.token in ("*", "/"):
            sign = self.advance()
            tree = _operation(sign, tree, self.signed())
        return tree

    def signed(self) -> Tree:
        """Signed = [+ | -] signed | power."""
        if self.token in ("+", "-"):
            sign, tree = self.advance(), self.signed()
            return tree if sign == "+" else lambda lookup: _negative(tree(lookup))
        return self.power()

    def power(self) -> Tree:
        """Power = item [(** | ^) signed]."""
        tree = self.item()
        if self.token in ("**", "^"):
            self.advance()
            tree = _operation("**", tree, self.signed())
        return tree

    def item(self) -> Tree:
        """Item = atom {[ index ]}."""
        tree = self.atom()
        while self.token == "[":
            self.advance()
            if not self.token.isdecimal():
                raise self.error("an index is a whole number, counted from 0")
            tree = _indexed(tree, int(self.advance()), self.text)
            self.expect("]")
        return tree

    def atom(self) -> Tree:
        """Atom = number [unit] | name | function ( sum {, sum} ) | ( sum )."""
        if self.kind == "number":
            return self.number()
        if self.kind == "name":
            name = self.advance()
            if self.token == "(":
                return self.call(name)
            if name in CONSTANTS:
                constant = Quantity(CONSTANTS[name])
                return lambda lookup: constant
            self.names.append(name)
            return lambda lookup: lookup(name)
        if self.token == "(":
            self.advance()
            tree = self.sum()
            self.expect(")")
            return tree
        if not self.token:
            raise self.error("something is missing at the end" if self.text.strip() else "there is no text")
        raise self.error(f"a number or a name is missing before '{self.token}'")

    def number(self) -> Tree:
        value, unit = float(self.advance()), None
        if (self.kind == "name" and "." not in self.token) or self.token in ("°", "%"):
            word = self.advance()
            if word in self.known:
                raise self.error(f"'{word}' is a parameter here; write '{value:g}*{word}'")
            if self.token in ("^", "**"):
                self.advance()
                sign = self.advance() if self.token == "-" else ""
                word += f"^{sign}{self.advance()}"
            given = parse_unit(word)
            value, unit = value * given.factor, replace(given, factor=1.0)
        quantity = Quantity(value, unit)
        return lambda lookup: quantity

    def call(self, name: str) -> Tree:
        if name not in FUNCTIONS:
            raise self.error(f"there is no function '{name}'{did_you_mean(name, FUNCTIONS)}")
        self.expect("(")
        arguments = [self.sum()]
        while self.token == ",":
            self.advance()
            arguments.append(self.sum())
        self.expect(")")
        wanted = FUNCTIONS[name][0]
        if len(arguments) != wanted:
            raise self.error(f"{name}() takes {wanted} value{'s' * (wanted > 1)}, not {len(arguments)}")
        return lambda lookup: _called(name, [argument(lookup) for argument in arguments])


_OPERATORS = {"+": operator.add, "-": operator.sub, "*": operator.mul, "/": operator.truediv, "**": operator.pow}


def _operation(sign: str, left: Tree, right: Tree) -> Tree:
    def tree(lookup: Lookup) -> Quantity:
        a, b = left(lookup), right(lookup)
        unit = _power_unit(a, b) if sign == "**" else _unit(sign, a.unit, b.unit)
        if sign == "*" and isinstance(b.value, float) and b.value == 1.0:  # such as `* 1 m`, which only gives a unit
            return Quantity(a.value, unit)
        return Quantity(_OPERATORS[sign](a.value, b.value), unit)

    return tree


def _negative(a: Quantity) -> Quantity:
    return Quantity(-a.value, a.unit)


def _indexed(tree: Tree, index: int, text: str) -> Tree:
    def indexed(lookup: Lookup) -> Quantity:
        a = tree(lookup)
        if isinstance(a.value, (int, float)):
            raise ModelFileError(f"'{text}' takes an element of a single number.")
        return Quantity(a.value[index], a.unit)

    return indexed


def _called(name: str, arguments: list[Quantity]) -> Quantity:
    _, numeric, delayed, rule = FUNCTIONS[name]
    unit = arguments[0].unit
    if rule == "none":
        if unit is not None and unit.dimension != NONE.dimension:
            raise ModelFileError(f"{name}() of {kind_of(unit)} has no meaning.")
        unit = None
    elif rule == "root":
        unit = unit and unit ** Fraction(1, 2)
    elif len(arguments) == 2:
        unit = _unit("+", unit, arguments[1].unit)
        unit = None if rule == "ratio" else unit
    values = [argument.value for argument in arguments]
    symbols = any(not isinstance(value, (int, float)) for value in values)
    return Quantity(delayed(*values) if symbols else float(numeric(*values)), unit)


def _unit(sign: str, a: Unit | None, b: Unit | None) -> Unit | None:
    if sign in "+-":
        if a is not None and b is not None and (a.dimension, a.cycle) != (b.dimension, b.cycle):
            word = "added to" if sign == "+" else "subtracted from"
            first, second = (kind_of(a), kind_of(b)) if sign == "+" else (kind_of(b), kind_of(a))
            raise ModelFileError(f"{first} cannot be {word} {second}.")
        return a if b is None else b
    if a is None and b is None:
        return None
    unit = (a or NONE) * ((b or NONE) ** Fraction(-1) if sign == "/" else (b or NONE))
    return None if unit == NONE and (a is None or b is None) else unit


def _power_unit(base: Quantity, exponent: Quantity) -> Unit | None:
    if exponent.unit is not None and exponent.unit.dimension != NONE.dimension:
        raise ModelFileError(f"an exponent cannot be {kind_of(exponent.unit)}.")
    if base.unit is None or base.unit == NONE:
        return base.unit
    if not isinstance(exponent.value, float):
        raise ModelFileError(f"{kind_of(base.unit)} can only be raised to a power that is a number.")
    return base.unit ** Fraction(exponent.value).limit_denominator(1000)
