"""By what a flat model is known again: everything that its equations follow from, as one digest.

That is the code of the components and of the flattening, versions, values and objects in the component tree, and the
content of the files that parameters name. The values of bound parameters are left out: no equation can depend on them.
What cannot be told apart by its content is `Unknown`, and such a model is flattened every time.
"""

from __future__ import annotations

import functools
import hashlib
import operator
import sys
import types
from collections.abc import Iterable, Sequence
from enum import Enum
from pathlib import PurePath
from typing import Any

import casadi as ca
import numpy as np

from fowtlib.flattening.foreign_code import ForeignCode
from fowtlib.flattening.own_code import Unknown, digest_of_own_code, is_own
from fowtlib.language.component import Component
from fowtlib.language.data_files import digest_of, files_of
from fowtlib.language.declarations import Field, PortReference
from fowtlib.language.errors import ModelError
from fowtlib.language.expressions import Expression, ParameterReference, StartNumbers
from fowtlib.language.externals import ExternalFunction
from fowtlib.language.native import compiler

# What a component knows of its place, of the text it was read from, and of the way in which it was composed.
_NO_CONTENT = {"_binding", "_parent", "origins", "_predecessors", "_by_owner", "_given", "_added", "_later", "parts"}
_PLAIN = (int, float, bool, str, bytes, complex, type(None))


def fingerprint(root: Component, opened: Sequence[str] = ()) -> tuple[str, bool]:
    """The digest of a model, and whether code from outside of fowtlib is in it. Raises Unknown."""
    contents = _Contents(root)
    for component in root.walk():
        contents.component(component)
    foreign: list[types.ModuleType] = []
    while more := [module for module in contents.foreign.modules() if module not in foreign]:
        for module in more:
            contents.module(module)  # whose functions may import others
        foreign += more
    files = {path: digest_of(file) for path, file in files_of(root).items() if not _bound(root, path)}
    contents.add([digest_of_own_code(), sys.version, sys.platform, list(compiler()), list(opened), files])
    return contents.digest(), bool(foreign)


def bound_values(root: Component) -> str:
    """The digest of what `fingerprint` leaves out: values of bound parameters, and the files that they name."""
    contents = _Contents(root)
    for component in root.walk():
        for name, field in component.parameters.items():
            if field.bound and component.is_set(name):
                contents.add([component.path, name, component.parameter_binding(name)])
    contents.add({path: digest_of(file) for path, file in files_of(root).items() if _bound(root, path)})
    return contents.digest()


def _stands_in_text(kind: type) -> bool:
    """Whether a class is the one that its module defines; not so one that a model file makes, with values in it."""
    try:
        return operator.attrgetter(kind.__qualname__)(sys.modules[kind.__module__]) is kind
    except AttributeError:
        return False


def _bound(root: Component, path: str) -> bool:
    owner, _, name = path.rpartition(".")
    return root.find(owner).parameters[name].bound


