"""Arrays on straight lines between the points of a schedule, as a part has them from a ScheduledTable."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from fowtlib.language import math as m


def interpolated(at, points, rows):
    """Row of a table (k, ...) at a value of its schedule: straight lines, and the first or the last row beyond."""
    row = rows[0, :]
    for i in range(rows.shape[0] - 1):
        weight = m.fmin(m.fmax((at - points[i]) / (points[i + 1] - points[i]), 0), 1)
        row = row + weight * (rows[i + 1, :] - rows[i, :])
    return row.T


def flat(name: str) -> Callable[[Any], np.ndarray]:
    """Default of a parameter: an array of the part's table as one row a point."""
    return lambda part: getattr(part.table, name).reshape(len(part.table.points), -1)


def flat_shape(name: str) -> Callable[[Any], tuple[int, ...]]:
    """The shape of that."""
    return lambda part: np.shape(flat(name)(part))
