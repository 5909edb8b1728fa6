"""Derivatives of the equations of a model at many points of a run at once."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import casadi as ca
import numpy as np

from fowtlib.language.errors import SimulationError
from fowtlib.solving.differences import SMOOTH
from fowtlib.solving.functions import POINTS, AtParameters, Functions
from fowtlib.solving.tangents.directions import MovedData, RunDirections

Blocks = list[np.ndarray]

DATA_ROUNDING = 1e-11  # of data over their size


@dataclass(frozen=True, eq=False)
class Points:
    """Points of a run: t (n,), x (n, n_x), z (n, n_z), q = [u; d] (n, n_q); changes of data dw (n, n_w, m)."""

    t: np.ndarray
    x: np.ndarray
    z: np.ndarray
    q: np.ndarray
    dw: np.ndarray

    def part(self, which: slice | np.ndarray) -> Points:
        """Some of them."""
        return Points(self.t[which], self.x[which], self.z[which], self.q[which], self.dw[which])


@dataclass(frozen=True, eq=False)
class Entries:
    """Derivatives of rows at points (n, nonzero): rows and columns of the entries, and where kinds of columns end.

    Columns are x, z, moving discrete variables, entries of p, which move by by_p (., m), and data, which move by dw.
    """

    row: np.ndarray
    column: np.ndarray
    rows: int
    ends: np.ndarray
    values: np.ndarray
    by_p: np.ndarray
    points: Points

    def blocks(self) -> Blocks:
        """Dense: by x, by z, by the moving discrete variables, and by parameters (n, rows, .)."""
        dense = np.zeros((len(self.values), self.rows, self.ends[-1]))
        dense[:, self.row, self.column] = self.values
        of_x, of_z, of_d, of_p, of_w = np.split(dense, self.ends[1:-1], axis=2)
        return [of_x, of_z, of_d, of_p @ self.by_p + of_w @ self.points.dw]

    def split(self, counts: Sequence[int]) -> list[Entries]:
        """Those of consecutive groups of points."""
        ends = np.cumsum(counts)
        parts = [slice(last - count, last) for count, last in zip(counts, ends.tolist(), strict=True)]
        return [replace(self, values=self.values[part], points=self.points.part(part)) for part in parts]


class Linearised:
    """The model along a run, in the directions of parameters.

    moving: numbers of the discrete variables that move with parameters. Columns of all derivatives are those by x, z,
    the moving discrete variables, and the m parameters: what they do at fixed x, z and d.
    """

    def __init__(self, at: AtParameters, run: RunDirections, moving: Sequence[int]):
        self.at, self.dae, self.run, self.moving = at, at.dae, run, list(moving)
        self.used = np.flatnonzero(np.any(run.numbers != 0, axis=1))  # entries of p
        self.by_p = run.numbers[self.used]
        self.externals = sorted({item.external for item in run.data})
        self.functions = self._functions(at)
        self.given_before_d = self.dae.u.numel()
        before = self.given_before_d + self.dae.d.numel()
        q = self.functions.q
        discrete, numbers = [self.given_before_d + k for k in self.moving], (before + self.used).tolist()
        outputs = [k for number in self.externals for k in range(*self._of(number).indices(self.dae.w.numel()))]
        self.outputs = outputs
        chosen = ((q, discrete), (q, numbers), (self.dae.w, outputs))
        self.columns = [self.dae.x, self.dae.z, *(of[which] if which else ca.SX(0, 1) for of, which in chosen)]
        self.key = (tuple(discrete), tuple(numbers), tuple(outputs))

    def _of(self, number: int) -> slice:
        return self.dae.externals[number].outputs

    def _functions(self, at: AtParameters) -> Functions:
        """Those in which the parameters that move are symbols, also where they are zero."""
        zeros = at.functions.zeros - set(self.used.tolist())
        if zeros == at.functions.zeros:
            return at.functions
        return at.general.once(("with zeros", zeros), lambda: Functions(self.dae, zeros))

    def by(self, name: str, rows: ca.SX) -> ca.Function:
        """`(t, x, z, q) -> entries of the derivatives of rows`; its pattern is that of `pattern`."""
        key = ("tangent", name, self.key, rows.__hash__() if name == "" else name)

        def make() -> tuple[ca.Function, ca.Sparsity]:
            functions = self.functions
            whole = functions.torn_jacobian("tangent", ca.vec(ca.densify(rows)), self.columns)
            arguments = [ca.MX.sym(n, *v.shape) for n, v in zip("txzq", functions._arguments, strict=True)]
            blocks = whole(*arguments)
            matrix = ca.horzcat(*(blocks if isinstance(blocks, (list, tuple)) else [blocks]))
            entries = ca.vec(matrix.nz[:]) if matrix.nnz() else ca.MX(0, 1)
            return ca.Function("tangent_entries", arguments, [entries]), matrix.sparsity()

        return self.functions.once(key, make)

    def entries(self, name: str, rows: ca.SX, points: Points, p: np.ndarray | None = None) -> Entries:
        """Derivatives of rows at points. p: parameters, where they are others than those of the run."""
        function, pattern = self.by(name, rows)
        ends = np.cumsum([0, *(column.numel() for column in self.columns)])
        row, column = (np.array(numbers, dtype=np.intc) for numbers in (pattern.row(), pattern.get_col()))
        return Entries(row, column, pattern.shape[0], ends, self.evaluated(function, points, p), self.by_p, points)

    def slopes(self, name: str, rows: ca.SX, points: Points) -> Blocks:
        """The same as blocks."""
        return self.entries(name, rows, points).blocks()

    def evaluated(self, function: ca.Function, points: Points, p: np.ndarray | None = None) -> np.ndarray:
        """Rows of the values of a function at points."""
        p = self.at.parameters if p is None else p
        n, found, first = len(points.t), [], 0
        columns = (points.t[None], points.x.T, points.z.T)
        for size in POINTS:
            if (n - first) // size:
                at_once = self.functions.along(function, size)
            for _ in range((n - first) // size):
                part = slice(first, first + size)
                found.append(np.array(at_once(*(c[:, part] for c in columns), points.q.T[:, part], p)))
                first += size
        return np.concatenate(found, axis=1).T if found else np.zeros((0, function.size1_out(0)))

    def points(self, t: np.ndarray, x: np.ndarray, z: np.ndarray, q: np.ndarray) -> Points:
        """Points, with the changes of the data of external functions there."""
        m = len(self.run.elements)
        points = Points(np.asarray(t, dtype=float), x, z, q, np.zeros((len(t), len(self.outputs), m)))
        first = 0
        for number in self.externals:
            size = self._of(number).stop - self._of(number).start
            inputs = self.evaluated(self._inputs[number], points)
            for item in self.run.data:
                if item.external == number:
                    points.dw[:, first : first + size, item.column] = self._changes(number, item, inputs)
            first += size
        return points

    def _changes(self, number: int, item: MovedData, inputs: np.ndarray) -> np.ndarray:
        """Slopes of what an external function gives at its inputs (n, .) by the data behind it."""
        external, n = self.dae.externals[number], len(inputs)
        many = self.functions.once(("mapped", number, n), lambda: external.function.map(n))

        def values(handle: float | None) -> np.ndarray:
            moved = inputs.copy()
            if handle is not None:
                moved[:, item.place] = handle
            return np.array(many(moved.T)).reshape(-1, n, order="F").T

        above, below, here = values(item.above), values(item.below), values(None)
        slope, bent = (above - below) / (2 * item.step), (above - 2 * here + below) / item.step
        limit = SMOOTH * np.abs(slope).max() + DATA_ROUNDING * np.abs(here).max() / item.step
        if np.any(np.abs(bent) > limit):
            raise SimulationError(
                f"{external.path}: its data have a kink or a jump where {self.run.elements[item.column].name} is now, "
                "and no derivative. Take another value, beside it."
            )
        return slope

    @cached_property
    def _inputs(self) -> dict[int, ca.Function]:
        return {k: self.functions.function("data_inputs", [ca.vec(ca.densify(self.dae.externals[k].inputs))])
                for k in self.externals}  # fmt: skip

    @cached_property
    def equations(self) -> ca.SX:
        """Rows of ode and alg."""
        return ca.vertcat(self.dae.ode, self.dae.alg)
