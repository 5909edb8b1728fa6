"""Linear models made smaller, or sampled."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy import signal

from fowtlib.control.checks import Matrix, numbers_of
from fowtlib.language.errors import ParameterError
from fowtlib.language.operators import transfer_matrix
from fowtlib.solving.linear import LinearModel, Mode


class SampledModel(LinearModel):
    """x[k+1] = A x[k] + B u[k], y[k] = C x[k] + D u[k], once every `period` [s]."""

    def __init__(self, A: Matrix, B: Matrix, C: Matrix, D: Matrix, states: Sequence[str], inputs: Sequence[str],
                 outputs: Sequence[str], units: dict[str, str], period: float):  # fmt: skip
        super().__init__(A, B, C, D, states, inputs, outputs, units)
        self.period = period

    def frequency_response(self, omega: Sequence[float], *, realized: bool = False) -> np.ndarray:
        """Outputs per input at circular frequencies [rad/s] up to pi / period: complex (n, outputs, inputs)."""
        z = np.exp(1j * np.asarray(omega, dtype=float) * self.period)
        return transfer_matrix(z, *(self.matrices[name] for name in "ABCD"))

    def modes(self) -> list[Mode]:
        """The modes of the continuous motion that has these samples, s = log(z) / period; those with z = 0 are gone."""
        from scipy.linalg import logm

        values, right = np.linalg.eig(self.matrices["A"])
        kept = np.abs(values) > 1e-300
        if np.all(kept):
            slow = np.real(logm(self.matrices["A"])) / self.period
        else:
            left = np.linalg.pinv(right)
            slow = np.real(right[:, kept] @ np.diag(np.log(values[kept]) / self.period) @ left[kept])
        C = self.matrices["C"]
        return LinearModel(slow, self.matrices["B"], C, self.matrices["D"], self.states, self.inputs, self.outputs,
                           self.units).modes()  # fmt: skip

    def __repr__(self) -> str:
        return super().__repr__().replace("LinearModel", "SampledModel")[:-1] + f", every {self.period:g} s>"


def like(model: LinearModel, A: Matrix, B: Matrix, C: Matrix, D: Matrix, states: Sequence[str], inputs: Sequence[str],
         outputs: Sequence[str], units: dict[str, str]) -> LinearModel:  # fmt: skip
    """A model of the same kind, continuous or sampled, with other matrices."""
    if isinstance(model, SampledModel):
        return SampledModel(A, B, C, D, states, inputs, outputs, units, model.period)
    return LinearModel(A, B, C, D, states, inputs, outputs, units)


def reduced(model: LinearModel, states: Sequence[str], held: Sequence[str] = ()) -> LinearModel:
    """The model with these states alone, in this order.

    The others are residualised: their rates are set to zero, so that they follow at once and the steady gain from any
    input to any output stays what it was. Those `held` stay at the operating point, as if their motion were locked.
    A state that nothing kept depends on is left out without a trace. For a continuous model.
    Raises NotFoundError for a name that the model has not, ParameterError where a state to be residualised has no rest
    of its own, as the angle of a shaft: keep it or hold it.
    """
    if isinstance(model, SampledModel):
        raise ParameterError("a sampled model is not reduced; reduce the continuous one and sample it.")
    A, B, C, D = (model.matrices[name] for name in "ABCD")
    keep, still = numbers_of(states, model.states, "state"), set(numbers_of(held, model.states, "state"))
    if still & set(keep):
        raise ParameterError(f"the state '{model.states[min(still & set(keep))]}' is kept and held; one of the two.")
    rest = _heard(A, C, keep, still)
    k, r = np.array(keep, int), np.array(rest, int)
    Ak, Bk, Ck = A[np.ix_(k, k)], B[k], C[:, k]
    if rest:
        own = A[np.ix_(r, r)]
        _refuse_without_rest(own, [model.states[i] for i in rest])
        follow = -np.linalg.solve(own, np.hstack([A[np.ix_(r, k)], B[r]]))
        by_x, by_u = follow[:, : len(k)], follow[:, len(k) :]
        Ak, Bk = Ak + A[np.ix_(k, r)] @ by_x, Bk + A[np.ix_(k, r)] @ by_u
        Ck, D = Ck + C[:, r] @ by_x, D + C[:, r] @ by_u
    return LinearModel(Ak, Bk, Ck, D.copy(), [model.states[i] for i in keep], model.inputs, model.outputs, model.units)


def opened(model: LinearModel, states: Sequence[str]) -> LinearModel:
    """The model with states taken as inputs, behind its own: the loop through each of them is cut there.

    So a loop is cut at the output of a controller that is a state, without a second model: what the state does to the
    others stays, what drives it is gone. Its value at the operating point is that of the state there.
    """
    if isinstance(model, SampledModel):
        raise ParameterError("a sampled model is not opened at states; open the continuous one and sample it.")
    cut = numbers_of(states, model.states, "state")
    rest = [k for k in range(len(model.states)) if k not in cut]
    A, B, C, D = (model.matrices[name] for name in "ABCD")
    return LinearModel(
        A[np.ix_(rest, rest)], np.hstack([B[rest], A[np.ix_(rest, cut)]]), C[:, rest], np.hstack([D, C[:, cut]]),
        [model.states[k] for k in rest], [*model.inputs, *states], model.outputs, model.units,
    )  # fmt: skip


def _heard(A: Matrix, C: Matrix, keep: Sequence[int], still: set[int]) -> list[int]:
    """Numbers of the other states that the kept ones, or the outputs, depend on, directly or through each other."""
    found: set[int] = set()
    ahead = [*keep]
    fresh = {int(j) for j in np.flatnonzero(np.any(C != 0, axis=0))}
    while ahead or fresh:
        new = {int(j) for i in ahead for j in np.flatnonzero(A[i])} | fresh
        ahead, fresh = [j for j in new if j not in found and j not in keep and j not in still], set()
        found.update(ahead)
    return sorted(found)


def _refuse_without_rest(own: Matrix, names: Sequence[str]) -> None:
    """Raise where the rates of these states do not determine them: one drifts on its own."""
    rows = np.abs(own).sum(axis=1)
    scaled = own / np.where(rows > 0, rows, 1.0)[:, None]
    columns = np.linalg.norm(scaled, axis=0)
    _, sizes, right = np.linalg.svd(scaled / np.where(columns > 0, columns, 1.0))
    if sizes[-1] <= 1e-12 * sizes[0]:
        name = names[int(np.argmax(np.abs(right[-1])))]
        raise ParameterError(f"the state '{name}' has no rest of its own and cannot be residualised; keep or hold it.")


def discretized(model: LinearModel, period: float, method: str = "zoh") -> SampledModel:
    """The model at samples every `period` [s].

    method: "zoh", exact for inputs that are held between samples; "tustin", the bilinear transformation, which keeps
    the frequency response but for a warped frequency, (2 / period) tan(omega period / 2).
    """
    if isinstance(model, SampledModel):
        raise ParameterError(f"the model is sampled already, every {model.period:g} s.")
    if not 0 < period < np.inf:
        raise ParameterError(f"the period of sampling is {period:g} s; it must be positive and finite.")
    if method not in ("zoh", "tustin"):
        raise ParameterError(f"there is no method '{method}' of sampling; there are 'zoh' and 'tustin'.")
    system = tuple(model.matrices[name] for name in "ABCD")
    how = "bilinear" if method == "tustin" else "zoh"
    A, B, C, D, _ = signal.cont2discrete(system, period, method=how)
    return SampledModel(A, B, C, D, model.states, model.inputs, model.outputs, model.units, float(period))
