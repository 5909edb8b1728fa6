"""Whether cases can be run, before any of them is: what the models say of their parameters, and impossible seas."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

from fowtlib.cases.case import Case
from fowtlib.cases.case_set import CaseSet
from fowtlib.cases.run_keys import CONDITIONS
from fowtlib.cases.values import as_quantity
from fowtlib.components.environment.waves import breaking_height, steepest_sea
from fowtlib.language import bounds
from fowtlib.language.component import Component
from fowtlib.language.declarations import SHAPES, Parameter
from fowtlib.language.errors import ModelError, ModelFileError, did_you_mean, one_of
from fowtlib.language.units import to_si
from fowtlib.modelfile.loading import load
from fowtlib.modelfile.paths import check_variable
from fowtlib.modelfile.short_forms import Condition
from fowtlib.solving.engines.base import SOLVERS
from fowtlib.solving.model import Model
from fowtlib.solving.paths import EVERY, meant, spread_out

SEA, REGULAR = "sea", "regular"
STATED = {REGULAR: ("wave_height", "wave_period"), "jonswap": ("significant_wave_height", "peak_period")}
"""Kinds of sea that are given height and period as numbers."""
HIGHEST = 0.78  # height of a wave over the depth above which it breaks (DNV-RP-C205, 3.4.6.1)


def check_cases(cases: CaseSet, load_model: Callable[[str], Model] = load) -> dict[str, Model]:
    """Refuse cases that cannot be run; gives the models by name.

    Each model is loaded once, and none is compiled. Raises ModelFileError with the place and the name of the first case
    that names what its model does not have, a value out of its bounds or of the wrong kind, an output or a solver that
    there is not, or a sea that cannot be: steeper than DNV-RP-C205 knows (unless its set says `steep_sea: allow`),
    breaking, or without what it needs.
    """
    checkers: dict[str, _Checker] = {}
    for case in cases:
        if case.model not in checkers:
            try:
                checkers[case.model] = _Checker(load_model(case.model))
            except ModelError as error:
                raise cases.place(case.name, "model").error(f"model: {error}") from None
        try:
            checkers[case.model].check(case, cases.steep)
        except _Wrong as wrong:
            raise cases.place(case.name, wrong.path).error(f"case '{case.name}': {wrong}") from None
    return {name: checker.model for name, checker in checkers.items()}


class _Wrong(Exception):
    """What is wrong, and the key or the path of the parameter."""

    def __init__(self, path: str, message: str):
        super().__init__(message)
        self.path = path


class _Checker:
    """Checks the cases of one model. Cases that differ in numbers only share the model with their parameters."""

    def __init__(self, model: Model):
        self.model = model
        self._changed: dict[str, Component] = {}
        self._outputs: set[str] = set(model.outputs)
        self._seas: dict[str, tuple[float, float]] = {}
        self._events = [f"{part.path}.{own}" for part in model.root.walk() for own in part.offered_events]

    def check(self, case: Case, steep: frozenset[str]) -> None:
        case = self._whole(case)
        root = self._root(case)
        for path, value in case.parameters.items():
            _check_value(root, path, value)
        for condition in CONDITIONS.values():
            _check_needs(root, condition)
        self._check_sea(root, case, case.name in steep)
        if case.solver is not None and case.solver not in SOLVERS:
            raise _Wrong("solver", f"solver: '{case.solver}' is not {one_of(SOLVERS)}.")
        for name in case.outputs or ():
            self._check_output(name)
        for event in case.events:
            self._check_event(event, case.duration)

    def _whole(self, case: Case) -> Case:
        """The case with parameters by whole paths, without stars."""
        for path in case.parameters:
            try:
                spread_out({path: 0}, self.model.root)
            except ModelError as error:
                raise _Wrong(path, str(error)) from None
        return replace(case, parameters=spread_out(case.parameters, self.model.root))

    def _root(self, case: Case) -> Component:
        """The parts with the parameters of a case, or of another one that differs from it in numbers only."""
        kind = {path: None if _is_number(value) else value for path, value in case.parameters.items()}
        key = json.dumps(kind, sort_keys=True)
        if key not in self._changed:
            for path in case.parameters:
                if _has(self.model.root, path):  # before anything is built with it
                    self._check_changeable(self.model.root, path)
            try:
                root = self.model.with_parameters(case.parameters).root if case.parameters else self.model.root
            except ModelError as error:
                message = str(error).removeprefix("set: ")
                raise _Wrong(_about(message, case.parameters), message) from None
            _check_void(root)
            for path in case.parameters:
                self._check_changeable(root, path)
            self._changed[key] = root
        return self._changed[key]

    def _check_changeable(self, root: Component, path: str) -> None:
        """Parameters with which a model is built are not those of a case."""
        owner, _, name = path.rpartition(".")
        part = root.find(owner)
        why = part.parameters[name].why_structural
        if why:
            raise _Wrong(path, f"{path} is structural ({why}), and all cases of a model are runs of one that is built; "
                               "set it in a model file of its own.")  # fmt: skip
        family = part.family
        if family is not None and name == family.selector and type(part) is not type(self.model.root.find(owner)):
            own = family.own_equations(type(part))
            if own:
                raise _Wrong(path, f"{path}: the kind '{part.parameter_value(name)}' has equations of its own ({own}); "
                                   "choose it in a model file of its own.")  # fmt: skip

    def _check_sea(self, root: Component, case: Case, steep: bool) -> None:
        """A sea that can be; what a kind of sea makes of wind and site, it says itself."""
        sea = root.parts.get(SEA)
        if sea is None or "world" not in root.parts:
            return
        kind = sea.parameter_value(CONDITIONS[SEA].selector)
        if kind in STATED:
            _check_sea(root, case.parameters, kind == REGULAR, steep)
            return
        made = next((name for name in ("wave", "state") if hasattr(sea, name)), None)
        if made is None:
            return
        parameters = {path: value for path, value in case.parameters.items()
                      if path.partition(".")[0] in CONDITIONS and not path.endswith(".seed")}  # fmt: skip
        key = json.dumps(parameters, sort_keys=True)
        if key not in self._seas:
            own = self.model.with_parameters(parameters).root.parts[SEA]
            try:
                self._seas[key] = getattr(own, made)()
            except ModelError as error:
                raise _Wrong(f"{SEA}.{CONDITIONS[SEA].selector}", str(error)) from None
        height, period = self._seas[key]
        _check_state(root, height, period, made == "wave", steep, f"{SEA}.{CONDITIONS[SEA].selector}")

    def _check_event(self, event: Mapping[str, Any], duration: float | None) -> None:
        """Some part offers the event, and it happens within the run."""
        name, known = str(event.get("event")), self._events
        fits = meant(name, known)
        if not fits:
            hint = did_you_mean(name, known) if known else ": no part of the model offers any."
            raise _Wrong("events", f"events: there is no event '{name}'{hint}")
        if len(fits) > 1 and EVERY not in name:
            raise _Wrong("events", f"events: '{name}' can happen at {len(fits)} places; say which: {', '.join(fits)}.")
        end = self.model.settings.get("duration") if duration is None else duration
        if isinstance(at := event.get("at"), (int, float)) and end is not None and at > float(end):
            raise _Wrong("events", f"events: '{name}' is to happen at {at:g} s, and the run ends at {float(end):g} s.")

    def _check_output(self, name: str) -> None:
        if name in self._outputs:
            return
        try:
            check_variable(self.model.root, name, _NoPlace(), "outputs")
        except ModelError as error:
            hint = did_you_mean(name, self.model.outputs, list_up_to=0)
            message = f"{error}" if hint == "." else f"outputs: there is no result '{name}'{hint}"
            raise _Wrong("outputs", message) from None
        self._outputs.add(name)


def _has(root: Component, path: str) -> bool:
    owner, _, name = path.rpartition(".")
    try:
        return name in root.find(owner).parameters
    except ModelError:
        return False


class _NoPlace:
    """Where an error is raised that gets its place later."""

    @staticmethod
    def error(message: str) -> ModelFileError:
        return ModelFileError(message)


def _about(message: str, parameters: Mapping[str, Any]) -> str:
    """The path of the parameter that a message begins with, the longest that does."""
    named = [path for path in parameters if re.match(rf"{re.escape(path)}\b", message)]
    if named:
        return max(named, key=len)
    unknown = re.search(r"has no (?:parameter|part) '([^']*)'", message)
    words = {unknown[1]} if unknown else set()
    return next((path for path in parameters if words & set(path.split("."))), "")


def _is_number(value: Any) -> bool:
    if isinstance(value, bool):
        return False
    return isinstance(value, (int, float)) or (isinstance(value, str) and as_quantity(value) is not None)


def _number(field: Parameter, path: str, value: Any) -> float:
    try:
        given = as_quantity(value) if isinstance(value, str) else None
        if not isinstance(value, str) or (given is not None and given.unit is None):
            bounds.refuse_turns(float(value), field.unit)
        return float(to_si(value, field.unit))
    except ModelError as error:
        raise _Wrong(path, f"{path}: {error}") from None


def _check_value(root: Component, path: str, value: Any) -> None:
    """A number is within the bounds of its parameter."""
    owner, _, name = path.rpartition(".")
    field = root.find(owner).parameters[name]
    if not _is_number(value) or field.annotation not in (*SHAPES, int, float):
        return
    number = _number(field, path, value)
    unit = "" if field.unit == "1" else f" {field.unit}"
    if field.annotation is int and not number.is_integer():
        raise _Wrong(path, f"{path}: got {number:g}; a whole number is expected ({field.doc}).")
    if not math.isfinite(number):
        raise _Wrong(path, f"{path} = {number:g} is not a finite number ({field.doc}).")
    found = bounds.outside(number, field.min, field.max, field.unit)
    if found:
        raise _Wrong(path, f"{path} = {number:g}{unit} is {found[1]} ({field.doc}).")
    if field.choices is not None and number not in field.choices:
        raise _Wrong(path, f"{path} = {number:g} is not {one_of(map(str, field.choices))} ({field.doc}).")


def _check_void(root: Component) -> None:
    """No value of wind or sea stands in the way of another one, or belongs to another kind."""
    for condition in CONDITIONS.values():
        part = root.parts.get(condition.part)
        try:
            if part is not None:
                part.refuse_void()
        except ModelError as error:
            raise _Wrong(f"{condition.part}.{condition.selector}", str(error)) from None


def _check_needs(root: Component, condition: Condition) -> None:
    """The kind of wind or sea has what it cannot do without."""
    part = root.parts.get(condition.part)
    if part is None or condition.selector not in part.parameters:
        return
    name = part.parameter_value(condition.selector)
    kind = condition.kinds.get(name)
    for key in kind.keys.values() if kind else ():
        if key.required and not (part.is_set(key.parameter) and part.parameter_value(key.parameter) not in (None, "")):
            path = f"{condition.part}.{key.parameter}"
            raise _Wrong(f"{condition.part}.{condition.selector}",
                         f"{path} has no value; {condition.part} '{name}' needs it.")  # fmt: skip


def _check_sea(root: Component, parameters: Mapping[str, Any], regular: bool, steep: bool) -> None:
    """A sea whose height and period are among the parameters, or are those of the model."""
    sea = root.parts[SEA]
    numbers = []
    for name in STATED[REGULAR if regular else "jonswap"]:
        given = parameters.get(f"{SEA}.{name}", sea.parameter_value(name))
        numbers.append(_number(sea.parameters[name], f"{SEA}.{name}", given))
    height, period = STATED[REGULAR if regular else "jonswap"]
    if numbers[1] <= 0:
        raise _Wrong(f"{SEA}.{period}", f"{SEA}.{period} is {numbers[1]:g} s; it must be above zero.")
    _check_state(root, numbers[0], numbers[1], regular, steep, f"{SEA}.{height}")


def _check_state(root: Component, height: float, period: float, regular: bool, steep: bool, path: str) -> None:
    depth, gravity = (float(root.parts["world"].parameter_value(name)) for name in ("water_depth", "gravity"))
    message = _impossible(height, period, depth, gravity, regular, steep)
    if message:
        raise _Wrong(path, message)


def _impossible(height: float, period: float, depth: float, gravity: float, regular: bool, steep: bool) -> str:
    """Why a sea cannot be; empty for one that can."""
    if height > HIGHEST * depth:
        return (
            f"waves of {height:.4g} m break in water {depth:.4g} m deep, where {HIGHEST:g} times the depth is the "
            "limit (DNV-RP-C205, 3.4.6)."
        )
    highest = breaking_height(period, depth, gravity) if regular else steepest_sea(period, gravity)
    if height <= highest:
        return ""
    if regular:
        return (
            f"a regular wave of {period:g} s breaks at {highest:.3g} m (Miche; DNV-RP-C205, 3.4.6), and this one has "
            f"{height:.4g} m; take a lower or a longer one."
        )
    if steep:
        return ""
    return (
        f"a sea of Hs {height:.4g} m and Tp {period:.4g} s is steeper than seas are: for this Tp Hs is at most "
        f"{highest:.3g} m (DNV-RP-C205, 3.5.4). Take a lower or a longer one, or, where it is known to occur, write "
        "'steep_sea: allow' in its set."
    )
