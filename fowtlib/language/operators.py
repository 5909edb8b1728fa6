"""Linear operators: what is known by its transfer function, and realised by states where time is stepped.

The memory of waves, of a viscoelastic material, of heat in the ground: linear parts that a theory or a measurement
gives over frequency. A run in time needs a state space, which is an approximation; the frequency domain needs none.
`linear_operator` states both, so that one model serves them.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import casadi as ca
import numpy as np
from numpy.typing import ArrayLike

from fowtlib.language.eigenvectors import eigenvectors
from fowtlib.language.equations import Equation, der, input_rate, source_line
from fowtlib.language.errors import StructureError
from fowtlib.language.run_time import at_start

Transfer = Callable[[np.ndarray], np.ndarray]


@dataclass(frozen=True, eq=False)
class StateSpace:
    """x' = A x + B u, y = C x + D u: matrices (k, k), (k, m), (n, k), (n, m); without D it is zero."""

    A: np.ndarray
    B: np.ndarray
    C: np.ndarray
    D: np.ndarray

    def __init__(self, A: ArrayLike, B: ArrayLike, C: ArrayLike, D: ArrayLike | None = None):
        A, B, C = (np.atleast_2d(np.asarray(matrix, dtype=float)) for matrix in (A, B, C))
        k, m, n = len(A), B.shape[1], C.shape[0]
        D = np.zeros((n, m)) if D is None else np.atleast_2d(np.asarray(D, dtype=float))
        shapes = [matrix.shape for matrix in (A, B, C, D)]
        if k and shapes != [(k, k), (k, m), (n, k), (n, m)]:
            raise StructureError(f"a state space with A, B, C, D of the shapes {', '.join(map(str, shapes))}.")
        for name, matrix in zip("ABCD", (A, B, C, D), strict=True):
            object.__setattr__(self, name, matrix)

    @property
    def states(self) -> int:
        """Number of states."""
        return self.A.shape[0] if self.A.size else 0

    def transfer(self, omega: ArrayLike) -> np.ndarray:
        """D + C (i omega - A)^-1 B at circular frequencies [rad/s], complex (n_omega, n, m)."""
        omega = np.atleast_1d(np.asarray(omega, dtype=float))
        if not self.states:
            return np.broadcast_to(self.D.astype(complex), (omega.size, *self.D.shape))
        if self._basis is None:
            return transfer_matrix(1j * omega, self.A, self.B, self.C, self.D)
        roots, right, left = self._basis
        shares = 1 / (1j * omega[:, None] - roots)
        by_root = (self.C @ right) * shares[:, None, :]  # (q, n, k), and all frequencies in one product
        return (by_root.reshape(-1, roots.size) @ (left @ self.B)).reshape(omega.size, *self.D.shape) + self.D

    @cached_property
    def _basis(self) -> tuple[np.ndarray, np.ndarray, np.ndarray] | None:
        return eigenvectors(self.A)


def transfer_matrix(s: ArrayLike, A: np.ndarray, B: np.ndarray, C: np.ndarray, D: np.ndarray) -> np.ndarray:
    """D + C (s - A)^-1 B at complex s (q,), of samples at z: complex (q, n, m)."""
    s, one = np.atleast_1d(np.asarray(s, dtype=complex)), np.eye(len(A))
    found = [D + C @ np.linalg.solve(value * one - A, B) for value in s]  # one by one: all at once is q large matrices
    return np.array(found, dtype=complex).reshape(s.size, *D.shape)


@dataclass(slots=True)
class LinearOperator:
    """What the frequency domain is told.

    inputs: (m,); correction: (n, 3), zeros that are added to the outputs, and their first and second derivative, which
    equations hold where they have been differentiated.
    """

    inputs: ca.SX
    correction: ca.SX
    transfer: Transfer
    realization: StateSpace
    source: str


def linear_operator(y: Any, u: Any, transfer: Transfer, realization: StateSpace, x: Any, *, scale: Any = 1.0,
                    name: str = "operator") -> list[Any]:  # fmt: skip
    """Y = scale H u, with H known over frequency and realised by a state space. Inside equations() only.

    y (n,), u (m,): expressions. x (k,): the variables that are the states of the realization; none where k is zero.
    transfer(omega [rad/s], (q,)) gives H, complex (q, n, m), for exp(+i omega t); it is asked when a linear model
    answers at frequencies, must not hold components of the model, and gives H of the realization itself where it knows
    no better. In time, y = scale (C x + D u) and x' = A x + B u. name: of this operator, where a part has several.
    """
    y, u, x = (ca.densify(ca.vec(ca.SX(value))) for value in (y, u, x))
    n, m, k = y.numel(), u.numel(), realization.states
    if realization.D.shape != (n, m) or x.numel() != k:
        raise StructureError(
            f"a linear operator from {m} inputs to {n} outputs with {x.numel()} states does not fit a realization of "
            f"the shape {realization.D.shape[0]} x {realization.D.shape[1]} with {k} states."
        )
    source = source_line()
    doc = "added by the frequency domain to a linear operator, and derivatives; zero in time"
    correction = ca.reshape(at_start(name, 3 * n, "", doc, _Zeros(3 * n)), n, 3)
    input_rate(correction[:, :2], correction[:, 1:])
    realized = ca.mtimes(_exact(realization.D), u) + correction[:, 0]
    statements: list[Any] = [LinearOperator(u, correction, transfer, realization, source)]
    if k:
        realized += ca.mtimes(_exact(realization.C), x)
        rate = ca.mtimes(_exact(realization.A), x) + ca.mtimes(_exact(realization.B), u)
        statements.append(Equation(der(x), rate, source))
    return [Equation(y, scale * realized, source), *statements]


class _Zeros:
    """So many zeros when a run starts."""

    def __init__(self, size: int):
        self.size = size

    def __call__(self, component: Any) -> np.ndarray:
        return np.zeros(self.size)


def _exact(matrix: np.ndarray) -> ca.SX:
    """The matrix without its zeros, which would stay in the equations."""
    return ca.SX(ca.sparsify(ca.DM(matrix)))
