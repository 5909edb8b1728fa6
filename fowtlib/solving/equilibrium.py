"""The mean position: states and algebraic unknowns at which nothing changes."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import casadi as ca
import numpy as np

from fowtlib.flattening import FlatDAE
from fowtlib.language.errors import SimulationError
from fowtlib.solving.functions import AtParameters, Functions
from fowtlib.solving.initial import failure_text
from fowtlib.solving.newton import DENSE, Jacobian, Residual, beside, newton, solve, undamped
from fowtlib.solving.state import State

if TYPE_CHECKING:
    from scipy import sparse


def time_dependence(at: AtParameters, d: np.ndarray) -> list[str]:
    """Paths of what makes the equations depend on time: components with time functions, or the equations themselves.

    d: the discrete variables, by which it may be that a ramp goes on, or none.
    """
    steady = at.binding.steady
    return at.functions.once(("time", steady, d.tobytes()), lambda: _time_dependence(at, steady, d))


def _time_dependence(at: AtParameters, steady: frozenset[int], d: np.ndarray) -> list[str]:
    dae = at.dae
    rows = ca.vertcat(dae.ode, dae.alg)
    moving = [dae.externals[k] for k in sorted(at.functions.needed([rows]))]
    moving = [item for item in moving if ca.depends_on(item.inputs, dae.t)]
    moving = [item for item in moving if ca.vec(item.inputs)[0].element_hash() not in steady]
    found = [(item.path, item.inputs) for item in moving]
    if ca.depends_on(rows, dae.t):
        found += [(f"der({s.path})", row) for s, row in zip(dae.states, ca.vertsplit(dae.ode), strict=True)]
        found += zip(dae.residual_paths, ca.vertsplit(dae.alg), strict=True)
    found = [(path, row) for path, row in found if ca.depends_on(row, dae.t)]
    if found and dae.d.numel():
        now = ca.substitute([row for _, row in found], [dae.d], [ca.SX(ca.DM(d))])
        found = [(path, row) for (path, _), row in zip(found, now, strict=True) if ca.depends_on(row, dae.t)]
    return list(dict.fromkeys(path for path, _ in found))


def refuse_time(at: AtParameters, q: np.ndarray) -> None:
    """SimulationError where the equations depend on time, so that nothing is at rest."""
    sources = time_dependence(at, q[len(q) - at.dae.d.numel() :])
    if sources:
        raise SimulationError(
            f"no equilibrium: the equations depend on time through {', '.join(sources[:4])}. "
            "Take still water and steady wind: in Python set={'wind.kind': 'steady', 'sea.spectrum': 'still'}, "
            "on the command line --wind steady:8 --waves still."
        )


def moving_states(functions: Functions, held: set[int]) -> list[int]:
    """Numbers of the states that an equilibrium seeks: those that anything depends on, and that are not held."""
    pattern = functions.once("dependence", lambda: dependence(functions))
    return [k for k in range(pattern.shape[1]) if pattern[:, k].any() and k not in held]


def equilibrium(at: AtParameters, t: float, x: np.ndarray, z: np.ndarray, q: np.ndarray,
                held: set[int]) -> tuple[np.ndarray, np.ndarray]:  # fmt: skip
    """Solve ode = 0 and alg = 0 for the states that anything depends on, except the `held` ones.

    Implicit Euler steps of growing length follow the transient to an equilibrium (pseudo-transient continuation, C. T.
    Kelley and D. E. Keyes, SIAM J. Numer. Anal. 35 (1998) 508); Newton finishes. Ignorable coordinates, such as the
    angle of a turning shaft, keep their value.
    """
    dae = at.dae
    refuse_time(at, q)
    rest = _rest(at, t, x, q, held)
    moving = rest.moving
    values = _continuation(rest.rates, rest.slopes, np.concatenate([x[moving], z]), len(moving))
    solution = newton(rest.rates, rest.slopes, values, tolerance=1e-11)
    if not solution.converged:
        _refuse_turning(dae, moving, values[: len(moving)] - x[moving])
        raise SimulationError(failure_text(dae, _renamed(solution, moving, dae), "no equilibrium found"))
    return rest.unpack(solution.values)


@dataclass(frozen=True)
class Rest:
    """The equations of an equilibrium at a time and inputs: unknowns are the states that move, and the algebraics."""

    at: AtParameters
    t: float
    x: np.ndarray
    q: np.ndarray
    moving: list[int]

    def unpack(self, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """All states, and the algebraic unknowns."""
        states = self.x.copy()
        states[self.moving] = values[: len(self.moving)]
        return states, values[len(self.moving) :]

    def rates(self, values: np.ndarray) -> np.ndarray:
        ode, alg = self.at.arrays(self.at.functions.residual, self.t, *self.unpack(values), self.q)
        return np.concatenate([ode.ravel()[self.moving], alg.ravel()])

    def slopes(self, values: np.ndarray) -> sparse.csc_matrix:
        from scipy import sparse  # slow to import

        kept, rows, columns = self.places
        return sparse.csc_matrix((self._entries(values)[kept], (rows, columns)), shape=(self.size, self.size))

    def dense_slopes(self, values: np.ndarray) -> np.ndarray:
        """The same as an array."""
        kept, rows, columns = self.places
        matrix = np.zeros((self.size, self.size), order="F")
        matrix[rows, columns] = self._entries(values)[kept]
        return matrix

    def _entries(self, values: np.ndarray) -> np.ndarray:
        return self.at.entries(self.at.functions.jacobian_entries, self.t, *self.unpack(values), self.q)[0]

    @property
    def size(self) -> int:
        return len(self.moving) + self.at.dae.z.numel()

    @cached_property
    def places(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Of the four blocks of the Jacobian: the entries that are taken, their rows and their columns."""
        return self.at.functions.once(("places", tuple(self.moving)), self._places)

    def _places(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        states, moved = np.full(self.x.size, -1), len(self.moving)
        states[self.moving] = np.arange(moved)
        unknown = {"x": states, "z": moved + np.arange(self.at.dae.z.numel())}
        rows, columns = [], []
        for k, (row, column) in enumerate(("xx", "xz", "zx", "zz")):
            sparsity = self.at.functions.jacobian.sparsity_out(k)
            rows.append(unknown[row][np.array(sparsity.row(), int)])
            columns.append(unknown[column][np.array(sparsity.get_col(), int)])
        found = np.concatenate(rows), np.concatenate(columns)
        kept = np.flatnonzero((found[0] >= 0) & (found[1] >= 0))
        return kept, found[0][kept], found[1][kept]


def _rest(at: AtParameters, t: float, x: np.ndarray, q: np.ndarray, held: set[int]) -> Rest:
    return Rest(at, t, x, q, moving_states(at.functions, held))


def next_equilibrium(at: AtParameters, near: State) -> tuple[np.ndarray, np.ndarray, np.ndarray] | None:
    """x, z and d of the equilibrium that whole steps find from one of other parameters; None: none.

    With the slopes there alone, and where these do not serve with those of each step.
    """
    d = at.start_values()[2]
    if time_dependence(at, d):
        return None
    rest = _rest(at, near.t, near.x, np.concatenate([near.u, d]), set())
    slopes = rest.dense_slopes if rest.size <= DENSE else rest.slopes
    asked = rest.rates, slopes, np.concatenate([near.x[rest.moving], near.z])
    solution = beside(*asked, tolerance=1e-11) or undamped(*asked, tolerance=1e-11)
    return None if solution is None else (*rest.unpack(solution.values), d)


def _refuse_turning(dae: FlatDAE, moving: list[int], way: np.ndarray) -> None:
    """An error of its own where an angle that the equations depend on went round on its way."""
    for k, change in zip(moving, way, strict=True):
        state = dae.states[k]
        if state.unit == "rad" and abs(change) > 2 * np.pi:
            raise SimulationError(
                f"no equilibrium: {state.path} turns on and on, and the loads depend on this angle. Where this is the "
                "azimuth of a rotor of blade elements, let the rotor stand (--wind none), hold it, or take the mean of "
                "a simulation."
            )


def _continuation(rates: Residual, slopes: Jacobian, values: np.ndarray, nx: int, limit: int = 400) -> np.ndarray:
    """Values after implicit Euler steps that double until nothing moves any more.

    A step for which Newton finds no solution is shortened.
    """
    rows = np.arange(values.size) < nx
    length = 0.1
    for _ in range(limit):
        after = _implicit_euler(rates, slopes, values, rows, length)
        if after is None:
            length /= 4
            if length < 1e-8:
                break
            continue
        moved = np.max(np.abs(after - values) / (1 + np.abs(values)), initial=0.0)
        values = after
        if length > 1e5 and moved < 1e-6:
            break
        length = min(2 * length, 1e7)
    return values


def _implicit_euler(
    rates: Residual, slopes: Jacobian, before: np.ndarray, rows: np.ndarray, length: float
) -> np.ndarray | None:
    """Values one step later, by at most eight Newton iterations; None where they do not settle."""
    from scipy import sparse

    mass = sparse.diags(rows / length)
    values, last = before.copy(), np.inf
    for _ in range(8):
        residual = rates(values) - rows * (values - before) / length
        if not np.all(np.isfinite(residual)):
            return None
        try:
            step = solve(mass - slopes(values), residual)
        except RuntimeError:
            return None
        size = np.max(np.abs(step) / (1 + np.abs(values)), initial=0.0)
        if not np.isfinite(size) or size > 2 * last:
            return None
        values, last = values + step, size
        if size < 1e-8:
            return values
    return values if last < 1e-4 else None


def dependence(functions: Functions) -> np.ndarray:
    """Whether an equation depends on each state."""
    nx = functions.x.shape[0]
    by_x, _, alg_x, _ = (functions.jacobian.sparsity_out(i) for i in range(4))
    used = np.zeros((2, nx), bool)
    used[0, list(by_x.get_triplet()[1])] = True
    used[1, list(alg_x.get_triplet()[1])] = True
    return used


def _renamed(solution, moving: list[int], dae):
    """Residual rows in the order of the paths that the message uses."""
    n = len(moving)
    rows = np.zeros(len(dae.residual_paths) + len(dae.initial_paths) + len(dae.states))
    rows[: len(dae.residual_paths)] = solution.residual[n:]
    rows[len(dae.residual_paths) + len(dae.initial_paths) + np.array(moving, int)] = solution.residual[:n]
    solution.residual = rows
    return solution
