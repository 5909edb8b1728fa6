"""Derivatives of the equations of a model at many points of a run at once."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import casadi as ca
import numpy as np

from fowtlib.language.errors import SimulationError
from fowtlib.solving.differences import SMOOTH
from fowtlib.solving.functions import AtParameters, Functions
from fowtlib.solving.tangents.columns import mapped
from fowtlib.solving.tangents.directions import MovedData, RunDirections
from fowtlib.solving.tangents.torn import TornRows

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
    """Derivatives of rows at points: values (n, rows, columns), and where they can be other than zero.

    ends: where kinds of columns end. Columns are x, z, moving discrete variables, entries of p, which move by by_p
    (., m), and data, which move by dw.
    """

    row: np.ndarray
    column: np.ndarray
    ends: np.ndarray
    values: np.ndarray
    by_p: np.ndarray
    points: Points

    def blocks(self) -> Blocks:
        """Dense: by x, by z, by the moving discrete variables, and by parameters (n, rows, .)."""
        of_x, of_z, of_d, of_p, of_w = np.split(self.values, self.ends[1:-1], axis=2)
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

    def by(self, name: str, rows: ca.SX) -> TornRows:
        """Derivatives of rows; `name` tells them from others."""
        key = ("tangent", name, self.key)
        return self.functions.once(key, lambda: TornRows(self.functions, rows, self.columns))

    def entries(self, name: str, rows: ca.SX, points: Points, p: np.ndarray | None = None) -> Entries:
        """Derivatives of rows at points. p: parameters, where they are others than those of the run."""
        function = self.by(name, rows)
        ends = np.cumsum([0, *(column.numel() for column in self.columns)])
        values = function(points.t, points.x, points.z, points.q, self.at.parameters if p is None else p)
        return Entries(function.row, function.column, ends, values, self.by_p, points)

    def slopes(self, name: str, rows: ca.SX, points: Points) -> Blocks:
        """The same as blocks."""
        return self.entries(name, rows, points).blocks()

    def points(self, t: np.ndarray, x: np.ndarray, z: np.ndarray, q: np.ndarray) -> Points:
        """Points, with the changes of the data of external functions there."""
        m = len(self.run.elements)
        points = Points(np.asarray(t, dtype=float), x, z, q, np.zeros((len(t), len(self.outputs), m)))
        first = 0
        for number in self.externals:
            size = self._of(number).stop - self._of(number).start
            inputs = self._data.outputs(points.t, points.x, points.z, points.q, self.at.parameters)[1][number]
            for item in self.run.data:
                if item.external == number:
                    points.dw[:, first : first + size, item.column] = self._changes(number, item, inputs)
            first += size
        return points

    def _changes(self, number: int, item: MovedData, inputs: np.ndarray) -> np.ndarray:
        """Slopes of what an external function gives at its inputs (n, .) by the data behind it."""
        external = self.dae.externals[number]
        def values(handle: float | None) -> np.ndarray:
            moved = inputs.copy()
            if handle is not None:
                moved[:, item.place] = handle
            return mapped(external.function, [moved], len(moved))

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
    def _data(self) -> TornRows:
        """What reads the data that move."""
        return TornRows(self.functions, self.dae.w[self.outputs], [])

    @cached_property
    def equations(self) -> ca.SX:
        """Rows of ode and alg."""
        return ca.vertcat(self.dae.ode, self.dae.alg)
