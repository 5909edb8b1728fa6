"""A whole model in another scale by Froude similarity: every quantity by its dimension, data sets by what they say.

Every parameter that has a value is multiplied by the factor of its declared unit (fowtlib.language.similarity);
elements with units of their own, as those of a 6 x 6 matrix, by theirs (`Component.units_within`); data by their
`in_similarity`. A formula goes on to hold, and what it gives is checked; where it has a number of its own in it, so
that it gives something else, the scaled value takes its place. Parameters of general blocks go by the units of the
signals that the block is connected to. Times and steps of the simulation, events and targets are scaled too.

What cannot be scaled is refused, with its path: files in their own units, controller libraries, turbulence of a
standard, whose lengths and speeds are those of full scale (`Component.in_own_units`).
"""

from __future__ import annotations

import copy
import inspect
import re
from collections.abc import Iterable, Mapping
from dataclasses import fields, is_dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from fowtlib.language.component import Component
from fowtlib.language.connectors import Signal
from fowtlib.language.declarations import SHAPES, Parameter, join
from fowtlib.language.errors import ModelError, ParameterError, UnusedParameterError
from fowtlib.language.expressions import is_expression
from fowtlib.language.similarity import Similarity
from fowtlib.language.units import quantity
from fowtlib.solving.model import Model
from fowtlib.solving.timeline import events_of

_TOLERANCE = 1e-9
_SOLVED = 1e-5  # of what a formula or a class finds by itself, as the operating point in a wind: it goes on to follow
_UNLIMITED = 1e29
_WORD = re.compile(r"[A-Za-z_]\w*")
_CONDITION = re.compile(r"\s*([^<>]+?)\s*([<>])\s*([^<>=]+?)\s*")


def scaled(
    model: Model, by: float, *, density_ratio: float = 1.0, wind_ratio: float = 1.0,
    units: Mapping[str, str] | None = None,
) -> Model:  # fmt: skip
    """The model in another scale: new = factor x old, lengths by ``by``, times by its square root.

    by             1/45 makes a tank model of a prototype, 45 the way back
    density_ratio  densities of the new over the old: 1000/1025 from sea water to fresh water
    wind_ratio     of wind speeds beyond sqrt(by), see Similarity.wind; rotors with tables over the tip speed ratio
                   refuse another one than 1
    units          units of signals or parameters that are declared without: {"drive.y": "N"} for the port of a block

    Raises ModelError: what cannot be scaled, with its path. A model with the statement `equilibrium` is solved first.
    """
    similarity = Similarity(float(by), float(density_ratio), float(wind_ratio))
    model = model.solved()
    wanted = _Wanted(model.root, similarity, dict(units or {}))
    root = copy.deepcopy(model.root)
    _give(root, wanted)
    return replace(
        model, root=root, settings=_settings(model, similarity), source=None, rebuild=None, files=(),
    )  # fmt: skip


def store_data(model: Model, path: str | Path) -> list[Path]:
    """Write the data sets that a model has as objects beside a file that is to be `path`, and let it name them.

    A model file names data by their files: fw.dump() refuses objects. The files are <stem>_<part>.nc or .csv.
    """
    path, written, known = Path(path), [], {}
    parts = list(model.root.walk())
    places = [(part.path, name) for part in parts for name, field in part.parameters.items()
              if field.is_data and _was_given(part, name)]  # fmt: skip
    for of, name in places:  # a part may be another one after its owner was given a file
        part = model.root.find(of) if of else model.root
        value = part.parameter_binding(name)
        ending = getattr(value, "ending", None)
        if ending is None:
            continue
        file = known.get(id(value))
        if file is None:
            file = path.with_name(f"{path.stem}_{join(of, name).replace('.', '_')}{ending}").absolute()
            value.write(file)
            known[id(value)] = file
            written.append(file)
        setattr(part, name, str(file))
    return written


