"""Floor 3: from a flat DAE to numbers."""

from __future__ import annotations

import importlib as _importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from fowtlib.solving.conditions import Conditions
    from fowtlib.solving.linear import LinearModel, Mode
    from fowtlib.solving.mean_linear import mean_linear_model
    from fowtlib.solving.model import Model, Output
    from fowtlib.solving.modes import NaturalMode, natural_modes
    from fowtlib.solving.plant import Plant
    from fowtlib.solving.results import Result
    from fowtlib.solving.state import State
    from fowtlib.solving.tangents import Sensitivities, sensitivities
    from fowtlib.solving.timeline import Event
    from fowtlib.solving.turning import mean_state

# imported when first used: a run needs no modes, and nobody should wait for them
_LATER = {
    "Conditions": "conditions",
    "LinearModel": "linear", "Mode": "linear",
    "mean_linear_model": "mean_linear",
    "Model": "model", "Output": "model",
    "NaturalMode": "modes", "natural_modes": "modes",
    "Plant": "plant",
    "Result": "results",
    "State": "state",
    "Sensitivities": "tangents", "sensitivities": "tangents",
    "Event": "timeline",
    "mean_state": "turning",
}  # fmt: skip


def __getattr__(name: str) -> Any:
    if name not in _LATER:
        raise AttributeError(f"module 'fowtlib.solving' has no attribute '{name}'")
    found = globals()[name] = getattr(_importlib.import_module(f"fowtlib.solving.{_LATER[name]}"), name)
    return found


def __dir__() -> list[str]:
    return sorted(__all__)


__all__ = [
    "Conditions",
    "Event",
    "LinearModel",
    "Mode",
    "Model",
    "NaturalMode",
    "Output",
    "Plant",
    "Result",
    "Sensitivities",
    "State",
    "mean_linear_model",
    "mean_state",
    "natural_modes",
    "sensitivities",
]
