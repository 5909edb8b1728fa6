"""How far a search goes towards what it finds, where whole steps go to and fro and what is found is rough.

H. Kesten, Accelerated stochastic approximation, Annals of Mathematical Statistics 29 (1958) 41: steps get shorter each
time they turn back, and only then. What is found near a swing that hardly decays falls steeply with its deviation, so
that whole steps grow, and jumps with the points of the means, so that no slope can be told from two steps.
"""

from __future__ import annotations

import numpy as np

FIRST = 0.5  # share of a step


class Relaxation:
    """The share of each step of a search, by what is left (n,) before it: what is found, less the guess."""

    def __init__(self) -> None:
        self._turns = 0
        self._last: np.ndarray | None = None

    def __call__(self, left: np.ndarray) -> float:
        """The share of the step that `left` is."""
        if self._last is not None and float(self._last @ left) < 0:
            self._turns += 1
        self._last = left
        return FIRST / (1 + self._turns)
