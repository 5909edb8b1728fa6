"""Second derivatives of a flat model, pulled back: the gradient of any combination of the entries of its Jacobian.

With rows r(v, w) of the model, w the outputs of its externals and v = [x; z; u; d; p], and with directions V_c in which
v moves (and w, where a signal is what moves), this gives

    d/dv sum_c W_c . (dr/dv V_c),

the total derivative through the externals. It is the reverse of a forward derivative, one column of directions after
the other by the same small function, torn at the externals as everything else: they give their exact Jacobian, and its
own derivative is exact for splines and by differences of fourth order for compiled code. Made once for a plant.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import casadi as ca
import numpy as np
from scipy import sparse

from fowtlib.flattening import FlatDAE
from fowtlib.language.tables import SplineFunction
from fowtlib.solving.differences import derivative
from fowtlib.solving.functions import AtParameters, Functions
from fowtlib.solving.initial import csc

BLOCK = 32  # directions in one call


@dataclass(frozen=True, eq=False)
class Directions:
    """Directions, a column each: of v (n_v, c), and what is added to the outputs of externals (n_w, c)."""

    v: np.ndarray
    w: np.ndarray


class _Torn:
    """Expressions of (v, w) as functions: Jacobians, and the gradient of their derivative along directions."""

    def __init__(self, functions: Functions, name: str, rows: ca.SX):
        arguments = [functions.t, functions.x, functions.z, functions.q, functions.w]
        rows = ca.vec(ca.densify(rows))
        v = ca.vertcat(functions.x, functions.z, functions.q)
        self.size, nv, nw = rows.numel(), v.numel(), functions.w.numel()
        both = ca.vertcat(v, functions.w)
        self.jacobian = ca.Function(f"{name}_jacobian", arguments, [
            ca.sparsify(ca.jacobian(rows, v)), ca.sparsify(ca.jacobian(rows, functions.w)),
        ])  # without "cse": of a million instructions, as of a spar with twenty hinges, it takes minutes
        seed, weight = ca.SX.sym("seed", nv + nw), ca.SX.sym("weight", self.size)
        along = ca.dot(weight, ca.densify(ca.jtimes(rows, both, seed)))
        slope = ca.densify(ca.gradient(along, both))
        one = ca.Function(f"{name}_second", [*arguments, seed, weight], [slope], {"cse": True})
        summed = list(range(len(arguments)))
        self.second = one.map(f"{name}_second_{BLOCK}", "serial", BLOCK, summed, [0])
        self.nv = nv

    def pulled(self, point: list[np.ndarray], directions: np.ndarray, weights: np.ndarray) -> np.ndarray:
        """The gradient by [v; w] (n_v + n_w,) of the sum over all columns."""
        kept = np.flatnonzero(np.any(weights != 0, axis=0) & np.any(directions != 0, axis=0))
        total = np.zeros(len(directions))
        for first in range(0, kept.size, BLOCK):
            part = kept[first : first + BLOCK]
            seed, weight = np.zeros((len(directions), BLOCK)), np.zeros((self.size, BLOCK))
            seed[:, : part.size], weight[:, : part.size] = directions[:, part], weights[:, part]
            total += np.array(self.second(*point, seed, weight)).ravel()
        return total


class Pullback:
    """Rows of a flat model, to be pulled back at points.

    rows: expressions of the flat model. key: what they are, for what was made before. Parameters count as symbols, also
    those that are zero.
    """

    def __init__(self, at: AtParameters, key: tuple[object, ...], rows: Callable[[], ca.SX]):
        functions = at.general
        self.at, self.functions, self.dae = at, functions, at.dae
        self.rows = functions.once(("pullback", *key), lambda: _Torn(functions, "rows", rows()))
        self.levels = functions.once("pullback levels", self._levels)

    def _levels(self) -> list[tuple[list[int], list[slice], _Torn]]:
        """For each level of externals their numbers, where their inputs are among the rows, and these."""
        made = []
        for number, group in enumerate(self.dae.levels):
            inputs = [ca.vec(ca.densify(self.dae.externals[k].inputs)) for k in group]
            ends = np.cumsum([0, *(column.numel() for column in inputs)])
            places = [slice(int(a), int(b)) for a, b in zip(ends[:-1], ends[1:], strict=True)]
            made.append((list(group), places, _Torn(self.functions, f"level_{number}", ca.vertcat(*inputs))))
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
        """Of weights (n_r, c) times the derivatives of the rows along directions (., c), summed: by v, and by w."""
        changes, of_inputs = self.forward(directions)
        both = np.vstack([directions.v, changes])
        nv = len(directions.v)
        total = self.owner.rows.pulled(self.here, both, weights)
        v, w = total[:nv], total[nv:]
        w_weights = self.by_w.T @ weights  # of the changes of w, column by column
        steps = zip(self.owner.levels[::-1], self.levels[::-1], of_inputs[::-1], strict=True)
        for (group, places, torn), (by_v, by_w), moved in steps:
            along, y = np.zeros((by_v.shape[0], weights.shape[1])), np.zeros(by_v.shape[0])
            for k, place in zip(group, places, strict=True):
                outputs = self.owner.dae.externals[k].outputs
                along[place] = self.slopes[k].T @ w_weights[outputs]
                y[place] = self.slopes[k].T @ w[outputs] + self._second(k, w_weights[outputs] @ moved[place].T)
            total = torn.pulled(self.here, both, along)
            v = v + total[:nv] + by_v.T @ y
            w = w + total[nv:] + by_w.T @ y
            w_weights = w_weights + by_w.T @ along
        return v, w

    def _second(self, k: int, weights: np.ndarray) -> np.ndarray:
        """Gradient of the Jacobian of an external times weights (n_out, n_in), by its inputs."""
        if not np.any(weights):
            return np.zeros(weights.shape[1])
        external, functions = self.owner.dae.externals[k], self.owner.functions
        if isinstance(external.function, SplineFunction):
            made = functions.once(("second", external.function.__hash__()), lambda: _contracted(external.function))
            return np.array(made(self.inputs[k], weights)).ravel()
        jacobian, found = functions.external_jacobian(k), np.zeros(weights.shape[1])
        here = np.array([np.sum(weights * self.slopes[k])])
        for i in _continuous(self.owner.dae, k):

            def contracted(value: float, i: int = i) -> np.ndarray:
                moved = self.inputs[k].copy()
                moved[i] = value
                return np.array([np.sum(weights * jacobian(moved).full())])

            value, what = float(self.inputs[k][i]), f"what {external.path} gives"
            found[i] = derivative(contracted, value, here=here, size=max(abs(value), 1e-2), what=what)[0]
        return found


def _contracted(function: ca.Function) -> ca.Function:
    y, weights = ca.MX.sym("y", function.size1_in(0)), ca.MX.sym("weights", function.numel_out(0), function.size1_in(0))
    slope = ca.jacobian(ca.vec(function(y)), y)
    return ca.Function("second", [y, weights], [ca.densify(ca.gradient(ca.sum1(ca.vec(weights * slope)), y))])


def _continuous(dae: FlatDAE, k: int) -> Sequence[int]:
    """Inputs of an external that are no handles of data."""
    handles = {item.symbol[0].element_hash() for item in dae.bound.values() if item.functions}
    inputs = ca.vec(ca.densify(dae.externals[k].inputs)).elements()
    return [i for i, item in enumerate(inputs) if item.element_hash() not in handles and not item.is_constant()]
