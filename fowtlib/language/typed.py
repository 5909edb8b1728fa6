"""What type checkers and editors know of the fields of a component; nothing imports this module when a program runs.

A parameter takes a number, a text with a unit, or a formula of other parameters. What it gives depends on where it is
read, a number, a formula or a CasADi symbol, so that reading one gives `Any`.
"""

from __future__ import annotations

import os
from collections.abc import Sequence
from typing import Any, Generic, TypeVar, overload

import numpy as np

from fowtlib.language.expressions import Arithmetic

Real = float | str | Arithmetic | np.number[Any] | np.ndarray[Any, Any]
Reals = Sequence[Real] | np.ndarray[Any, Any] | Arithmetic
T = TypeVar("T")


class _Given(Arithmetic):
    """A field whose value is a quantity; arithmetic on it in the class body makes a formula."""

    @overload
    def __get__(self, component: None, owner: type) -> Any: ...
    @overload
    def __get__(self, component: object, owner: type) -> Any: ...
    def __get__(self, component: object, owner: type) -> Any: ...

    def __getattr__(self, name: str) -> Any: ...


class Scalar(_Given):
    """One real number."""

    def __set__(self, component: object, value: Real) -> None: ...


class Vector(_Given):
    """Three real numbers, a column."""

    def __set__(self, component: object, value: Reals) -> None: ...


class Matrix(_Given):
    """Nine real numbers, 3 x 3."""

    def __set__(self, component: object, value: Sequence[Reals] | np.ndarray[Any, Any] | Arithmetic) -> None: ...


class Array(_Given):
    """Real numbers of the declared shape."""

    def __set__(self, component: object, value: Real | Reals | Sequence[Reals]) -> None: ...


class Data(Generic[T]):
    """What is read from a data file."""

    @overload
    def __get__(self, component: None, owner: type) -> Any: ...
    @overload
    def __get__(self, component: object, owner: type) -> T: ...
    def __get__(self, component: object, owner: type) -> Any: ...

    def __set__(self, component: object, value: str | os.PathLike[str] | T | None) -> None: ...


class Number(Arithmetic):
    """One real number that is no symbol."""

    @overload
    def __get__(self, component: None, owner: type) -> Any: ...
    @overload
    def __get__(self, component: object, owner: type) -> float: ...
    def __get__(self, component: object, owner: type) -> Any: ...

    def __set__(self, component: object, value: float | str | None) -> None: ...
