"""fowtlib: acausal models of floating wind turbines, from components to results."""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

from fowtlib.language import Assembly, Component, ModelError
from fowtlib.language.upstairs import hand_in

if TYPE_CHECKING:
    from fowtlib.modelfile import load
    from fowtlib.solving import Conditions, LinearModel, Mode, Model, Output, Plant, Result, State

# imported when first used, so that `import fowtlib` stays fast
_LATER = {
    "load": "fowtlib.modelfile",
    **dict.fromkeys(
        ("Conditions", "LinearModel", "Mode", "Model", "Output", "Plant", "Result", "State"), "fowtlib.solving"
    ),
}


def __getattr__(name: str) -> Any:
    if name in _LATER:
        return getattr(importlib.import_module(_LATER[name]), name)
    raise AttributeError(f"module 'fowtlib' has no attribute '{name}'")


def _view(*arguments: Any, **options: Any) -> Any:
    return importlib.import_module("fowtlib.view").view(*arguments, **options)


def _export_fmu(*arguments: Any, **options: Any) -> Any:
    return importlib.import_module("fowtlib.fmi").export_fmu(*arguments, **options)


hand_in("view", _view)
hand_in("export_fmu", _export_fmu)

__all__ = [
    "Assembly",
    "Component",
    "Conditions",
    "LinearModel",
    "Mode",
    "Model",
    "ModelError",
    "Output",
    "Plant",
    "Result",
    "State",
    "load",
]
