"""Variables of a model along a trajectory: every eliminated variable is rebuilt from the states."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import casadi as ca
import numpy as np

from fowtlib.solving.functions import AtParameters

if TYPE_CHECKING:
    from fowtlib.solving.plant import Plant

BLOCK = 2000  # points of time evaluated together


class Observation:
    """Rebuilds variables of the model along a trajectory."""

    def __init__(
        self, plant: Plant, at: AtParameters, t: np.ndarray, x: np.ndarray, z: np.ndarray, u: np.ndarray, d: np.ndarray
    ):
        self.plant, self.at = plant, at
        self.arguments = (t[None], x.T, z.T, np.concatenate([u, d], axis=1).T)

    def arrays(self, paths: Sequence[str]) -> list[np.ndarray]:
        """One array (n_time, *shape) for each path."""
        if not paths:
            return []
        expressions = [ca.densify(self.plant.dae.observe_expression(path)) for path in paths]
        sizes, shapes = [e.numel() for e in expressions], [e.shape for e in expressions]
        table = self._compiled(paths)
        if table is None:
            table = self._interpreted(paths)
        columns = np.split(table, np.cumsum(sizes)[:-1], axis=1)
        return [_shaped(column, shape) for column, shape in zip(columns, shapes, strict=True)]

    def _compiled(self, paths: Sequence[str]) -> np.ndarray | None:
        """By the code of the fixed-step engine, where it has been made, for just these variables."""
        code = self.plant.__dict__.get("fixed_step_code")
        if code is None or code.observed != list(paths):
            return None
        t, x, z, q = self.arguments
        return code.observe(t[0], x.T, z.T, self.at.whole(q).T)

    def _interpreted(self, paths: Sequence[str]) -> np.ndarray:
        function = self.at.functions.observed(paths)
        n = self.arguments[0].shape[1]
        blocks = []
        for first in range(0, n, BLOCK):
            part = slice(first, min(first + BLOCK, n))
            blocks.append(np.array(self.at.call(function, *(a[:, part] for a in self.arguments))))
        return np.concatenate(blocks, axis=1).T

    def values(self, names: Sequence[str]) -> np.ndarray:
        """Columns of scalars, (n_time, n); a single vector or matrix as (n_time, *shape)."""
        arrays = self.arrays(names)
        return arrays[0] if len(arrays) == 1 and arrays[0].ndim > 1 else np.column_stack(arrays)


def _shaped(column: np.ndarray, shape: tuple[int, int]) -> np.ndarray:
    """Rows of elements in column-major order as scalars, vectors or matrices."""
    if shape == (1, 1):
        return column[:, 0]
    return column if shape[1] == 1 else column.reshape(-1, shape[1], shape[0]).transpose(0, 2, 1)
