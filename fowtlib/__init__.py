"""fowtlib: acausal models of floating wind turbines, from components to results."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from fowtlib.language import Assembly, Component, ModelError
from fowtlib.solving import LinearModel, Model, Output, Plant, Result, State

if TYPE_CHECKING:
    from fowtlib.modelfile import load


def __getattr__(name: str) -> Any:
    if name == "load":  # YAML is read only when a model is loaded
        from fowtlib.modelfile import load

        return load
    raise AttributeError(f"module 'fowtlib' has no attribute '{name}'")


__all__ = ["Assembly", "Component", "LinearModel", "Model", "ModelError", "Output", "Plant", "Result", "State", "load"]
