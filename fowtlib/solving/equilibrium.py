"""The mean position: states and algebraic unknowns at which nothing changes."""

from __future__ import annotations

import casadi as ca
import numpy as np
from scipy import sparse

from fowtlib.flattening import FlatDAE
from fowtlib.language.errors import SimulationError
from fowtlib.solving.functions import AtParameters, Functions
from fowtlib.solving.initial import csc, failure_text
from fowtlib.solving.newton import Jacobian, Residual, newton, solve


def time_dependence(at: AtParameters, d: np.ndarray) -> list[str]:
    """Paths of what makes the equations depend on time: components with time functions, or the equations themselves.

    d: the discrete variables, by which it may be that a ramp goes on, or none.
    """
    dae = at.dae
    rows, steady = ca.vertcat(dae.ode, dae.alg), at.binding.steady
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
    pattern = dependence(functions)
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
    moving = moving_states(at.functions, held)
    residual, jacobian = at.residual, at.jacobian

    def unpack(values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        states = x.copy()
        states[moving] = values[: len(moving)]
        return states, values[len(moving) :]

    def rates(values: np.ndarray) -> np.ndarray:
        ode, alg = residual(t, *unpack(values), q)
        return np.concatenate([np.array(ode).ravel()[moving], np.array(alg).ravel()])

    def slopes(values: np.ndarray) -> sparse.csc_matrix:
        xx, xz, zx, zz = (csc(block) for block in jacobian(t, *unpack(values), q))
        top = sparse.hstack([xx[moving, :][:, moving], xz[moving, :]])
        return sparse.csc_matrix(sparse.vstack([top, sparse.hstack([zx[:, moving], zz])]))

    values = _continuation(rates, slopes, np.concatenate([x[moving], z]), len(moving))
    solution = newton(rates, slopes, values, tolerance=1e-11)
    if not solution.converged:
        _refuse_turning(dae, moving, values[: len(moving)] - x[moving])
        raise SimulationError(failure_text(dae, _renamed(solution, moving, dae), "no equilibrium found"))
    return unpack(solution.values)


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
