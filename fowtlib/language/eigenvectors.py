"""Eigenvectors of the matrices of linear models; those of the last ones are kept, since more than one asks for them."""

from __future__ import annotations

from collections import OrderedDict
from threading import Lock

import numpy as np

Basis = tuple[np.ndarray, np.ndarray, np.ndarray]

EIGENVECTORS = 1e-9
"""Error of a matrix from its eigenvectors, relative, up to which these serve."""


KEPT = 4
_bases: OrderedDict[bytes, Basis | None] = OrderedDict()
_bases_lock = Lock()


def eigenvectors(A: np.ndarray) -> Basis | None:
    """Eigenvalues (n,) of a matrix, its right and its left eigenvectors; None where these do not give A (defective).

    Not to be changed: those of the last matrices are kept.
    """
    key = _key(A)
    with _bases_lock:
        if key in _bases:
            _bases.move_to_end(key)
            return _bases[key]
    found = _found(A)
    for array in found or ():
        array.flags.writeable = False
    with _bases_lock:
        _bases[key] = found
        while len(_bases) > KEPT:
            _bases.popitem(last=False)
    return found


def eigenvalues(A: np.ndarray) -> np.ndarray:
    """Eigenvalues (n,) of a matrix: those beside its eigenvectors, where these are known."""
    with _bases_lock:
        known = _bases.get(_key(A))
    return known[0] if known is not None else np.linalg.eigvals(A)


def _key(A: np.ndarray) -> bytes:
    A = np.asarray(A)
    return repr((A.shape, A.dtype.str)).encode() + A.tobytes()


def _found(A: np.ndarray) -> Basis | None:
    roots, right = np.linalg.eig(A)
    try:
        left = np.linalg.inv(right)
    except np.linalg.LinAlgError:
        return None
    good = np.linalg.norm((right * roots) @ left - A) < EIGENVECTORS * np.linalg.norm(A)
    return (roots, right, left) if good else None
