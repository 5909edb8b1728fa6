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
from scipy.linalg import block_diag

from fowtlib.flattening import FlatDAE
from fowtlib.language.component import Component
from fowtlib.language.run_time import RandomSignals
from fowtlib.solving.linear import Further, LinearModel
from fowtlib.solving.mean_linear import mean_linear_model
from fowtlib.solving.random_fields import FieldPlaces, blows, field_places
from fowtlib.solving.state import State
from fowtlib.solving.turning import turns_of


@dataclass(frozen=True, eq=False)
class Signal:
    """Signals that follow a random process: their path, their columns of the inputs, who knows the process.

    outputs: their places among the outputs of all externals.
    """

    path: str
    owner: str
    columns: slice
    outputs: slice
    compute: RandomSignals

    def elements(self, dae: FlatDAE) -> list[ca.SX]:
        """Their symbols."""
        return dae.w[self.outputs].elements()

    def process(self, root: Component) -> Any:
        """The component of a run that they follow."""
        return self.compute.process(self._component(root))

    def response(self, root: Component, omega: np.ndarray) -> np.ndarray:
        """Signals per channel of the process, complex (q, signals, channels)."""
        return np.asarray(self.compute.response(self._component(root), omega))

    def _component(self, root: Component) -> Any:
        return root.find(self.owner)


@dataclass(frozen=True, eq=False)
class ExcitedModel:
    """Linear model whose inputs are signals, channels of fields, and then what is added to quadratic laws; see above.

    linear: its outputs are the results, and then the inputs of the laws. fields: columns of the inputs, and the places
    of one field. laws: paths of the laws, and their columns among what is added. further: what of the flat model these
    inputs and outputs are.
    """

    linear: LinearModel
    signals: tuple[Signal, ...]
    fields: tuple[tuple[slice, tuple[FieldPlaces, ...]], ...]
    laws: tuple[tuple[str, slice], ...]
    results: int
    further: Further

    @property
    def driven(self) -> int:
        """Number of the signals and channels, one by one."""
        return len(self.linear.inputs) - sum(place.stop - place.start for _, place in self.laws)

    def with_gains(self, gains: Sequence[np.ndarray]) -> LinearModel:
        """The linear model from what drives it to the results and the inputs u of the laws, which give gain @ u."""
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


def excited_model(plant: Any, state: State, names: Sequence[str], root: Component) -> ExcitedModel:
    """The linear model of a plant at a mean state, from all that follows from the random processes of a run.

    names: results and variables. root: component tree of the run, whose mean the state is.
    """
    dae, at = plant.dae, plant.at(state.parameters)
    signals = _signals(dae)
    places = [item for item in field_places(plant, at, state, turns_of(plant, at, state)) if blows([item], root)]
    symbols = {f"{item.path} [{k}]": element for item in signals for k, element in enumerate(item.elements(dae))}
    labels = list(symbols)
    fields, raw, start = [], len(symbols), len(symbols)
    for owner in dict.fromkeys(item.owner for item in places):
        members = tuple(item for item in places if item.owner == owner)
        fields.append((slice(start, start := start + sum(item.places.channels for item in members)), members))
        for item in members:
            velocities = dae.w[dae.externals[item.external].outputs].elements()
            symbols |= {f"{item.path} {item.external} velocity [{k}]": v for k, v in enumerate(velocities)}
            labels += item.labels
    laws, outputs, first = [], {}, 0
    for number, law in enumerate(dae.quadratics):
        n = law.added.numel()
        symbols |= (added := {f"law {number} added [{k}]": symbol for k, symbol in enumerate(law.added.elements())})
        labels += added
        outputs |= {f"law {number} of [{k}]": element for k, element in enumerate(law.inputs.elements())}
        laws.append((law.path, slice(first, first + n)))
        first += n

    def mixing(*point: Any) -> np.ndarray:
        blocks = [item.mixing(at, *point) for _, members in fields for item in members]
        return block_diag(np.eye(raw), *blocks, np.eye(first))

    further = Further(symbols, outputs, tuple(labels), mixing if fields else None)
    linear = mean_linear_model(plant, state, (), names, further)
    return ExcitedModel(linear, tuple(signals), tuple(fields), tuple(laws), len(linear.outputs) - first,
                        further)  # fmt: skip


def _signals(dae: FlatDAE) -> list[Signal]:
    """All signals of a model that say how they follow from a random process."""
    found, first = [], 0
    for number, item in dae.with_data:
        if hasattr(item.compute, "response"):
            outputs = dae.externals[number].outputs
            last = first + outputs.stop - outputs.start
            found.append(Signal(item.path, item.owner, slice(first, last), outputs, item.compute))
            first = last
    return found
