"""Code in a model that is not fowtlib's: the modules that a user has written, and what they import of their own."""

from __future__ import annotations

import dis
import sys
import types
from collections.abc import Mapping
from importlib.util import resolve_name
from typing import Any

from fowtlib.flattening.own_code import Unknown, content_from_before, is_own

_MOST = 30  # modules; a model that leads to more is one of a program, not of a file of parts
_KNOWN = sys.stdlib_module_names | {"numpy", "scipy", "casadi", "networkx"}  # known by their versions
_OUTSIDE = {"environ", "environb", "getenv", "getenvb", "argv", "import_module", "__import__", "exec", "eval"}
"""Names by which a function asks for what stands in no module."""


class ForeignCode:
    """The modules that were met, and those that their names lead to."""

    def __init__(self) -> None:
        self._names: set[str] = set()
        self._last = ""  # module that was imported

    def meet(self, name: str | None) -> None:
        """Note the module of a class or a function."""
        if not name:
            raise Unknown("code without a module")
        self._names.add(name)

    def look_into(self, code: types.CodeType, names: Mapping[str, Any]) -> None:
        """Note what a function imports when it is called, with the names of its module. Raises Unknown.

        Unknown where such a module has not been imported yet, and where a function asks for more than code and values.
        """
        if asked := sorted(_OUTSIDE & {*code.co_names}):
            raise Unknown(f"{code.co_qualname} in {code.co_filename} asks for {asked[0]}")
        package, level = names.get("__package__") or "", 0
        for step in dis.get_instructions(code):
            if step.opname.startswith("LOAD") and isinstance(step.argval, int):
                level = step.argval  # the first of two constants before an import
            elif step.opname == "IMPORT_NAME":
                self._imported("." * level + step.argval, package)
            elif step.opname == "IMPORT_FROM" and f"{self._last}.{step.argval}" in sys.modules:
                self.meet(f"{self._last}.{step.argval}")
        for constant in code.co_consts:
            if isinstance(constant, types.CodeType):
                self.look_into(constant, names)

    def _imported(self, name: str, package: str) -> None:
        try:
            self._last = resolve_name(name, package)
        except ImportError:
            raise Unknown(f"{name} is imported from nowhere") from None
        self.meet(self._last)

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
