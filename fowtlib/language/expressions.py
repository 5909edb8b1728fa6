"""Arithmetic on declared parameters that stays symbolic until the model is flattened.

`part(RigidBody, mass=mass / 2)` in a class body and `Unit(length=self.length / 3)` in `build()` both make an
`Expression`. It has a value at any time (`float(expression)`), and while flattening it becomes a CasADi expression of
the parameter symbols, so that a changed parameter reaches every part that depends on it.
"""

from __future__ import annotations

import operator
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from typing import Any

import numpy as np

from fowtlib.language.errors import ModelError
from fowtlib.language.placing import placed

Lookup = Callable[[Any], Any]


class Arithmetic:
    """Operators that build an `Expression` instead of computing."""

    def __add__(self, other: Any) -> Expression:
        return Expression(operator.add, "+", (self, other))

    def __radd__(self, other: Any) -> Expression:
        return Expression(operator.add, "+", (other, self))

    def __sub__(self, other: Any) -> Expression:
        return Expression(operator.sub, "-", (self, other))

    def __rsub__(self, other: Any) -> Expression:
        return Expression(operator.sub, "-", (other, self))

    def __mul__(self, other: Any) -> Expression:
        return Expression(operator.mul, "*", (self, other))

    def __rmul__(self, other: Any) -> Expression:
        return Expression(operator.mul, "*", (other, self))

    def __truediv__(self, other: Any) -> Expression:
        return Expression(operator.truediv, "/", (self, other))

    def __rtruediv__(self, other: Any) -> Expression:
        return Expression(operator.truediv, "/", (other, self))

    def __pow__(self, other: Any) -> Expression:
        return Expression(operator.pow, "**", (self, other))

    def __neg__(self) -> Expression:
        return Expression(operator.neg, "-", (self,))

    def __pos__(self) -> Arithmetic:
        return self

    def __getitem__(self, index: Any) -> Expression:
        if isinstance(index, int) and index < 0:
            index += np.asarray(evaluate(self)).shape[0]
        return Expression(lambda values: values[index], f"[{index}]", (self,))

    def __iter__(self):
        shape = np.asarray(evaluate(self)).shape
        if not shape:
            raise TypeError("a scalar parameter cannot be iterated over")
        return (self[i] for i in range(shape[0]))

    def __float__(self) -> float:
        return float(evaluate(self))

    def __array__(self, dtype: Any = None, copy: Any = None) -> np.ndarray:
        return np.asarray(evaluate(self), dtype=dtype)


class Expression(Arithmetic):
    """A function of parameters: an operation and its operands."""

    __slots__ = ("arguments", "function", "symbol")

    def __init__(self, function: Callable[..., Any], symbol: str, arguments: tuple[Any, ...]):
        self.function = function
        self.symbol = symbol
        self.arguments = arguments

    def __repr__(self) -> str:
        if self.symbol.startswith("["):
            return f"{self.arguments[0]!r}{self.symbol}"
        if len(self.arguments) == 2 and not self.symbol.isalpha():
            return f"({self.arguments[0]!r} {self.symbol} {self.arguments[1]!r})"
        return f"{self.symbol}({', '.join(map(repr, self.arguments))})"


class ParameterReference(Arithmetic):
    """A tunable parameter of one component instance, seen from outside of its equations."""

    __slots__ = ("component", "name")

    def __init__(self, component: Any, name: str):
        self.component = component
        self.name = name

    @property
    def value(self) -> Any:
        """The number (SI units) the parameter has now."""
        return evaluate(self)

    def __repr__(self) -> str:
        return f"{self.component.path}.{self.name}" if self.component.path else self.name


class StartNumbers(Arithmetic):
    """Numbers that a component computes when a run starts, as values of the parameters of its parts.

    `chain = StartNumbers(self, "chain", 7, chain_of)` in build(), then `RigidBody(mass=chain[0], ...)`: `compute(self)`
    gives them from the parameter values of the run, as `at_start` does inside equations(). While the model is flattened
    they are symbols, which no run needs new equations for.
    """

    __slots__ = ("component", "compute", "name", "size")

    def __init__(self, component: Any, name: str, size: int, compute: Callable[[Any], Any]):
        self.component, self.name, self.size, self.compute = component, name, size, compute

    def __repr__(self) -> str:
        return f"{self.component.path}.{self.name}" if self.component.path else self.name


def call(function: Callable[..., Any], name: str, *arguments: Any) -> Any:
    """`function(*arguments)`, delayed as an Expression where an argument is one."""
    if any(isinstance(argument, Arithmetic) for argument in arguments):
        return Expression(function, name, arguments)
    return function(*arguments)


