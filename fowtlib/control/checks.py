"""What a user gives to a design by name: weights and noise of states, inputs and outputs, as matrices."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fowtlib.language.errors import NotFoundError, ParameterError, did_you_mean

Matrix = NDArray[np.float64]
Eigenvalues = NDArray[np.complex128] | NDArray[np.float64]
Weights = Mapping[str, float] | ArrayLike
"""By name, where what is not named has none; or a number for all, a diagonal, or a whole symmetric matrix."""


def numbers_of(names: Sequence[str], known: Sequence[str], what: str) -> list[int]:
    """Places of names among those known. Raises NotFoundError."""
    for name in names:
        if name not in known:
            raise NotFoundError(f"the linear model has no {what} '{name}'{did_you_mean(name, known)}")
    return [list(known).index(name) for name in names]


def weight_matrix(weights: Weights, names: Sequence[str], what: str, *, definite: bool) -> Matrix:
    """The symmetric matrix (n, n) of weights of `what` (states, inputs, ...) by name.

    definite: each direction needs a positive weight; else none may have a negative one. Raises ParameterError.
    """
    n = len(names)
    try:
        if isinstance(weights, Mapping):
            numbers_of(list(weights), names, what)
            weights = [float(weights.get(name, 0.0)) for name in names]
        given = np.array(weights, dtype=float)
    except (TypeError, ValueError):
        raise ParameterError(f"the weights of the {what}s are not numbers.") from None
    if given.ndim == 0:
        matrix = float(given) * np.eye(n)
    elif given.shape == (n,):
        matrix = np.diag(given)
    elif given.shape == (n, n):
        matrix = given
    else:
        raise ParameterError(
            f"the weights of the {what}s have the shape {given.shape}; there are {n} {what}s, so give a number, "
            f"{n} numbers, a matrix {(n, n)}, or weights by name."
        )
    if not np.all(np.isfinite(matrix)):
        raise ParameterError(f"the weights of the {what}s are not all finite numbers.")
    if not np.allclose(matrix, matrix.T, rtol=1e-9, atol=0):
        raise ParameterError(f"the matrix of the weights of the {what}s is not symmetric.")
    least, vectors = np.linalg.eigh(matrix)
    bound = 1e-13 * max(float(np.max(np.abs(least), initial=0.0)), 1e-300)
    if n and (least[0] <= 0 if definite else least[0] < -bound):
        name = names[int(np.argmax(np.abs(vectors[:, 0])))]
        wanted = "be positive" if definite else "not be negative"
        raise ParameterError(f"the weight of the {what} '{name}' must {wanted}: an eigenvalue is {least[0]:g}.")
    return matrix
