"""The library of parts, in packages (`fowtlib.components.mooring.CatenaryLine`), each imported when first used."""

from __future__ import annotations

import importlib as _importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from fowtlib.components import (
        aero,
        blocks,
        environment,
        fmu,
        hydro,
        mechanics,
        mooring,
        platform,
        servo,
        support,
        turbine,
    )


def __getattr__(name: str) -> Any:
    if name in __all__:
        return _importlib.import_module(f"fowtlib.components.{name}")
    raise AttributeError(f"module 'fowtlib.components' has no attribute '{name}'; there are {', '.join(__all__)}")


def __dir__() -> list[str]:
    return list(__all__)


__all__ = [
    "aero",
    "blocks",
    "environment",
    "fmu",
    "hydro",
    "mechanics",
    "mooring",
    "platform",
    "servo",
    "support",
    "turbine",
]
