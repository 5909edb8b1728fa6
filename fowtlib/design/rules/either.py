"""Mathematics of what is either numbers and NumPy arrays or CasADi expressions, and checks of the former."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from functools import wraps
from typing import Any, TypeVar, cast

import casadi as ca
import numpy as np

from fowtlib.language.errors import ModelError

_EXPRESSIONS = (ca.SX, ca.MX, ca.DM)

F = TypeVar("F", bound=Callable[..., Any])


def of_arrays(rule: F) -> F:
    """A rule that takes lists as arrays, and refuses texts and arrays whose sizes do not fit (ModelError).

    Its quantities are those of its arguments that are annotated as Any.
    """
    signature = inspect.signature(rule)
    quantities = {name for name, item in signature.parameters.items() if item.annotation in (Any, "Any")}
    title = rule.__name__

    @wraps(rule)
    def checked(*args: Any, **kwargs: Any) -> Any:
        given = signature.bind(*args, **kwargs)
        shapes = {}
        for name, value in given.arguments.items():
            if name not in quantities or value is None or is_expression(value):
                continue
            if not isinstance(value, (int, float, np.ndarray, np.generic)):
                try:
                    given.arguments[name] = value = np.asarray(value, dtype=float)
                except (TypeError, ValueError):
                    raise ModelError(f"{title}: {name} is {value!r}; a number or an array in SI units is expected, "
                                     "without a unit.") from None  # fmt: skip
            shapes[name] = np.shape(value)
        try:
            np.broadcast_shapes(*shapes.values())
        except ValueError:
            sizes = ", ".join(f"{name} {shape}" for name, shape in shapes.items() if shape)
            raise ModelError(f"{title}: the arrays are of sizes that do not fit each other: {sizes}.") from None
        return rule(*given.args, **given.kwargs)

    return cast(F, checked)


def is_expression(*values: Any) -> bool:
    """Whether any of them is of CasADi."""
    return any(isinstance(value, _EXPRESSIONS) for value in values)


def _one(name: str) -> Any:
    def function(x: Any) -> Any:
        return getattr(ca if is_expression(x) else np, name)(x)

    function.__name__, function.__doc__ = name, f"{name} of numbers, arrays or expressions."
    return function


sqrt, exp, log, sin, cos, tan, sinh, cosh = (
    _one(name) for name in ("sqrt", "exp", "log", "sin", "cos", "tan", "sinh", "cosh")
)


def atan(x: Any) -> Any:
    """Arc tangent."""
    return ca.atan(x) if is_expression(x) else np.arctan(x)


def asinh(x: Any) -> Any:
    """Inverse hyperbolic sine."""
    return ca.asinh(x) if is_expression(x) else np.arcsinh(x)


def size(x: Any) -> Any:
    """Absolute value."""
    return ca.fabs(x) if is_expression(x) else np.abs(x)


def larger(a: Any, b: Any) -> Any:
    """The larger of two; a kink where they are equal."""
    return ca.fmax(a, b) if is_expression(a, b) else np.maximum(a, b)


def smaller(a: Any, b: Any) -> Any:
    """The smaller of two; a kink where they are equal."""
    return ca.fmin(a, b) if is_expression(a, b) else np.minimum(a, b)


def choose(condition: Any, then: Any, otherwise: Any) -> Any:
    """One of two, both of which are computed and must be finite everywhere."""
    if is_expression(condition, then, otherwise):
        return ca.if_else(condition, then, otherwise)
    return np.where(condition, then, otherwise)[()]


def total(x: Any) -> Any:
    """Sum of all elements."""
    return ca.sum1(ca.vec(x)) if is_expression(x) else np.sum(x)


def between(values: Any) -> tuple[Any, Any]:
    """Values (n,) at nodes as those below and above each of the n - 1 sections."""
    if not is_expression(values):
        values = np.asarray(values, dtype=float)
    return values[:-1], values[1:]


def demand(rule: str, least: float, **values: Any) -> None:
    """ModelError for numbers at or below `least`, or not finite, by name; expressions pass, they have no value yet."""
    for name, value in values.items():
        if is_expression(value):
            continue
        numbers = np.asarray(value, dtype=float)
        if not np.all(np.isfinite(numbers) & (numbers > least)):
            wrong = np.ravel(numbers)[~np.ravel(np.isfinite(numbers) & (numbers > least))][0]
            raise ModelError(f"{rule}: {name} is {wrong:g}; it must be above {least:g}.")


def demand_not_negative(rule: str, **values: Any) -> None:
    """ModelError for numbers below zero, or not finite, by name; expressions pass."""
    for name, value in values.items():
        if is_expression(value):
            continue
        numbers = np.ravel(np.asarray(value, dtype=float))
        wrong = numbers[~(np.isfinite(numbers) & (numbers >= 0))]
        if wrong.size:
            raise ModelError(f"{rule}: {name} is {wrong[0]:g}; it must be 0 or more.")


def demand_within(rule: str, low: float, high: float, source: str, **values: Any) -> None:
    """ModelError for numbers outside of what a rule was made for; expressions pass."""
    for name, value in values.items():
        if is_expression(value):
            continue
        numbers = np.ravel(np.asarray(value, dtype=float))
        wrong = numbers[~((numbers >= low) & (numbers <= high))]
        if wrong.size:
            raise ModelError(f"{rule}: {name} is {wrong[0]:g}; {source} holds from {low:g} to {high:g}.")


def demand_nodes(rule: str, **values: Any) -> None:
    """ModelError unless all have the same number of nodes (n,), two or more."""
    counts = {name: value.numel() if is_expression(value) else np.size(value) for name, value in values.items()}
    if len(set(counts.values())) > 1 or min(counts.values()) < 2:
        told = ", ".join(f"{name} {count}" for name, count in counts.items())
        raise ModelError(f"{rule}: each quantity has a value at each node, and there are two nodes or more; given are "
                         f"{told}.")  # fmt: skip
