"""Whether the equations of a model hold at a state: the conditions that its parts state for them."""

from __future__ import annotations

import warnings

import casadi as ca
import numpy as np

from fowtlib.language.errors import SimulationError
from fowtlib.solving.evaluation import Evaluation
from fowtlib.solving.state import State


def check_state(evaluation: Evaluation, state: State, model: str, *, warn: bool = True) -> None:
    """SimulationError where a condition of level "error" is broken; with `warn`, a warning for each of that level.

    A run checks its output points by itself; a state that no run has passed through is checked here.
    """
    checks, q = evaluation.dae.checks, np.concatenate([state.u, state.d])
    if not checks:
        return

    def numbers(expressions: list[ca.SX]) -> np.ndarray:
        function = evaluation.function("checks", [ca.vertcat(*expressions)])
        return np.array(function(state.t, state.x, state.z, q)).ravel()

    broken = [checks[i] for i in np.flatnonzero(numbers([check.condition for check in checks]) == 0)]
    for check in sorted(broken, key=lambda check: check.level):  # errors first
        text = check.message.rstrip(".")
        for name, value in zip(check.values, numbers(list(check.values.values())) if check.values else (), strict=True):
            text = text.replace("{" + name + "}", f"{value:.6g}")
        text = f"{check.path or model or 'model'}: {text}."
        if check.level == "error":
            raise SimulationError(text)
        if warn:
            warnings.warn(text, stacklevel=4)
