"""Consistent values at the start: states from start values or `initial` equations, the rest by Newton."""

from __future__ import annotations

from typing import TYPE_CHECKING

import casadi as ca
import numpy as np

from fowtlib.flattening import FlatDAE
from fowtlib.flattening.structure import matching
from fowtlib.language.errors import SimulationError
from fowtlib.solving.functions import MANY, AtParameters, Functions
from fowtlib.solving.known_again import kept_or_found
from fowtlib.solving.layout import Layout, Values
from fowtlib.solving.newton import NewtonResult, newton, undamped
from fowtlib.solving.state import State

if TYPE_CHECKING:
    from scipy import sparse


def csc(value: ca.DM) -> sparse.csc_matrix:
    """CasADi matrix as a SciPy matrix."""
    from scipy import sparse  # slow to import

    return sparse.csc_matrix(
        (np.array(value.nonzeros()), np.array(value.row(), int), np.array(value.colind(), int)), shape=value.shape
    )


def consistent_algebraics(at: AtParameters, t: float, x: np.ndarray, z: np.ndarray, q: np.ndarray) -> np.ndarray:
    """Algebraic unknowns that satisfy the equations at the given states; SimulationError where none are found."""
    if not z.size:
        return z
    residual, jacobian = at.residual, at.algebraic_jacobian
    solution = newton(
        lambda values: np.array(residual(t, x, values, q)[1]).ravel(), lambda values: csc(jacobian(t, x, values, q)), z
    )
    if not solution.converged:
        raise SimulationError(failure_text(at.dae, solution, f"no consistent start values at t = {t:g} s"))
    return solution.values


def start_point(at: AtParameters, layout: Layout, u: np.ndarray, start: Values, t: float,
                base: State | None) -> tuple[float, np.ndarray, np.ndarray, np.ndarray]:  # fmt: skip
    """The consistent t, x, z and d with start values by path put in; of `base`, if there is one, and these changed."""
    x, z, d = at.start_values() if base is None else (base.x.copy(), base.z.copy(), base.d.copy())
    given = layout.put(start, x, z, d)
    q = np.concatenate([u, d])
    if base is not None:
        return base.t, x, consistent_algebraics(at, base.t, x, z, q), d
    x, z = initial_values(at, t, x, z, q, given)
    return t, x, z, d


def initial_values(at: AtParameters, t: float, x: np.ndarray, z: np.ndarray, q: np.ndarray,
                   given: set[int]) -> tuple[np.ndarray, np.ndarray]:  # fmt: skip
    """X and z at the start; `given` are the numbers of states whose value the user fixed for this run.

    The functions for it are made at the first start of a process, which takes far longer than to solve them: the values
    of that start are kept on disk, under all that they follow from.
    """
    dae = at.dae
    if not dae.initial_equations.shape[0]:
        return x, consistent_algebraics(at, t, x, z, q)
    if at.functions.has(("freed", frozenset(given))):
        return _solved(at, t, x, z, q, given)
    about = repr((sorted(given), sorted(at.functions.zeros), sorted(at.binding.data.items())))
    parts = [about, np.array([t]), x, z, q, at.parameters]
    found = kept_or_found(dae, "initial", parts, lambda: _solved(at, t, x, z, q, given))
    return np.array(found[0], float), np.array(found[1], float)


