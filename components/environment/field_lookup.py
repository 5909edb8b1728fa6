"""Wind at points and times from a full-field file: frozen turbulence, trilinear interpolation. Plain numpy.

The field moves along x with its mean speed U (Taylor's hypothesis): at time t the point (x, y, z) sees the plane of the
field's time t + (shift - x)/U. As in OpenFAST's InflowWind the shift is half the width of a field that ends, so that a
turbine may move upwind at t = 0, and nothing for a periodic one. Between time steps, rows and columns the speed is
interpolated linearly: continuous, with a derivative that jumps there. Only the numbers around the points are decoded.
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


class FieldLookup:
    """Velocities of a WindField, and their derivatives.

    covers: the first and last y [m], z [m] and, unless the field is periodic, time of the field [s].
    """

    def __init__(self, field: WindField, shift: float | None = None):
        grid = field.grid
        if grid.rows < 2 or grid.columns < 2:
            raise ParameterError(
                f"{field.path}: {grid.columns} x {grid.rows} points cannot be interpolated; "
                "a wind field needs 2 columns and 2 rows at least."
            )
        self.field, self.grid = field, grid
        width = (grid.columns - 1) * grid.dy
        self.shift = (0.0 if grid.periodic else width / 2) if shift is None else float(shift)
        self.covers = {"y": (-width / 2, width / 2), "z": (grid.bottom, grid.bottom + (grid.rows - 1) * grid.dz)}
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
        cells, place, scale = self._cells(points, time)
        corner, weight, slope = [], [], []
        for axis, n, position, per_unit in zip(AXES, cells, place, scale, strict=True):
            wraps = axis == "time" and self.grid.periodic
            inside = np.mod(position, n) if wraps else np.clip(position, 0, n - 1)
            low = np.minimum(np.floor(np.nan_to_num(inside)).astype(int), n - (1 if wraps else 2))
            moving = 1.0 if wraps else (position == inside).astype(float)
            corner.append((low, (low + 1) % n))
            weight.append((1 - (inside - low), inside - low))
            slope.append((-per_unit * moving * np.ones(len(low)), per_unit * moving * np.ones(len(low))))
        velocity, rate = np.zeros((len(low), 3)), np.zeros((len(low), 3, 4))
        plane = self.field.plane
        for a, b, c in np.ndindex(2, 2, 2):
            speed = self.field.speeds(plane[corner[2][c], corner[1][b], corner[0][a]])
            velocity += (weight[0][a] * weight[1][b] * weight[2][c])[:, None] * speed
            rate[..., 1] += (slope[0][a] * weight[1][b] * weight[2][c])[:, None] * speed
            rate[..., 2] += (weight[0][a] * slope[1][b] * weight[2][c])[:, None] * speed
            rate[..., 3] += (weight[0][a] * weight[1][b] * slope[2][c])[:, None] * speed
        rate[..., 0] = -rate[..., 3] / self.grid.speed
        return velocity, rate

    def mean(self, y: float, z: float) -> float:
        """Mean over the field's time of u [m/s] at (y, z)."""
        points = np.array([[0.0, y, z]])
        self._check(*self._cells(points, 0.0)[:2], axes=("y", "z"))
        grid = self.grid
        column = min(max(int((y - self.covers["y"][0]) / grid.dy), 0), grid.columns - 2)
        row = min(max(int((z - grid.bottom) / grid.dz), 0), grid.rows - 2)
        s, t = (y - self.covers["y"][0]) / grid.dy - column, (z - grid.bottom) / grid.dz - row
        corners = self.field.plane[:, row : row + 2, column : column + 2, 0].mean(axis=0)
        stored = np.array([1 - t, t]) @ corners @ np.array([1 - s, s])
        return float((stored - grid.offset[0]) / grid.slope[0])

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
            outside = ~((position >= -_MARGIN) & (position <= n - 1 + _MARGIN))
            if np.any(outside):
                i = int(np.argmax(outside))
                low, high = self.covers[axis]
                value, unit = low + position[i] * (high - low) / (n - 1), _UNITS[axis]
                remedy = "a longer" if axis == "time" else "a larger"
                raise ParameterError(
                    f"{self.field.path}: the wind field is too small: point {i} is at {axis} = {value:g} {unit}, and "
                    f"the field covers {low:g} to {high:g} {unit}; use {remedy} field."
                )
