"""What an optimiser is told, and what it tells at its end."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np


@dataclass(frozen=True)
class Settings:
    """tolerance: of optimality and of constraints, of the scaled problem; iterations: at most.

    options: further ones, handed to the optimiser as they are.
    """

    tolerance: float = 1e-6
    iterations: int = 200
    options: Mapping[str, Any] = field(default_factory=dict)


@dataclass(frozen=True)
class Ended:
    """Where an optimiser has ended: y, whether it says that this is an optimum, and its reason in words."""

    y: np.ndarray
    converged: bool
    reason: str
