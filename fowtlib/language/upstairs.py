"""What a floor above hands in, so that a method of a lower floor can offer it without importing upwards.

`Model.view`, `Result.view` and `Plant.export_fmu` belong to the objects that users hold, and pictures and FMUs are made
on a floor above. The package fowtlib, which imports before any of its parts, hands the functions in.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

_functions: dict[str, Callable[..., Any]] = {}


def hand_in(name: str, function: Callable[..., Any]) -> None:
    """Give the function that methods below call by this name."""
    _functions[name] = function


def handed_in(name: str) -> Callable[..., Any]:
    """The function of this name."""
    return _functions[name]
