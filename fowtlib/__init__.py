"""fowtlib: acausal models of floating wind turbines, from components to results."""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

from fowtlib.language import Assembly, Component, ModelError

if TYPE_CHECKING:
    from fowtlib.fmi import export_fmu
    from fowtlib.modelfile import load
    from fowtlib.solving import LinearModel, Mode, Model, Output, Plant, Result, State
    from fowtlib.view import view

# imported when first used, so that `import fowtlib` stays fast
_LATER = {
    "export_fmu": "fowtlib.fmi",
    "load": "fowtlib.modelfile",
    "view": "fowtlib.view",
    **dict.fromkeys(("LinearModel", "Mode", "Model", "Output", "Plant", "Result", "State"), "fowtlib.solving"),
}


def __getattr__(name: str) -> Any:
    if name in _LATER:
        return getattr(importlib.import_module(_LATER[name]), name)
    raise AttributeError(f"module 'fowtlib' has no attribute '{name}'")


__all__ = [
    "Assembly",
    "Component",
    "LinearModel",
    "Mode",
    "Model",
    "ModelError",
    "Output",
    "Plant",
    "Result",
    "State",
    "export_fmu",
    "load",
    "view",
]
