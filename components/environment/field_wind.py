"""The wind of a full-field file in a model: external functions around the look-up."""

from __future__ import annotations

from functools import lru_cache
from pathlib import Path
from typing import Any

import casadi as ca
import numpy as np

from fowtlib.components.environment.field_file import read_field
from fowtlib.components.environment.field_lookup import FieldLookup
from fowtlib.language import ExternalFunction
from fowtlib.language import math as m
from fowtlib.language.equations import active


def open_field(path: str, shift: float | None) -> FieldLookup:
    """The look-up of a `.bts` file; the same object as long as the file does not change."""
    try:
        status = Path(path).stat()
        version = (status.st_mtime_ns, status.st_size)
    except OSError:
        version = (0, 0)
    return _open(path, shift, version)


@lru_cache(maxsize=8)
def _open(path: str, shift: float | None, version: tuple[int, int]) -> FieldLookup:
    return FieldLookup(read_field(path), shift)


def field_function(lookup: FieldLookup, points: int) -> ExternalFunction:
    """External function of the time [s] and the positions x, y, z [m] of each point, one after the other.

    Gives u, v, w [m/s] of each point, and its Jacobian. Beyond the edge it keeps the value of the edge, so that an
    iteration may look there.
    """

    def evaluate(column: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        return lookup.evaluate(column[1:].reshape(points, 3), column[0])

    def slope(column: np.ndarray) -> np.ndarray:
        rate = evaluate(column)[1]
        matrix = np.zeros((points, 3, 1 + 3 * points))
        for i in range(points):
            matrix[i, :, 0] = rate[i, :, 3]
            matrix[i, :, 1 + 3 * i : 4 + 3 * i] = rate[i, :, :3]
        return matrix.reshape(3 * points, -1)

    sizes = {"time": 1, "positions": 3 * points}, {"velocities": 3 * points}
    return ExternalFunction("wind_field", *sizes, python=lambda column: evaluate(column)[0].ravel(), jacobian=slope)


def field_velocity(lookup: FieldLookup, time: Any, positions: Any) -> Any:
    """Velocities (3, n) at `positions` (3, n), both along the axes of the field; while flattening.

    A run in which one of the points leaves the field stops there.
    """
    positions = ca.SX(positions)  # fixed points are numbers
    points, grid = positions.shape[1], lookup.grid
    for i in range(points):
        places = {"y": positions[1, i], "z": positions[2, i]}
        if not grid.periodic:
            places["time"] = time + (lookup.shift - positions[0, i]) / grid.speed
        for axis, (low, high) in lookup.covers.items():
            active().check_range(places[axis], low, high, f"wind field {lookup.field.path}", axis)
    result = field_function(lookup, points)(time=time, positions=positions)["velocities"]
    return m.horzcat(*[result[3 * i : 3 * i + 3] for i in range(points)])
