"""Code in a model that is not fowtlib's: the modules that a user has written, and what they import of their own."""

from __future__ import annotations

import sys
import types
from typing import Any

from fowtlib.flattening.own_code import Unknown, content_from_before, is_own

_MOST = 30  # modules; a model that leads to more is one of a program, not of a file of parts
_KNOWN = sys.stdlib_module_names | {"numpy", "scipy", "casadi", "networkx"}  # known by their versions


class ForeignCode:
    """The modules that were met, and those that their names lead to."""

    def __init__(self) -> None:
        self._names: set[str] = set()

    def meet(self, name: str | None) -> None:
        """Note the module of a class or a function."""
        if not name:
            raise Unknown("code without a module")
        self._names.add(name)

    def modules(self) -> list[types.ModuleType]:
        """All of them, by name; without fowtlib's and those that are known by their versions. Raises Unknown."""
        found: dict[str, types.ModuleType] = {}
        left = sorted(self._names)
        while left:
            name = left.pop()
            if name in found or _is_known(name):
                continue
            module = sys.modules.get(name)
            if module is None:
                raise Unknown(f"the module {name} is not there")
            if is_own(module) or name == "fowtlib":
                continue
            found[name] = module
            if len(found) > _MOST:
                raise Unknown("much code that is not fowtlib's")
            left += sorted({str(_home(value)) for value in vars(module).values() if self.is_code(value)} - {"None"})
        return [found[name] for name in sorted(found)]

    @staticmethod
    def is_code(value: Any) -> bool:
        """Whether something in a module is code, of a module of its own, and no data."""
        return isinstance(value, types.ModuleType) or _home(value) is not None

    @staticmethod
    def text(module: types.ModuleType) -> str:
        """The text of a module. Raises Unknown where it has none, or where it may be another than the one that runs."""
        file = getattr(module, "__file__", None)
        if not file or not file.endswith(".py"):
            raise Unknown(f"the module {module.__name__} has no text")
        return content_from_before(file).decode("utf-8", "surrogateescape")


def _is_known(name: str) -> bool:
    return name.partition(".")[0] in _KNOWN and name != "__main__"


def _home(value: Any) -> str | None:
    """The module of a module, a class or a function; None of what is neither."""
    if isinstance(value, types.ModuleType):
        return value.__name__
    if isinstance(value, (type, types.FunctionType, types.BuiltinFunctionType)):
        return value.__module__
    return None
