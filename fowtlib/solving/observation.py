"""Variables of a model at a state and along a trajectory: every eliminated variable is rebuilt from the states."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import casadi as ca
import numpy as np

from fowtlib.solving.engines.fixed_step_code import FixedStepCode
from fowtlib.solving.functions import AtParameters
from fowtlib.solving.state import State

ROWS = 4096  # points that compiled functions are given at once


def observed(at: AtParameters, paths: Sequence[str], state: State) -> list[np.ndarray]:
    """Variables at a state, SI, as matrices."""
    shapes = [at.dae.observe_expression(path).shape for path in paths]
    q = np.concatenate([state.u, state.d])
    values = np.array(at.call(at.functions.observed(paths), state.t, state.x, state.z, q)).ravel()
    columns = np.split(values, np.cumsum([rows * columns for rows, columns in shapes])[:-1])
    return [column.reshape(shape, order="F") for column, shape in zip(columns, shapes, strict=True)]


class Observation:
    """Rebuilds variables of the model along a trajectory: t (n,), and x, z, d with a row for each, u of all times.

    code: the compiled functions of the fixed-step engine, where they have been made; they give the variables that they
    were made for. seen: what they have given at these points already, (n, code.width), rows of NaN where nothing.
    """

    def __init__(self, at: AtParameters, t: np.ndarray, x: np.ndarray, z: np.ndarray, u: np.ndarray, d: np.ndarray,
                 code: FixedStepCode | None = None, seen: np.ndarray | None = None):  # fmt: skip
        self.at, self.code, self.seen = at, code, seen
        self.arguments = (t, x, z, np.concatenate([np.repeat(u[None], len(t), axis=0), d], axis=1))

    def arrays(self, paths: Sequence[str]) -> list[np.ndarray]:
        """One array (n_time, *shape) for each path."""
        if not paths:
            return []
        expressions = [ca.densify(self.at.dae.observe_expression(path)) for path in paths]
        sizes, shapes = [e.numel() for e in expressions], [e.shape for e in expressions]
        table = self._compiled(paths)
        if table is None:
            table = self.at.along(self.at.functions.observed(paths), *self.arguments)
        columns = np.split(table, np.cumsum(sizes)[:-1], axis=1)
        return [_shaped(column, shape) for column, shape in zip(columns, shapes, strict=True)]

    def _compiled(self, paths: Sequence[str]) -> np.ndarray | None:
        """The variables from compiled code, all their elements in a row; None where it does not give all of them."""
        if self.code is None or not all(path in self.code.columns for path in paths):
            return None
        columns = [column for path in paths for column in self.code.columns[path]]
        if self.seen is None:
            table = self.rows()
        elif (unseen := np.isnan(self.seen).all(axis=1)).any():
            missing = self.rows(unseen)
            table = None if missing is None else self.seen.copy()
            if table is not None:
                table[unseen] = missing
        else:
            table = self.seen
        return None if table is None else table[:, columns]

    def rows(self, chosen: Any = slice(None)) -> np.ndarray | None:
        """What compiled code gives at the chosen points, (n, code.width), NaN for the conditions of the checks.

        None where there is no such code, or it fails.
        """
        if self.code is None:
            return None
        t, x, z, q = (values[chosen] for values in self.arguments)
        blocks = []
        for first in range(0, max(len(t), 1), ROWS):  # the parameters stand beside each point, and there may be many
            part = slice(first, first + ROWS)
            parameters = np.repeat(self.at.parameters[None], len(t[part]), axis=0)
            values = self.code.observe(t[part], x[part], z[part], np.concatenate([q[part], parameters], axis=1))
            if values is None:
                return None
            blocks.append(values)
        rows = np.concatenate(blocks)
        return np.hstack([rows, np.full((len(rows), self.code.width - self.code.size), np.nan)])

    def values(self, names: Sequence[str]) -> np.ndarray:
        """Columns of scalars, (n_time, n); a single vector or matrix as (n_time, *shape)."""
        arrays = self.arrays(names)
        return arrays[0] if len(arrays) == 1 and arrays[0].ndim > 1 else np.column_stack(arrays)


def _shaped(column: np.ndarray, shape: tuple[int, int]) -> np.ndarray:
    """Rows of elements in column-major order as scalars, vectors or matrices."""
    if shape == (1, 1):
        return column[:, 0]
    return column if shape[1] == 1 else column.reshape(-1, shape[1], shape[0]).transpose(0, 2, 1)
