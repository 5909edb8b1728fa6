"""The layers of specifications that make a component: a class, definitions, and what overrides them."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, replace
from typing import Any

from fowtlib.language import expressions
from fowtlib.language.component import Assembly, Component
from fowtlib.language.declarations import Array, DataParameter, Parameter, Scalar, join
from fowtlib.language.errors import ModelError, ModelFileError, did_you_mean
from fowtlib.language.families import Family
from fowtlib.modelfile.nodes import Place
from fowtlib.modelfile.paths import port_alias
from fowtlib.modelfile.scopes import Scope, freeze
from fowtlib.modelfile.specs import Declared, Spec, Value
from fowtlib.modelfile.values import ValueReader

# What a component whose author did not expect a value may raise while it is built.
UNEXPECTED = (TypeError, ValueError, LookupError, ArithmeticError, AttributeError, RuntimeError, OSError)


@dataclass(frozen=True)
class Layer:
    """One of the specifications that together make a component, with the names that its values may use."""

    spec: Spec
    scope: Scope

    def reader(self) -> ValueReader:
        return ValueReader(self.scope, self.scope.folder, self.scope.permit)


class FileComponent(Component):
    """Base of the classes made for components that a file gives parameters or ports of its own."""

    file_base: type[Component] = Assembly

    def _set(self, name: str, value: Any) -> None:
        super()._set(name, expressions.rebind(value, self))  # declarations of this class become parameters of this part


def parts_of(layers: list[Layer]) -> dict[str, list[Layer]]:
    """The layers of each part, in the order in which the definitions name them."""
    found: dict[str, list[Layer]] = {}
    for layer in reversed(layers):
        for name, spec in layer.spec.parts.items():
            inner = Layer(spec, Scope(layer.scope.folder, {}, parent=layer.scope, permit=layer.scope.permit))
            found.setdefault(name, []).insert(0, inner)
    return found


def of_kind(base: type[Component], layers: list[Layer], path: str) -> tuple[type[Component], list[Layer]]:
    """The class of the kind that the layers name, for a class that has kinds.

    Where a layer names a kind, what those below it say of parameters that only another kind has is left out.
    """
    family = base.family
    if family is None or base is not family.base:
        return base, layers
    kinds = [_kind_in(layer, family, path) for layer in layers]
    named = next((kind for kind in kinds if kind is not None), family.field.default)
    chosen = family.class_of(named, join(path, family.selector))
    kept, own = [], named
    for layer, kind in zip(layers, kinds, strict=True):
        below = kept and own != named  # of a layer that belongs to another kind
        kept.append(_only(layer, family.base.parameters.keys() - set(chosen.void)) if below else layer)
        own = next((k for k in kinds[len(kept) :] if k is not None), family.field.default) if kind is not None else own
    return chosen, kept


def _kind_in(layer: Layer, family: Family, path: str) -> str | None:
    """The kind that one layer names."""
    value = layer.spec.values.get(family.selector)
    if value is None:
        return None
    where = join(path, family.selector)
    named = layer.reader().read(value, family.field, where)
    try:
        family.class_of(named, where)
    except ModelError as error:
        raise value.place.error(str(error)) from None
    return named


def _only(layer: Layer, names: Collection[str]) -> Layer:
    values = {name: value for name, value in layer.spec.values.items() if name in names}
    return Layer(replace(layer.spec, values=values), layer.scope)


def kind_first(kind: type[Component], values: Mapping[str, Value]) -> list[tuple[str, Value]]:
    """Values in the order in which they can be set: the kind decides which others there are."""
    selector = kind.family.selector if kind.family is not None else None
    return sorted(values.items(), key=lambda item: item[0] != selector)


def declared_parameters(layers: list[Layer], base: type[Component], path: str) -> dict[str, Parameter]:
    """Declarations of the parameters that the files give the component, with values from the layers above."""
    found: dict[str, Parameter] = {}
    for i, layer in enumerate(layers):
        if not layer.spec.parameters:
            continue
        place = next(iter(layer.spec.parameters.values())).value.place
        below = {name for lower in layers[i + 1 :] for name in lower.spec.parameters}
        # a file that goes on from a definition may have parameters of its own, a part that uses one may not
        if layer.spec.use is not None and (layer.spec.document is None or below & layer.spec.parameters.keys()):
            raise place.error(f"{path}: beside 'use', give the parameters of the definition values directly.")
        for name, declared in layer.spec.parameters.items():
            taken = [*base.parameters, *base.ports, *base.variables, *base.declared_parts, *base.part_arrays]
            taken += base.outers
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


def make_class(base: type[Component], declared: dict[str, Parameter], layers: list[Layer]) -> type[Component]:
    """The class of a component: that of the catalogue, or one made from it with parameters and ports of the file."""
    ports = {alias: item for layer in reversed(layers) for alias, item in layer.spec.ports.items()}
    if not declared and not ports:
        return base
    for alias, (_, place) in ports.items():
        if hasattr(base, alias) or alias in declared:
            by = "a parameter of this file" if alias in declared else "the class of the part"
            raise place.error(f"the port '{alias}' has a name that is taken already, by {by}; choose another.")
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


def given_values(
    layers: list[Layer], made: type[Component], declared: dict[str, Parameter], path: str
) -> dict[str, Any]:
    """The values that the layers give to parameters of the class."""
    values: dict[str, Any] = {}
    for layer in layers:
        void = {rival for name in values if name in made.parameters for rival in made.rivals(name)}
        for name, value in layer.spec.values.items():
            if name in values or name in declared or name in void:
                continue
            values[name] = parameter_value(layer, made, name, value, path, [*parts_of(layers)])
    return values


def check_required(made: type[Component], values: dict[str, Any], path: str, place: Place) -> None:
    """Refuse to build a component that lacks a value."""
    missing = [field for field in made.parameters.values() if field.required and field.name not in values]
    if missing:
        listed = " and ".join(f"'{field.name}' [{field.unit}] ({field.doc})" for field in missing)
        raise place.error(f"{path or 'the model'}: {known_class(made).__name__} needs a value for {listed}.")


def remember(component: Component, layers: list[Layer], path: str) -> None:
    """Tell the component where its values stand, and the scopes which component they belong to."""
    for layer in reversed(layers):
        for name, value in layer.spec.values.items():
            component.origins[name] = str(value.place)
            field = component.parameters.get(name)
            if field is not None and not (isinstance(field, DataParameter) and field.using):
                with building(value.place, join(path, name), type(component)):
                    component.parameter_value(name)  # an expression that has no value is found now
        for name, item in layer.spec.parameters.items():
            component.origins.setdefault(name, str(item.value.place))
        if layer.spec.parameters or layer.spec.parts:
            layer.scope.component = component


def parameter_value(layer: Layer, kind: type[Component], name: str, value: Value, path: str, parts: list[str]) -> Any:
    """The value of a parameter of a class."""
    field = kind.parameters.get(name)
    if field is None:
        known = known_class(kind)
        has = f"{known.__name__} has" if known is not Assembly else "it has"
        if name in parts:
            raise value.place.error(f"{join(path, name)} is a part, not a parameter; give values to its parameters.")
        hint = kind.family.hint(name) if kind.family is not None else ""
        hint = hint or did_you_mean(name, [*kind.parameters, *parts])
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


def known_class(kind: type[Component]) -> type[Component]:
    """The class that a file names, for one made from it."""
    return getattr(kind, "file_base", kind)


def has_base(layers: list[Layer]) -> bool:
    """True where one of the layers says what the component is."""
    return any(layer.spec.class_name or layer.spec.use for layer in layers)


@contextmanager
def building(place: Place, path: str, kind: type[Component]) -> Iterator[None]:
    """What goes wrong while a component is built becomes an error with a place."""
    try:
        yield
    except ModelFileError:
        raise
    except ModelError as error:
        named = str(error) if path and str(error).startswith(path) else f"{path + ': ' if path else ''}{error}"
        raise place.error(named) from None
    except UNEXPECTED as error:
        name = known_class(kind).__name__
        reason = str(error).strip().splitlines()[-1] if str(error).strip() else type(error).__name__
        raise place.error(f"{path}: {name} cannot be built from these values: {reason}.") from error
