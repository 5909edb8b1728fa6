"""Slopes of the values of parameters by elements of others, from the arithmetic by which they are computed.

A part of a hull is told its ends by expressions of what its hull computes when a run starts, and its diameters by a
name of the model; that is arithmetic, and so are its slopes. What a part makes of them may say its own: a callable of
`at_start` with `slopes(component, tangent)`, where tangent(component, name) gives the changes (size, m) of a parameter
along m elements, and the answer are those of the numbers (count, m). NaN stands for what is not known; then differences
are taken.
"""

from __future__ import annotations

import inspect
import operator
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from fowtlib.language.component import Component
from fowtlib.language.declarations import SHAPES, join
from fowtlib.language.expressions import (
    Arithmetic,
    Expression,
    ParameterReference,
    StartNumbers,
    evaluate,
    parameters_read,
)

Both = tuple[np.ndarray, np.ndarray]
"""A value, and its changes along m elements: with one more axis, the last."""


class Tangents:
    """Changes of the values of parameters of a component tree along some elements.

    elements: path, and number in column order, of each. started(path, numbers): changes (n, m) of what a part computes
    when a run starts, whose values are these numbers; None where they are not known.
    """

    def __init__(self, elements: Sequence[tuple[str, int]], started: Callable[[str, np.ndarray], np.ndarray | None]):
        self.elements, self._started = list(elements), started
        self._known: dict[tuple[int, str], tuple[Component, Both]] = {}  # a component that is held keeps its id

    def __call__(self, component: Component, name: str) -> np.ndarray:
        """Changes (size, m) of a parameter of a component, in column order; NaN where they are not known."""
        change = self._of(component, name)[1]
        return change.transpose(*reversed(range(change.ndim - 1)), -1).reshape(-1, len(self.elements))

    def _of(self, component: Component, name: str) -> Both:
        here = component.current if name in component.current.parameters else component
        key = id(here), name
        if key not in self._known:
            self._known[key] = here, self._found(here, name)
        return self._known[key][1]

    def _found(self, component: Component, name: str) -> Both:
        with parameters_read() as read:
            value = np.asarray(component.parameter_value(name), dtype=float)
        path, paths = join(component.path, name), {join(*place) for place in read}
        field = component.parameters[name]
        change = self._none(value)
        if any(own in paths and own != path for own, _ in self.elements):
            computed = field.annotation not in SHAPES or (
                not component.is_set(name) and inspect.isfunction(field.default))  # fmt: skip
            found = None if computed else self._dual(component.parameter_binding(name))
            if found is None or found[1].shape != change.shape:
                change[..., [own in paths and own != path for own, _ in self.elements]] = np.nan
            else:
                change = change + found[1]
        for column, (own, number) in enumerate(self.elements):
            if own == path:
                change[..., column].T.flat[number] += 1.0
        return value, change

    def _none(self, value: np.ndarray) -> np.ndarray:
        return np.zeros((*value.shape, len(self.elements)))

    def _dual(self, value: Any) -> Both | None:
        """The value of an expression and its changes; None where its arithmetic is not known."""
        if isinstance(value, Expression):
            arguments = [self._dual(argument) for argument in value.arguments]
            return None if any(one is None for one in arguments) else self._combined(value, arguments)
        if isinstance(value, ParameterReference):
            return self._of(value.component, value.name)
        if isinstance(value, StartNumbers):
            numbers = np.asarray(evaluate(value))
            found = self._started(join(value.component.path, value.name), numbers)
            return None if found is None else (numbers, found)
        if isinstance(value, Arithmetic):
            return None
        if isinstance(value, (list, tuple)):
            items = [self._dual(item) for item in value]
            if any(item is None for item in items) or len({item[0].shape for item in items}) > 1:
                return None
            return np.array([item[0] for item in items]), np.array([item[1] for item in items])
        try:
            value = np.asarray(value, dtype=float)
        except (TypeError, ValueError):
            return None
        return value, self._none(value)

    def _combined(self, expression: Expression, arguments: list[Both]) -> Both | None:
        """By the rule of its operation."""
        function, symbol = expression.function, expression.symbol
        if symbol.startswith("["):
            (value, change), = arguments
            return function(value), function(change)
        if function in (operator.neg, operator.pos):
            return function(arguments[0][0]), function(arguments[0][1])
        if function not in _RULES:
            return None
        (a, da), (b, db) = arguments
        with np.errstate(all="ignore"):
            value = function(a, b)
            return np.asarray(value), _RULES[function](a[..., None], da, b[..., None], db, np.asarray(value)[..., None])


def _power(a: np.ndarray, da: np.ndarray, b: np.ndarray, db: np.ndarray, value: np.ndarray) -> np.ndarray:
    found = b * a ** (b - 1) * da
    return found + value * np.log(a) * db if db.any() else found


_RULES: dict[Any, Callable[..., np.ndarray]] = {
    operator.add: lambda a, da, b, db, value: da + db,
    operator.sub: lambda a, da, b, db, value: da - db,
    operator.mul: lambda a, da, b, db, value: a * db + b * da,
    operator.truediv: lambda a, da, b, db, value: (da - value * db) / b,
    operator.pow: _power,
}
