"""Whether the equations of a model hold at a state: the conditions that its parts state for them."""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np

from fowtlib.language.errors import SimulationError
from fowtlib.solving.engines.base import Engine
from fowtlib.solving.functions import AtParameters
from fowtlib.solving.state import State

NONE = "So there is no equilibrium: where nothing would change any more the model breaks this condition."


def check_state(at: AtParameters, state: State, model: str, *, warn: bool = True, rest: bool = False) -> None:
    """SimulationError where a condition of level "error" is broken; with `warn`, a warning for each of that level.

    rest: the state is an equilibrium, for which conditions of level "rest" are errors too.
    A run checks its output points by itself; a state that no run has passed through is checked here.
    """
    if not at.dae.checks:
        return
    point = state.t, state.x, state.z, np.concatenate([state.u, state.d])
    numbers = np.flatnonzero(np.array(at.call(at.functions.conditions, *point)).ravel() == 0)
    for i in sorted(numbers.tolist(), key=lambda i: at.dae.checks[i].level):  # errors first
        text, level = broken(at, i, model, *point) + ".", at.dae.checks[i].level
        if level == "error" or (rest and level == "rest"):
            raise SimulationError(f"{text} {NONE}" if rest and level == "error" else text)
        if warn and level == "warning":
            warnings.warn(text, stacklevel=4)


@contextmanager
def search_from(at: AtParameters, state: State, model: str) -> Iterator[None]:
    """What is said of a search that fails also says which conditions of level "error" were broken where it began."""
    try:
        yield
    except SimulationError as error:
        try:
            check_state(at, state, model, warn=False)
        except SimulationError as cause:
            error.message += f" It was sought from a state that breaks a condition: {cause.message}"
        raise


def broken(at: AtParameters, check: int, model: str, t: float, x: np.ndarray, z: np.ndarray, q: np.ndarray) -> str:
    """What is said of a broken condition at a point, without the full stop."""
    item = at.dae.checks[check]
    text = at.binding.words(item.message)
    told = np.array(at.call(at.functions.told(check), t, x, z, q)).ravel() if item.values else ()
    for name, value in zip(item.values, told, strict=True):
        text = text.replace("{" + name + "}", f"{value:.6g}")
    return f"{item.path or model or 'model'}: {text.rstrip('.')}"


def too_coarse(at: AtParameters, check: int, t: float, x: np.ndarray, z: np.ndarray, q: np.ndarray, engine: Engine,
               output_step: float) -> str:  # fmt: skip
    """How far apart the points of a run are, where a condition of level "step" asks for nearer ones; else nothing."""
    names = list(at.dae.checks[check].values)
    asked = float(np.array(at.call(at.functions.told(check), t, x, z, q)).ravel()[names.index("seconds")])
    step = float(engine.attributes.get("step", 0.0))  # one that watches its error has none
    said = [f"{name} {length:g} s" for name, length in (("steps of", step), ("output points every", output_step))
            if length > asked * (1 + 1e-9)]  # fmt: skip
    return f"; this run has {' and '.join(said)}" if said else ""
