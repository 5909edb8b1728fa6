"""What the matrix of a parameter must be: symmetric, and without directions in which it has the wrong sign."""

from __future__ import annotations

from typing import Literal

import numpy as np

Form = Literal["symmetric", "inertia", "stiffness"]
"""symmetric: as added mass and the stiffness of a waterplane are. inertia: an inertia tensor, symmetric without a
negative principal moment. stiffness: of something that holds in all directions, symmetric and positive definite."""

# Difference of (i, j) and (j, i) over sqrt(M_ii M_jj). What comes from panels is symmetric within 5 %, as a database is
# asked to be; what comes from a drawing has a few digits.
TOLERANCE = {"symmetric": 0.05, "inertia": 1e-3, "stiffness": 1e-6}
WORDS = {"symmetric": "this matrix", "inertia": "an inertia tensor", "stiffness": "a stiffness"}
ROUNDING = 1e-6  # of the largest principal moment: a negative one as small as this is rounding


def wrong_form(form: Form, matrix: np.ndarray) -> str:
    """What is wrong with a matrix, in words; "" where nothing is.

    Entries beside a diagonal without numbers, as those of yaw in a waterplane, are compared where the form asks for
    signs too: elsewhere nothing says what is small.
    """
    M = np.asarray(matrix, dtype=float)
    diagonal = np.diag(M)
    if np.count_nonzero(M) > np.count_nonzero(diagonal):
        scale = np.sqrt(np.outer(np.abs(diagonal), np.abs(diagonal)))
        off = np.abs(M - M.T) / np.where(scale > 0, scale, np.inf if form == "symmetric" else 1e-300)
        i, j = (int(k) for k in np.unravel_index(np.argmax(off), off.shape))
        if off[i, j] > TOLERANCE[form]:
            i, j = min(i, j), max(i, j)
            return (f"entry ({i + 1}, {j + 1}) is {M[i, j]:g} and ({j + 1}, {i + 1}) is {M[j, i]:g}; {WORDS[form]} is "
                    "symmetric")  # fmt: skip
        lowest, highest = np.linalg.eigvalsh((M + M.T) / 2)[[0, -1]]
    else:
        lowest, highest = diagonal.min(), diagonal.max()
    if form == "inertia" and lowest < -ROUNDING * max(highest, 0.0):
        return f"its least principal moment is {lowest:g} kg m^2, and no body has a negative one; check the signs"
    if form == "stiffness" and not _definite(M):
        return ("it must be positive definite, as what holds in all directions is; check the signs of the entries that "
                "couple forces and moments")  # fmt: skip
    return ""


def _definite(M: np.ndarray) -> bool:
    """Whether a symmetric matrix is positive definite, whatever the units of its rows."""
    diagonal = np.diag(M)
    return bool(np.all(diagonal > 0) and np.linalg.eigvalsh(M / np.sqrt(np.outer(diagonal, diagonal)))[0] > 0)
