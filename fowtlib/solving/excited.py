"""The linear model about a mean, from the signals that drive it at random, with quadratic laws as linear ones.

Signals are what the parts take from waves and wind (`run_time_series`); they are inputs here, and each part says how
its own follow from the process. A quadratic law |u| u (drag) has hardly a slope at a mean of zero. Its best linear law
for a random u is G u, with a matrix G of the covariance of u (language.quadratic_laws); `with_gains` puts such matrices
in.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import casadi as ca
import numpy as np

from fowtlib.language.run_time import RandomSignals
from fowtlib.solving.binding import Binding
from fowtlib.solving.linear import LinearModel
from fowtlib.solving.mean_linear import mean_linear_model
from fowtlib.solving.state import State


@dataclass(frozen=True, eq=False)
class Signal:
    """Signals that follow a random process: their path, their columns of the inputs, and who knows the process."""

    path: str
    owner: str
    columns: slice
    compute: RandomSignals

    def process(self, binding: Binding) -> Any:
        """The component of a run that they follow."""
        return self.compute.process(self._component(binding))

    def response(self, binding: Binding, omega: np.ndarray) -> np.ndarray:
        """Signals per channel of the process, complex (q, signals, channels)."""
        return np.asarray(self.compute.response(self._component(binding), omega))

    def _component(self, binding: Binding) -> Any:
        assert binding.root is not None
        return binding.root.find(self.owner)


@dataclass(frozen=True, eq=False)
class ExcitedModel:
    """Linear model whose inputs are signals, and then what is added to quadratic laws; see the module.

    linear: its outputs are the results, and then the inputs of the laws. laws: paths of the laws, and their columns
    among what is added.
    """

    linear: LinearModel
    signals: tuple[Signal, ...]
    laws: tuple[tuple[str, slice], ...]
    results: int

    @property
    def driven(self) -> int:
        """Number of the signals, one by one."""
        return sum(item.columns.stop - item.columns.start for item in self.signals)

    def with_gains(self, gains: Sequence[np.ndarray]) -> LinearModel:
        """The linear model from the signals to the results and the inputs of the laws, whose outputs are gain @ u."""
        n, m = self.driven, self.results
        linear = self.linear
        A, B, C, D = (linear.matrices[name] for name in "ABCD")
        G = np.zeros((B.shape[1] - n, B.shape[1] - n))
        for (_, place), gain in zip(self.laws, gains, strict=True):
            G[place, place] = gain
        loop = np.linalg.solve(np.eye(len(G)) - G @ D[m:, n:], G)  # from u without the laws to what they add
        A, B = A + B[:, n:] @ loop @ C[m:], B[:, :n] + B[:, n:] @ loop @ D[m:, :n]
        C, D = C + D[:, n:] @ loop @ C[m:], D[:, :n] + D[:, n:] @ loop @ D[m:, :n]
        operators = linear.operators
        if operators is not None:
            operators = operators.fed_back(loop, n, m, linear.matrices)
        return LinearModel(A, B, C, D, linear.states, linear.inputs[:n], linear.outputs, linear.units, operators)


def excited_model(plant: Any, state: State, names: Sequence[str]) -> ExcitedModel:
    """The linear model of a plant at a mean state, from all signals that say how they follow from a random process.

    names: results and variables.
    """
    dae = plant.dae
    bound = {item.symbol[0].element_hash(): item for item in dae.bound.values() if item.functions}
    inputs: dict[str, ca.SX] = {}
    signals = []
    for external in dae.externals:
        item = bound.get(ca.vec(external.inputs)[0].element_hash())
        if item is None or not hasattr(item.compute, "response"):
            continue
        elements = dae.w[external.outputs].elements()
        place = slice(len(inputs), len(inputs) + len(elements))
        inputs |= {f"{item.path} [{k}]": element for k, element in enumerate(elements)}
        signals.append(Signal(item.path, item.owner, place, item.compute))
    laws, outputs, first = [], {}, 0
    for number, law in enumerate(dae.quadratics):
        n = law.added.numel()
        inputs |= {f"law {number} added [{k}]": symbol for k, symbol in enumerate(law.added.elements())}
        outputs |= {f"law {number} of [{k}]": element for k, element in enumerate(law.inputs.elements())}
        laws.append((law.path, slice(first, first + n)))
        first += n
    linear = mean_linear_model(plant, state, (), names, (inputs, outputs))
    return ExcitedModel(linear, tuple(signals), tuple(laws), len(linear.outputs) - first)