def _solved(at: AtParameters, t: float, x: np.ndarray, z: np.ndarray, q: np.ndarray,
            given: set[int]) -> tuple[np.ndarray, np.ndarray]:  # fmt: skip
    """X and z at which alg and the initial equations hold."""
    dae = at.dae
    kept, free = at.functions.once(("freed", frozenset(given)), lambda: freed_states(dae, given))
    if not free and not dae.z.shape[0]:
        return x, z  # all start values are given, and nothing is left to solve for
    function, slopes = at.functions.once(
        ("initial", tuple(kept), tuple(free)), lambda: _initial_functions(at.functions, kept, free)
    )

    def unpack(values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        states = x.copy()
        states[free] = values[: len(free)]
        return states, values[len(free) :]

    def residual(values: np.ndarray) -> np.ndarray:
        return np.array(at.call(function, t, *unpack(values), q)).ravel()

    def jacobian(values: np.ndarray) -> sparse.csc_matrix:
        return csc(at.call(slopes, t, *unpack(values), q))

    guess = np.concatenate([x[free], z])
    solution = undamped(residual, jacobian, guess) or newton(residual, jacobian, guess)
    if not solution.converged:
        raise SimulationError(
            failure_text(dae, solution, "the initial equations have no solution near the start values")
        )
    return unpack(solution.values)


def _initial_functions(functions: Functions, kept: list[int], free: list[int]) -> tuple[ca.Function, ca.Function]:
    """Residual of alg and the initial equations that hold, and its slopes by the free states and z."""
    dae = functions.dae
    rows = ca.vertcat(dae.alg, dae.initial_equations[kept])
    columns = ca.vertcat(dae.x[free], dae.z)
    hidden = {element.element_hash() for stage in dae.stages for element in ca.vertsplit(stage.states)}
    of_externals = [c for c in range(columns.shape[0]) if columns[c].element_hash() in hidden]
    others = [c for c in range(columns.shape[0]) if c not in set(of_externals)]
    if not others or len(others) > MANY:
        slopes = functions.torn_jacobian("initial_jacobian", rows, [columns])
    elif not of_externals:
        slopes = functions.directional_jacobian("initial_jacobian", rows, columns)
    else:  # only an external function reads them, so that few expressions lead from them
        parts = [functions.torn_jacobian("initial_jacobian_of_externals", rows, [columns[of_externals]]),
                 functions.directional_jacobian("initial_jacobian_of_others", rows, columns[others])]  # fmt: skip
        arguments = parts[0].mx_in()
        both = ca.horzcat(*[part(*arguments) for part in parts])
        order = np.argsort([*of_externals, *others]).tolist()
        slopes = ca.Function("initial_jacobian", arguments, [both[:, order]])
    return functions.function("initial", [rows]), slopes


def initial_matching(dae: FlatDAE) -> tuple[list[int], list[int]]:
    """The initial equations and, for each, the state whose start value gives way to it."""
    if not dae.initial_equations.shape[0]:
        return [], []
    _, chosen, match = _matched_states(dae, set())
    return list(range(len(match))), [chosen[k] for k in match]


def freed_states(dae: FlatDAE, given: set[int]) -> tuple[list[int], list[int]]:
    """The initial equations that hold, and the states whose start values give way to them.

    States of the component that writes an equation come first, then those without a start value; fixed ones never give
    way. An equation that only a state with a `given` value could satisfy is left out: the user's value counts more.
    """
    n, chosen, match = _matched_states(dae, given)
    kept = [r for r in range(n) if chosen[match[r]] not in given]
    return kept, sorted(c for c in chosen if c not in given)


def _matched_states(dae: FlatDAE, given: set[int]) -> tuple[int, list[int], np.ndarray]:
    """How many initial equations there are, the states that give way, and which of these for each equation."""
    n = dae.initial_equations.shape[0]
    pattern = ca.Function("i", [dae.x, dae.z, dae.w], [dae.initial_equations], {"allow_free": True})
    members: list[set[int]] = [set() for _ in range(n)]
    for r, c in zip(*pattern.jac_sparsity(0, 0).get_triplet(), strict=True):
        members[r].add(int(c))
    if dae.z.shape[0]:  # through the algebraic unknowns, every state counts
        for r in set(pattern.jac_sparsity(0, 1).get_triplet()[0]):
            members[r] = set(range(len(dae.states)))
    for r in set(pattern.jac_sparsity(0, 2).get_triplet()[0]):
        members[r] = members[r] or set(range(len(dae.states)))  # and where an external function alone knows them
    owners = tuple({f"{path}." for path in dae.initial_paths})
    order = sorted(
        (c for c in range(len(dae.states)) if not dae.states[c].fixed),
        key=lambda c: (c in given, not dae.states[c].path.startswith(owners), dae.states[c].start_given),
    )
    chosen: list[int] = []
    match = np.full(n, -1)
    for candidate in order:
        trial = [*chosen, candidate]
        incidence = [np.array([k for k, c in enumerate(trial) if c in row], int) for row in members]
        attempt = matching(incidence, len(trial))
        if np.count_nonzero(attempt >= 0) == len(trial):
            chosen, match = trial, attempt
        if len(chosen) == n:
            break
    else:
        raise SimulationError(
            f"{n} initial equations, and only {len(chosen)} states whose start values can give way to them: "
            + ", ".join(dae.initial_sources[:5])
            + ". Remove an initial equation, or the fixed=True of a state."
        )
    return n, chosen, match


def failure_text(dae: FlatDAE, solution: NewtonResult, what: str) -> str:
    """Which equations are not satisfied, by path."""
    paths = [*dae.residual_paths, *dae.initial_paths, *(f"der({s.path})" for s in dae.states)]
    bad = np.flatnonzero(~np.isfinite(solution.residual))
    if len(bad):
        names = _first_paths(paths, bad)
        return f"{what}: the residual is not a finite number in {names}. Check the start values and parameters there."
    names = _first_paths(paths, np.argsort(-np.abs(solution.residual)))
    return f"{what}: the equations furthest from being satisfied are {names}. Give start values nearer to a solution."


def _first_paths(paths: list[str], rows: np.ndarray) -> str:
    """The first three different paths of rows; the six balances of a frame have one path."""
    return ", ".join(list(dict.fromkeys(paths[i] if i < len(paths) else str(i) for i in rows))[:3])
