"""From a YAML model file to a tree of components, with the line number in every error; and back."""

from __future__ import annotations

import importlib as _importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from fowtlib.modelfile.files import data_path, shipped_models
    from fowtlib.modelfile.loading import load, models
    from fowtlib.modelfile.writing import dump

# imported when first used: the command line takes the short forms alone, and `fowt --help` must not wait for the rest
_LATER = {
    **dict.fromkeys(("data_path", "shipped_models"), "files"),
    **dict.fromkeys(("load", "models"), "loading"),
    "dump": "writing",
}

__all__ = ["data_path", "dump", "load", "models", "shipped_models"]


def __getattr__(name: str) -> Any:
    if name in _LATER:
        return getattr(_importlib.import_module(f"fowtlib.modelfile.{_LATER[name]}"), name)
    raise AttributeError(f"module 'fowtlib.modelfile' has no attribute '{name}'")


def __dir__() -> list[str]:
    return sorted(__all__)
