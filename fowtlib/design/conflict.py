"""Where no design keeps all constraints: which of them are against each other."""

from __future__ import annotations

import contextlib
from dataclasses import replace

import numpy as np

from fowtlib.design.multipliers import ACTIVE
from fowtlib.design.optimisers import Settings, optimiser
from fowtlib.design.problem import Problem

MOST = 40  # evaluations for the least violation
ITERATIONS = 25


class _Enough(Exception):
    """As many evaluations as are spent on this."""


class Elastic:
    """The problem of the least largest violation: min t with lower - t <= g <= upper + t; the last variable is t."""

    def __init__(self, problem: Problem, reach: float):
        self.problem, self.before = problem, problem.evaluations
        self.best, self.least = np.zeros(0), np.inf
        self.over, self.under = np.isfinite(problem.upper), np.isfinite(problem.lower)
        k = int(self.over.sum() + self.under.sum())
        self.lower, self.upper = np.full(k, -np.inf), np.zeros(k)
        self.y_lower, self.y_upper = np.append(problem.y_lower, -1.0), np.append(problem.y_upper, 2 * reach + 1.0)

    def f(self, y: np.ndarray) -> float:
        self.problem.point(y[:-1])
        return float(y[-1])

    def g(self, y: np.ndarray) -> np.ndarray:
        if self.problem.evaluations - self.before > MOST:
            raise _Enough
        g = self.problem.g(y[:-1])
        over = np.concatenate([(g - self.problem.upper)[self.over], (self.problem.lower - g)[self.under]])
        if over.max() < self.least:
            self.best, self.least = np.array(y[:-1]), float(over.max())
        return over - y[-1]

    def slopes(self, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        _, dg = self.problem.slopes(y[:-1])
        rows = np.concatenate([dg[self.over], -dg[self.under]])
        return np.append(np.zeros(y.size - 1), 1.0), np.column_stack([rows, -np.ones(len(rows))])


def least_violation(problem: Problem, y: np.ndarray, settings: Settings, method: str) -> tuple[np.ndarray, list[int]]:
    """Where the largest scaled violation is least, and the scaled constraints that hold it there."""
    g = problem.g(y)
    t = float(np.max(np.maximum(g - problem.upper, problem.lower - g)))
    elastic = Elastic(problem, max(t, 0.0))
    settings = replace(settings, iterations=min(settings.iterations, ITERATIONS))
    with contextlib.suppress(_Enough):
        optimiser(method)(elastic, np.append(y, t), settings)
    g = problem.g(elastic.best)
    over = np.maximum(g - problem.upper, problem.lower - g)
    return elastic.best, np.flatnonzero(over >= over.max() - ACTIVE - 0.01 * abs(over.max())).tolist()
