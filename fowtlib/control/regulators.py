"""Linear-quadratic regulators, with and without integral action, for continuous and sampled models.

Minimised is the integral (sum, of samples) of x' Q x + u' R u under x' = A x + B u; then u = -K x with
K = R^-1 B' P, and P solves the algebraic Riccati equation (A. E. Bryson and Y.-C. Ho, Applied Optimal Control, 1975).
The integrals of errors e' = -y join the states. They feed nothing back, so that their block of the Riccati equation is
K_e' R K_e = Q_e, exactly: with one error an input, |K_e| = sqrt(Q_e / R).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np
from scipy import linalg

from fowtlib.control.checks import Eigenvalues, Matrix, Weights, numbers_of, weight_matrix
from fowtlib.control.reduction import SampledModel, like
from fowtlib.language.errors import ModelError
from fowtlib.solving.linear import LinearModel

if TYPE_CHECKING:
    from fowtlib.solving.labelled import LabelledMatrix

UNREACHED = 1e-9  # relative: a direction of the state that no input reaches, or no weight sees


class DesignError(ModelError):
    """There is no regulator or estimator for what was asked: a mode that nothing reaches, or that nothing sees."""


@dataclass(frozen=True, eq=False)
class Regulator:
    """u = -K (x, e): the gain (inputs, states and integrals) of a model, whose states x come first.

    model: with the integrals of the errors as further states, named after the outputs, "integral of ...". cost: P, with
    which x' P x is the cost from x on.
    """

    model: LinearModel
    gain: Matrix
    cost: Matrix = field(repr=False)
    integrals: tuple[str, ...] = ()

    @property
    def K(self) -> LabelledMatrix:
        """The gain with its names."""
        from fowtlib.solving.labelled import labelled

        return labelled("K", self.gain, ("input", self.model.inputs), ("state", self.model.states))

    @property
    def state_gain(self) -> Matrix:
        """Of the states alone (inputs, states)."""
        return self.gain[:, : self.gain.shape[1] - len(self.integrals)]

    @property
    def integral_gain(self) -> Matrix:
        """Of the integrals of the errors (inputs, integrals)."""
        return self.gain[:, self.gain.shape[1] - len(self.integrals) :]

    @property
    def closed_loop(self) -> LinearModel:
        """The model under its regulator; its inputs are added to those of the regulator."""
        A, B, C, D = (self.model.matrices[name] for name in "ABCD")
        return like(self.model, A - B @ self.gain, B, C - D @ self.gain, D, self.model.states, self.model.inputs,
                    self.model.outputs, self.model.units)  # fmt: skip

    @property
    def poles(self) -> Eigenvalues:
        """Eigenvalues of the closed loop: [1/s], of a sampled model z; slowest first."""
        return poles_of(self.closed_loop)

    @property
    def loop(self) -> LinearModel:
        """K (s - A)^-1 B, the loop cut at the inputs, for negative feedback; see `margins`."""
        A, B = self.model.matrices["A"], self.model.matrices["B"]
        names = self.model.inputs
        none = np.zeros((len(names), len(names)))
        return like(self.model, A, B, self.gain, none, self.model.states, names, names, {})


def poles_of(model: LinearModel) -> Eigenvalues:
    """Eigenvalues of A, slowest first: by distance from 0, of a sampled model from 1."""
    values = np.linalg.eigvals(model.matrices["A"])
    distance = np.abs(values - 1.0) if isinstance(model, SampledModel) else np.abs(values)
    return values[np.lexsort((values.imag, np.round(distance, 12)))]


def lqr(model: LinearModel, states: Weights, inputs: Weights, *, used: Sequence[str] | None = None) -> Regulator:
    """The linear-quadratic regulator with weights Q of the states and R of the inputs.

    used: the inputs that the regulator has; the others are disturbances. Without it all that `inputs` names, or all.
    Raises DesignError naming the mode that cannot be stabilised, or that no weight sees; ParameterError for weights of
    the wrong sign or shape; NotFoundError for a name the model has not.
    """
    return _regulator(_with_inputs(model, inputs, used), states, inputs, {})


def lqi(model: LinearModel, states: Weights, inputs: Weights, integrals: Mapping[str, float], *,
        used: Sequence[str] | None = None) -> Regulator:  # fmt: skip
    """The same with the integrals of the errors of outputs, e' = -y, and their weights; so they have no steady error.

    Outputs, and so their integrals, count in the units that the model gives them in. Raises as `lqr` does; DesignError
    also where the inputs cannot hold all these outputs.
    """
    return _regulator(_with_inputs(model, inputs, used), states, inputs, integrals)


def _with_inputs(model: LinearModel, weights: Weights, used: Sequence[str] | None) -> LinearModel:
    names = list(used or (weights if isinstance(weights, Mapping) else model.inputs))
    columns = numbers_of(names, model.inputs, "input")
    A, B, C, D = (model.matrices[name] for name in "ABCD")
    return like(model, A, B[:, columns], C, D[:, columns], model.states, names, model.outputs, model.units)


def with_integrals(model: LinearModel, outputs: Sequence[str]) -> LinearModel:
    """The model with the integrals of the errors e' = -y of outputs as further states, and as further outputs."""
    A, B, C, D = (model.matrices[name] for name in "ABCD")
    rows, n, p = numbers_of(outputs, model.outputs, "output"), len(A), len(outputs)
    step, stay = step_of(model, p)
    top = np.hstack([A, np.zeros((n, p))])
    names = [f"integral of {name}" for name in outputs]
    return like(
        model, np.vstack([top, np.hstack([-step * C[rows], stay])]), np.vstack([B, -step * D[rows]]),
        np.vstack([np.hstack([C, np.zeros((len(C), p))]), np.hstack([np.zeros((p, n)), np.eye(p)])]),
        np.vstack([D, np.zeros((p, D.shape[1]))]), [*model.states, *names], model.inputs, [*model.outputs, *names],
        model.units,
    )  # fmt: skip


