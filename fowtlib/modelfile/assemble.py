"""Specifications -> components: classes and definitions found, overrides put on top, parts added, ports joined."""

from __future__ import annotations

from pathlib import Path

from fowtlib.language.component import Assembly, Component, did_you_mean_part
from fowtlib.language.composition import check_fits
from fowtlib.language.declarations import join
from fowtlib.language.errors import ModelFileError, did_you_mean, one_of
from fowtlib.modelfile import catalogue, document, files
from fowtlib.modelfile.layers import (
    Layer,
    building,
    check_required,
    declared_parameters,
    given_values,
    has_base,
    kind_first,
    make_class,
    of_kind,
    parameter_value,
    parts_of,
    remember,
)
from fowtlib.modelfile.nodes import Place
from fowtlib.modelfile.paths import find_port
from fowtlib.modelfile.permit import Permit
from fowtlib.modelfile.scopes import Scope
from fowtlib.modelfile.specs import Document, Spec, Value
from fowtlib.modelfile.values import ValueReader

MOST_PARTS = 20_000
DEEPEST = 30  # definitions that include each other
RESERVED = ("parts", "connections", "origins", "title")


class TreeBuilder:
    """Builds the component of a document; `allow_python` lets files name Python code of their own.

    permit: what files may be named in it. files: what was read so far, the model file, definitions and Python code.
    """

    def __init__(self, allow_python: bool = False, permit: Permit | None = None):
        self.allow_python, self.permit = allow_python, permit
        self.used: list[Path] = []
        self.files: list[Path] = []
        self.count = 0

    def root(self, top: Document, changes: Spec | None = None) -> Component:
        """The whole model; `changes` go on top of what the file says."""
        self.used.append(top.path.resolve())
        layers = [Layer(top.spec, self._file_scope(top))]
        if changes is not None:
            layers.insert(0, Layer(changes, Scope(Path.cwd(), {}, parent=layers[0].scope)))
        return self.build(layers, "", "the model")

    def build(self, layers: list[Layer], path: str, name: str, usual: type[Component] | None = None) -> Component:
        """The component that the layers describe, the most important first; `usual` is its class if they give none."""
        depth = len(self.used)
        base, layers = self._base(layers, path) if has_base(layers) or not usual else (usual, layers)
        base, layers = of_kind(base, layers, path)
        declared = declared_parameters(layers, base, path)
        made = make_class(base, declared, layers)
        values = given_values(layers, made, declared, path)
        inner = parts_of(layers)
        slots = base.declared_parts
        replaced = [part for part in inner if part in slots and (has_base(inner[part]) or not slots[part].modifiers)]
        for part in replaced:
            values[part] = self.build(inner[part], join(path, part), part, slots[part].component_class)
            with building(inner[part][0].spec.place, "", slots[part].base):
                check_fits(values[part], slots[part].base, join(path, part))
        place = layers[0 if path else -1].spec.place
        check_required(made, values, path, place)
        with building(place, path or name, base):
            component = made(**values)
        component.origins[""] = str(place)
        self._counted(component, place)
        remember(component, layers, path)
        for part, part_layers in inner.items():
            if part in component.parts and part not in replaced and not has_base(part_layers):
                self._change(component.parts[part], part_layers, join(path, part))
            elif part not in replaced:
                self._add(component, part, part_layers, path)
        self._connect(component, layers, path)
        del self.used[depth:]
        return component

    def _counted(self, component: Component, place: Place) -> None:
        """Count a component and what its class has put into it."""
        self.count += sum(1 for _ in component.walk())
        if self.count > MOST_PARTS:
            raise place.error(f"the model has more than {MOST_PARTS} parts; that is the limit.")

    def change(self, component: Component, changes: Spec) -> None:
        """Put values into a component that exists."""
        self._change(component, [Layer(changes, Scope(Path.cwd(), {}, component=component))], "")

    # --- where a component comes from ----------------------------------------------------------------------------

    def _file_scope(self, top: Document) -> Scope:
        classes: catalogue.Classes = {}
        self._read(top.path)
        for value in top.python:
            name = str(value.node.value)
            if not self.allow_python:
                raise value.place.error(
                    f"the file wants to run the Python code in '{name}'; if you trust it, "
                    "load it with allow_python=True, or --allow-python on the command line."
                )
            try:
                code = files.find_data(name, top.path.parent)
                self._read(code)
                classes.update(catalogue.classes_of_file(code))
            except ModelFileError as error:
                raise error.at(str(value.place)) from None
        return Scope(top.path.parent, classes, permit=self.permit)

    def _read(self, path: Path) -> None:
        if path.resolve() not in self.files:
            self.files.append(path.resolve())

    def _base(self, layers: list[Layer], path: str) -> tuple[type[Component], list[Layer]]:
        """The class to start from, and the layers on top of it with definitions put in, the most important first."""
        for i, layer in enumerate(layers):
            spec, above = layer.spec, layers[: i + 1]
            if spec.class_name is not None:
                named = self._class_named(spec.class_name, layer.scope, path)
                return named, [*above, *self._kept_below(named, layers[i + 1 :], path)]
            if spec.use is not None:
                base, below = self._base([self._definition(spec.use, layer, path)], path)
                return base, [*above, *below]
        if path and not any(layer.spec.parts for layer in layers):
            place = layers[0].spec.place
            raise place.error(f"{path}: the part has no 'class', no 'use' (a definition file) and no 'parts'.")
        return Assembly, layers

    def _kept_below(self, named: type[Component], layers: list[Layer], path: str) -> list[Layer]:
        """What a class named on top leaves of the part below: all where it is derived from that class, else nothing."""
        if not has_base(layers):
            return []
        below, kept = self._base(layers, path)
        return kept if issubclass(named, below) and below not in (named, Assembly) else []

    def _class_named(self, value: Value, scope: Scope, path: str) -> type[Component]:
        name = ValueReader(scope, scope.folder).text(value, "the name of a class")
        own = _own_classes(scope)
        if name in own:
            return own[name]
        if name == Assembly.__name__:
            return Assembly
        found = catalogue.class_named(name)
        if found is None:
            made = catalogue.derived_from(name)
            if made:
                where = f"{path + ': ' if path else ''}"
                raise value.place.error(f"{where}'{name}' is a base of other classes, no part; take {one_of(made)}.")
            hint = did_you_mean(name, [*own, *catalogue.classes()])
            raise value.place.error(f"{path + ': ' if path else ''}there is no class '{name}'{hint} See `fowt parts`.")
        return found

    def _definition(self, use: Value, layer: Layer, path: str) -> Layer:
        name = layer.reader().text(use, "the name of a definition file")
        try:
            permit = self.permit if use.place.line else None
            file = files.find_definition(name, layer.scope.folder, permit)
        except ModelFileError as error:
            raise use.place.error(f"{path + ': ' if path else ''}{error}") from None
        if file.resolve() in self.used:
            raise use.place.error(f"the definition '{name}' includes itself.")
        if len(self.used) >= DEEPEST:
            raise use.place.error(f"definitions are nested more than {DEEPEST} deep; that is the limit.")
        self.used.append(file.resolve())
        top = document.read(file, definition=True)
        return Layer(top.spec, self._file_scope(top))

    # --- parts and connections -----------------------------------------------------------------------------------

    def _add(self, component: Component, name: str, layers: list[Layer], path: str) -> None:
        place = layers[0].spec.place
        if not has_base(layers) and not any(layer.spec.parts for layer in layers if layer.spec.place.line):
            hint = did_you_mean_part(name, component) + (" A new part needs 'class' or 'use'." if place.line else "")
            raise place.error(f"{path or 'the model'} has no part '{name}'{hint}")
        if (hasattr(type(component), name) and name not in component.declared_parts) or name in RESERVED:
            raise place.error(f"a part cannot be called '{name}', which has a meaning in every component.")
        part = self.build(layers, join(path, name), name)
        with building(place, join(path, name), type(part)):
            component.add(name, part)

    def _change(self, component: Component, layers: list[Layer], path: str) -> None:
        """Parameters of a part that a class has made."""
        for layer in reversed(layers):
            for name, value in kind_first(type(component), layer.spec.values):
                kind = type(component)
                read = parameter_value(layer, kind, name, value, path, [*component.parts])
                with building(value.place, path, kind):
                    setattr(component, name, read)
                component.origins[name] = str(value.place)
            if layer.spec.parameters or layer.spec.ports:
                raise layer.spec.place.error(f"{path} is made by a class; it cannot get parameters or ports.")
        for name, inner in parts_of(layers).items():
            if name in component.parts and not has_base(inner):
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


def _own_classes(scope: Scope | None) -> catalogue.Classes:
    return {**_own_classes(scope.parent), **scope.classes} if scope is not None else {}
