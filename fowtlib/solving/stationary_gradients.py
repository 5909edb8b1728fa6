"""Gradients by adjoints: of what a model is in its mean, of its linear model there, and of its poles.

A stationary state v = (x, z) solves F(v, p) = 0. Of a result g(v, p) the gradient by all p takes one solve with the
transposed Jacobian, F_v' mu = -g_v, dg/dp = g_p + F_p' mu. Of a function of the matrices A, B, C, D it is the same with
g_v and g_p from `solving.pullback`: where S are the rows of states and outputs and dz = -Z^-1 (alg by x, u), so that
[A B; C D] = S_(x,u) + S_z dz, and M is the slope of the function by these matrices, then

    d function = sum_c W_c . d(J V_c),  V_c = (e_c, dz_c),  W_c = (M_c, -Z^-T S_z' M_c).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import casadi as ca
import numpy as np
from scipy.linalg import schur, solve_sylvester
from scipy.linalg.lapack import dgecon, dgetrf, dgetrs

from fowtlib.language.errors import SimulationError
from fowtlib.solving.equilibrium import moving_states
from fowtlib.solving.linear import NOTHING, Further, LinearModel, slopes_of
from fowtlib.solving.pullback import Directions, Pullback
from fowtlib.solving.state import State
from fowtlib.solving.tuned import TunedRun
from fowtlib.solving.turning import turns_of

Plant = Any

SINGULAR = 1e-13  # reciprocal condition of the equations of an equilibrium, from which on some position is free
SATISFIED = 1e-7  # what may be left of the adjoint equations there
REPEATED = 1e-6  # distance of two poles over their size, from which on they are one


@dataclass(frozen=True, eq=False)
class Bars:
    """Slopes of a scalar by the matrices of a linear model, with all columns and all rows that `Slopes` has."""

    A: np.ndarray
    B: np.ndarray
    C: np.ndarray
    D: np.ndarray


@dataclass(frozen=True, eq=False)
class Partial:
    """Slopes of scalars (k, .) by v = [x; z; u; d; p], and by the outputs of the externals w."""

    v: np.ndarray
    w: np.ndarray

    def __add__(self, other: Partial) -> Partial:
        return Partial(self.v + other.v, self.w + other.w)

    def plus(self, rows: Sequence[int], other: Partial) -> Partial:
        """With those of other scalars added to some of these."""
        v, w = self.v.copy(), self.w.copy()
        v[rows] += other.v
        w[rows] += other.w
        return Partial(v, w)


def refuse_turning(plant: Plant, state: State) -> None:
    """SimulationError where rotors of blade elements turn."""
    if turns_of(plant, plant.at(state.parameters), state):
        raise SimulationError(
            "there are no gradients of the mean over a revolution: rotors of blade elements turn here. Take a rotor "
            "that is one actuator disc, or differences of two results."
        )


class LinearGradient:
    """A plant in a stationary state: its linear model from `further` inputs to results, and gradients there.

    names: results and variables; further: see slopes_of. Raises SimulationError where rotors of blade elements turn.
    """

    def __init__(self, plant: Plant, state: State, names: Sequence[str] = (), further: Further = NOTHING):
        at = plant.at(state.parameters)
        refuse_turning(plant, state)
        self.plant, self.state, self.at, self.dae = plant, state, at, plant.dae
        self.slopes = slopes_of(at, plant.layout, plant.outputs, (), names, further)
        q = np.concatenate([state.u, state.d])
        self.nx, self.nz = state.x.size, state.z.size
        key = (self.slopes.shown, self.slopes.inputs, tuple(further.symbols))
        first = state.x.size + state.z.size
        results = slice(first, first + len(self.slopes.shown) - len(further.outputs))
        pullback = Pullback(at, key, lambda: self.slopes.rows, self.slopes.columns, results)
        self.point = pullback.point(state.t, state.x, state.z, q)
        by_x, by_z, by_u = self.slopes(state.t, state.x, state.z, q)
        ode, alg, out = slice(0, self.nx), slice(self.nx, self.nx + self.nz), slice(self.nx + self.nz, None)
        self.by_z = by_z
        self.dz = -np.linalg.solve(by_z[alg], np.hstack([by_x[alg], by_u[alg]]))
        nx = self.nx
        A, B = by_x[ode] + by_z[ode] @ self.dz[:, :nx], by_u[ode] + by_z[ode] @ self.dz[:, nx:]
        C, D = by_x[out] + by_z[out] @ self.dz[:, :nx], by_u[out] + by_z[out] @ self.dz[:, nx:]
        self.linear: LinearModel = self.slopes.model(A, B, C, D, list(plant.layout.x))

    @cached_property
    def directions(self) -> Directions:
        """How v and w move with each state and each column of inputs."""
        dae, nx, nz = self.dae, self.nx, self.nz
        columns = self.slopes.columns
        asked = tuple(symbol.element_hash() for symbol in columns)
        places = self.at.general.once(("places of columns", asked), lambda: self._places(asked))
        nv = nx + nz + self.at.general.q.numel()
        v, w = np.zeros((nv, len(columns))), np.zeros((dae.w.numel(), len(columns)))
        for column, (of_w, k) in enumerate(places):
            (w if of_w else v)[k, column] = 1.0
        further = self.slopes.further
        if further.mixing is not None:
            q = np.concatenate([self.state.u, self.state.d])
            mixing, n = further.mixing(self.state.t, self.state.x, self.state.z, q), len(further.symbols)
            v, w = (np.hstack([block[:, :n] @ mixing, block[:, n:]]) for block in (v, w))
        of_states = np.zeros((nv, nx))
        of_states[:nx] = np.eye(nx)
        v, w = np.hstack([of_states, v]), np.hstack([np.zeros((len(w), nx)), w])
        v[nx : nx + nz] = self.dz
        return Directions(v, w)

    def _places(self, asked: Sequence[int]) -> list[tuple[bool, int]]:
        """Where symbols of these hashes stand: whether in w, else in v, and their numbers there."""
        found, first = {}, self.nx + self.nz
        for of_w, start, group in ((False, first, self.at.general.q), (True, 0, self.dae.w)):
            found |= {element.element_hash(): (of_w, start + k) for k, element in enumerate(group.elements())}
        return [found[symbol] for symbol in asked]

    def of_matrices(self, bars: Sequence[Bars]) -> Partial:
        """Slopes of scalars that have these slopes by the matrices."""
        scale, nx, nz = self.slopes.scale, self.nx, self.nz
        if not bars:
            return Partial(np.zeros((0, self.directions.v.shape[0])), np.zeros((0, self.directions.w.shape[0])))
        M = np.array([np.vstack([np.hstack([bar.A, bar.B]), scale * np.hstack([bar.C, bar.D])]) for bar in bars])
        by_z = np.vstack([self.by_z[:nx], self.by_z[nx + nz :]])
        alg = -np.linalg.solve(self.by_z[nx : nx + nz].T, by_z.T @ M) if nz else M[:, :0]
        v, w = self.point.pulled(self.directions, np.concatenate([M[:, :nx], alg, M[:, nx:]], axis=1))
        return Partial(v.T, w.T)

    def of_outputs(self, weights: np.ndarray) -> Partial:
        """Slopes of the values of outputs, in their units: rows of weights (k, outputs) of them."""
        whole = np.zeros((self.nx + self.nz + len(self.slopes.scale), len(weights)))
        whole[self.nx + self.nz :] = self.slopes.scale * weights.T
        v, w = self.point.plain(whole)
        return Partial(v.T, w.T)

    def total(self, partial: Partial, run: TunedRun, freed: TunedRun | None = None,
              targets: Sequence[int] = ()) -> np.ndarray:  # fmt: skip
        """The gradients (k, m) by the elements of a run, through the stationary state.

        freed, targets: elements that took the values at which outputs of these numbers are what they are.
        """
        nx, nz, scale = self.nx, self.nz, self.slopes.scale.ravel()
        moving = moving_states(self.at.functions, set())
        unknowns = np.array([*moving, *range(nx, nx + nz)], dtype=int)
        rows = np.array([*unknowns, *(nx + nz + k for k in targets)], dtype=int)
        weights = np.zeros((nx + nz + scale.size, rows.size))
        weights[rows, np.arange(rows.size)] = [1.0] * unknowns.size + [scale[k] for k in targets]
        v, w = self.point.plain(weights)
        equations = Partial(v.T, w.T)
        jacobian, right = equations.v[:, unknowns], partial.v[:, unknowns]
        if freed is not None:
            jacobian = np.hstack([jacobian, self._by(equations, freed)])
            right = np.hstack([right, self._by(partial, freed)])
        adjoint = -self._transposed(jacobian, right.T).T
        return self._by(partial + Partial(adjoint @ equations.v, adjoint @ equations.w), run)

    def _by(self, partial: Partial, run: TunedRun) -> np.ndarray:
        """Slopes by the elements of a run at a fixed state; states that nothing moves start as the parameters say."""
        nx, nz, dae = self.nx, self.nz, self.dae
        count = dae.p.numel()
        of_p = partial.v[:, -count:].copy() if count else np.zeros((len(partial.v), 0))
        first = nx + nz + dae.u.numel()
        fixed = np.setdiff1d(np.arange(nx), moving_states(self.at.functions, set()))
        by_start = np.hstack([partial.v[:, fixed], partial.v[:, first : first + dae.d.numel()]])
        if np.any(by_start):
            by_p = np.array(ca.DM(self._start_slopes(self.at.parameters)))
            of_p += by_start @ by_p[np.concatenate([fixed, nx + np.arange(dae.d.numel())]).astype(int)]
        return run.pulled_back(of_p, partial.w, self.state.t)

    @property
    def _start_slopes(self) -> ca.Function:
        def make() -> ca.Function:
            dae = self.dae
            starts = ca.vertcat(*[item.start for item in (*dae.states, *dae.discretes)])
            return ca.Function("start_slopes", [dae.p], [ca.densify(ca.jacobian(starts, dae.p))])

        return self.at.general.once("start slopes", make)

    def _transposed(self, jacobian: np.ndarray, right: np.ndarray) -> np.ndarray:
        """Solution of jacobian' mu = right; where a position is free, of least size, if results do not depend on it."""
        if not len(right):
            return right
        rows = 1 / np.maximum(np.abs(jacobian).max(axis=1, initial=0.0), 1e-300)[:, None]
        scaled = jacobian * rows
        columns = 1 / np.maximum(np.abs(scaled).max(axis=0, initial=0.0), 1e-300)
        scaled, wanted = (scaled * columns).T, right * columns[:, None]
        factors, pivots, singular = dgetrf(scaled)
        if not singular and dgecon(factors, np.abs(scaled).sum(axis=0).max())[0] > SINGULAR:
            found = dgetrs(factors, pivots, wanted)[0]
            found += dgetrs(factors, pivots, wanted - scaled @ found)[0]
        else:
            found = np.linalg.lstsq(scaled, wanted, rcond=1e-12)[0]
            left = np.abs(scaled @ found - wanted).max(axis=0)
            if np.any(left > SATISFIED * np.maximum(np.abs(wanted).max(axis=0), 1e-300)):
                raise SimulationError(
                    "a result depends on a position that nothing holds, so that it has no derivative: at the "
                    "equilibrium the model is free to move. Hold it by a spring, or take another result."
                )
        return rows * found


