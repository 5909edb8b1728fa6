"""Pure graph code on the incidence of equations and unknowns: matching, Dulmage-Mendelsohn, strong components."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import casadi as ca
import numpy as np

if TYPE_CHECKING:
    from scipy.sparse import csr_array

Rows = Sequence[np.ndarray]


def matrix(rows: Rows, columns: int) -> csr_array:
    """Incidence as a sparse matrix of ones."""
    from scipy.sparse import csr_array  # slow to import, and a model that is kept on disk needs none

    lengths = np.fromiter((len(row) for row in rows), int, len(rows))
    indices = np.concatenate(list(rows)) if len(rows) and lengths.sum() else np.zeros(0, int)
    pointers = np.concatenate([[0], np.cumsum(lengths)])
    return csr_array((np.ones(len(indices), dtype=np.int8), indices.astype(np.int32), pointers.astype(np.int32)),
                     shape=(len(rows), columns))  # fmt: skip


def matching(rows: Rows, columns: int) -> np.ndarray:
    """Column matched to each row in a maximum matching, -1 for none."""
    if not len(rows) or not columns:
        return np.full(len(rows), -1)
    from scipy.sparse.csgraph import maximum_bipartite_matching

    return maximum_bipartite_matching(matrix(rows, columns), perm_type="column")


@dataclass
class Coarse:
    """Dulmage-Mendelsohn coarse decomposition: what is over- and what is under-determined."""

    over_rows: np.ndarray
    over_columns: np.ndarray
    under_rows: np.ndarray
    under_columns: np.ndarray
    unmatched_rows: np.ndarray
    unmatched_columns: np.ndarray

    @property
    def is_regular(self) -> bool:
        return not len(self.unmatched_rows) and not len(self.unmatched_columns)


def dulmage_mendelsohn(rows: Rows, columns: int) -> Coarse:
    """Rows reached by alternating paths from unmatched rows, columns reached from unmatched columns."""
    match = matching(rows, columns)
    row_of = np.full(columns, -1)
    row_of[match[match >= 0]] = np.flatnonzero(match >= 0)
    free_rows, free_columns = np.flatnonzero(match < 0), np.flatnonzero(row_of < 0)
    if not len(free_rows) and not len(free_columns):
        return Coarse(*[np.zeros(0, int)] * 6)
    over_rows, over_columns = reachable(rows, row_of, free_rows)
    transposed: list[list[int]] = [[] for _ in range(columns)]
    for i, row in enumerate(rows):
        for j in row:
            transposed[j].append(i)
    under_columns, under_rows = reachable([np.array(t, int) for t in transposed], match, free_columns)
    return Coarse(over_rows, over_columns, under_rows, under_columns, free_rows, free_columns)


def reachable(rows: Rows, row_of: np.ndarray, start: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Rows and columns on alternating paths from given rows: row, any column of it, the row matched to that."""
    seen_rows, seen_columns = set(map(int, start)), set()
    front = list(seen_rows)
    while front:
        row = front.pop()
        for column in rows[row]:
            if column in seen_columns:
                continue
            seen_columns.add(int(column))
            partner = int(row_of[column])
            if partner >= 0 and partner not in seen_rows:
                seen_rows.add(partner)
                front.append(partner)
    return np.array(sorted(seen_rows), int), np.array(sorted(seen_columns), int)


def strong_components(rows: Rows, columns: int) -> list[tuple[np.ndarray, np.ndarray]]:
    """Blocks (rows, columns) of a square regular incidence in the order in which they can be solved."""
    n = len(rows)
    row_index = np.repeat(np.arange(n), [len(row) for row in rows]) if n else np.zeros(0, int)
    column_index = np.concatenate(list(rows)) if n else np.zeros(0, int)
    sparsity = ca.Sparsity.triplet(n, columns, row_index.tolist(), column_index.tolist())
    blocks, row_order, column_order, row_start, column_start, *_ = sparsity.btf()
    row_order, column_order = np.array(row_order, int), np.array(column_order, int)
    return [
        (row_order[row_start[k] : row_start[k + 1]], column_order[column_start[k] : column_start[k + 1]])
        for k in range(blocks)
    ]
