"""A value of a model file -> the value of a parameter: quantities, formulas, lists, choices, paths of files."""

from __future__ import annotations

import math
import re
from collections.abc import Collection
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol

from fowtlib.language.bounds import refuse_turns
from fowtlib.language.declarations import SHAPES, Parameter
from fowtlib.language.errors import ModelError, ModelFileError, did_you_mean
from fowtlib.language.leave import FromModelFile
from fowtlib.language.unit_grammar import parse_unit
from fowtlib.language.units import conversion, expected, kind_of, quantity, si_unit, to_si, unit_text
from fowtlib.modelfile import files, formulas
from fowtlib.modelfile.formulas import Quantity
from fowtlib.modelfile.nodes import Node
from fowtlib.modelfile.permit import Permit
from fowtlib.modelfile.specs import Declared, Value, substituted

_WORD = re.compile(r"[^\W\d]\w*")
_NAME = re.compile(r"[^\W\d][\w.]*")
_EXPONENT = re.compile(r"(\^|\*\*)\s*-?\d+(\.\d+)?")
_NOT_FINITE = ("nan", "inf", "infinity")
_UNIT = re.compile(r"[\w\s*/()·°%]*")


class Names(Protocol):
    """What a formula can name: parameters of the file, and parameters of parts by path."""

    @property
    def names(self) -> list[str]:
        """All names, for proposals."""

    def find(self, name: str) -> Quantity | None:
        """The value of a name, None if there is none."""


@dataclass(frozen=True)
class ValueReader:
    """Reads values; `scope` is what formulas can name, `folder` where relative paths of files begin."""

    scope: Names
    folder: Path
    permit: Permit | None = None

    def read(self, value: Value, field: Parameter, path: str) -> Any:
        """The value for a declared parameter; `path` is how errors call the parameter."""
        try:
            if field.annotation in SHAPES or field.annotation in (int, float):
                return self._numeric(value, value.node, field)
            if field.annotation is str or field.is_data:
                return self._text(value, field)
            if field.annotation is list and field.unit != "1":
                return self._list(value, field)
            return _plain(value, value.node)
        except ModelError as error:
            raise _located(error, value.node, path) from None

    def unit(self, declared: Declared, path: str) -> str:
        """The SI unit of a parameter that a file declares: the given one, or as its value shows."""
        try:
            return si_unit(declared.unit) if declared.unit else self._unit_shown(declared.value, declared.value.node)
        except ModelError as error:
            raise _located(error, declared.value.node, path) from None

    def declared(self, value: Value, unit: str, unit_of_numbers: str, path: str) -> Any:
        """The value (SI) of a parameter that a file declares; plain numbers are in `unit_of_numbers`, where given."""
        field = Parameter(None, unit, "", None, None, None, False, None)
        try:
            _check_rows(value.node)
            result = self._numeric(value, value.node, field)
            plain = not any(isinstance(node.value, str) for node in value.node.walk())
            factor = conversion(parse_unit(unit_of_numbers), parse_unit(unit)) if unit_of_numbers and plain else 1.0
            return result if factor == 1.0 else _scaled(result, factor)
        except ModelError as error:
            raise _located(error, value.node, path) from None

    def bound(self, value: Value | None, unit: str, path: str) -> float | None:
        """A lower or upper bound of a declared parameter."""
        if value is None:
            return None
        try:
            if isinstance(value.node.value, (list, dict)):
                raise ModelFileError(f"a bound is one number, not {value.node.kind}.")
            bound = float(to_si(value.node.plain(), unit))
            if math.isnan(bound):
                raise ModelFileError("a bound is a number.")
            return bound
        except ModelError as error:
            raise _located(error, value.node, path) from None

    def text(self, value: Value, what: str) -> str:
        """Text such as the name of a class, with the variables put in."""
        if not isinstance(value.node.value, str):
            raise value.place.error(f"{what} is text, not {value.node.kind}.")
        return substituted(value.node.value, value.variables, value.place)

    # --- numbers -------------------------------------------------------------------------------------------------

    def _list(self, value: Value, field: Parameter) -> Any:
        """A list of quantities, or of lists of them: what a model is built with, in SI."""
        if not isinstance(value.node.value, (list, str)):
            raise ModelFileError(f"got {value.node.kind}; a list is expected ({field.doc}).")
        return self._numeric(value, value.node, field)

    def _numeric(self, value: Value, node: Node, field: Parameter) -> Any:
        """A number in SI or an expression of parameters; lists of those keep their form."""
        if isinstance(node.value, list):
            return [self._numeric(value, item, field) for item in node.value]
        if node.value is None and field.default is None and field.annotation is not None:
            return None
        if node.value is None or isinstance(node.value, (bool, dict)):
            given = {True: "true", False: "false"}.get(node.value) if isinstance(node.value, bool) else node.kind
            raise ModelFileError(f"got {given}; {expected(field.unit)}.")
        if not isinstance(node.value, str):
            refuse_turns(node.value, field.unit)
            return _whole(node.value, field)
        text = _formula_text(value, node)
        found = quantity(text)
        if found and self._is_unit(found[1], value.variables):
            if not found[1]:
                refuse_turns(found[0], field.unit)
            return _whole(to_si(text, field.unit), field)
        result = self._formula(value, node, field.unit)
        if result.unit is None:
            return _whole(result.value, field)
        wanted = parse_unit(field.unit)
        if result.unit.dimension != wanted.dimension:
            raise ModelFileError(f"'{text}' is {kind_of(result.unit)}; {expected(field.unit)}.")
        factor = conversion(result.unit, wanted)
        if factor != 1.0 and not _NAME.fullmatch(text):
            raise ModelFileError(
                f"'{text}' is {kind_of(result.unit)} in {unit_text(result.unit)}, and {field.unit} is expected; "
                f"a formula does not turn cycles into radians. Give the parameter in it 'unit: {field.unit}'."
            )
        return result.value if factor == 1.0 else result.value * factor

    def _is_unit(self, text: str, variables: Collection[str]) -> bool:
        """True where what follows a number is a unit (or should be one), not the rest of a formula."""
        bare = _EXPONENT.sub("", text)
        if not _UNIT.fullmatch(bare) or re.match(r"[*/]", bare) or re.search(r"\b\d", bare):
            return False
        return not set(_WORD.findall(bare)) & {*self.scope.names, *variables}

    def _formula(self, value: Value, node: Node, unit: str = "") -> Quantity:
        if not isinstance(node.value, str):
            return Quantity(float(node.value))
        text = _formula_text(value, node)
        if any(name.lower() in _NOT_FINITE and not self._known(name, value) for name in _WORD.findall(text)):
            raise ModelFileError(f"'{text}' is not a finite number; {expected(unit)}.")

        def lookup(name: str) -> Quantity:
            found = self.scope.find(name)
            if found is None and name in value.variables:
                found = self._variable(value.variables[name])
            if found is None:
                known = [*self.scope.names, *value.variables, *formulas.FUNCTIONS, *formulas.CONSTANTS]
                hint = did_you_mean(name, known, list_up_to=0)
                if name == text and hint == "." and unit:
                    raise ModelFileError(f"'{text}' is neither a quantity nor a parameter; {expected(unit)}.")
                raise ModelFileError(f"'{text}': there is no parameter '{name}'{hint}")
            return found

        return formulas.parse(text, {*self.scope.names, *value.variables}).evaluate(lookup)

    def _known(self, name: str, value: Value) -> bool:
        return name in value.variables or self.scope.find(name) is not None

    def _variable(self, node: Node) -> Quantity:
        """A variable of an `each` block in a formula."""
        if isinstance(node.value, str):
            found = quantity(node.value)
            if found and found[1]:
                return Quantity(float(to_si(node.value, si_unit(found[1]))), parse_unit(si_unit(found[1])))
        return self._formula(Value(node), node)

    def _unit_shown(self, value: Value, node: Node) -> str:
        """The unit that a value shows: of its first quantity, or of the result of a formula."""
        for inner in node.walk():
            if not isinstance(inner.value, str):
                continue
            found = quantity(_formula_text(value, inner))
            if found and found[1] and self._is_unit(found[1], value.variables):
                return si_unit(found[1])
            result = self._formula(value, inner)
            if result.unit is not None:
                return unit_text(result.unit)
        return "1"

    # --- text ----------------------------------------------------------------------------------------------------

    def _text(self, value: Value, field: Parameter) -> str | None:
        node = value.node
        if node.value is None and field.default is None:
            return None
        if isinstance(node.value, (list, dict, bool)) or node.value is None:
            raise ModelFileError(f"got {node.kind}; text is expected ({field.doc}).")
        text = substituted(str(node.value), value.variables, node.place)
        if field.choices is not None and text not in field.choices:
            raise ModelFileError(f"'{text}' is not possible{did_you_mean(text, field.choices)} ({field.doc})")
        if not is_file(text, field):
            return text
        if not node.place.line:  # given by the user, who allows it by that
            return str(files.find_data(text, self.folder))
        path = files.find_data(text, self.folder, self.permit, native=field.native)
        return FromModelFile.at(str(path), str(node.place), self.permit is not None and self.permit.trust)