# --- poles --------------------------------------------------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class Pole:
    """A pole [rad/s], or the mean of those that are one with it, and the slope of it by A: d pole = sum(by_A * dA)."""

    value: complex
    by_A: np.ndarray
    count: int

    @property
    def frequency(self) -> tuple[float, np.ndarray]:
        """Undamped frequency [Hz], and its slopes by A."""
        size = abs(self.value)
        return size / (2 * np.pi), (np.conj(self.value) * self.by_A).real / size / (2 * np.pi)

    @property
    def damping(self) -> tuple[float, np.ndarray]:
        """Damping ratio, and its slopes by A."""
        size, real = abs(self.value), self.value.real
        by_size = (np.conj(self.value) * self.by_A).real / size
        return -real / size, -self.by_A.real / size + real * by_size / size**2


def pole(A: np.ndarray, near: complex, *, together: bool = False, what: str = "the mode") -> Pole:
    """The pole of A nearest to a value, by its spectral projector P: d pole = trace(P dA), exact for one that is alone.

    together: where others are one with it, the mean of all, trace(P dA) / count, which is smooth where they are not.
    Else SimulationError. The projector is that of an ordered Schur form.
    """
    roots = np.linalg.eigvals(A)
    mine = roots[np.argmin(np.abs(roots - near))]
    limit = REPEATED * max(abs(mine), 1e-12)
    count = int(np.sum(np.abs(roots - mine) <= limit))
    if count > 1 and not together:
        raise SimulationError(
            f"{what}: {count} poles are one here, at {abs(mine) / (2 * np.pi):.4g} Hz, so that none of them has a "
            "derivative. Take their mean (together=True), or a model that is not symmetric."
        )
    found, vectors, size = schur(A, output="complex", sort=lambda root: abs(root - mine) <= limit)
    if size != count:
        at = f"{abs(mine) / (2 * np.pi):.4g} Hz"
        raise SimulationError(f"{what}: its pole, {at}, cannot be told from its neighbours.")
    n = size
    R = solve_sylvester(found[:n, :n], -found[n:, n:], found[:n, n:])
    projector = vectors[:, :n] @ (vectors[:, :n] + vectors[:, n:] @ R.conj().T).conj().T
    value = complex(np.trace(found[:n, :n]) / n)
    return Pole(value, projector.T / n, n)
