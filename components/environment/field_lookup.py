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
        self._plane = np.asarray(field.plane)  # the same memory, without the overhead of np.memmap at every access
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
        cells = [
            _cell(axis == "time" and self.grid.periodic, n, *rest)
            for axis, n, *rest in zip(AXES, *self._cells(points, time), strict=True)
        ]
        (y, along_y, slope_y), (z, along_z, slope_z), (t, along_t, slope_t) = cells
        stored = self._plane[t[:, :, None, None], z[:, None, :, None], y[:, None, None, :]]
        corners = self.field.speeds(stored)  # (n, time, z, y, component), two of each
        now, change = _between(corners, along_t)
        here, upwards = _between(now, along_z)
        velocity, sideways = _between(here, along_y)
        rate = np.empty((len(velocity), 3, 4))
        rate[..., 1] = sideways * slope_y
        rate[..., 2] = _between(upwards, along_y)[0] * slope_z
        rate[..., 3] = _between(_between(change, along_z)[0], along_y)[0] * slope_t
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
        corner = row * grid.columns + column
        points = [corner, corner + 1, corner + grid.columns, corner + grid.columns + 1]
        total = sum(block[:, points, 0].sum(axis=0, dtype=float) for _, block in self.field.blocks())
        corners = total.reshape(2, 2) / grid.steps
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


def _cell(wraps: bool, n: int, position: Floats, per_unit: float) -> tuple[NDArray[np.int64], Floats, Floats]:
    """Samples about a position in cells (points, 2), part of the way between them, cells per unit (0 outside)."""
    inside = np.mod(position, n) if wraps else np.clip(position, 0, n - 1)
    low = np.minimum(np.floor(np.nan_to_num(inside)).astype(int), n - (1 if wraps else 2))
    slope = np.where(wraps | (position == inside), per_unit, 0.0)
    return np.stack([low, (low + 1) % n], axis=1), inside - low, slope[:, None]


def _between(pairs: Floats, part: Floats) -> tuple[Floats, Floats]:
    """Interpolated values and differences of pairs (points, 2, ...) along their second direction."""
    change = pairs[:, 1] - pairs[:, 0]
    return pairs[:, 0] + part.reshape(-1, *[1] * (change.ndim - 1)) * change, change
