"""A globalised Newton iteration for consistent values and equilibria."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, TypeAlias

import numpy as np

if TYPE_CHECKING:
    from scipy import sparse

DENSE = 300  # unknowns up to which a dense solution is faster and quieter than a sparse one

Residual = Callable[[np.ndarray], np.ndarray]
Jacobian: TypeAlias = "Callable[[np.ndarray], sparse.spmatrix | np.ndarray]"


@dataclass
class NewtonResult:
    """`values` solve the equations where `converged`; `residual` is what is left, row by row, scaled."""

    values: np.ndarray
    residual: np.ndarray
    converged: bool
    iterations: int


def newton(
    residual: Residual, jacobian: Jacobian, start: np.ndarray, *, tolerance: float = 1e-10, limit: int = 100
) -> NewtonResult:
    """Damped Newton on rows scaled by their Jacobian; a singular or uphill step becomes a Levenberg-Marquardt step.

    Converged when a full Newton step changes no unknown by more than `tolerance`, relative to 1 and to its size.
    """
    from scipy import sparse  # slow to import, as what else SciPy gives here: a start that is kept needs none of it

    values = np.array(start, dtype=float)
    r = residual(values)
    damping = 0.0
    for iteration in range(limit):
        if not np.all(np.isfinite(r)):
            return NewtonResult(values, r, False, iteration)
        matrix = sparse.csc_matrix(jacobian(values))
        length = np.sqrt(np.asarray(matrix.multiply(matrix).sum(axis=1)).ravel())
        scale = np.where((length > 0) & np.isfinite(length), 1.0 / np.maximum(length, 1e-300), 1.0)
        scaled, size = sparse.diags(scale) @ matrix, r * scale
        step, full = _step(scaled, size, damping)
        full = full or float(np.max(np.abs(size), initial=0.0)) < tolerance  # singular, and satisfied all the same
        largest = np.max(np.abs(step) / (1.0 + np.abs(values)), initial=0.0)
        if damping == 0.0 and full and largest < tolerance:
            values = values + step
            final = residual(values)
            return NewtonResult(values, final * scale, bool(np.all(np.isfinite(final))), iteration + 1)
        merit, fraction, accepted = float(size @ size), 1.0, False
        while fraction > 1e-4:
            trial = values + fraction * step
            fresh = residual(trial)
            if np.all(np.isfinite(fresh)) and float((fresh * scale) @ (fresh * scale)) <= (1 - 1e-4 * fraction) * merit:
                accepted = True
                break
            fraction *= 0.5
        if accepted:
            values, r = trial, fresh
            damping = 0.0 if fraction == 1.0 or damping < 1e-8 else damping * 0.1
        elif full and largest < 1e-7:  # the rounding of the residual is reached
            return NewtonResult(values, r * scale, True, iteration + 1)
        elif damping > 1e8:
            break
        else:
            damping = max(10 * damping, 1e-6)
    return NewtonResult(values, r, False, limit)


def undamped(residual: Residual, jacobian: Jacobian, start: np.ndarray, *, tolerance: float = 1e-10,
             limit: int = 8) -> NewtonResult | None:  # fmt: skip
    """Newton by whole steps; None where they do not become shorter from the third on.

    Start values of a turbine are near enough for this, and a residual that has to fall at each step leads a long way
    round: torques of a stiff shaft rise by far before they fall.
    """
    values, last = np.array(start, dtype=float), np.inf
    for iteration in range(limit):
        try:
            step = -solve(jacobian(values), residual(values))
        except RuntimeError:
            return None
        largest = float(np.max(np.abs(step) / (1.0 + np.abs(values)), initial=0.0))
        if not np.isfinite(largest) or (iteration > 1 and largest > last / 2):
            return None
        values, last = values + step, largest
        if largest < tolerance:
            final = residual(values)
            return NewtonResult(values, final, True, iteration + 1) if np.all(np.isfinite(final)) else None
    return None


def beside(residual: Residual, jacobian: Jacobian, start: np.ndarray, *, tolerance: float = 1e-10,
           limit: int = 16) -> NewtonResult | None:  # fmt: skip
    """From a solution of equations that have changed a little, with the slopes there alone, by Broyden's updates.

    None where the steps do not become shorter from the third on, or not fast. Of equations whose slopes take as long as
    ten residuals. The last step is one after the tolerance is reached, so that its rounding is that of Newton's; what
    it leaves is judged by the slopes alone, as updates may make any step short. C. T. Kelley, Iterative Methods for
    Linear and Nonlinear Equations (1995), algorithm 7.3.1 (brsol).
    """
    values, last, steps, done = np.array(start, dtype=float), np.inf, [], False
    try:
        solved = factored(jacobian(values))
    except RuntimeError:
        return None
    for iteration in range(limit):
        step = -solved(residual(values))
        for before, after in zip(steps[:-1], steps[1:], strict=True):
            step = step + after * (before @ step / (before @ before))
        if steps:
            with np.errstate(divide="ignore", invalid="ignore"):  # of steps without an end, which are seen below
                step = step / (1 - steps[-1] @ step / (steps[-1] @ steps[-1]))
        largest = float(np.max(np.abs(step) / (1.0 + np.abs(values)), initial=0.0))
        if done or largest == 0.0:
            values = values + step
            final = residual(values)
            left = float(np.max(np.abs(solved(final)) / (1.0 + np.abs(values)), initial=0.0))
            return NewtonResult(values, final, True, iteration + 1) if left < tolerance else None
        if not np.isfinite(largest) or (iteration > 1 and largest > last / 2):
            return None
        values, last, done = values + step, largest, largest < tolerance
        steps.append(step)
    return None


def _step(matrix: sparse.csc_matrix, size: np.ndarray, damping: float) -> tuple[np.ndarray, bool]:
    """A step, and whether it is a full Newton step."""
    from scipy import sparse

    if damping == 0.0:
        try:
            step = -solve(matrix, size)
            if np.all(np.isfinite(step)):
                return step, True
        except RuntimeError:
            pass
        damping = 1e-8
    normal = matrix.T @ matrix
    diagonal = np.maximum(normal.diagonal(), 1e-12)
    return -solve(normal + damping * sparse.diags(diagonal), matrix.T @ size), False


def solve(matrix: sparse.spmatrix | np.ndarray, right: np.ndarray) -> np.ndarray:
    """Solution of matrix @ x = right; RuntimeError where the matrix is singular.

    Small matrices are solved as dense ones; by SciPy's LAPACK, for NumPy's waits for its threads on a busy machine
    (a system of 126 equations: 1 ms against 270 ms).
    """
    return factored(matrix)(right)


def factored(matrix: sparse.spmatrix | np.ndarray) -> Residual:
    """`solve` for one right side after the other, by the factors of the matrix."""
    size = matrix.shape[0]
    if size > DENSE:
        from scipy import sparse
        from scipy.sparse.linalg import splu

        return splu(sparse.csc_matrix(matrix)).solve
    if not size:
        return lambda right: right
    from scipy.linalg.lapack import dgetrf, dgetrs

    factors, pivots, info = dgetrf(matrix if isinstance(matrix, np.ndarray) else matrix.toarray())
    if info:
        raise RuntimeError("singular matrix")
    return lambda right: dgetrs(factors, pivots, right)[0]
