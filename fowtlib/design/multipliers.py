"""What each active limit costs: Lagrange multipliers from the conditions of Karush, Kuhn and Tucker at a point."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fowtlib.design.problem import Problem

ACTIVE = 1e-3  # of its scale, by which a limit may be missed and still counts as active


@dataclass(frozen=True, eq=False)
class Multipliers:
    """Prices at a point, for the scaled problem, none below zero: what the objective gains as a limit gives way by one.

    constraints (k,), of equalities with the sign of their slope; variables (n,): of bounds. rest: what is left of the
    slope of the objective, over its size; zero at an optimum.
    """

    constraints: np.ndarray
    variables: np.ndarray
    rest: float


def multipliers(problem: Problem, y: np.ndarray) -> Multipliers:
    """Of the limits that are active at y, by non-negative least squares."""
    from scipy.optimize import nnls

    df, dg = problem.slopes(y)
    g = problem.g(y)
    columns: list[np.ndarray] = []
    owners: list[tuple[str, int, float]] = []
    for k in range(g.size):
        for side, limit in ((1.0, problem.upper[k]), (-1.0, problem.lower[k])):
            if np.isfinite(limit) and abs(g[k] - limit) <= ACTIVE * max(1.0, abs(limit)):
                columns.append(side * dg[k])
                owners.append(("g", k, side))
    for k in range(y.size):
        for side, limit in ((1.0, problem.y_upper[k]), (-1.0, problem.y_lower[k])):
            if abs(y[k] - limit) <= ACTIVE:
                columns.append(side * np.eye(y.size)[k])
                owners.append(("y", k, side))
    constraints, variables, rest = np.zeros(g.size), np.zeros(y.size), -df
    if columns:
        matrix = np.array(columns).T
        prices, _ = nnls(matrix, -df)
        rest = -df - matrix @ prices
        for (kind, k, side), price in zip(owners, prices, strict=True):
            if kind == "g":
                constraints[k] += price * (side if problem.lower[k] == problem.upper[k] else 1.0)
            else:
                variables[k] += price
    return Multipliers(constraints, variables, float(np.linalg.norm(rest) / max(np.linalg.norm(df), 1e-12)))
