"""What the run of a simulation needs of an engine, and the settings that a user leaves out."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, Protocol

import numpy as np

from fowtlib.solving.functions import AtParameters

SOLVERS = ("idas", "fixed")
STEP, RHO_INF = 0.0125, 0.8


class Engine(Protocol):
    """What the run of a simulation needs of an engine; StepFailure where it cannot go on."""

    at: AtParameters
    """The functions of the model at the parameters of the run."""

    seen: np.ndarray
    """What the engine also knows at the points of the last `advance`: rows as of FixedStepCode.observe, or none."""

    advice: str
    """What to try where it fails; the end of a sentence."""

    @property
    def attributes(self) -> dict[str, float | str]:
        """What a result says about its solver."""

    def advance(
        self, t: float, length: float, points: int, x: np.ndarray, z: np.ndarray, q: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """States and algebraic unknowns (rows) at `points` equidistant times after t."""

    def stop(self, now: bool) -> None:
        """Let `advance`, which runs in another thread, return early, with fewer rows, or fail; False: no more."""

    def remarks(self) -> list[str]:
        """Sentences on what a user should know of the run so far, each a warning at its end."""

    def memory(self) -> tuple[dict[str, Any], dict[str, np.ndarray]]:
        """All that the next `advance` depends on besides its arguments: a text that JSON can hold, and numbers."""

    def remember(self, text: Mapping[str, Any], numbers: Mapping[str, np.ndarray]) -> None:
        """Take what `memory` of an engine with the same model and settings gave; ValueError where it does not fit."""

    def algebraics(self, t: float, x: np.ndarray, z: np.ndarray, q: np.ndarray) -> np.ndarray:
        """Algebraic unknowns that satisfy the equations at the states, after a jump."""

    def updater(self, sample: int) -> Callable[..., np.ndarray]:
        """What a sampled part computes (see SampledUpdate.values), as a function of t, x, z, q."""
