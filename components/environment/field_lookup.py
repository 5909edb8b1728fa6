"""Wind at points and times from a full-field file: frozen turbulence, linear or cubic interpolation. Plain numpy.

The field moves along x with its mean speed U (Taylor's hypothesis): at time t the point (x, y, z) sees the plane of the
field's time t + (shift - x)/U. As in OpenFAST's InflowWind the shift is half the width of a field that ends, so that a
turbine may move upwind at t = 0, and nothing for a periodic one. Between time steps, rows and columns the speed is
interpolated linearly, continuous, with a derivative that jumps there; or by the cubic convolution of Keys (1981), with
a continuous derivative. Only the numbers around the points are decoded.

Below the plane the points of the tower serve, where the file has them: linear in z from the middle of the lowest row
down, whatever y is, as in InflowWind.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fowtlib.components.environment.field_file import WindField
from fowtlib.language.errors import ParameterError

Floats = NDArray[np.float64]

AXES = ("y", "z", "time")
_UNITS = {"y": "m", "z": "m", "time": "s"}
_MARGIN = 1e-6  # of a cell: rounding of positions and of the header's float32


SAMPLES = {"linear": 2, "cubic": 4}
"""Samples in each direction that a value comes from, by the kind of interpolation."""


class FieldLookup:
    """Velocities of a WindField, and their derivatives.

    interpolation: "linear" or "cubic" along y, z and time. Cubic is the convolution of R. G. Keys (1981), IEEE Trans.
    Acoust. Speech Signal Process. 29, 1153-1160, with a = -1/2; at an edge it goes on by a parabola, as there.
    covers: the first and last y [m], z [m] and, unless the field is periodic, time [s] of its plane; lowest: z [m] of
    the lowest tower point, or of the plane.
    """

    def __init__(self, field: WindField, shift: float | None = None, interpolation: str = "linear"):
        grid, least = field.grid, SAMPLES[interpolation]
        instead = ", or linear interpolation" if least > 2 else ""
        if grid.rows < least or grid.columns < least:
            raise ParameterError(
                f"{field.path}: {grid.columns} x {grid.rows} points cannot be interpolated; "
                f"a wind field needs {least} columns and {least} rows at least{instead}."
            )
        if grid.steps < least:
            raise ParameterError(
                f"{field.path}: {grid.steps} time steps cannot be interpolated; "
                f"a wind field needs {least} at least{instead}."
            )
        self.field, self.grid, self.interpolation, self.count = field, grid, interpolation, least
        # the same memory, without the overhead of np.memmap at every access
        self._plane, self._tower = np.asarray(field.plane), np.asarray(field.tower)
        width = (grid.columns - 1) * grid.dy
        self.shift = (0.0 if grid.periodic else width / 2) if shift is None else float(shift)
        self.covers = {"y": (-width / 2, width / 2), "z": (grid.bottom, grid.bottom + (grid.rows - 1) * grid.dz)}
        self.lowest = grid.bottom - grid.tower_points * grid.dz
        if not grid.periodic:
            self.covers["time"] = (0.0, grid.duration)

    def velocity(self, points: ArrayLike, time: ArrayLike) -> Floats:
        """Velocities (n, 3) [m/s] at `points` (n, 3) [m] and one `time` or n times [s].

        Raises ParameterError where the field does not reach.
        """
        self._check(*self._cells(points, time)[:2])
        return self.evaluate(points, time)[0]

    def evaluate(self, points: ArrayLike, time: ArrayLike) -> tuple[Floats, Floats]:
        """Velocities (n, 3) and d velocity / d (x, y, z, t) (n, 3, 4); beyond the edge the values of the edge."""
        cells = [
            _cell(axis == "time" and self.grid.periodic, n, *rest, self.count)
            for axis, n, *rest in zip(AXES, *self._cells(points, time), strict=True)
        ]
        (y, along_y, slope_y), (z, along_z, slope_z), (t, along_t, slope_t) = cells
        stored = self._plane[t[:, :, None, None], z[:, None, :, None], y[:, None, None, :]]
        about = self.field.speeds(stored)  # (n, time, z, y, component)
        now, here = _sum(about, along_t), _sum(_sum(about, along_t), along_z)
        rate = np.empty((len(about), 3, 4))
        rate[..., 1] = _sum(here, slope_y)
        rate[..., 2] = _sum(_sum(now, slope_z), along_y)
        rate[..., 3] = _sum(_sum(_sum(about, slope_t), along_z), along_y)
        rate[..., 0] = -rate[..., 3] / self.grid.speed
        velocity, heights = _sum(here, along_y), np.asarray(points, dtype=float).reshape(-1, 3)[:, 2]
        below = heights < self.grid.bottom if self.grid.tower_points else np.zeros(len(rate), dtype=bool)
        if np.any(below):
            velocity[below], rate[below] = self._in_tower(heights[below], *(x[below] for x in (t, along_t, slope_t)))
        return velocity, rate

    def _in_tower(self, z: Floats, t: NDArray[np.int64], along_t: Floats, slope_t: Floats) -> tuple[Floats, Floats]:
        """As `evaluate`, at heights z (n,) below the plane, with the samples in time and their weights."""
        grid = self.grid
        depth = (grid.bottom - z) / grid.dz
        k = np.minimum(depth.astype(int), grid.tower_points - 1)
        part = np.minimum(depth - k, 1)[:, None]
        upper, lower = self._line(t, k), self._line(t, k + 1)
        down, along_z = _sum(lower - upper, along_t), np.hstack([1 - part, part])
        rate = np.zeros((len(z), 3, 4))
        here = np.stack([upper, lower], axis=1)
        rate[..., 2] = -down / grid.dz * (depth < grid.tower_points)[:, None]
        rate[..., 3] = _sum(_sum(here, along_z), slope_t)
        rate[..., 0] = -rate[..., 3] / grid.speed
        return _sum(_sum(here, along_z), along_t), rate

    def _line(self, t: NDArray[np.int64], k: NDArray[np.int64]) -> Floats:
        """Speeds (n, samples, 3) at time steps (n, samples) in point k (n,) of the tower; 0: above it, the plane."""
        middle = slice((self.grid.columns - 1) // 2, self.grid.columns // 2 + 1)
        plane = self._plane[t, 0, middle].mean(axis=2)
        return self.field.speeds(np.where((k > 0)[:, None, None], self._tower[t, k[:, None] - 1], plane))

    def mean(self, y: float, z: float) -> float:
        """Mean over the field's time of u [m/s] at (y, z)."""
        points = np.array([[0.0, y, z]])
        self._check(*self._cells(points, 0.0)[:2], axes=("y", "z"))
        grid = self.grid
        below = z < grid.bottom and grid.tower_points
        about, weights = self._tower_weights(z) if below else self._plane_weights(points)
        total = sum(block[:, about, 0].sum(axis=0, dtype=float) for _, block in self.field.blocks())
        return float((weights @ total / grid.steps - grid.offset[0]) / grid.slope[0])

    def over_disk(self, y: float, z: float, radius: float) -> Floats:
        """Mean of u [m/s] over the grid points within `radius` [m] of (y, z), at the time steps (steps,).

        Without a point that near it is u at the place itself.
        """
        grid = self.grid
        inside = np.hypot(grid.y - y, grid.z[:, None] - z) <= radius
        about, weights = np.flatnonzero(inside), np.full(inside.sum(), 1 / max(inside.sum(), 1))
        if not about.size:
            about, weights = self._plane_weights(np.array([[0.0, y, z]]))
        stored = np.concatenate([block[:, about, 0] @ weights for _, block in self.field.blocks()])
        return (stored - grid.offset[0]) / grid.slope[0]

    def _plane_weights(self, points: Floats) -> tuple[NDArray[np.int64], Floats]:
        """Numbers and weights of the stored points about one in the plane."""
        cells = list(zip(*self._cells(points, 0.0), strict=True))[:2]
        (columns, along_y, _), (rows, along_z, _) = (_cell(False, *cell, self.count) for cell in cells)
        about = rows[0][:, None] * self.grid.columns + columns[0]
        return about.ravel(), np.outer(along_z[0], along_y[0]).ravel()

    def _tower_weights(self, z: float) -> tuple[NDArray[np.int64], Floats]:
        """Numbers and weights of the stored points about one below the plane."""
        grid = self.grid
        depth = (grid.bottom - z) / grid.dz
        k = min(int(depth), grid.tower_points - 1)
        part, tower = min(depth - k, 1.0), grid.rows * grid.columns
        above = [(grid.columns - 1) // 2, grid.columns // 2] if k == 0 else [tower + k - 1] * 2
        return np.array([*above, tower + k]), np.array([(1 - part) / 2, (1 - part) / 2, part])

    def field_time(self, x: ArrayLike, time: ArrayLike) -> Floats:
        """Time of the field [s] that position x [m] sees at `time` [s]."""
        return np.asarray(time, dtype=float) + (self.shift - np.asarray(x, dtype=float)) / self.grid.speed

    def _cells(self, points: ArrayLike, time: ArrayLike) -> tuple[tuple[int, ...], list[Floats], tuple[float, ...]]:
        """Number of samples, position in cells and cells per unit, along y, z and time."""
        r, grid = np.asarray(points, dtype=float).reshape(-1, 3), self.grid
        tau = np.broadcast_to(self.field_time(r[:, 0], time), len(r))
        scale = (1 / grid.dy, 1 / grid.dz, 1 / grid.dt)
        origin = (self.covers["y"][0], grid.bottom, 0.0)
        place = [(value - o) * s for value, o, s in zip((r[:, 1], r[:, 2], tau), origin, scale, strict=True)]
        return (grid.columns, grid.rows, grid.steps), place, scale

    def _check(self, cells: tuple[int, ...], place: list[Floats], axes: tuple[str, ...] = AXES) -> None:
        for axis, n, position in zip(AXES, cells, place, strict=True):
            if axis not in self.covers or axis not in axes:
                continue
            first = -self.grid.tower_points if axis == "z" else 0
            outside = ~((position >= first - _MARGIN) & (position <= n - 1 + _MARGIN))
            if np.any(outside):
                i = int(np.argmax(outside))
                low, high = self.covers[axis]
                value, unit = low + position[i] * (high - low) / (n - 1), _UNITS[axis]
                low, remedy = self.lowest if axis == "z" else low, "a longer" if axis == "time" else "a larger"
                raise ParameterError(
                    f"{self.field.path}: the wind field is too small: point {i} is at {axis} = {value:g} {unit}, and "
                    f"the field covers {low:g} to {high:g} {unit}; use {remedy} field."
                )


def _cell(
    wraps: bool, n: int, position: Floats, per_unit: float, count: int
) -> tuple[NDArray[np.int64], Floats, Floats]:
    """Samples about a position in cells, their weights and the derivatives of these (0 outside), (points, count)."""
    inside = np.mod(position, n) if wraps else np.clip(position, 0, n - 1)
    low = np.minimum(np.floor(np.nan_to_num(inside)).astype(int), n - (1 if wraps else 2))
    part = (inside - low)[:, None]
    samples = low[:, None] + np.arange(count) - (count // 2 - 1)
    if count == 2:
        weights, slopes = np.hstack([1 - part, part]), np.tile([-1.0, 1.0], (len(part), 1))
    else:
        weights, slopes = _keys(part - np.arange(-1, 3))
    slopes = slopes * np.where(wraps | (position == inside), per_unit, 0.0)[:, None]
    for one in (weights, slopes) if count == 4 and not wraps else ():
        below, above = np.where(samples < 0, one, 0)[:, :1], np.where(samples >= n, one, 0)[:, 3:]
        one += below * [-1, 3, -3, 1] + above * [1, -3, 3, -1]  # what is beyond an edge goes on by a parabola
    return samples % n, weights, slopes


def cell_weights(n: int, position: Floats, count: int) -> tuple[NDArray[np.int64], Floats]:
    """Samples of n about positions (points,) in cells, and their weights, (points, count); see SAMPLES."""
    return _cell(False, n, position, 1.0, count)[:2]


def _keys(away: Floats) -> tuple[Floats, Floats]:
    """Weights of samples that are `away` cells from a position, Keys (1981), equation (15), and their derivatives."""
    s = np.abs(away)
    weights = np.where(s <= 1, (1.5 * s - 2.5) * s**2 + 1, ((2.5 - 0.5 * s) * s - 4) * s + 2)
    slopes = np.where(s <= 1, (4.5 * s - 5) * s, (5 - 1.5 * s) * s - 4)
    return weights, slopes * np.sign(away)


def _sum(samples: Floats, weights: Floats) -> Floats:
    """Samples (points, n, ...) times their weights (points, n), added up."""
    return np.einsum("pn...,pn->p...", samples, weights)
