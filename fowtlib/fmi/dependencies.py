"""Which inputs and states each derivative, output and event indicator depends on, through externals and loops."""

from __future__ import annotations

import casadi as ca
import numpy as np
from scipy import sparse
from scipy.sparse.csgraph import connected_components

from fowtlib.flattening import FlatDAE
from fowtlib.flattening.structure import matching


def dependencies(dae: FlatDAE, rows: ca.SX) -> np.ndarray:
    """Booleans (rows, 1 + states + inputs): whether a row depends on the time, each state and each input."""
    columns = ca.vertcat(dae.t, dae.x, dae.u)
    w_by, w_by_z = np.zeros((dae.w.shape[0], columns.shape[0]), bool), np.zeros((dae.w.shape[0], dae.z.shape[0]), bool)
    for k in (k for level in dae.levels for k in level):
        external = dae.externals[k]
        own = _pattern(external.function.jac_sparsity(0, 0))
        own = np.ones_like(own) if not own.any() else own
        inside = _partial(dae, external.inputs, columns, w_by, w_by_z)
        w_by[external.outputs], w_by_z[external.outputs] = (_product(own, part) for part in inside)
    alg_by, alg_by_z = _partial(dae, dae.alg, columns, w_by, w_by_z)
    z_by = _product(_inverse(alg_by_z), alg_by)
    by, by_z = _partial(dae, rows, columns, w_by, w_by_z)
    return by | _product(by_z, z_by)


def _partial(
    dae: FlatDAE, rows: ca.SX, columns: ca.SX, w_by: np.ndarray, w_by_z: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """By the columns and by z, with the externals between."""
    function = ca.Function("rows", [columns, dae.z, dae.w], [ca.densify(rows)], {"allow_free": True})
    by, by_z, by_w = (_pattern(function.jac_sparsity(0, i)) for i in range(3))
    return by | _product(by_w, w_by), by_z | _product(by_w, w_by_z)


def _pattern(sparsity: ca.Sparsity) -> np.ndarray:
    table = np.zeros(sparsity.shape, bool)
    table[tuple(sparsity.get_triplet())] = True
    return table


def _product(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    return (sparse.csr_matrix(a, dtype=np.int32) @ sparse.csr_matrix(b, dtype=np.int32)).toarray() > 0


def _inverse(pattern: np.ndarray) -> np.ndarray:
    """Pattern of the inverse of a matrix that is structurally regular: unknowns by rows."""
    n = pattern.shape[0]
    if not n:
        return pattern
    match = matching([np.flatnonzero(row) for row in pattern], n)
    if np.any(match < 0):
        return np.ones((n, n), bool)
    by_unknown = np.zeros((n, n), bool)  # unknown i needs unknown j; its equation is the one matched to it
    by_unknown[match] = pattern
    count, label = connected_components(sparse.csr_matrix(by_unknown), directed=True, connection="strong")
    member = np.zeros((n, count), bool)
    member[np.arange(n), label] = True
    blocks = _product(member.T, _product(by_unknown, member)) | np.eye(count, dtype=bool)
    reach, before = blocks, np.zeros_like(blocks)
    while np.any(reach != before):
        before, reach = reach, _product(reach, reach)
    needs = _product(_product(member, reach), member.T)
    return needs[:, match]
