"""Specifications -> components: classes and definitions found, overrides put on top, parts added, ports joined."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from fowtlib.language import expressions
from fowtlib.language.component import Assembly, Component
from fowtlib.language.declarations import Array, Parameter, Scalar, join
from fowtlib.language.errors import ModelError, ModelFileError, did_you_mean
from fowtlib.modelfile import catalogue, document, files
from fowtlib.modelfile.nodes import Place
from fowtlib.modelfile.paths import find_port, port_alias
from fowtlib.modelfile.scopes import Scope, freeze
from fowtlib.modelfile.specs import Declared, Document, Spec, Value
from fowtlib.modelfile.values import ValueReader

# What a component whose author did not expect a value may raise while it is built.
UNEXPECTED = (TypeError, ValueError, LookupError, ArithmeticError, AttributeError, RuntimeError, OSError)


@dataclass(frozen=True)
class Layer:
    """One of the specifications that together make a component, with the names that its values may use."""

    spec: Spec
    scope: Scope

    def reader(self) -> ValueReader:
        return ValueReader(self.scope, self.scope.folder)


class FileComponent(Component):
    """Base of the classes made for components that a file gives parameters or ports of its own."""

    file_base: type[Component] = Assembly

    def _set(self, name: str, value: Any) -> None:
        super()._set(name, expressions.rebind(value, self))  # declarations of this class become parameters of this part


class Assembler:
    """Builds the component of a document; `allow_python` lets files name Python code of their own."""

    def __init__(self, allow_python: bool = False):
        self.allow_python = allow_python
        self.used: list[Path] = []

    def root(self, top: Document, changes: Spec | None = None) -> Component:
        """The whole model; `changes` go on top of what the file says."""
        self.used.append(top.path.resolve())
        layers = [Layer(top.spec, self._file_scope(top))]
        if changes is not None:
            layers.insert(0, Layer(changes, Scope(layers[0].scope.folder, {}, parent=layers[0].scope)))
        return self.build(layers, "", "the model")

    def build(self, layers: list[Layer], path: str, name: str) -> Component:
        """The component that the layers describe, the most important first."""
        depth = len(self.used)
        base, layers = self._base(layers, path)
        declared = self._declared(layers, base, path)
        made = self._class(base, declared, layers)
        values = self._values(layers, made, declared, path)
        inner = self._parts(layers)
        replaced = [part for part in inner if part in base.declared_parts and _has_base(inner[part])]
        for part in replaced:
            values[part] = self.build(inner[part], join(path, part), part)
        place = next(layer.spec.place for layer in reversed(layers))
        self._check_required(made, values, path, layers[0].spec.place)
        with _building(layers[0].spec.place if path else place, path or name, base):
            component = made(**values)
        self._remember(component, layers)
        for part, part_layers in inner.items():
            if part in component.parts and part not in replaced and not _has_base(part_layers):
                self._change(component.parts[part], part_layers, join(path, part))
            elif part not in replaced:
                self._add(component, part, part_layers, path)
        self._connect(component, layers, path)
        del self.used[depth:]
        return component

    def change(self, component: Component, changes: Spec) -> None:
        """Put values into a component that exists."""
        self._change(component, [Layer(changes, Scope(Path.cwd(), {}, component=component))], "")

    # --- where a component comes from ----------------------------------------------------------------------------

    def _file_scope(self, top: Document) -> Scope:
        classes: catalogue.Classes = {}
        for value in top.python:
            name = str(value.node.value)
            if not self.allow_python:
                raise value.place.error(
                    f"the file wants to run the Python code in '{name}'; if you trust it, "
                    "load it with allow_python=True, or --allow-python on the command line."
                )
            try:
                classes.update(catalogue.classes_of_file(files.find_data(name, top.path.parent)))
            except ModelFileError as error:
                raise error.at(str(value.place)) from None
        return Scope(top.path.parent, classes)

    def _base(self, layers: list[Layer], path: str) -> tuple[type[Component], list[Layer]]:
        """The class to start from, and the layers on top of it with definitions put in, the most important first."""
        for i, layer in enumerate(layers):
            spec, above = layer.spec, layers[: i + 1]
            if spec.class_name is not None:
                return self._class_named(spec.class_name, layer.scope, path), above
            if spec.use is not None:
                base, below = self._base([self._definition(spec.use, layer, path)], path)
                return base, [*above, *below]
        if path and not any(layer.spec.parts for layer in layers):
            place = layers[0].spec.place
            raise place.error(f"{path}: the part has no 'class', no 'use' (a definition file) and no 'parts'.")
        return Assembly, layers

    def _class_named(self, value: Value, scope: Scope, path: str) -> type[Component]:
        name = ValueReader(scope, scope.folder).text(value, "the name of a class")
        own = _own_classes(scope)
        if name in own:
            return own[name]
        known = catalogue.classes()
        if name == Assembly.__name__:
            return Assembly
        if name not in known:
            hint = did_you_mean(name, [*own, *known])
            raise value.place.error(f"{path + ': ' if path else ''}there is no class '{name}'{hint} See `fowt parts`.")
        return known[name]

    def _definition(self, use: Value, layer: Layer, path: str) -> Layer:
        name = layer.reader().text(use, "the name of a definition file")
        try:
            file = files.find_definition(name, layer.scope.folder)
        except ModelFileError as error:
            raise use.place.error(f"{path + ': ' if path else ''}{error}") from None
        if file.resolve() in self.used:
            raise use.place.error(f"the definition '{name}' includes itself.")
        self.used.append(file.resolve())
        top = document.read(file, definition=True)
        return Layer(top.spec, self._file_scope(top))

    # --- parameters ----------------------------------------------------------------------------------------------

    def _declared(self, layers: list[Layer], base: type[Component], path: str) -> dict[str, Parameter]:
        """Declarations of the parameters that the files give the component, with values from the layers above."""
        found: dict[str, Parameter] = {}
        for i, layer in enumerate(layers):
            if not layer.spec.parameters:
                continue
            place = next(iter(layer.spec.parameters.values())).value.place
            if layer.spec.use is not None:
                raise place.error(f"{path}: beside 'use', give the parameters of the definition values directly.")
            for name, declared in layer.spec.parameters.items():
                taken = [*base.parameters, *base.ports, *base.variables, *base.declared_parts, *base.outers]
                if name in found or name in taken or hasattr(base, name):
                    raise declared.value.place.error(f"the parameter '{name}' has a name that is taken already.")
                layer.scope.waiting[name] = _declaration(name, declared, layers[: i + 1], join(path, name))
            for name, declared in layer.spec.parameters.items():
                try:
                    if name in layer.scope.waiting:
                        layer.scope.declare(name)
                except ModelFileError as error:
                    raise error if error.where else error.at(str(declared.value.place)) from None
                found[name] = layer.scope.parameters[name]
        return found

    @staticmethod
    def _class(base: type[Component], declared: dict[str, Parameter], layers: list[Layer]) -> type[Component]:
        ports = {alias: item for layer in reversed(layers) for alias, item in layer.spec.ports.items()}
        if not declared and not ports:
            return base
        for alias, (_, place) in ports.items():
            if hasattr(base, alias) or alias in declared:
                raise place.error(f"the port '{alias}' has a name that is taken already.")
        body: dict[str, Any] = {
            "__doc__": base.__doc__,
            "__module__": __name__,
            "__annotations__": {key: item.annotation for key, item in declared.items()},
            "file_base": base,
            **declared,
            **{alias: port_alias(alias, target, place) for alias, (target, place) in ports.items()},
        }
        document = layers[-1].spec.document
        name = document.path.stem if document and base is Assembly else base.__name__
        return type(name, (base, FileComponent), body)

    def _values(
        self, layers: list[Layer], made: type[Component], declared: dict[str, Parameter], path: str
    ) -> dict[str, Any]:
        values: dict[str, Any] = {}
        for layer in layers:
            for name, value in layer.spec.values.items():
                if name in values or name in declared:
                    continue
                values[name] = _parameter_value(layer, made, name, value, path, [*self._parts(layers)])
        return values

    @staticmethod
    def _check_required(made: type[Component], values: dict[str, Any], path: str, place: Place) -> None:
        missing = [field for field in made.parameters.values() if field.required and field.name not in values]
        if missing:
            listed = " and ".join(f"'{field.name}' [{field.unit}] ({field.doc})" for field in missing)
            raise place.error(f"{path or 'the model'}: {_known_class(made).__name__} needs a value for {listed}.")

    @staticmethod
    def _remember(component: Component, layers: list[Layer]) -> None:
        """Tell the component where its values stand, and the scopes which component they belong to."""
        for layer in reversed(layers):
            for name, value in layer.spec.values.items():
                component.origins[name] = str(value.place)
            for name, item in layer.spec.parameters.items():
                component.origins.setdefault(name, str(item.value.place))
            if layer.spec.parameters or layer.spec.parts:
                layer.scope.component = component

    # --- parts and connections -----------------------------------------------------------------------------------

    @staticmethod
    def _parts(layers: list[Layer]) -> dict[str, list[Layer]]:
        """The layers of each part, in the order in which the definitions name them."""
        found: dict[str, list[Layer]] = {}
        for layer in reversed(layers):
            for name, spec in layer.spec.parts.items():
                inner = Layer(spec, Scope(layer.scope.folder, {}, parent=layer.scope))
                found.setdefault(name, []).insert(0, inner)
        return found

    def _add(self, component: Component, name: str, layers: list[Layer], path: str) -> None:
        place = layers[0].spec.place
        if not _has_base(layers) and not any(layer.spec.parts for layer in layers if layer.spec.place.line):
            known = did_you_mean(name, component.parts)
            raise place.error(f"{path or 'the model'} has no part '{name}'{known} A new part needs 'class' or 'use'.")
        part = self.build(layers, join(path, name), name)
        with _building(place, join(path, name), type(part)):
            component.add(name, part)

    def _change(self, component: Component, layers: list[Layer], path: str) -> None:
        """Parameters of a part that a class has made."""
        kind = type(component)
        for layer in reversed(layers):
            for name, value in layer.spec.values.items():
                field = kind.parameters.get(name)
                read = _parameter_value(layer, kind, name, value, path, [*component.parts])
                composed = kind.build is not Component.build or kind.declared_parts
                if field is not None and not field.tunable and composed:
                    raise value.place.error(
                        f"{path}.{name} decides how the part is built, which its owner has done already; "
                        f"replace the part: {path.rpartition('.')[2]}: {{class: {kind.__name__}, ...}}."
                    )
                with _building(value.place, path, kind):
                    setattr(component, name, read)
                component.origins[name] = str(value.place)
            if layer.spec.parameters or layer.spec.ports:
                raise layer.spec.place.error(f"{path} is made by a class; it cannot get parameters or ports.")
        for name, inner in self._parts(layers).items():
            if name in component.parts and not _has_base(inner):
                self._change(component.parts[name], inner, join(path, name))
            else:
                self._add(component, name, inner, path)
        self._connect(component, layers, path)

    @staticmethod
    def _connect(component: Component, layers: list[Layer], path: str) -> None:
        for layer in reversed(layers):
            for alias, (target, place) in layer.spec.ports.items():
                find_port(component, target, place, f"{join(path, alias)}: ")
            for connection in layer.spec.connections:
                place = connection.place
                ports = [find_port(component, end, place) for end in connection.ends]
                for a, b in zip(ports[:-1], ports[1:], strict=True):
                    component.connections.append((a, b, str(place)))


def _parameter_value(layer: Layer, kind: type[Component], name: str, value: Value, path: str, parts: list[str]) -> Any:
    """The value of a parameter of a class."""
    field = kind.parameters.get(name)
    if field is None:
        known = _known_class(kind)
        has = f"{known.__name__} has" if known is not Assembly else "it has"
        hint = did_you_mean(name, [*kind.parameters, *parts])
        raise value.place.error(f"{path or 'the model'}: {has} no parameter '{name}'{hint}")
    result = layer.reader().read(value, field, join(path, name))
    if not field.tunable:
        try:
            freeze(result)
        except ModelFileError as error:
            raise value.place.error(f"{join(path, name)}: {error}") from None
    return result


def _declaration(name: str, declared: Declared, layers: list[Layer], path: str) -> Callable[[], Parameter]:
    """A function that makes the declaration, when the name is first needed; the last of the layers declares it."""
    own = layers[-1].reader()
    given = [(layer.reader(), layer.spec.values[name]) for layer in layers if name in layer.spec.values]

    def make() -> Parameter:
        unit = own.unit(declared, path)
        reader, value = (*given, (own, declared.value))[0]
        result = reader.declared(value, unit, declared.unit, path)
        low, high = (own.bound(bound, unit, path) for bound in (declared.min, declared.max))
        made = Parameter(result, unit, declared.description, low, high, None, False, None)
        made.name, made.annotation, made.from_file = name, Array if isinstance(result, list) else Scalar, True
        return made

    return make


def _own_classes(scope: Scope | None) -> catalogue.Classes:
    return {**_own_classes(scope.parent), **scope.classes} if scope is not None else {}


def _known_class(kind: type[Component]) -> type[Component]:
    """The class that a file names, for one made from it."""
    return getattr(kind, "file_base", kind)


def _has_base(layers: list[Layer]) -> bool:
    return any(layer.spec.class_name or layer.spec.use for layer in layers)


@contextmanager
def _building(place: Place, path: str, kind: type[Component]) -> Iterator[None]:
    """What goes wrong while a component is built becomes an error with a place."""
    try:
        yield
    except ModelFileError:
        raise
    except ModelError as error:
        named = str(error) if path and str(error).startswith(path) else f"{path + ': ' if path else ''}{error}"
        raise place.error(named) from None
    except UNEXPECTED as error:
        name = _known_class(kind).__name__
        reason = str(error).strip().splitlines()[-1] if str(error).strip() else type(error).__name__
        raise place.error(f"{path}: {name} cannot be built from these values: {reason}.") from error
