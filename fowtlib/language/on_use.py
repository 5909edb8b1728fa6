"""Modules that take long to import, imported when something of them is first used."""

from __future__ import annotations

from importlib import import_module
from types import ModuleType
from typing import Any


class OnUse(ModuleType):
    """A stand-in for a module; beside it stands the import under TYPE_CHECKING, for readers and type checkers."""

    def __getattr__(self, name: str) -> Any:
        found = getattr(import_module(self.__name__), name)
        setattr(self, name, found)  # this method is asked for what is missing alone
        return found
