"""What gives a design the results of its model, and how they change with the variables.

`Evaluator` is what an optimiser sees. `fowtlib.design.differences` has one of central differences; one with exact
slopes by adjoints fits in its place.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np

from fowtlib.solving import State

Key = tuple[str, str]
"""A result in a case: (name of the case, name of the result)."""


@dataclass(frozen=True, eq=False)
class Evaluated:
    """Results at a point x (n,) of the space of a design: columns (m,) by key, and slopes (m, n) where asked for.

    units: of the results, by their names. states: where they were found, by case.
    """

    values: Mapping[Key, np.ndarray]
    units: Mapping[str, str]
    jacobian: Mapping[Key, np.ndarray] | None = None
    states: Mapping[str, State] = field(default_factory=dict)


class Evaluator(Protocol):
    """Results of a model at points of a space. A point without results raises ModelError, with the reason."""

    def evaluate(self, x: np.ndarray, jacobian: bool = False) -> Evaluated:
        """The results at x (n,) in SI, and with `jacobian` their slopes by its elements."""
        ...


class NoModel:
    """The evaluator of a design without a model: all its results are functions of its variables."""

    def evaluate(self, x: np.ndarray, jacobian: bool = False) -> Evaluated:
        return Evaluated({}, {}, {} if jacobian else None)
