"""A point in the state space of a compiled model."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

import numpy as np


@dataclass(frozen=True)
class State:
    """Time t [s], states x, algebraic unknowns z, discrete variables d, inputs u, at given parameter values.

    `state["platform.motion.surge"]` gives any variable of the model, in SI units.
    """

    t: float
    x: np.ndarray
    z: np.ndarray
    d: np.ndarray
    u: np.ndarray
    parameters: Mapping[str, object] = field(default_factory=dict)
    observe: Callable[[str, State], np.ndarray] | None = field(default=None, repr=False, compare=False)

    def __getitem__(self, name: str) -> float | np.ndarray:
        value = np.asarray(self.observe(name, self)).squeeze()
        return float(value) if value.shape == () else value
