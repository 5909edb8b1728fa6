"""Second derivatives of a flat model, pulled back: the gradients of any combinations of the entries of its Jacobian.

With rows r(v, w) of the model, w the outputs of its externals and v = [x; z; u; d; p], and with directions V_c in which
v moves (and w, where a signal is what moves), this gives

    d/dv sum_c W_c . (dr/dv V_c),

the total derivative through the externals. The sum is one of the entries of the Jacobian with weights, sum_c W_c V_c',
of which only those that are not zero by structure are asked: one reverse sweep of the sparse Jacobian for any number of
directions. It is torn at the externals as everything else: they give their exact Jacobian, and its own derivative is
exact for splines and by differences of fourth order for compiled code. Made once for a plant.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property

import casadi as ca
import numpy as np
from scipy import sparse

from fowtlib.flattening import FlatDAE
from fowtlib.language.tables import SplineFunction
from fowtlib.solving.arrays import Arrays
from fowtlib.solving.differences import derivative
from fowtlib.solving.functions import AtParameters, Functions
from fowtlib.solving.initial import csc


@dataclass(frozen=True, eq=False)
class Directions:
    """Directions, a column each: of v (n_v, c), and what is added to the outputs of externals (n_w, c)."""

    v: np.ndarray
    w: np.ndarray


class _Torn:
    """Expressions of (v, w) as functions: Jacobians, and gradients of sums of the entries of the one by what moves.

    moving: numbers of the entries of [v; w] in whose directions anything moves. alone: rows that have a function each,
    as a scalar asks for hardly more than one of them.
    """

    def __init__(self, functions: Functions, rows: ca.SX, moving: np.ndarray, alone: slice = slice(0)):
        self._arguments = [functions.t, functions.x, functions.z, functions.q, functions.w]
        self._rows, self._moving, self._alone = ca.cse(ca.vec(ca.densify(rows))), moving, alone
        v = ca.vertcat(functions.x, functions.z, functions.q)
        self._both, self.nv = ca.vertcat(v, functions.w), v.numel()
        jacobian = ca.jacobian(self._rows, self._both)  # without "cse": of a million instructions it takes minutes
        self.jacobian = ca.Function("jacobian", self._arguments, [jacobian[:, : self.nv], jacobian[:, self.nv :]])

    @cached_property
    def _second(self) -> tuple[np.ndarray, np.ndarray, list[tuple[Arrays, np.ndarray]]]:
        """Rows and columns of the entries, and gradients by [v; w] of sums of some of them times weights, and which."""
        jacobian = ca.jacobian(self._rows, self._both[self._moving.tolist()])
        row, column = (np.array(numbers, dtype=int) for numbers in jacobian.sparsity().get_triplet())
        entries, made = ca.vertcat(*jacobian.nonzeros()), []
        alone = range(*self._alone.indices(self._rows.numel()))
        for chosen in (~np.isin(row, alone), *(row == one for one in alone)):
            which = np.flatnonzero(chosen)
            weights = ca.SX.sym("weights", which.size)
            slope = ca.gradient(ca.dot(weights, entries[which.tolist()]), self._both)
            made.append((Arrays(ca.Function("second", [*self._arguments, weights], [ca.densify(slope)])), which))
        return row, column, made

    def pulled(self, point: list[np.ndarray], directions: np.ndarray, weights: np.ndarray) -> np.ndarray:
        """Gradients by [v; w] (n_v + n_w, k) of the sums over all columns, for weights (k, rows, columns)."""
        total = np.zeros((len(directions), len(weights)))
        if not np.any(weights):
            return total
        row, column, made = self._second
        entries = _entries(weights, directions[self._moving], row, column)
        for second, which in made:
            for k in np.flatnonzero(entries[:, which].any(axis=1)):
                total[:, k] += second.entries(*point, entries[k, which])[0]
        return total


def _entries(weights: np.ndarray, moved: np.ndarray, row: np.ndarray, column: np.ndarray) -> np.ndarray:
    """Of products of weights (k, rows, c) and moved' (c, n) the elements at rows and columns: (k, elements).

    Most of what moves does so in one direction alone.
    """
    count = np.count_nonzero(moved, axis=1)
    alone, several = np.flatnonzero(count == 1), np.flatnonzero(count > 1)
    place = np.full(len(moved), -1)
    place[alone] = np.argmax(moved[alone] != 0, axis=1)
    found = np.zeros((len(weights), row.size))
    at = np.flatnonzero(place[column] >= 0)
    found[:, at] = weights[:, row[at], place[column[at]]] * moved[column[at], place[column[at]]]
    if several.size:
        place[:], place[several] = -1, np.arange(several.size)
        at = np.flatnonzero(place[column] >= 0)
        found[:, at] = (weights @ moved[several].T)[:, row[at], place[column[at]]]
    return found


class Pullback:
    """Rows of a flat model, to be pulled back at points.

    rows: expressions of the flat model. key: what they are, for what was made before. columns: symbols of [u; d; p]
    that move; x, z and the outputs of externals always do. Parameters count as symbols, also those that are zero.
    alone: rows of which a scalar asks for one or so.
    """

    def __init__(self, at: AtParameters, key: tuple[object, ...], rows: Callable[[], ca.SX],
                 columns: Sequence[ca.SX] = (), alone: slice = slice(0)):  # fmt: skip
        functions = at.general
        self.at, self.functions, self.dae = at, functions, at.dae
        self._columns = columns
        self.rows = functions.once(("pullback", *key), lambda: _Torn(functions, rows(), self._moving, alone))
        self.levels = functions.once(("pullback levels", *(item.element_hash() for item in columns)), self._levels)

    @property
    def _moving(self) -> np.ndarray:
        functions = self.functions
        first, asked = functions.x.numel() + functions.z.numel(), {item.element_hash() for item in self._columns}
        q = [k for k, item in enumerate(functions.q.elements()) if item.element_hash() in asked]
        last = first + functions.q.numel()
        return np.r_[0:first, first + np.array(q, dtype=int), last : last + functions.w.numel()]

    def _levels(self) -> list[tuple[list[int], list[slice], _Torn]]:
        """For each level of externals their numbers, where their inputs are among the rows, and these."""
        made = []
        for group in self.dae.levels:
            inputs = [ca.vec(ca.densify(self.dae.externals[k].inputs)) for k in group]
            ends = np.cumsum([0, *(column.numel() for column in inputs)])
            places = [slice(int(a), int(b)) for a, b in zip(ends[:-1], ends[1:], strict=True)]
            made.append((list(group), places, _Torn(self.functions, ca.vertcat(*inputs), self._moving)))
        return made

    def point(self, t: float, x: np.ndarray, z: np.ndarray, q: np.ndarray) -> Point:
        """The same at a point; q = [u; d]."""
        return Point(self, t, x, z, self.at.whole(q))


class Point:
    """Where rows are pulled back: Jacobians by v and w there, and those of the externals."""

    def __init__(self, owner: Pullback, t: float, x: np.ndarray, z: np.ndarray, q: np.ndarray):
        self.owner, dae = owner, owner.dae
        self.w = np.zeros(dae.w.numel())
        self.here = [np.array([t]), x, z, q, self.w]
        self.inputs: dict[int, np.ndarray] = {}
        self.slopes: dict[int, np.ndarray] = {}
        self.levels: list[tuple[sparse.csc_matrix, sparse.csc_matrix]] = []
        for group, places, torn in owner.levels:
            inputs = owner.functions.once(("external inputs", tuple(group)), lambda group=group: ca.Function(
                "inputs", [dae.t, dae.x, dae.z, owner.functions.q, dae.w],
                [ca.vertcat(*[ca.vec(ca.densify(dae.externals[k].inputs)) for k in group])],
            ))  # fmt: skip
            values = np.array(inputs(*self.here)).ravel()
            for k, place in zip(group, places, strict=True):
                self.inputs[k] = values[place]
                self.w[dae.externals[k].outputs] = np.array(dae.externals[k].function(values[place])).ravel()
                self.slopes[k] = owner.functions.external_jacobian(k)(values[place]).full()
            self.levels.append(tuple(csc(block) for block in torn.jacobian(*self.here)))
        self.by_v, self.by_w = (csc(block) for block in owner.rows.jacobian(*self.here))

    @property
    def sizes(self) -> tuple[int, int, int]:
        """Numbers of entries of x, z and q."""
        return tuple(column.size for column in self.here[1:4])

    def forward(self, directions: Directions) -> tuple[np.ndarray, list[np.ndarray]]:
        """Changes of w (n_w, c) along directions, and of the inputs of the externals of each level."""
        changes, of_inputs = np.array(directions.w, dtype=float), []
        for (group, places, _), (by_v, by_w) in zip(self.owner.levels, self.levels, strict=True):
            moved = by_v @ directions.v + by_w @ changes
            of_inputs.append(moved)
            for k, place in zip(group, places, strict=True):
                changes[self.owner.dae.externals[k].outputs] += self.slopes[k] @ moved[place]
        return changes, of_inputs

    def slope(self, directions: Directions) -> np.ndarray:
        """Changes of the rows (n_r, c) along directions."""
        changes, _ = self.forward(directions)
        return self.by_v @ directions.v + self.by_w @ changes

    def plain(self, weights: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Of weights (n_r, k) times the rows, the total derivatives by v (n_v, k), and by w alone (n_w, k)."""
        v, w = self.by_v.T @ weights, self.by_w.T @ weights
        for (group, places, _), (by_v, by_w) in zip(self.owner.levels[::-1], self.levels[::-1], strict=True):
            y = np.zeros((by_v.shape[0], weights.shape[1]))
            for k, place in zip(group, places, strict=True):
                y[place] = self.slopes[k].T @ w[self.owner.dae.externals[k].outputs]
            v, w = v + by_v.T @ y, w + by_w.T @ y
        return v, w

    def pulled(self, directions: Directions, weights: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Of weights (k, n_r, c) times the derivatives of the rows along directions (., c): by v (n_v, k), and by w.

        Each of the k sums over all columns.
        """
        changes, of_inputs = self.forward(directions)
        both = np.vstack([directions.v, changes])
        nv, count = len(directions.v), len(weights)
        total = self.owner.rows.pulled(self.here, both, weights)
        v, w = total[:nv], total[nv:]
        w_weights = [self.by_w.T @ weight for weight in weights]  # of the changes of w, column by column
        steps = zip(self.owner.levels[::-1], self.levels[::-1], of_inputs[::-1], strict=True)
        for (group, places, torn), (by_v, by_w), moved in steps:
            along, y = np.zeros((count, by_v.shape[0], both.shape[1])), np.zeros((by_v.shape[0], count))
            for k, place in zip(group, places, strict=True):
                outputs = self.owner.dae.externals[k].outputs
                mine = np.array([weight[outputs] for weight in w_weights])
                along[:, place] = self.slopes[k].T @ mine
                y[place] = self.slopes[k].T @ w[outputs] + self._second(k, mine @ moved[place].T).T
            total = torn.pulled(self.here, both, along)
            v = v + total[:nv] + by_v.T @ y
            w = w + total[nv:] + by_w.T @ y
            w_weights = [weight + by_w.T @ row for weight, row in zip(w_weights, along, strict=True)]
        return v, w

    def _second(self, k: int, weights: np.ndarray) -> np.ndarray:
        """Gradients of the Jacobian of an external times weights (m, n_out, n_in), by its inputs: (m, n_in)."""
        found = np.zeros((len(weights), weights.shape[2]))
        if not np.any(weights):
            return found
        external, functions = self.owner.dae.externals[k], self.owner.functions
        if isinstance(external.function, SplineFunction):
            made = functions.once(("second", external.function.__hash__()), lambda: _contracted(external.function))
            return np.array([made(self.inputs[k], weight).full().ravel() for weight in weights])
        jacobian, flat = functions.external_jacobian(k), weights.reshape(len(weights), -1)
        size = np.maximum(np.abs(flat).max(axis=1), 1e-300)  # alike, so that a kink is seen in each
        flat = flat / size[:, None]
        here = flat @ self.slopes[k].ravel()
        for i in _continuous(self.owner.dae, k):

            def contracted(value: float, i: int = i) -> np.ndarray:
                moved = self.inputs[k].copy()
                moved[i] = value
                return flat @ jacobian(moved).full().ravel()

            value, what = float(self.inputs[k][i]), f"what {external.path} gives"
            found[:, i] = derivative(contracted, value, here=here, size=max(abs(value), 1e-2), what=what)
        return found * size[:, None]


def _contracted(function: ca.Function) -> ca.Function:
    y, weights = ca.MX.sym("y", function.size1_in(0)), ca.MX.sym("weights", function.numel_out(0), function.size1_in(0))
    slope = ca.jacobian(ca.vec(function(y)), y)
    return ca.Function("second", [y, weights], [ca.densify(ca.gradient(ca.sum1(ca.vec(weights * slope)), y))])


def _continuous(dae: FlatDAE, k: int) -> Sequence[int]:
    """Inputs of an external that are no handles of data."""
    handles = {item.symbol[0].element_hash() for item in dae.bound.values() if item.functions}
    inputs = ca.vec(ca.densify(dae.externals[k].inputs)).elements()
    return [i for i, item in enumerate(inputs) if item.element_hash() not in handles and not item.is_constant()]
