"""The Kalman estimator, and the controller that a regulator and an estimator make together."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from fowtlib.control.checks import Eigenvalues, Matrix, numbers_of, weight_matrix
from fowtlib.control.reduction import SampledModel, like
from fowtlib.control.regulators import Regulator, poles_of, refuse_unreached, riccati, step_of
from fowtlib.language.errors import ParameterError
from fowtlib.solving.linear import LinearModel


@dataclass(frozen=True, eq=False)
class Estimator:
    """x^' = A x^ + B u + L (y - C x^ - D u), of the states of a model from its known inputs and measured outputs.

    model: with the known inputs and the measured outputs alone. gain: L (states, outputs); of a sampled model that of
    the prediction, A x^ + B u + L (...). covariance: of the error of the states.
    """

    model: LinearModel
    gain: Matrix
    covariance: Matrix = field(repr=False)

    @property
    def filter(self) -> LinearModel:
        """From the known inputs and the outputs to the states."""
        A, B, C, D = (self.model.matrices[name] for name in "ABCD")
        n, inputs = len(A), [*self.model.inputs, *self.model.outputs]
        return like(self.model, A - self.gain @ C, np.hstack([B - self.gain @ D, self.gain]), np.eye(n),
                    np.zeros((n, len(inputs))), self.model.states, inputs, self.model.states, {})  # fmt: skip

    @property
    def poles(self) -> Eigenvalues:
        """Eigenvalues of the error: [1/s], of a sampled model z; slowest first."""
        return poles_of(self.filter)


def kalman(model: LinearModel, process: Mapping[str, float], measured: Mapping[str, float]) -> Estimator:
    """The stationary Kalman estimator of the states of a model (R. E. Kalman and R. S. Bucy, 1961).

    process: two-sided spectral densities of white noise, by inputs (the disturbances: what the estimator does not know)
    or states (added to their rates); of a sampled model variances. measured: the same of the noise of each output that
    is measured. Raises DesignError for a mode that does not decay and shows in no output, ParameterError for noise that
    is not positive, NotFoundError for a name that the model has not.
    """
    known = [*model.inputs, *(name for name in model.states if name not in model.inputs)]
    numbers_of(list(process), known, "input or state")
    noisy = [name for name in process if name in model.inputs]
    A, B, C, D = (model.matrices[name] for name in "ABCD")
    columns = [B[:, model.inputs.index(name)] if name in noisy else np.eye(len(A))[:, model.states.index(name)]
               for name in process]  # fmt: skip
    W = weight_matrix(process, list(process), "process noise", definite=False)
    rows = numbers_of(list(measured), model.outputs, "output")
    if not rows:
        raise ParameterError("nothing is measured; name the outputs that are, with the density of their noise.")
    V = weight_matrix(dict(measured), list(measured), "measured output", definite=True)
    G = np.column_stack(columns) if columns else np.zeros((len(A), 0))
    Q = G @ W @ G.T
    used = [k for k, name in enumerate(model.inputs) if name not in noisy]
    names = list(measured)
    units = {name: model.units.get(name, "1") for name in names}
    own = like(model, A, B[:, used], C[rows], D[np.ix_(rows, used)], model.states, [model.inputs[k] for k in used],
               names, units)  # fmt: skip
    refuse_unreached(A.T, C[rows].T, own, "does not decay by itself and shows in no measured output")
    refuse_unreached(A, Q, own, "neither decays by itself nor is moved by the process noise: give it some")
    sampled = isinstance(model, SampledModel)
    P = riccati(A.T, C[rows].T, Q, V, sampled)
    H = C[rows]
    gain = A @ P @ H.T @ np.linalg.inv(V + H @ P @ H.T) if sampled else P @ H.T @ np.linalg.inv(V)
    return Estimator(own, gain, P)


def compensator(regulator: Regulator, estimator: Estimator) -> LinearModel:
    """The controller u = -K (x^, e) with estimated states: from the measured outputs to the inputs.

    The errors that the regulator integrates must be measured. Close it with positive sign: u = compensator y.
    """
    A, B, C, D = (estimator.model.matrices[name] for name in "ABCD")
    if regulator.model.inputs != estimator.model.inputs:
        raise ParameterError(
            f"the regulator moves {_listed(regulator.model.inputs)} and the estimator knows "
            f"{_listed(estimator.model.inputs)}; both must have the same inputs."
        )
    n, p = len(A), len(regulator.integrals)
    if regulator.model.states[:n] != estimator.model.states:
        raise ParameterError("the regulator and the estimator have different states; design both for one model.")
    rows = numbers_of(regulator.integrals, estimator.model.outputs, "measured output")
    L, K, Ke = estimator.gain, regulator.state_gain, regulator.integral_gain
    step, stay = step_of(estimator.model, p)
    into = B - L @ D
    top = np.hstack([A - L @ C - into @ K, -into @ Ke])
    below = np.hstack([np.zeros((p, n)), stay])
    pick = np.zeros((p, len(C)))
    pick[range(p), rows] = -step
    names = [*(f"estimate of {name}" for name in estimator.model.states), *regulator.model.states[n:]]
    return like(estimator.model, np.vstack([top, below]), np.vstack([L, pick]), -np.hstack([K, Ke]),
                np.zeros((len(K), len(C))), names, estimator.model.outputs, regulator.model.inputs, {})  # fmt: skip


def _listed(names: Sequence[str]) -> str:
    return ", ".join(f"'{name}'" for name in names) or "nothing"
