"""CasADi functions called with NumPy arrays: into memory that is there, without CasADi's matrices between.

A matrix of CasADi becomes an array by way of a list of numbers, which takes longer than what computed it.
"""

from __future__ import annotations

from functools import cached_property
from threading import Lock
from typing import Any

import casadi as ca
import numpy as np


class Arrays:
    """A function with dense arguments: its results as arrays, or the entries of their sparsity alone.

    Raises RuntimeError where the function does.
    """

    def __init__(self, function: ca.Function):
        self.function = function
        self._arguments = [np.zeros(function.nnz_in(k)) for k in range(function.n_in())]
        self._results = [np.zeros(function.nnz_out(k)) for k in range(function.n_out())]
        self._buffer, self._evaluate = function.buffer()
        for k, array in enumerate(self._arguments):
            self._buffer.set_arg(k, memoryview(array))
        for k, array in enumerate(self._results):
            self._buffer.set_res(k, memoryview(array))
        self._lock = Lock()

    def entries(self, *arguments: Any) -> list[np.ndarray]:
        """The entries of each result, column by column."""
        with self._lock:
            for array, value in zip(self._arguments, arguments, strict=True):
                array[:] = np.ravel(value)
            self._evaluate()
            if self._buffer.ret():
                raise RuntimeError(f"{self.function.name()} cannot be evaluated")
            return [array.copy() for array in self._results]

    def __call__(self, *arguments: Any) -> list[np.ndarray]:
        """Each result as a matrix."""
        found = []
        for entries, (rows, columns, shape) in zip(self.entries(*arguments), self.places, strict=True):
            matrix = np.zeros(shape)
            matrix[rows, columns] = entries
            found.append(matrix)
        return found

    @cached_property
    def places(self) -> list[tuple[np.ndarray, np.ndarray, tuple[int, int]]]:
        """Of each result: rows and columns of its entries, and its shape."""
        patterns = [self.function.sparsity_out(k) for k in range(self.function.n_out())]
        return [(np.array(of.row(), int), np.array(of.get_col(), int), of.shape) for of in patterns]
