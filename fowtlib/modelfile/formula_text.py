"""Expressions of parameters -> the text of formulas, with names as the place in the file needs them."""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction
from typing import Any

import numpy as np

from fowtlib.language.component import Component
from fowtlib.language.declarations import Parameter
from fowtlib.language.errors import ModelFileError
from fowtlib.language.expressions import Expression, ParameterReference, is_expression
from fowtlib.language.unit_grammar import BASE, parse_unit
from fowtlib.language.units import conversion
from fowtlib.modelfile.formulas import FUNCTIONS, Quantity, parse

_NAMES = {"fmin": "min", "fmax": "max", "fabs": "abs"}
_SIGNS = ("+", "-", "*", "/", "**")


class FormulaWriter:
    """Writes formulas; `reached` are the components written so far, which alone can be named by path."""

    def __init__(self, is_composite: Callable[[Component], bool]):
        self.is_composite = is_composite
        self.reached: list[Component] = []
        self.used: dict[int, list[str]] = {}

    def used_of(self, component: Component) -> list[str]:
        """The parameters of a component that formulas call by their bare name."""
        return self.used.get(id(component), [])

    def value(self, component: Component, field: Parameter, value: Any, where: str) -> Any:
        """A value that holds expressions, for a parameter of `component`."""
        if isinstance(value, (list, tuple)):
            return [self.value(component, field, item, where) for item in value]
        if not is_expression(value):
            return float(value) if isinstance(value, np.number) else value
        units: dict[str, Quantity] = {}
        text = self._text(component, value, where, units, top=True)
        return text + _correction(text, units, field, where)

    def _text(self, component: Component, value: Any, where: str, units: dict[str, Quantity],
              top: bool = False) -> str:  # fmt: skip
        if isinstance(value, ParameterReference):
            name, unit = self._name(component, value, where), value.component.parameters[value.name].unit
            units.setdefault(name, Quantity(1.0, None if unit == "1" else parse_unit(unit)))
            return name
        if not isinstance(value, Expression):
            if isinstance(value, (int, float, np.number)):
                return repr(float(value)) if value >= 0 else f"({float(value)!r})"
            raise ModelFileError(f"{where}: a model file cannot say {value!r} in a formula.")
        symbol, texts = value.symbol, [self._text(component, item, where, units) for item in value.arguments]
        if symbol.startswith("["):
            if texts[0] in units:  # elements of an array
                count = max(np.size(units[texts[0]].value), int(symbol[1:-1]) + 1)
                units[texts[0]] = Quantity(np.ones(count), units[texts[0]].unit)
            return texts[0] + symbol
        if symbol in _SIGNS:
            text = f"-{texts[0]}" if len(texts) == 1 else f"{texts[0]} {symbol} {texts[1]}"
            return text if top and symbol in "*/" else f"({text})"
        name = _NAMES.get(symbol, symbol)
        if name not in FUNCTIONS:
            raise ModelFileError(f"{where}: a model file has no function '{symbol}'.")
        return f"{name}({', '.join(texts)})"

    def _name(self, component: Component, leaf: ParameterReference, where: str) -> str:
        """How a formula in the values of `component` calls a parameter."""
        around: Component | None = component
        while around is not None:
            if leaf.component is around and (self.is_composite(around) or _of_file(around, leaf.name)):
                if leaf.name not in self.used.setdefault(id(around), []):
                    self.used[id(around)].append(leaf.name)
                return leaf.name
            if leaf.component in list(around.walk())[1:] and any(leaf.component is item for item in self.reached):
                path = leaf.component.path
                return f"{path.removeprefix(around.path + '.') if around.path else path}.{leaf.name}"
            if self._captured(around, leaf):
                break
            around = around._parent
        raise ModelFileError(f"{where} depends on {leaf!r}, which a formula there cannot name.")

    def _captured(self, around: Component, leaf: ParameterReference) -> bool:
        """True where the bare name would mean another parameter, one of `around`."""
        return leaf.name in around.parameters and self.is_composite(around) and leaf.component is not around


def _correction(text: str, units: dict[str, Quantity], field: Parameter, where: str) -> str:
    """What turns the unit that the loader sees in a formula into that of the parameter, without changing the number.

    Python's arithmetic knows no units, so a formula from there may lack some.
    """
    try:
        unit = parse(text).tree(units.__getitem__).unit
    except (ModelFileError, ArithmeticError) as error:
        raise ModelFileError(f"{where}: '{text}': {error}") from None
    wanted = parse_unit(field.unit)
    if unit is None or (unit.dimension == wanted.dimension and conversion(unit, wanted) == 1.0):
        return ""
    factors = [f"1 Hz^{float(-unit.cycle):g}"] if unit.cycle else []
    rest = wanted * unit ** Fraction(-1) * parse_unit("s") ** -unit.cycle
    factors += [f"1 {name}^{float(power):g}" for name, power in zip(BASE, rest.dimension, strict=True) if power]
    return "".join(f" * {factor}" for factor in factors)


def _of_file(component: Component, name: str) -> bool:
    return getattr(component.parameters[name], "from_file", False)
