"""What nonlinear rows have of second order at a Gaussian state, beside their expected values and slopes.

In Hermite polynomials of independent normal u a function is f = E[f] + E[df/du] u + 1/2 (u' h u - trace h) + ...
with h = E[d2f/du2], which is the slope of df/du by u in the mean square. So it is found from slopes at the points of
the expectations by least squares, for corners too (T. K. Caughey, 1963, and M. G. Donley and P. D. Spanos, Dynamic
Analysis of Non-Linear Structures by the Method of Statistical Quadratization, 1990: quadratic functions in place of
nonlinear ones).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

LEAST = 1e-5  # of what a row is by its terms of first order: what counts as none


@dataclass(frozen=True, eq=False)
class Points:
    """Normal numbers u (count, n), and Gaussian deviations of variables by them: u @ lift.T, lift (variables, n).

    whitening (n, variables): u of deviations; none of one that does not move.
    """

    u: np.ndarray
    lift: np.ndarray
    whitening: np.ndarray

    @property
    def deviations(self) -> np.ndarray:
        """Of the variables (count, variables)."""
        return self.u @ self.lift.T

    def by(self, values: np.ndarray) -> np.ndarray:
        """Slopes of values (count, m) by u, by least squares: (n, m)."""
        design = np.column_stack([np.ones(len(self.u)), self.u])
        return np.linalg.lstsq(design, values, rcond=None)[0][1:]


@dataclass(frozen=True, eq=False)
class QuadraticRows:
    """1/2 (u' h u - trace h) of some rows: their numbers (k,), forms h (k, n, n), and u = whitening @ deviations."""

    rows: tuple[int, ...]
    forms: np.ndarray
    whitening: np.ndarray

    @staticmethod
    def of(points: Points, forms: Mapping[int, np.ndarray], sizes: Mapping[int, float]) -> QuadraticRows:
        """Those of forms, not symmetric yet, that are something beside the size of their rows."""
        n, kept, told = points.u.shape[1], {}, points.whitening.any(axis=1)
        for row, form in forms.items():
            symmetric = (form + form.T) / 2 * np.outer(told, told)
            if np.linalg.norm(symmetric) > LEAST * sizes[row]:
                kept[row] = symmetric
        return QuadraticRows(tuple(kept), np.array(list(kept.values())).reshape(-1, n, n), points.whitening)


def forms_of(points: Points, rows: np.ndarray, columns: np.ndarray, values: np.ndarray,
             by_u: np.ndarray) -> tuple[dict[int, np.ndarray], dict[int, float]]:  # fmt: skip
    """Forms of rows, and their sizes, from entries of a matrix of slopes at all points.

    rows, columns: of the entries; values (count, entries); by_u: what the columns are by u, (columns, n).
    """
    spread, mean = np.ptp(values, axis=0), np.abs(values).max(axis=0)
    moving = np.flatnonzero(spread > 1e-12 * mean)
    slopes = points.by(values[:, moving])
    forms: dict[int, np.ndarray] = {}
    sizes: dict[int, float] = {}
    felt = np.linalg.norm(by_u, axis=1)
    for row, size in zip(rows.tolist(), (np.abs(values.mean(axis=0)) * felt[columns]).tolist(), strict=True):
        sizes[row] = max(sizes.get(row, 0.0), size)
    for k, entry in enumerate(moving.tolist()):
        form = np.outer(by_u[columns[entry]], slopes[:, k])
        row = int(rows[entry])
        forms[row] = forms[row] + form if row in forms else form
    return forms, sizes


def added(forms: dict[int, np.ndarray], row: int, form: np.ndarray) -> None:
    """Add a form to that of a row."""
    forms[row] = forms[row] + form if row in forms else form


def lifted(form: np.ndarray, size: int, at: Sequence[int]) -> np.ndarray:
    """A form of some u among `size` of them."""
    whole = np.zeros((size, size))
    whole[np.ix_(at, at)] = form
    return whole
