"""Piecewise cubics through data by their slopes, for what a start needs: SciPy's take a fifth of a start to import."""

from __future__ import annotations

import numpy as np

from fowtlib.language.errors import ParameterError


def makima_slopes(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Slopes of y (n, ...) over rising x (n,), n of 2 or more, by Akima's method (J. ACM 17, 1970), modified.

    The modification weighs differences by |d2 - d1| + |d2 + d1| / 2, so that there is no overshoot beside a flat piece,
    where slopes are zero; SciPy's Akima1DInterpolator of method "makima" is the same.
    """
    _check(x, y, 2)
    step = np.diff(x).reshape(-1, *[1] * (y.ndim - 1))
    if len(x) == 2:
        return np.repeat(np.diff(y, axis=0) / step, 2, axis=0)
    d = np.empty((len(x) + 3, *y.shape[1:]))  # of the pieces, with two more at both ends
    d[2:-2] = np.diff(y, axis=0) / step
    d[1], d[-2] = 2 * d[2] - d[3], 2 * d[-3] - d[-4]
    d[0], d[-1] = 2 * d[1] - d[2], 2 * d[-2] - d[-3]
    weight = np.abs(np.diff(d, axis=0)) + np.abs(d[1:] + d[:-1]) / 2
    before, after = weight[2:], weight[:-2]
    total = before + after
    flat = total <= 1e-9 * np.max(total, initial=0.0)
    return np.where(flat, 0.5 * (d[3:] + d[:-3]), (before * d[1:-2] + after * d[2:-1]) / np.where(flat, 1.0, total))


def not_a_knot_slopes(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Slopes of y (n, ...) over rising x (n,), n of 4 or more: of the spline without its second and last but one knot.

    C. de Boor, A Practical Guide to Splines (1978), chapter IV.
    """
    from scipy.linalg import solve_banded

    _check(x, y, 4)
    n, h = len(x), np.diff(x)
    d = np.diff(y.reshape(n, -1), axis=0) / h[:, None]
    bands, right = np.zeros((3, n)), np.empty((n, d.shape[1]))
    bands[0, 2:], bands[1, 1:-1], bands[2, :-2] = h[:-1], 2 * (h[:-1] + h[1:]), h[1:]
    right[1:-1] = 3 * (h[1:, None] * d[:-1] + h[:-1, None] * d[1:])
    for end, first, second in ((0, 0, 1), (-1, -1, -2)):
        both = h[first] + h[second]
        bands[1, end] = h[second]
        bands[0 if end == 0 else 2, 1 if end == 0 else -2] = both
        right[end] = ((h[first] + 2 * both) * h[second] * d[first] + h[first] ** 2 * d[second]) / both
    return solve_banded((1, 1), bands, right).reshape(y.shape)


def between(x: np.ndarray, y: np.ndarray, slopes: np.ndarray, at: np.ndarray) -> np.ndarray:
    """Values (m, ...) at points (m,) of the cubics through y (n, ...) with these slopes; outside, of the last piece."""
    k = np.clip(np.searchsorted(x, at, side="right") - 1, 0, len(x) - 2)
    h = x[k + 1] - x[k]
    weights = _weights((at - x[k]) / h, h)
    rows = (y[k], y[k + 1], slopes[k], slopes[k + 1])
    return sum(w.reshape(-1, *[1] * (y.ndim - 1)) * row for w, row in zip(weights, rows, strict=True))


def _weights(s: np.ndarray, h: np.ndarray) -> tuple[np.ndarray, ...]:
    """Of the values and slopes at both ends of a piece of length h, s from 0 to 1 in between."""
    r = 1 - s
    return (1 + 2 * s) * r * r, (1 + 2 * r) * s * s, h * s * r * r, -h * s * s * r


class CubicSurface:
    """The spline through a table (n, m) over rising x (n,) and y (m,), 4 or more of each; not a knot in both ways."""

    def __init__(self, x: np.ndarray, y: np.ndarray, table: np.ndarray):
        self.x, self.y = (np.asarray(axis, dtype=float) for axis in (x, y))
        table = np.asarray(table, dtype=float)
        of_x, of_y = not_a_knot_slopes(self.x, table), not_a_knot_slopes(self.y, table.T).T
        self._corners = np.array([[table, of_y], [of_x, not_a_knot_slopes(self.x, of_y)]])

    def __call__(self, x: np.ndarray | float, y: np.ndarray | float) -> np.ndarray:
        """Values at points within the table, x and y of one shape or one number."""
        at = np.broadcast_arrays(np.asarray(x, dtype=float), np.asarray(y, dtype=float))
        places, weights = [], []
        for axis, point in zip((self.x, self.y), at, strict=True):
            k = np.searchsorted(axis[1:-1], point, side="right")  # of the pieces
            h = axis[k + 1] - axis[k]
            low, high, low_slope, high_slope = _weights((point - axis[k]) / h, h)
            places.append(k)
            weights.append([[low, high], [low_slope, high_slope]])
        corners = [(i, j, a, b) for i in (0, 1) for j in (0, 1) for a in (0, 1) for b in (0, 1)]
        (k, n), (of_x, of_y) = places, weights
        return sum(of_x[i][a] * of_y[j][b] * self._corners[i, j, k + a, n + b] for i, j, a, b in corners)


def _check(x: np.ndarray, y: np.ndarray, least: int) -> None:
    if len(x) < least or len(x) != len(y) or not np.all(np.diff(x) > 0):
        raise ParameterError(f"cubics need {least} points or more, at values that rise, with as many numbers.")
