"""`load`: a model file, a shipped name or a component -> a Model."""

from __future__ import annotations

import copy
import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any

from fowtlib.language.component import Assembly, Component
from fowtlib.language.errors import NotFoundError, UnitError
from fowtlib.language.units import dimension, kind_of
from fowtlib.modelfile import document, files
from fowtlib.modelfile.assemble import TreeBuilder
from fowtlib.modelfile.nodes import Place, from_python
from fowtlib.modelfile.paths import check_variable
from fowtlib.modelfile.permit import permit_for
from fowtlib.modelfile.specs import OutputSpec, Spec, Value
from fowtlib.solving.model import Model, Output, known_of

Source = str | os.PathLike[str] | Component | Model
Settings = Mapping[str, Any]


def load(
    source: Source, *, set: Settings | None = None, allow_python: bool = False, trust: bool = False,
    allow: str | os.PathLike[str] | Sequence[str | os.PathLike[str]] = (),
) -> Model:  # fmt: skip
    """A model, from the name of a shipped one, the path of a model file, or a component composed in Python.

    set: values by path that replace those of the file before anything is built: {"sea.seed": 2, "hull.mass": "8 t"}.
    A component that is the root of a model has the outputs and settings of that model; any other one has none.
    allow_python: the file may name Python code of its own, which is then run.
    trust: native code that the file names (controller libraries, FMUs) may run; else a run needs leave given before.
    allow: folders in which the file may read data, beside its own and the shipped ones.
    A path in `set` is allowed, and trusted, by being there.
    Raises ModelFileError: the file and line, what is wrong, what to do.
    """
    values = dict(set or {})
    if isinstance(source, Model):
        return source.with_parameters(values) if values else source
    if isinstance(source, Component):
        return _from_component(source, values)
    path = files.find_model(source)
    top = document.read(path)
    permit = permit_for(path, files.models_folder(), allow, trust)
    builder = TreeBuilder(allow_python, permit)
    root = builder.root(top, _changes(values))
    if isinstance(root, Assembly):
        object.__setattr__(root, "title", top.title)

    def rebuild(more: Settings) -> Model:
        return load(path, set=_merged(root, values, more), allow_python=allow_python, trust=trust, allow=allow)

    outputs = {name: _output(root, name, spec) for name, spec in top.outputs.items()}
    model = Model(root, top.title, outputs, top.settings, path, path.stem, files=tuple(builder.files))
    return _changeable(model, rebuild)


def _changeable(model: Model, rebuild: Callable[[Settings], Model]) -> Model:
    """The model with a `rebuild` that builds it anew only where other parameters than those of its data change."""

    def changed(more: Settings) -> Model:
        if not more or not _are_data(model.root, more):
            return rebuild(more)
        root = copy.deepcopy(model.root)
        TreeBuilder().change(root, _changes(more))
        return _changeable(replace(model, root=root), lambda again: rebuild(_merged(root, more, again)))

    return replace(model, rebuild=changed)


def _merged(root: Component, earlier: Settings, later: Settings) -> dict[str, Any]:
    """Both, the later before the earlier; what the earlier say of a kind is left out where the later name another."""
    left_out = set()
    for path, kind in later.items():
        owner, _, name = path.rpartition(".")
        try:
            family = root.find(owner).family
        except NotFoundError:
            continue
        if family is not None and name == family.selector and kind != family.kind_of(type(root.find(owner))):
            left_out |= {f"{owner}.{own}" for own in family.parameters if own not in family.base.parameters}
    return {**{path: value for path, value in earlier.items() if path not in left_out}, **later}


def _are_data(root: Component, values: Settings) -> bool:
    """Whether all these values are of parts of a family, and do not change which equations a part has."""
    kinds: dict[str, type[Component]] = {}
    for path, value in values.items():
        owner, _, name = path.rpartition(".")
        try:
            part = root.find(owner)
        except NotFoundError:
            return False
        family = part.family
        if family is None or family.own_equations(type(part)):
            return False
        if name == family.selector:
            kinds[owner] = family.kinds.get(value if isinstance(value, str) else "", type(part))
        elif name not in family.parameters or not (family.parameters[name].bound or family.parameters[name].tunable):
            return False
    return not any(kind.family.own_equations(kind) for kind in kinds.values())


def _from_component(component: Component, values: Settings) -> Model:
    root = component
    if values:
        root = copy.deepcopy(component)
        TreeBuilder().change(root, _changes(values))

    def rebuild(more: Settings) -> Model:
        return _from_component(component, _merged(root, values, more))

    title, outputs, settings, name = known_of(component) or (
        getattr(component, "title", type(component).__name__), {}, {}, type(component).__name__.lower()
    )  # fmt: skip
    return _changeable(Model(root, title, outputs, settings, name=name), rebuild)


def _changes(values: Settings) -> Spec | None:
    """A specification with the given values, to be put on top of that of a file."""
    if not values:
        return None
    place = Place("set")
    top = Spec(place)
    for path, value in values.items():
        *owners, name = path.split(".")
        spec = top
        for owner in owners:
            spec = spec.parts.setdefault(owner, Spec(place))
        if not name:
            raise place.error(f"'{path}' is not the path of a parameter: a name, or names joined by dots.")
        spec.values[name] = Value(from_python(value, place))
    return top


def _output(root: Component, name: str, spec: OutputSpec) -> Output:
    where = f"output '{name}'"
    unit = check_variable(root, spec.of, spec.place, where)
    try:
        if spec.unit and unit and dimension(spec.unit) != dimension(unit):
            wanted = f"{kind_of(unit)} in {unit}"
            raise spec.place.error(f"{where}: '{spec.of}' is {wanted}, and cannot be given in '{spec.unit}'.")
    except UnitError as error:
        raise spec.place.error(f"{where}: {error}") from None
    return Output(spec.of, spec.unit or None, spec.description)


def models() -> dict[str, str]:
    """The shipped models: name and title."""
    return {name: document.read(path).title for name, path in files.shipped_models().items()}
