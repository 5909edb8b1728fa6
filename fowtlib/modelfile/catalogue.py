"""The component classes that a model file can name: all public ones of fowtlib.components, found when first needed."""

from __future__ import annotations

import importlib
import importlib.util
import inspect
import pkgutil
import re
from functools import cache
from importlib.machinery import SourceFileLoader
from pathlib import Path
from types import CodeType, ModuleType

from fowtlib.language.component import Component
from fowtlib.language.errors import ModelFileError

Classes = dict[str, type[Component]]
_CLASS = re.compile(r"^class ([A-Za-z]\w*)\(", re.MULTILINE)


@cache
def classes() -> Classes:
    """Every public component class of the library by name; two of one name are an error of the library."""
    import fowtlib.components as library

    found: Classes = {}
    for info in pkgutil.walk_packages(library.__path__, library.__name__ + "."):
        for name, item in _defined_in(importlib.import_module(info.name)).items():
            if name in found:
                raise TypeError(f"two components are called {name}: in {found[name].__module__} and {item.__module__}")
            found[name] = item
    return dict(sorted(found.items()))


def class_named(name: str) -> type[Component] | None:
    """The class of the library of that name, or None; of the library only the room is imported in which it stands."""
    module = _places().get(name)
    return None if module is None else _defined_in(importlib.import_module(module)).get(name)


@cache
def _places() -> dict[str, str]:
    """The modules in whose text the classes of the library stand."""
    import fowtlib.components as library

    found = {}
    for folder in map(Path, library.__path__):
        for path in folder.rglob("*.py"):
            names = path.relative_to(folder).with_suffix("").parts
            module = ".".join((library.__name__, *(names[:-1] if names[-1] == "__init__" else names)))
            found |= dict.fromkeys(_CLASS.findall(path.read_text(encoding="utf-8")), module)
    return found


class _FromText(SourceFileLoader):
    """Runs the text as it is now.

    Python takes a compiled file (.pyc) for that of a text with the same size and second of change: of a text edited by
    a program it may be the former one, of which a flat model would then be kept under the name of the new one.
    """

    def get_code(self, fullname: str) -> CodeType:
        return self.source_to_code(self.get_data(self.path), self.path)


def classes_of_file(path: Path) -> Classes:
    """The component classes that a Python file defines. This runs the file."""
    name = f"_parts_of_{path.stem}"
    spec = importlib.util.spec_from_file_location(name, path, loader=_FromText(name, str(path)))
    if spec is None or spec.loader is None:
        raise ModelFileError(f"'{path}' is not a Python file.")
    import sys

    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module  # annotations of the classes are looked up there
    try:
        spec.loader.exec_module(module)
    except Exception as error:
        raise ModelFileError(f"'{path}' does not run: {type(error).__name__}: {error}") from error
    return _defined_in(module)


def is_partial(item: type[Component]) -> bool:
    """A class that is there for others to derive from: its docstring says so, or it has no equations and no parts."""
    if re.search(r"(^|[.:] )Partial[.:]", " ".join((item.__doc__ or "").partition("\n\n")[0].split())):
        return True
    empty = not (item.declared_parts or item.part_arrays)
    return item.equations is Component.equations and item.build is Component.build and empty


def derived_from(name: str) -> list[str]:
    """The classes of the library that are made from a partial one of this name."""
    if name == Component.__name__:
        return []
    return [made for made, item in classes().items() if name in {base.__name__ for base in item.__mro__[1:]}]


def _defined_in(module: ModuleType) -> Classes:
    return {
        name: item
        for name, item in vars(module).items()
        if inspect.isclass(item)
        and issubclass(item, Component)
        and item.__module__ == module.__name__
        and not name.startswith("_")
        and not is_partial(item)
    }