def is_expression(value: Any) -> bool:
    """True where `value` or a member of it depends on parameters."""
    if not isinstance(value, (list, tuple)):
        return isinstance(value, Arithmetic)
    return any(is_expression(item) for item in value if type(item) is not float)


def leaves(value: Any) -> Iterator[Any]:
    """The parameters that an expression depends on."""
    if isinstance(value, Expression):
        for argument in value.arguments:
            yield from leaves(argument)
    elif isinstance(value, Arithmetic):
        yield value
    elif isinstance(value, (list, tuple)) and is_expression(value):
        for item in value:
            yield from leaves(item)


def evaluate(value: Any, lookup: Lookup | None = None, combine: Callable[[list[Any]], Any] | None = None) -> Any:
    """The value of an expression.

    `lookup` gives the value of a leaf (default: the number a referenced parameter has); `combine` makes one value of a
    sequence of values (default: a NumPy array).
    """
    lookup = lookup or _number
    combine = combine or np.asarray
    if isinstance(value, Expression):
        return value.function(*(evaluate(argument, lookup, combine) for argument in value.arguments))
    if isinstance(value, Arithmetic):
        return lookup(value)
    if isinstance(value, (list, tuple)) and is_expression(value):
        return combine([evaluate(item, lookup, combine) for item in value])
    return value


def rebind(value: Any, component: Any) -> Any:
    """The same expression with the parameters of a class body replaced by those of an instance of the class."""
    if isinstance(value, Expression):
        return Expression(value.function, value.symbol, tuple(rebind(item, component) for item in value.arguments))
    if isinstance(value, ParameterReference):
        return value
    if isinstance(value, Arithmetic):  # a declaration in the class body
        return getattr(component, value.name)
    if isinstance(value, (list, tuple)):
        return type(value)(rebind(item, component) for item in value)
    return value


_reads: ContextVar[set[tuple[str, str]] | None] = ContextVar("reads", default=None)


@contextmanager
def parameters_read() -> Iterator[set[tuple[str, str]]]:
    """The parameters whose values are asked for in between: path of the component, and name."""
    found: set[tuple[str, str]] = set()
    token = _reads.set(found)
    try:
        yield found
    finally:
        _reads.reset(token)


def reads_now() -> set[tuple[str, str]] | None:
    """Where the parameters are noted whose values are asked for; None: nowhere."""
    return _reads.get()


_known: ContextVar[dict[Any, Any] | None] = ContextVar("known", default=None)


def known_now() -> dict[Any, Any] | None:
    """The values of the evaluation at hand; None outside of one."""
    return _known.get()


@contextmanager
def one_evaluation() -> Iterator[dict[Any, Any]]:
    """Values of parameters while nothing sets any: each is computed once, however many ways lead to it."""
    known = _known.get()
    if known is not None:
        yield known
        return
    token = _known.set(known := {})
    try:
        yield known
    finally:
        _known.reset(token)


@contextmanager
def evaluation_again(known: dict[Any, Any], reads: set[tuple[str, str]] | None = None) -> Iterator[None]:
    """An evaluation that has values of an earlier one, and notes in `reads`, if given, which parameters it asks for.

    Whoever keeps both sees to it that nothing that was read has changed, and holds the components.
    """
    tokens = _reads.set(reads), _known.set(known)
    try:
        yield
    finally:
        _known.reset(tokens[1])
        _reads.reset(tokens[0])


def remembered(key: Any, held: Any, compute: Callable[[], Any]) -> Any:
    """What `compute` says, once in an evaluation by its key; what it reads is noted wherever it is asked for.

    held: what the key names by its id, which stays its own.
    """
    reads, known = _reads.get(), _known.get()
    if known is None:
        with one_evaluation():
            return remembered(key, held, compute)
    found = known.get(key)
    if found is None or (reads is not None and found[1] is None):
        own: set[tuple[str, str]] | None = None if reads is None else set()
        token = _reads.set(own)
        try:
            found = known[key] = compute(), own, held
        finally:
            _reads.reset(token)
    if reads is not None:
        reads |= found[1]
    return found[0]


def value_of(owner: Any, what: str, compute: Callable[[], Any]) -> Any:
    """What follows from the values of parameters alone: computed once in an evaluation, by its owner and a word."""
    return remembered((id(owner), "value of", what), owner, compute)


def _number(leaf: Any) -> Any:
    if isinstance(leaf, StartNumbers):
        return remembered((id(leaf), "number"), leaf, lambda: _started(leaf))
    if not isinstance(leaf, ParameterReference):
        raise TypeError(f"{leaf!r} has no value outside of an instance")
    return leaf.component.current.parameter_value(leaf.name)


def _started(leaf: StartNumbers) -> np.ndarray:
    try:
        return np.asarray(leaf.compute(leaf.component), dtype=float)
    except ModelError as error:
        raise placed(error, leaf.component) from None
