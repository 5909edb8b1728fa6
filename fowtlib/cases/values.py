"""Values of a cases file: numbers, quantities, formulas of its variables, and text with `{...}` in it.

Text is a formula where it names a variable or is arithmetic, and what it says otherwise; in quotes it is never a
formula. Nothing is run as Python.
"""

from __future__ import annotations

import re
from collections.abc import Collection
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, Protocol

from fowtlib.language.errors import ModelError, ModelFileError, UnitError, did_you_mean
from fowtlib.language.unit_grammar import parse_unit
from fowtlib.language.units import quantity, si_unit, to_si, unit_text
from fowtlib.modelfile import formulas
from fowtlib.modelfile.formulas import Quantity
from fowtlib.modelfile.nodes import Node

_PLACE = re.compile(r"\{([^{}:]*)(?::([^{}]*))?\}")
_FORM = re.compile(r"[+]?0?\d{0,2}(?:\.\d{1,2})?([dfegs]?)")
NUMBER_FORMS = "02.0f, .1f, 03d, .3g"


@dataclass(frozen=True)
class Item:
    """A value: `written` as the file has it, `quantity` in SI; None for what is no number."""

    written: str | int | float | bool
    quantity: Quantity | None = None

    @property
    def plain(self) -> str | int | float | bool:
        """What a parameter is given."""
        return self.written

    @property
    def label(self) -> str | int | float | bool:
        """What names, tables and pictures show: of a quantity the number in the unit in which it is written."""
        if self.quantity is None or not isinstance(self.written, str):
            return self.written
        found = quantity(self.written)
        return tidy(found[0]) if found else self.written


_unit_text = lru_cache(maxsize=256)(unit_text)


class Names(Protocol):
    """The variables that formulas can name."""

    @property
    def names(self) -> Collection[str]:
        """All names."""

    def item(self, name: str) -> Item:
        """The value of one of the names."""


def number(value: float, unit: Any = None) -> Item:
    """The item of a number that was computed; whole numbers are integers."""
    written: str | float = tidy(float(value))
    if unit is not None and (text := _unit_text(unit)) != "1":
        written = f"{written!r} {text}"
    return Item(written, Quantity(float(value), unit))


def evaluate(node: Node, names: Names) -> Item:
    """The value of a node that is no list and no mapping; errors have its place."""
    try:
        return _evaluate(node, names)
    except ModelError as error:
        raise error if error.where else node.place.error(str(error)) from None


def plain(node: Node, names: Names) -> Any:
    """A node with all that is in it as what JSON can hold."""
    if isinstance(node.value, dict):
        return {key: plain(item, names) for key, item in node.value.items()}
    if isinstance(node.value, list):
        return [plain(item, names) for item in node.value]
    return None if node.value is None else evaluate(node, names).plain


def filled(text: str, names: Names, units: bool = False) -> str:
    """Text with `{formula}` and `{formula:form}` replaced by values; units: with their units, and all digits."""

    def put(found: re.Match[str]) -> str:
        formula, form = found[1].strip(), found[2]
        item = _formula(formula, names)
        if item is None:
            if formula.isidentifier():
                raise ModelFileError(f"'{text}': there is no variable '{formula}'{did_you_mean(formula, names.names)}")
            raise ModelFileError(f"'{text}': '{formula}' is not a formula of variables{_there_are(names)}")
        return _formatted(item, form, text, units)

    result = _PLACE.sub(put, text)
    if "{" in result or "}" in result:
        raise ModelFileError(f"'{text}': a brace is without its other one; write {{variable}} or {{variable:02.0f}}.")
    return result


def scalar(node: Node, what: str, names: Names, unit: str) -> float:
    """A number in SI."""
    if isinstance(node.value, (list, dict, bool)) or node.value is None:
        raise node.place.error(f"{what} is one value, not {node.kind}.")
    try:
        return float(to_si(evaluate(node, names).plain, unit))
    except ModelError as error:
        raise error if error.where else node.place.error(f"{what}: {error}") from None


def word(node: Node, what: str, names: Names, units: bool = False) -> str:
    """Text, with placeholders filled; units: with the unit of a quantity."""
    if not isinstance(node.value, (str, int, float)) or isinstance(node.value, bool):
        raise node.place.error(f"{what} is text, not {node.kind}.")
    try:
        return filled(str(node.value), names, units)
    except ModelError as error:
        raise error if error.where else node.place.error(f"{what}: {error}") from None


@lru_cache(maxsize=4096)
def as_quantity(text: str) -> Quantity | None:
    """The quantity that a text such as "12 m/s" writes, in SI; None for another text."""
    found = quantity(text)
    if found is None:
        return None
    value, unit = found
    if not unit:
        return Quantity(value)
    try:
        return Quantity(float(to_si(text, si_unit(unit))), parse_unit(si_unit(unit)))
    except UnitError:
        return None


def _evaluate(node: Node, names: Names) -> Item:
    value = node.value
    if isinstance(value, bool):
        return Item(value)
    if isinstance(value, (int, float)):
        return Item(value, Quantity(float(value)))
    if not isinstance(value, str):
        raise ModelFileError(f"got {node.kind}; a number or text is expected.")
    if "{" in value:
        return Item(filled(value, names))
    if node.quoted:
        return Item(value)
    given = as_quantity(value)
    if given is not None:
        return Item(value, given)
    return _formula(value, names) or Item(value)


def _formula(text: str, names: Names) -> Item | None:
    """The value of a formula; None for a text that is none, or in which no variable is named."""
    if text in names.names:
        return names.item(text)
    try:
        parsed = formulas.parse(text, names.names)
    except ModelError:
        return None
    if parsed.names and not set(parsed.names) & set(names.names):
        return None

    def lookup(name: str) -> Quantity:
        if name not in names.names:
            raise ModelFileError(f"'{text}': there is no variable '{name}'{did_you_mean(name, names.names)}")
        found = names.item(name).quantity
        if found is None:
            raise ModelFileError(f"'{text}': the variable '{name}' is no number.")
        return found

    result = parsed.evaluate(lookup)
    return number(float(result.value), result.unit)


def _formatted(item: Item, form: str | None, text: str, units: bool) -> str:
    value = item.written if units and form is None else item.label
    if form is None:
        return str(value) if units or not isinstance(value, float) else f"{value:.12g}"
    match = _FORM.fullmatch(form)
    if match is None or isinstance(value, bool):
        raise ModelFileError(f"'{text}': '{form}' is not how a number is written; there are {NUMBER_FORMS}.")
    if isinstance(value, str) != (match[1] == "s"):
        raise ModelFileError(f"'{text}': '{value}' cannot be written as '{form}'.")
    if match[1] == "d" and not isinstance(value, int):
        raise ModelFileError(f"'{text}': {value:g} is not a whole number, as '{form}' asks for.")
    return format(value, form)


def tidy(value: float) -> int | float:
    """A number as it is written down: whole ones as integers."""
    return int(value) if value.is_integer() and abs(value) < 2**53 else value


def _there_are(names: Names) -> str:
    return f"; there are {', '.join(sorted(names.names))}." if names.names else "; there are no variables here."