class _Wanted:
    """What every parameter of a model shall be in another scale: path -> value."""

    def __init__(self, root: Component, similarity: Similarity, units: dict[str, str]):
        self.similarity, self.units, self.used = similarity, units, set[str]()
        self.signals = _signal_units(root, units, self.used)
        self.values: dict[str, Any] = {}
        self.objects: dict[int, Any] = {}
        for part in root.walk():
            _refuse(part)
            for name, field in part.parameters.items():
                if name not in part.void:
                    self._add(part, name, field)
        unknown = sorted(set(units) - self.used)
        if unknown:
            raise ParameterError(f"units: '{unknown[0]}' is no parameter or signal without a unit in this model.")

    def _add(self, part: Component, name: str, field: Parameter) -> None:
        path, value = join(part.path, name), part.parameter_binding(name)
        if value is None or isinstance(value, (bool, str)) and not field.is_data or field.annotation is int:
            return
        if field.is_data or hasattr(value, "in_similarity"):
            if value != "" and part.parameter_value(name) is not None:
                self.values[path] = self._data(part.parameter_value(name), value, path)
            return
        value = part.parameter_value(name)
        if value is None or isinstance(value, str):
            return
        if field.annotation in SHAPES or field.annotation is float:
            numbers = np.asarray(value, dtype=float)
            if numbers.any() and not self._follows(part, name):
                self.values[path] = numbers * self._factor(part, name, field, path)
        elif isinstance(value, list) and value and not all(isinstance(item, str) for item in value):
            self.values[path] = _times(value, float(self._factor(part, name, field, path)))
        elif isinstance(value, dict) and value:
            raise ParameterError(f"{path} has numbers whose units nobody knows, so the model cannot be scaled.")

    def _follows(self, part: Component, name: str) -> bool:
        """A formula in a general block whose signals nothing tells: what it is a formula of is scaled."""
        within = part.units_within.get(name)
        if not isinstance(within, str) or not is_expression(part.parameter_binding(name)):
            return False
        return any(self.signals.get((id(part), word)) is None for word in _WORD.findall(within) if word in part.ports)

    def _data(self, read: Any, given: Any, path: str) -> Any:
        if not hasattr(read, "in_similarity"):
            what = given if isinstance(given, str) else f"a {type(read).__name__}"
            raise ParameterError(f"{path}: {what} is data in their own units, so the model cannot be scaled.")
        if id(read) not in self.objects:
            try:
                other = read.in_similarity(self.similarity)
            except ParameterError as error:
                raise ParameterError(f"{path}: {error}") from None
            self.objects[id(read)] = given if other is read else other
        return self.objects[id(read)]

    def _factor(self, part: Component, name: str, field: Parameter, path: str) -> Any:
        """Number or array of the shape of the value."""
        if path in self.units:
            self.used.add(path)
            return self.similarity.factor(self.units[path])
        within = part.units_within.get(name)
        if inspect.isfunction(within):
            within = within(part)
        if within is None:
            if _is_general(part) and field.unit in ("1", ""):
                return 1.0
            if part.of_the_air and field.unit == "m/s":
                return self.similarity.wind_speed
            return self.similarity.factor(field.unit)
        if not isinstance(within, str):
            one = np.vectorize(self._of_air if part.of_the_air else self.similarity.factor, otypes=[float])
            return one(np.asarray(within))
        return self._of_signals(part, name, within, field, path)

    def _of_air(self, unit: str) -> float:
        return self.similarity.wind_speed if unit == "m/s" else self.similarity.factor(unit)

    def _of_signals(self, part: Component, name: str, within: str, field: Parameter, path: str) -> float:
        """The factor of a unit in terms of the signals of a general block, "y/u": of its declared unit besides."""
        factor = self.similarity.factor(field.unit)
        ports = [word for word in _WORD.findall(within) if word in part.ports]
        unknown = [word for word in ports if self.signals.get((id(part), word)) is None]
        if unknown:
            value = np.abs(part.parameter_value(name))
            if not part.is_set(name) and within == "y/u":
                return 1.0  # a filter or a derivative, whose gain is 1: that tells the unit of y
            if not part.is_set(name) and np.all(value >= _UNLIMITED):
                return factor  # a limit that is not there
            raise ParameterError(
                f"{path} is in the unit of the signal {join(part.path, unknown[0])}, which nothing says; "
                f"give it: units={{'{join(part.path, unknown[0])}': 'N'}}, for example."
            )
        text = _WORD.sub(lambda found: f"({self.signals.get((id(part), found[0])) or found[0]})", within)
        return factor * self.similarity.factor(text)


_SCALES = {"wind": "--wind steady:12", "sea": "--waves jonswap:Hs=6,Tp=10"}  # what can be scaled


def _refuse(part: Component) -> None:
    """What a part says of itself that has its own units."""
    for name, what in part.in_own_units.items():
        if not name or part.parameter_value(name):
            shown = part.path if not name else f"{join(part.path, name)} = {part.parameter_value(name)!r}"
            other = f" Another kind may do, such as {_SCALES[part.path]}." if part.path in _SCALES else ""
            raise ParameterError(f"{shown}: {what}, so the model cannot be scaled.{other}")


