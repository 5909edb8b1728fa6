"""Matrices with names of rows and columns, that are matrices to `@` and to numpy.linalg as well."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import xarray

from fowtlib.language.errors import ModelError


class LabelledMatrix(xarray.DataArray):
    """An xarray.DataArray whose `@` and `dot` are the matrix product, last axis with first, as those of its numbers.

    xarray sums over the axes that have one name in both: of C (output, state) and A (rate, state) that is C A'. Names
    of rows and columns stay where both factors have them. What numpy.linalg makes of it is plain numbers. Element by
    element, `+` and the like, axes of other names or in another order are refused, which xarray would put in order by
    their names: A + A.T. With `dim=`, `dot` is that of xarray.
    """

    __slots__ = ()

    def __matmul__(self, other: Any) -> Any:
        return _product(self, other)

    def __rmatmul__(self, other: Any) -> Any:
        return _product(other, self)

    def dot(self, other: Any, dim: Any = None) -> Any:
        """The matrix product; over `dim`, where it is given, by names."""
        return _product(self, other) if dim is None else super().dot(other, dim)

    def __array_ufunc__(self, ufunc: Any, method: str, *inputs: Any, **kwargs: Any) -> Any:
        if ufunc is np.matmul and method == "__call__" and not kwargs:
            return _product(*inputs)
        _check_axes(inputs)
        return super().__array_ufunc__(ufunc, method, *inputs, **kwargs)

    def __array_wrap__(self, obj: Any, context: Any = None, return_scalar: bool = False) -> Any:
        """What numpy makes of the numbers alone has not the names: they are of what was put in."""
        return obj[()] if return_scalar else np.asarray(obj)

    def _unary_op(self, f: Any, *args: Any, **kwargs: Any) -> Any:
        return type(self)(xarray.DataArray(self)._unary_op(f, *args, **kwargs))  # xarray does it by __array_wrap__

    def _binary_op(self, other: Any, f: Any, reflexive: bool = False) -> Any:
        _check_axes((self, other))
        return super()._binary_op(other, f, reflexive)


def labelled(name: str, numbers: np.ndarray, rows: tuple[str, Sequence[str]],
             columns: tuple[str, Sequence[str]]) -> LabelledMatrix:  # fmt: skip
    """A matrix with what its rows and columns are called, each with the names in it."""
    coordinates = {axis: list(names) for axis, names in (rows, columns)}
    return LabelledMatrix(numbers, dims=(rows[0], columns[0]), coords=coordinates, name=name)


def _product(left: Any, right: Any) -> Any:
    factors = [np.asarray(item) for item in (left, right)]
    try:
        found = np.matmul(*factors)
    except ValueError:
        sizes = " and ".join(" x ".join(map(str, item.shape)) for item in factors)
        raise ModelError(f"there is no matrix product of {sizes}.") from None
    axes = []
    for item, numbers, kept in ((left, factors[0], slice(None, -1)), (right, factors[1], slice(1, None))):
        named = isinstance(item, xarray.DataArray)
        places = [0, 1][: numbers.ndim][kept] if numbers.ndim <= 2 else []
        axes += [(item.dims[k], item.coords.get(item.dims[k])) if named else None for k in places]
    if None in axes or len(axes) != found.ndim or len({axis[0] for axis in axes if axis}) < len(axes) or not axes:
        return found
    coordinates = {name: values.variable for name, values in axes if values is not None}
    return LabelledMatrix(found, dims=[name for name, _ in axes], coords=coordinates)


def _check_axes(items: Sequence[Any]) -> None:
    """Two matrices, element by element."""
    named = [item for item in items if isinstance(item, xarray.DataArray) and item.ndim == 2]
    for one in named[1:]:
        if one.dims != named[0].dims:
            raise ModelError(
                f"the axes {named[0].dims} and {one.dims} are not the same, and xarray would match those of labelled "
                "matrices by name, not by place; take the numbers, np.asarray(...), or linear.matrices['A']."
            )
