"""`dump`: a component tree -> the text of a model file that gives the same flat model."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from typing import Any

import numpy as np

from fowtlib.language.component import Assembly, Component
from fowtlib.language.declarations import Parameter, PortReference, join
from fowtlib.language.errors import ModelFileError
from fowtlib.language.expressions import ParameterReference, is_expression
from fowtlib.modelfile import catalogue, files
from fowtlib.modelfile.formula_text import FormulaWriter
from fowtlib.modelfile.scopes import leaves
from fowtlib.modelfile.yaml_text import to_text
from fowtlib.solving.model import Model, Output
from fowtlib.solving.timeline import events_of


def dump(source: Model | Component) -> str:
    """The model file (YAML text) of a model, or of a component composed in Python.

    Numbers are in SI. Parts that a class makes itself are not written, only what was changed in them afterwards. A
    class of your own that only composes others is written as its parts; one with equations must be in the catalogue.
    Raises ModelFileError: something that a model file cannot say.
    """
    model = source if isinstance(source, Model) else Model(source, getattr(source, "title", ""))
    document: dict[str, Any] = {"fowtlib": 1}
    if model.title:
        document["title"] = model.title
    document |= _Writer().component(model.root)
    if model.outputs:
        document["outputs"] = {name: _output(item) for name, item in model.outputs.items()}
    settings = dict(model.settings)
    events, equilibrium = events_of(settings.pop("events", ())), settings.pop("equilibrium", None)
    if settings:
        document["simulation"] = settings
    if events:
        document["events"] = [event.plain() for event in events]
    if equilibrium:
        document["equilibrium"] = equilibrium
    return to_text(document)


def _output(item: Output | str) -> Any:
    if isinstance(item, str):
        return item
    entries = {"of": item.of, "unit": item.unit, "description": item.doc}
    given = {key: value for key, value in entries.items() if value}
    return item.of if len(given) == 1 else given


class _Writer:
    """Writes components from the top down; a formula can name what was written before."""

    def __init__(self) -> None:
        self.formulas = FormulaWriter(is_composite)

    def component(self, component: Component, leave_out: Collection[str] = ()) -> dict[str, Any]:
        """The keys of one component; `leave_out` are values that its owner sets again."""
        known = _known_class(component)
        entries: dict[str, Any] = {}
        self.formulas.reached.append(component)
        if is_composite(component):
            names: list[str] = []
            entries["parts"] = {name: self.component(part) for name, part in component.parts.items()}
            connections = component.connections
        else:
            _check_in_catalogue(component, known)
            entries["class"] = _class_name(known)
            names = [name for name in component._values if name in known.parameters and name not in leave_out]
            entries |= {name: self._value(component, name) for name in names}
            fresh = known(**_parts_given(component), **{name: component._values[name] for name in names})
            entries["parts"] = self._changed_parts(component, fresh)
            connections = _more_connections(component, fresh)
        entries["connect"] = [[_end(a, component), _end(b, component)] for a, b, _ in connections]
        declared = self._parameters(component, known)
        return {"parameters": declared, **_filled(entries)} if declared else _filled(entries)

    def _parameters(self, component: Component, known: type[Component]) -> dict[str, Any]:
        """The parameters of its own that formulas use; one may need another, so ask until none is new."""
        written: dict[str, Any] = {}
        while names := [name for name in self.formulas.used_of(component) if name not in written]:
            for name in names:
                written[name] = self._declared(component, component.parameters[name])
        order = [name for name in component.parameters if name in written]
        return {name: written[name] for name in order if is_composite(component) or name not in known.parameters}

    def _declared(self, component: Component, field: Parameter) -> Any:
        value = self._value(component, field.name)
        about = {"unit": field.unit if field.unit != "1" else "", "description": field.doc, "min": field.min}
        about = {key: item for key, item in {**about, "max": field.max}.items() if item not in ("", None)}
        if not about:
            return value
        if list(about) == ["unit"] and isinstance(value, float):
            return f"{value!r} {field.unit}"
        return {"value": value, **about}

    def _value(self, component: Component, name: str) -> Any:
        """A parameter as the file says it."""
        field, value = component.parameters[name], component.parameter_binding(name)
        where = join(component.path or "the model", name)
        if is_expression(value):
            return self.formulas.value(component, field, value, where)
        if (field.annotation is str or field.is_data) and isinstance(value, str):
            return files.as_data_name(value)
        return plain(value, where)

    # --- parts that a class makes --------------------------------------------------------------------------------

    def _changed_parts(self, component: Component, fresh: Component) -> dict[str, Any]:
        """What differs from the parts that the class makes by itself."""
        missing = [name for name in fresh.parts if name not in component.parts]
        if missing:
            raise ModelFileError(f"{component.label}: the part '{missing[0]}' was removed, and a file cannot say that.")
        changed: dict[str, Any] = {}
        known_parts = _known_class(component).declared_parts
        for name, part in component.parts.items():
            twin = fresh.parts.get(name)
            if twin is None or (name in component._given and name not in known_parts):
                changed[name] = self.component(part)
            elif name in _parts_given(component):
                changed[name] = self.component(part, _set_by_owner(part, twin, component, fresh))
            elif difference := self._difference(part, twin, component, fresh):
                changed[name] = difference
        return changed

    def _difference(self, part: Component, twin: Component, top: Component, fresh_top: Component) -> dict[str, Any]:
        self.formulas.reached.append(part)
        entries: dict[str, Any] = {name: self._value(part, name) for name in _changed(part, twin, top, fresh_top)}
        inner = {
            name: self._difference(child, twin.parts[name], top, fresh_top)
            for name, child in part.parts.items()
            if not _replaced(part, name, twin)
        }
        added = {name: self.component(child) for name, child in part.parts.items() if _replaced(part, name, twin)}
        entries["parts"] = {**{name: item for name, item in inner.items() if item}, **added}
        entries["connect"] = [[_end(a, part), _end(b, part)] for a, b, _ in _more_connections(part, twin)]
        return _filled(entries)


def _replaced(owner: Component, name: str, twin: Component) -> bool:
    """True for a part that the class of its owner does not make: another stands there, or none."""
    other = twin.parts.get(name)
    return type(owner.parts[name]) is not type(other) or (name in owner._given and name not in twin._given)


def is_composite(component: Component) -> bool:
    """A component that is written as its parts: an Assembly, or a class that is not known and has no equations."""
    known = _known_class(component)
    return known is Assembly or (
        known.__name__ not in catalogue.classes() and known.equations is Component.equations and bool(component.parts)
    )


def plain(value: Any, where: str) -> Any:
    """Numbers, text, lists and mappings, as YAML has them."""
    if isinstance(value, (np.ndarray, np.generic)):
        return value.tolist()
    if isinstance(value, (list, tuple)):
        return [plain(item, where) for item in value]
    if isinstance(value, Mapping):
        return {str(key): plain(item, where) for key, item in value.items()}
    if value is None or isinstance(value, (bool, int, float, str)):
        return value
    raise ModelFileError(f"{where} is a Python object ({type(value).__name__}), and a model file cannot say that.")


def _known_class(component: Component) -> type[Component]:
    return getattr(type(component), "file_base", type(component))


def _check_in_catalogue(component: Component, known: type[Component]) -> None:
    if catalogue.classes().get(known.__name__) is not known:
        raise ModelFileError(
            f"{component.label} is of the class {known.__name__}, which has equations and is not in the catalogue, "
            "so a model file cannot name it."
        )


def _same(a: Any, top_a: Component, b: Any, top_b: Component) -> bool:
    """Equal values; expressions are equal when they say the same of parameters at the same place."""
    if is_expression(a) != is_expression(b):
        return False
    if not is_expression(a):
        return bool(np.array_equal(np.asarray(a, dtype=object), np.asarray(b, dtype=object)))
    return _relative(a, top_a) == _relative(b, top_b)


def _changed(part: Component, twin: Component, top: Component, fresh_top: Component) -> list[str]:
    """The parameters that have another value than in the twin."""
    return [
        name
        for name, value in part._values.items()
        if name not in twin._values or not _same(value, top, twin._values[name], fresh_top)
    ]


def _class_name(known: type[Component]) -> str:
    """What a file calls a class: a kind of a family goes by the name of the family."""
    family = known.family
    return family.base.__name__ if family is not None and known in family.kinds.values() else known.__name__


def _parts_given(component: Component) -> dict[str, Component]:
    """Copies of the declared parts that were not made as declared, with the values that are their own: for a twin."""
    given: dict[str, Component] = {}
    for name, declared in _known_class(component).declared_parts.items():
        part = component.parts[name]
        own = {key: value for key, value in part._values.items() if not _depends_on(value, component)}
        structural = [key for key in own if key not in declared.modifiers and not part.parameters[key].tunable]
        if type(part) is not declared.component_class or structural:
            given[name] = type(part)(**_parts_given(part), **own)
    return given


def _depends_on(value: Any, owner: Component) -> bool:
    below = list(owner.walk())
    return any(isinstance(leaf, ParameterReference) and leaf.component in below for leaf in leaves(value))


def _set_by_owner(part: Component, twin: Component, top: Component, fresh_top: Component) -> list[str]:
    """The values that the owner sets while it is built: they depend on it, and the twin has them too."""
    changed = _changed(part, twin, top, fresh_top)
    return [name for name, value in part._values.items() if name not in changed and _depends_on(value, top)]


def _relative(value: Any, top: Component) -> str:
    """An expression as text, with paths that begin at `top`."""
    text, prefix = repr(value), top.path + "."
    return text.replace(prefix, "") if top.path else text


def _end(port: PortReference, owner: Component) -> str:
    prefix = owner.path + "." if owner.path else ""
    return port.path.removeprefix(prefix)


def _more_connections(component: Component, fresh: Component) -> list[Any]:
    """The connections that the class does not make by itself."""
    made = {frozenset((_end(a, fresh), _end(b, fresh))) for a, b, _ in fresh.connections}
    return [item for item in component.connections if frozenset(_end(end, component) for end in item[:2]) not in made]


def _filled(entries: dict[str, Any]) -> dict[str, Any]:
    return {key: value for key, value in entries.items() if not (key in ("parts", "connect") and not value)}