class _Contents:
    """Words that say what objects are; equal words, equal objects."""

    def __init__(self, root: Component):
        self.words: list[str] = []
        self.foreign = ForeignCode()
        self._paths = {id(component): component.path for component in root.walk()}
        self._met: dict[int, int] = {}
        self._held: list[Any] = []  # so that no two have one id

    def digest(self) -> str:
        """The digest of all words."""
        text = "".join(f"{len(word)} {word}" for word in self.words)
        return hashlib.sha256(text.encode("utf-8", "surrogatepass")).hexdigest()[:40]

    def component(self, one: Component) -> None:
        """A component of the tree: its class, its values and whatever else it holds."""
        self._class(type(one))
        self._say("component", one.path)
        self._found_values(one)
        for name, value in vars(one).items():
            if name == "_values":
                for key, given in value.items():
                    bound = key in one.parameters and one.parameters[key].bound
                    self._say("value", key, "bound" if bound else "")
                    self.add(None if bound else given)
            elif name == "connections":
                self.add([pair[:2] for pair in value])
            elif name not in _NO_CONTENT:
                self._say("attribute", name)
                self.add(value)

    def _found_values(self, one: Component) -> None:
        """Structural values that a function finds, perhaps from bound ones: equations may be made with them."""
        for name, field in one.parameters.items():
            if field.bound or field.tunable or one.is_set(name) or not callable(field.default):
                continue
            try:
                value = one.parameter_value(name)
            except ModelError:  # the flattening says it
                raise Unknown(f"{name} of {one.label} has no value") from None
            self._say("found", name)
            self.add(value)

    def module(self, module: types.ModuleType) -> None:
        """A module from outside of fowtlib: its text, the code of it that runs, and the data in it."""
        self._say("module", module.__name__, self.foreign.text(module))
        for name, value in vars(module).items():
            own = getattr(value, "__module__", None) == module.__name__
            if not name.startswith("__") and (own or not self.foreign.is_code(value)):
                self._say(name)
                self.add(value)

    def add(self, value: Any) -> None:
        """Any object. Raises Unknown."""
        kind = type(value)
        if kind in _PLAIN:
            self.words.append(repr(value))
            return
        if isinstance(value, type):
            self._class(value)
            return
        if id(value) in self._paths:
            self._say("part", self._paths[id(value)])
            return
        if id(value) in self._met:
            self._say("again", str(self._met[id(value)]))
            return
        self._met[id(value)] = len(self._met)
        self._held.append(value)
        if kind in (list, tuple):
            self._say(kind.__name__, str(len(value)))
            for item in value:
                self.add(item)
        elif isinstance(value, (dict, types.MappingProxyType)):
            self._say("dict", str(len(value)))
            for key, item in value.items():
                self.add(key)
                self.add(item)
        elif kind in (set, frozenset):
            self._set(value)
        elif isinstance(value, np.ndarray) and value.dtype.kind in "fiucbUS":
            self._say("array", value.dtype.str, repr(value.shape), hashlib.sha256(value.tobytes()).hexdigest())
        elif isinstance(value, np.generic):
            self._say("number", value.dtype.str, repr(value.item()))
        elif isinstance(value, types.FunctionType):
            self._function(value)
        else:
            self._object(value)

    def _set(self, value: Iterable[Any]) -> None:
        if not all(type(item) in _PLAIN for item in value):
            raise Unknown("a set of objects")
        self._say("set", *sorted(map(repr, value)))

    def _object(self, value: Any) -> None:
        if isinstance(value, Component):
            self.component(value)
        elif isinstance(value, (ParameterReference, StartNumbers)):
            self._say("reference", value.name)
            self.add(value.component.current)
            self.add([value.size, value.compute] if isinstance(value, StartNumbers) else None)
        elif isinstance(value, Expression):
            self.add([value.symbol, value.function, list(value.arguments)])
        elif isinstance(value, PortReference):
            self.add([value.component, value.field.name, value.index])
        elif isinstance(value, ExternalFunction):
            self.add([value.name, value.inputs, value.outputs, None if value.library is None else str(value.library)])
            if value.library is None:
                raise Unknown(f"the Python function {value.name}")
        elif isinstance(value, PurePath):
            self._say("path", str(value))
        elif isinstance(value, Enum):
            self._say("choice", type(value).__qualname__, value.name)
        elif isinstance(value, types.MethodType):
            self.add([value.__func__, value.__self__])
        elif isinstance(value, property):
            self.add([value.fget, value.fset])
        elif isinstance(value, functools.cached_property):
            self.add(value.func)
        elif isinstance(value, functools.partial):
            self.add([value.func, list(value.args), value.keywords])
        elif isinstance(value, (types.BuiltinFunctionType, np.ufunc)):
            self._say("built in", getattr(value, "__module__", None) or "", value.__name__)
        elif isinstance(value, types.ModuleType):
            self.foreign.meet(value.__name__)
            self._say("module", value.__name__)
        elif isinstance(value, ca.Sparsity):
            self._say("sparsity", value.serialize())
        elif isinstance(value, Field):
            self._class(type(value))
            self.add(dict(vars(value)))
        else:
            self._parts_of(value)

    def _parts_of(self, value: Any) -> None:
        """An object by its class and its attributes."""
        kind = type(value)
        own = [name for base in kind.__mro__ for name in vars(base).get("__slots__", ()) if not name.startswith("__")]
        plain = not any(vars(base).get("__module__") in ("builtins", "weakref", "_weakref", "casadi.casadi", "ctypes")
                        for base in kind.__mro__[:-1])  # fmt: skip
        if not plain or not (hasattr(value, "__dict__") or own):
            raise Unknown(f"an object of the class {kind.__module__}.{kind.__qualname__}")
        self._class(kind)
        for name, item in {**{k: getattr(value, k, None) for k in own}, **getattr(value, "__dict__", {})}.items():
            self._say("attribute", name)
            self.add(item)

    def _class(self, kind: type) -> None:
        self._say("class", kind.__module__, kind.__qualname__)
        if id(kind) in self._met:
            return
        self._met[id(kind)] = len(self._met)
        self._held.append(kind)
        for base in kind.__mro__[:-1]:
            self.foreign.meet(base.__module__)
            own = is_own(sys.modules.get(base.__module__))
            if own and not self._unchanged(base):
                raise Unknown(f"{base.__qualname__} is not as its file says")
            if base.__module__ in sys.stdlib_module_names or (own and _stands_in_text(base)):
                continue
            for name, item in vars(base).items():
                if name == "__init__" or not name.startswith("__"):
                    self._say(name)
                    self.add(getattr(item, "__func__", item))

    @staticmethod
    def _unchanged(kind: type) -> bool:
        """Whether the methods of a class of fowtlib are those that stand in a file of fowtlib."""
        methods = (item for name, item in vars(kind).items() if not name.startswith("__"))
        return all(is_own(item.__code__) for item in methods if isinstance(item, types.FunctionType))

    def _function(self, function: types.FunctionType) -> None:
        self._say("function", function.__module__ or "", function.__qualname__)
        if not is_own(function.__code__):
            self.foreign.meet(function.__module__)
            self.foreign.look_into(function.__code__, function.__globals__)
        self._code(function.__code__)
        self.add([function.__defaults__, function.__kwdefaults__])
        for cell in function.__closure__ or ():
            try:
                self.add(cell.cell_contents)
            except ValueError:  # not assigned yet
                self._say("empty")

    def _code(self, code: types.CodeType) -> None:
        self._say("code", code.co_code.hex(), repr(code.co_names), repr(code.co_varnames), repr(code.co_freevars))
        for constant in code.co_consts:
            if isinstance(constant, types.CodeType):
                self._code(constant)
            else:
                self.words.append(repr(constant))

    def _say(self, *words: str) -> None:
        self.words += words
