"""Wind at points and times from a full-field file: frozen turbulence, linear or cubic interpolation. Plain numpy.

The field moves along x with its mean speed U (Taylor's hypothesis): at time t the point (x, y, z) sees the plane of the
field's time t + (shift - x)/U. As in OpenFAST's InflowWind the shift is half the width of a field that ends, so that a
turbine may move upwind at t = 0, and nothing for a periodic one. Between time steps, rows and columns the speed is
interpolated linearly, continuous, with a derivative that jumps there; or by the cubic convolution of Keys (1981), with
a continuous derivative. Only the numbers around the points are decoded.
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
    covers: the first and last y [m], z [m] and, unless the field is periodic, time of the field [s].
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
        return _sum(here, along_y), rate

    def mean(self, y: float, z: float) -> float:
        """Mean over the field's time of u [m/s] at (y, z)."""
        points = np.array([[0.0, y, z]])
        self._check(*self._cells(points, 0.0)[:2], axes=("y", "z"))
        grid = self.grid
        cells = list(zip(*self._cells(points, 0.0), strict=True))[:2]
        (columns, along_y, _), (rows, along_z, _) = (_cell(False, *cell, self.count) for cell in cells)
        about = (rows[0][:, None] * grid.columns + columns[0]).ravel()
        total = sum(block[:, about, 0].sum(axis=0, dtype=float) for _, block in self.field.blocks())
        stored = along_z[0] @ total.reshape(len(rows[0]), -1) @ along_y[0] / grid.steps
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


def _keys(away: Floats) -> tuple[Floats, Floats]:
    """Weights of samples that are `away` cells from a position, Keys (1981), equation (15), and their derivatives."""
    s = np.abs(away)
    weights = np.where(s <= 1, (1.5 * s - 2.5) * s**2 + 1, ((2.5 - 0.5 * s) * s - 4) * s + 2)
    slopes = np.where(s <= 1, (4.5 * s - 5) * s, (5 - 1.5 * s) * s - 4)
    return weights, slopes * np.sign(away)


def _sum(samples: Floats, weights: Floats) -> Floats:
    """Samples (points, n, ...) times their weights (points, n), added up."""
    return np.einsum("pn...,pn->p...", samples, weights)
