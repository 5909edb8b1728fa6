"""Derivatives of rows of a flat model at many points at once, torn at its external functions."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import casadi as ca
import numpy as np

from fowtlib.solving.functions import Functions
from fowtlib.solving.tangents.columns import Program, add_product, mapped


@dataclass(frozen=True, eq=False)
class _External:
    """An external through whose inputs rows depend on the columns; place: of its outputs among those of all of them."""

    number: int
    place: slice
    by_columns: _Piece
    by_w: _Piece
    slope: ca.Function


@dataclass(frozen=True, eq=False)
class _Piece:
    """A matrix among the results of a program: its place there, shape, and where it can be other than zero."""

    place: slice
    shape: tuple[int, int]
    pattern: np.ndarray

    def of(self, values: np.ndarray) -> np.ndarray:
        """Matrices (n, rows, columns) from rows of results."""
        return values[:, self.place].reshape(-1, *self.shape)


class TornRows:
    """Rows of a flat model and their total derivatives by columns, which are symbols of x, z, u, d, p or w.

    row, column: of the entries of the derivatives that can be other than zero.
    """

    def __init__(self, functions: Functions, rows: ca.SX, columns: Sequence[ca.SX]):
        self.functions, self.dae = functions, functions.dae
        self.rows = functions.without_zeros([ca.vec(ca.densify(rows))])[0]
        by = ca.vertcat(*columns)
        self.shape = self.rows.numel(), by.numel()
        self.needed = functions.needed([self.rows])
        self._levels = self._inputs()
        moved = self._moved(by)
        w = ca.vertcat(ca.SX(0, 1), *(functions.w[self.dae.externals[k].outputs] for k, _ in moved))
        self._entries: list[ca.SX] = []
        self._places: list[np.ndarray] = []
        self._width = 0
        self.direct, self.by_w = self._piece(self.rows, by), self._piece(self.rows, w)
        self.through, first = [], 0
        for k, y in moved:
            size = external_size(self.dae.externals[k].outputs)
            place = slice(first, first := first + size)
            self.through.append(_External(k, place, self._piece(y, by), self._piece(y, w), self._slope(k)))
        function = self._function("derivatives", ca.vertcat(ca.SX(0, 1), *self._entries))
        self.program = Program(function, np.concatenate(self._places), self._width)
        self.row, self.column = (numbers.astype(np.intc) for numbers in np.nonzero(self._pattern()))

    def _function(self, name: str, column: ca.SX) -> ca.Function:
        dae = self.dae
        arguments = [dae.t, dae.x, dae.z, ca.vertcat(dae.u, dae.d), dae.p, dae.w]
        return ca.Function(name, arguments, [ca.densify(column)], {"cse": True})

    def _inputs(self) -> list[tuple[list[int], Program]]:
        """For each level of externals those that are needed, and their inputs one below the other."""
        found = []
        for group in self.dae.levels:
            members = [k for k in group if k in self.needed]
            if members:
                y = ca.vertcat(*[ca.vec(ca.densify(self.functions.external_inputs[k])) for k in members])
                found.append((members, Program(self._function("inputs", y))))
        return found

    def _moved(self, by: ca.SX) -> list[tuple[int, ca.SX]]:
        """Externals whose inputs depend on the columns, directly or through others, in the order of their levels."""
        moved: list[int] = []
        found = []
        for members, _ in self._levels:
            for k in members:
                y = ca.vec(ca.densify(self.functions.external_inputs[k]))
                outputs = [self.functions.w[self.dae.externals[i].outputs] for i in moved]
                if ca.depends_on(y, ca.vertcat(by, *outputs)):
                    moved.append(k)
                    found.append((k, y))
        return found

    def _piece(self, rows: ca.SX, by: ca.SX) -> _Piece:
        matrix = ca.sparsify(ca.jacobian(rows, by))
        row, column = (np.array(of, dtype=int) for of in (matrix.sparsity().row(), matrix.sparsity().get_col()))
        self._entries += matrix.nonzeros()
        self._places.append(self._width + row * matrix.shape[1] + column)
        first, self._width = self._width, self._width + matrix.numel()
        pattern = np.zeros(matrix.shape, dtype=bool)
        pattern[row, column] = True
        return _Piece(slice(first, self._width), matrix.shape, pattern)

    def _slope(self, k: int) -> ca.Function:
        """The Jacobian of an external as one dense column."""
        jacobian = self.functions.external_jacobian(k)
        y = ca.MX.sym("y", jacobian.numel_in(0))
        return ca.Function("slope", [y], [ca.vec(ca.densify(jacobian(y)))])

    def _pattern(self) -> np.ndarray:
        moved = np.zeros((self.by_w.shape[1], self.shape[1]), dtype=bool)
        for item in self.through:
            inputs = item.by_columns.pattern | (item.by_w.pattern.astype(int) @ moved > 0)
            moved[item.place] = inputs.any(axis=0)
        return self.direct.pattern | (self.by_w.pattern.astype(int) @ moved > 0)

    # --- at points -----------------------------------------------------------------------------------------------

    def outputs(self, t: np.ndarray, x: np.ndarray, z: np.ndarray, q: np.ndarray, p: np.ndarray) \
            -> tuple[np.ndarray, dict[int, np.ndarray]]:  # fmt: skip
        """Outputs of the externals (n, n_w) at points, and the inputs of each that is needed (n, .)."""
        w, inputs = np.zeros((len(t), self.dae.w.numel())), {}
        for members, program in self._levels:
            values = program([t[:, None], x, z, q, p, w])
            first = 0
            for k in members:
                external = self.dae.externals[k]
                size = external.inputs.numel()
                inputs[k] = np.ascontiguousarray(values[:, first : first + size])
                w[:, external.outputs] = mapped(external.function, [inputs[k]], len(t))
                first += size
        return w, inputs

    def __call__(self, t: np.ndarray, x: np.ndarray, z: np.ndarray, q: np.ndarray, p: np.ndarray) -> np.ndarray:
        """Derivatives (n, rows, columns) at points: rows of t, x, z and q = [u; d]; p is the same at all of them."""
        w, inputs = self.outputs(t, x, z, q, p)
        values = self.program([t[:, None], x, z, q, p, w])
        total = self.direct.of(values)
        if not self.through:
            return total
        moved = np.zeros((len(t), self.by_w.shape[1], self.shape[1]))
        for item in self.through:
            change = item.by_columns.of(values)  # of the inputs of the external
            add_product(change, item.by_w.of(values), moved)
            slopes = mapped(item.slope, [inputs[item.number]], len(t)).reshape(len(t), change.shape[1], -1)
            found = np.zeros((len(t), slopes.shape[2], self.shape[1]))
            add_product(found, np.ascontiguousarray(slopes.transpose(0, 2, 1)), change)
            moved[:, item.place] = found
        add_product(total, self.by_w.of(values), moved)
        return total


def external_size(outputs: slice) -> int:
    """Number of outputs of an external."""
    return outputs.stop - outputs.start