def _is_general(part: Component) -> bool:
    """A block whose signals are declared without units: they are those of what it is connected to."""
    signals = [field for field in part.ports.values() if issubclass(field.annotation, Signal)]
    return bool(signals) and len(signals) == len(part.ports) and all(field.unit == "1" for field in signals)


def _signal_units(root: Component, units: Mapping[str, str], used: set[str]) -> dict[tuple[int, str], str | None]:
    """Unit of every signal by component and port: that of anything it is joined to which declares one."""
    leader: dict[tuple[int, str], tuple[int, str]] = {}

    def find(key: tuple[int, str]) -> tuple[int, str]:
        while leader.setdefault(key, key) != key:
            key = leader[key]
        return key

    known: dict[tuple[int, str], str] = {}
    for part in root.walk():
        for a, b, _ in part.connections:
            ends = [end for end in (a, b) if issubclass(end.field.annotation, Signal)]
            if len(ends) == 2:
                leader[find((id(a.component.current), a.field.name))] = find((id(b.component.current), b.field.name))
    for part in root.walk():
        for name, field in part.ports.items():
            if issubclass(field.annotation, Signal):
                path, key = join(part.path, name), (id(part), name)
                if path in units:
                    used.add(path)
                    known[find(key)] = units[path]
                elif not _is_general(part):
                    known.setdefault(find(key), field.unit or "1")
    return {key: known.get(find(key)) for key in list(leader) + [
        (id(part), name) for part in root.walk() for name in part.ports
    ]}  # fmt: skip


def _give(root: Component, wanted: _Wanted) -> None:
    """Set what was given, from the top down, and then what does not follow from it.

    On the way a model is half in one scale and half in the other, and a part may refuse that; it is asked again.
    """
    given = [(part.path, name) for part in root.walk() for name in part.parameters
             if join(part.path, name) in wanted.values and _was_given(part, name)]  # fmt: skip
    while given:
        left = _set_by_part(root, given, wanted.values)  # as the heights of a tower and its nodes, which go together
        refused = _set(root, left, wanted.values)
        if len(refused) == len(given):
            raise next(iter(refused.values()))
        given = list(refused)
    tried = set[tuple[str, str]]()
    while wrong := _different(root, wanted.values):
        places = [place for place, error in wrong.items() if error is None and place not in tried]
        if not places:
            break
        first = min(_order(root, place) for place in places)
        now = [place for place in places if _order(root, place) == first]
        tried |= set(now)
        refused = _set(root, now, wanted.values)
        for path, name in [place for place, error in refused.items() if isinstance(error, UnusedParameterError)]:
            del wanted.values[join(path, name)]  # it does nothing in this model, in either scale
    if wrong:
        (path, name), error = next(iter(wrong.items()))
        where = join(path, name)
        told = error or f"what the model is made of gives {root.find(path).parameter_value(name)}."
        raise ParameterError(f"{where} cannot be given its scaled value {wanted.values[where]}: {told}")


def _order(root: Component, place: tuple[str, str]) -> tuple[bool, bool, bool, int]:
    """Numbers before formulas, which may follow from them, and before what a class computes; owners before parts."""
    path, name = place
    part = root.find(path)
    formula = is_expression(part.parameter_binding(name))
    return _is_computed(part, name), formula, _is_made(part), path.count(".") + bool(path)


def _is_computed(part: Component, name: str) -> bool:
    """A default that is a function of the component: it may ask any other part."""
    return not part.is_set(name) and inspect.isfunction(part.parameters[name].default)


def _set(root: Component, places: Iterable[tuple[str, str]], values: Mapping[str, Any]) -> dict[Any, ModelError]:
    """Give values to parameters; those that a part refuses now, and why."""
    refused = {}
    for path, name in places:
        value = values[join(path, name)]
        try:
            setattr(root.find(path), name, _plain(value))
        except ModelError as error:
            refused[path, name] = error
    return refused


def _set_by_part(
    root: Component, places: Iterable[tuple[str, str]], values: Mapping[str, Any]
) -> list[tuple[str, str]]:
    """Give values to all parameters of a part at once; those of parts that refuse that now."""
    of_parts: dict[str, list[str]] = {}
    for path, name in places:
        of_parts.setdefault(path, []).append(name)
    left = []
    for path, names in of_parts.items():
        try:
            root.find(path).set_together({name: _plain(values[join(path, name)]) for name in names})
        except ModelError:
            left += [(path, name) for name in names]
    return left


def _plain(value: Any) -> Any:
    return value.tolist() if isinstance(value, np.ndarray) else value


