"""Expressions of parameters -> the text of formulas, with names as the place in the file needs them."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from fowtlib.language.component import Component
from fowtlib.language.declarations import Parameter
from fowtlib.language.errors import ModelFileError
from fowtlib.language.expressions import Expression, ParameterReference, is_expression
from fowtlib.language.unit_grammar import parse_unit
from fowtlib.language.units import conversion
from fowtlib.modelfile.formulas import FUNCTIONS

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
        if isinstance(value, ParameterReference):
            unit = value.component.parameters[value.name].unit
            if conversion(parse_unit(unit), parse_unit(field.unit)) != 1.0:
                raise ModelFileError(f"{where}: {value!r} is in {unit}; a model file would turn it into {field.unit}.")
        return self._text(component, value, where, top=True)

    def _text(self, component: Component, value: Any, where: str, top: bool = False) -> str:
        if isinstance(value, ParameterReference):
            return self._name(component, value, where)
        if not isinstance(value, Expression):
            if isinstance(value, (int, float, np.number)):
                return repr(float(value)) if value >= 0 else f"({float(value)!r})"
            raise ModelFileError(f"{where}: a model file cannot say {value!r} in a formula.")
        symbol, texts = value.symbol, [self._text(component, item, where) for item in value.arguments]
        if symbol.startswith("["):
            return texts[0] + symbol
        if symbol in _SIGNS:
            text = f"-{texts[0]}" if len(texts) == 1 else f"{texts[0]} {symbol} {texts[1]}"
            return text if top else f"({text})"
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


def _of_file(component: Component, name: str) -> bool:
    return getattr(component.parameters[name], "from_file", False)