def step_of(model: LinearModel, integrals: int) -> tuple[float, Matrix]:
    """Factor of what is integrated, and what an integral keeps: in the rate, or from sample to sample."""
    if isinstance(model, SampledModel):
        return model.period, np.eye(integrals)
    return 1.0, np.zeros((integrals, integrals))


def _regulator(model: LinearModel, states: Weights, inputs: Weights, integrals: Mapping[str, float]) -> Regulator:
    R = weight_matrix(inputs, model.inputs, "input", definite=True)
    Q = weight_matrix(states, model.states, "state", definite=False)
    if integrals:
        model = with_integrals(model, list(integrals))
        added = weight_matrix(list(integrals.values()), list(integrals), "integral", definite=False)
        Q = linalg.block_diag(Q, added)
    A, B = model.matrices["A"], model.matrices["B"]
    refuse_unreached(A, B, model, "cannot be stabilised: no input reaches it")
    refuse_unseen(A, Q, model)
    P = riccati(A, B, Q, R, isinstance(model, SampledModel))
    if isinstance(model, SampledModel):
        gain = np.linalg.solve(R + B.T @ P @ B, B.T @ P @ A)
    else:
        gain = np.linalg.solve(R, B.T @ P)
    return Regulator(model, gain, P, tuple(integrals))


def riccati(A: Matrix, B: Matrix, Q: Matrix, R: Matrix, sampled: bool) -> Matrix:
    """The stabilising solution P."""
    solve = linalg.solve_discrete_are if sampled else linalg.solve_continuous_are
    try:
        return solve(A, B, Q, R)
    except (np.linalg.LinAlgError, ValueError) as error:
        raise DesignError(f"the Riccati equation has no stabilising solution ({error}); change the weights.") from None


def refuse_unreached(A: Matrix, B: Matrix, model: LinearModel, what: str) -> None:
    """Raise DesignError where B misses a mode of A that does not decay by itself, naming the state it moves most.

    Popov, Belevitch and Hautus: [A - lambda, B] loses rank; in scaled coordinates.
    """
    sampled = isinstance(model, SampledModel)
    balanced, (scale, _) = linalg.matrix_balance(A, permute=False, separate=True)
    reach = B / scale[:, None]
    size = max(np.linalg.norm(balanced), 1e-300)
    reach = reach * (size / max(np.linalg.norm(reach), 1e-300))
    for value in np.linalg.eigvals(balanced):
        decays = abs(value) < 1 - 1e-10 if sampled else value.real < -1e-10 * size
        if decays:
            continue
        left, sizes, _ = np.linalg.svd(np.hstack([balanced - value * np.eye(len(A)), reach]))
        if sizes[-1] < UNREACHED * size:
            name = model.states[int(np.argmax(np.abs(left[:, -1])))]
            where = f"real part {value.real:.3g} 1/s, {abs(value.imag):.3g} rad/s"
            where = f"|z| = {abs(value):.6g}" if sampled else where
            raise DesignError(f"the mode of '{name}' ({where}) {what}.")


def refuse_unseen(A: Matrix, Q: Matrix, model: LinearModel) -> None:
    """Raise DesignError where a mode that does not decay has no weight: what it does would cost nothing."""
    refuse_unreached(A.T, Q, model, "does not decay by itself, and no weight sees it: give its state one")