def _different(root: Component, values: Mapping[str, Any]) -> dict[tuple[str, str], ModelError | None]:
    """The parameters that have not their value yet, parents first; with the error where they have none now."""
    found: dict[tuple[str, str], ModelError | None] = {}
    for part in root.walk():
        for name, field in part.parameters.items():
            wanted = values.get(join(part.path, name))
            if wanted is None:
                continue
            try:
                now = part.parameter_binding(name)
                if field.is_data or hasattr(wanted, "in_similarity"):
                    if not _same_data(now, wanted):
                        found[part.path, name] = None
                    continue
                now = part.parameter_value(name)
            except ModelError as error:
                found[part.path, name] = error
                continue
            solved = not part.is_set(name) or is_expression(part.parameter_binding(name))
            if now is None or not _close(now, wanted, _SOLVED if solved else _TOLERANCE):
                found[part.path, name] = None
    return found


def _same_data(now: Any, wanted: Any) -> bool:
    """The same object or file, or one that an owner made anew with the same numbers."""
    if now is wanted or isinstance(now, str):
        return bool(now is wanted or now == wanted)
    if type(now) is not type(wanted) or not is_dataclass(now):
        return False
    pairs = [(getattr(now, field.name), getattr(wanted, field.name)) for field in fields(now)]
    words = (str, dict, list, tuple, type(None))
    return all(one == other if isinstance(one, words) or other is None else _close(one, other) for one, other in pairs)


def _close(now: Any, wanted: Any, tolerance: float = _TOLERANCE) -> bool:
    one, other = np.asarray(now, dtype=float), np.asarray(wanted, dtype=float)
    if one.shape != other.shape:
        return False
    size = float(np.abs(other).max(initial=0.0))
    return bool(np.allclose(one, other, rtol=tolerance, atol=tolerance * size * 1e-3))


def _was_given(part: Component, name: str) -> bool:
    """A number that somebody gave: not a formula, and not what an owner gives to the part that it makes."""
    if not part.is_set(name) or is_expression(part.parameter_binding(name)):
        return False
    return not _is_made(part) or name in part._later


def _is_made(part: Component) -> bool:
    """Whether the class of its owner makes it, or makes what it is in."""
    owner = part._parent
    if owner is None:
        return False
    return (part._name not in owner._added and part._name not in owner._given) or _is_made(owner)


def _times(value: Any, factor: float) -> Any:
    return [_times(item, factor) for item in value] if isinstance(value, list) else value * factor


def _settings(model: Model, similarity: Similarity) -> dict[str, Any]:
    """Times of the simulation, and the events, in the other scale."""
    settings = dict(model.settings)
    for name in ("duration", "output_step", "step"):
        if settings.get(name) is not None:
            settings[name] = settings[name] * similarity.factor("s")
    if "events" in settings:
        settings["events"] = tuple(_event(event, model, similarity) for event in events_of(settings["events"]))
    return settings


def _event(event: Any, model: Model, similarity: Similarity) -> Any:
    at = None if event.at is None else event.at * similarity.factor("s")
    when = event.when
    if when is not None:
        found = _CONDITION.fullmatch(when)
        given = quantity(found[3]) if found else None
        if found is None or given is None:
            raise ParameterError(f"the event '{event.what}' when {when} cannot be scaled: write its value with a unit.")
        unit = given[1] or _unit_of(found[1], model)
        when = f"{found[1]} {found[2]} {given[0] * similarity.factor(unit):.15g} {given[1]}".rstrip()
    values = {name: _in_unit(name, value, event, similarity) for name, value in event.values.items()}
    return replace(event, at=at, when=when, values=values)


def _in_unit(name: str, value: Any, event: Any, similarity: Similarity) -> Any:
    given = quantity(value) if isinstance(value, str) else None
    if given is None or not given[1]:
        raise ParameterError(f"the event '{event.what}': {name} = {value!r} can be scaled with a unit only; give one.")
    return f"{given[0] * similarity.factor(given[1]):.15g} {given[1]}"


def _unit_of(name: str, model: Model) -> str:
    """Unit of a result or variable; of an output without one that of its variable."""
    output = model.outputs.get(name)
    if output is not None and getattr(output, "unit", None):
        return output.unit
    path = getattr(output, "of", name)
    owner, _, last = path.partition("[")[0].rpartition(".")
    part = model.root.find(owner)
    field = part.variables.get(last) or part.ports.get(last)
    if field is None:
        raise ModelError(f"the event's condition on '{name}' cannot be scaled: give its value with a unit.")
    return field.unit or "1"