def is_file(text: str, field: Parameter) -> bool:
    """True for text that names a file: because the parameter is one of files, or as files.names_file says."""
    if not text or field.choices is not None:
        return False
    return field.is_data or field.native or files.names_file(field.name, text)


def _check_rows(node: Node) -> None:
    """A list holds numbers, or rows of the same number of numbers."""
    rows = node.value if isinstance(node.value, list) else []
    lengths = {len(row.value) if isinstance(row.value, list) else None for row in rows}
    if len(lengths) > 1:
        raise ModelFileError("a list holds numbers, or rows of numbers that have the same length.")
    for row in rows:
        for item in row.value if isinstance(row.value, list) else ():
            if isinstance(item.value, list):
                raise item.place.error("lists are nested too deeply; a value is a number, a list or a list of rows.")


def _whole(value: Any, field: Parameter) -> Any:
    if field.annotation is int and isinstance(value, float) and not value.is_integer():
        raise ModelFileError(f"got {value:g}; a whole number is expected ({field.doc}).")
    return value


def _scaled(value: Any, factor: float) -> Any:
    return [_scaled(item, factor) for item in value] if isinstance(value, list) else value * factor


def _formula_text(value: Value, node: Node) -> str:
    return substituted(node.value, value.variables, node.place, formula=True).strip()


def _plain(value: Value, node: Node) -> Any:
    if isinstance(node.value, dict):
        return {substituted(key, value.variables, item.place): _plain(value, item) for key, item in node.value.items()}
    if isinstance(node.value, list):
        return [_plain(value, item) for item in node.value]
    if isinstance(node.value, str):
        return substituted(node.value, value.variables, node.place)
    return node.value


def _located(error: ModelError, node: Node, path: str) -> ModelFileError:
    """The error with the place of the value and the path of the parameter; one that has a place keeps it."""
    return error if isinstance(error, ModelFileError) and error.where else node.place.error(f"{path}: {error}")
