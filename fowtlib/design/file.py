"""`read_design`: a design as a file, with the line in every error. Its layout: docs/design.md."""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from fowtlib.analysis.fatigue.curves import sn_curve
from fowtlib.design.design import SLOPES, Design
from fowtlib.design.file_functions import read_functions
from fowtlib.design.measures import Statistics
from fowtlib.design.optimisers import METHODS
from fowtlib.design.terms import ALONE, Constraint, DesignCase, Objective
from fowtlib.design.variables import Space, Variable
from fowtlib.language.data_files import require_file
from fowtlib.language.errors import ModelError, ModelFileError, did_you_mean, one_of
from fowtlib.language.units import to_si
from fowtlib.modelfile import files, load
from fowtlib.modelfile.nodes import Node, Place, parse, read_text
from fowtlib.modelfile.permit import permit_for
from fowtlib.modelfile.short_forms import WAVES, WIND
from fowtlib.modelfile.specs import as_list, check_keys, check_version, mapping, text

VERSION = 1
KEY = "fowtlib_design"
FIRST_LINE = f"a design file begins with '{KEY}: {VERSION}'"
TOP_KEYS = (KEY, "title", "description", "model", "set", "variables", "objective", "constraints", "functions", "cases",
            "free", "targets", "balance", "statistics", "optimiser")  # fmt: skip
VARIABLE_KEYS = ("drives", "lower", "upper", "start", "points", "along", "degree", "scale", "unit")
CONSTRAINT_KEYS = ("result", "lower", "upper", "cases", "aggregate", "sharpness", "scale", "name")
CASE_KEYS = ("parameters", "wind", "waves", "weight", "model", "set")
STATISTIC_KEYS = ("duration", "quantile", "exponent", "lifetime", "curve", "environment", "tolerance")
OPTIMISER_KEYS = ("method", "starts", "seed", "tolerance", "iterations", "slopes")
DESIGNS = "designs"

Loader = Callable[[Path], Any]


@dataclass(frozen=True, eq=False)
class DesignFile:
    """A design that was read; optimiser: keywords of Design.optimise that the file has."""

    path: Path
    design: Design
    optimiser: Mapping[str, Any]
    top: Node = field(repr=False)

    def located(self, error: ModelError) -> ModelError:
        """The error with the line of what it is about, where it names something of the file."""
        return _located(error, self.top)


def shipped_designs() -> dict[str, Path]:
    """The shipped design files by name."""
    return {path.stem: path for path in sorted((files.models_folder() / DESIGNS).glob("*.yaml"))}


def find_design(source: str | os.PathLike[str]) -> Path:
    """The design file for a path or a shipped name."""
    path = Path(source)
    if files.is_file(path):
        require_file(path, ModelFileError)
        return path
    shipped = shipped_designs()
    if str(source) in shipped:
        return shipped[str(source)]
    if path.suffix in (".yaml", ".yml") or len(path.parts) > 1:
        here = [item.name for item in sorted(path.parent.glob("*.y*ml"))] if path.parent.is_dir() else []
        raise files.no_file(source, here)
    raise ModelFileError(f"there is no design '{source}', nor a file of that name{did_you_mean(str(source), shipped)}")


def read_design(source: str | os.PathLike[str], *, load_model: Loader | None = None) -> DesignFile:
    """The design of a file, or of a shipped name; load_model: in place of `fw.load`.

    The model is loaded and compiled. Raises ModelFileError: the file and line, what is wrong, what to do.
    """
    return _File(find_design(source), load_model or load).read()


class _File:
    """Reads one file."""

    def __init__(self, path: Path, load_model: Loader):
        self.path, self.load = path, load_model
        name = files.shown(path)
        self.top = parse(read_text(path, name), name, FIRST_LINE)
        self.items = mapping(self.top, f"{FIRST_LINE}, and is a mapping")
        check_version(self.items, self.top.place, KEY, VERSION, FIRST_LINE)
        check_keys(self.items, TOP_KEYS, "a design file")

    def read(self) -> DesignFile:
        for key in ("variables", "objective"):
            if key not in self.items:
                raise self.top.place.error(f"the key '{key}' is missing.")
        optimiser = self._optimiser()
        slopes = optimiser.pop("slopes", SLOPES[0])
        model = self._model()
        plant = model.compile() if model is not None else None
        variables = self._variables(plant)
        functions = read_functions(self.items.get("functions"))
        try:
            design = Design(
                plant, variables, self._objective(), self._constraints(), self._cases(model), functions,
                self._free(), self._mapping("targets"), text(self.items, "balance") or None, self._statistics(),
                slopes, title=self._title(plant),
            )  # fmt: skip
            _ = design.space, design.keys
        except ModelError as error:
            raise _located(error, self.top) from None
        return DesignFile(self.path, design, optimiser, self.top)

    def _title(self, plant: Any) -> str:
        return text(self.items, "title") or getattr(plant, "title", "") or self.path.stem

    def _model(self) -> Any:
        if "model" not in self.items:
            for key in ("set", "cases", "free", "targets", "balance"):
                if key in self.items:
                    raise self.items[key].place.error(f"'{key}' is of a model, and the file names none.")
            return None
        return self._named(self.items)

    def _named(self, items: Mapping[str, Node]) -> Any:
        """The model that the key 'model' names, with the values of the key 'set' beside it."""
        model, given = self._loaded(items), self._mapping("set", items)
        try:
            return model.with_parameters(given) if given else model
        except ModelError as error:
            raise _at(_located(error, items["set"]), items["set"]) from None

    def _loaded(self, items: Mapping[str, Node]) -> Any:
        node, name = items["model"], text(items, "model")
        try:
            permit = permit_for(self.path, files.models_folder(), (), trust=False)
            beside = files.data_place(name, self.path.absolute().parent, permit) if name.endswith(".yaml") else None
            return self.load(beside if beside is not None and files.is_file(beside) else name)
        except ModelError as error:
            raise _at(error, node) from None

    def _mapping(self, key: str, items: Mapping[str, Node] | None = None) -> dict[str, Any]:
        items = self.items if items is None else items
        if key not in items:
            return {}
        nodes = mapping(items[key], f"'{key}' is a mapping of names and values")
        return {name: node.plain() for name, node in nodes.items()}

    def _free(self) -> Any:
        node = self.items.get("free")
        if node is None:
            return ()
        return node.plain() if isinstance(node.value, dict) else [str(item.plain()) for item in as_list(node)]

    def _variables(self, plant: Any) -> list[Variable]:
        nodes = mapping(self.items["variables"], "'variables' is a mapping of names")
        if not nodes:
            raise self.items["variables"].place.error("'variables' is empty: nothing may change.")
        found = []
        for name, node in nodes.items():
            items = mapping(node, f"'{name}' is a mapping, such as {{lower: 8 m, upper: 12 m}}")
            check_keys(items, VARIABLE_KEYS, "a variable")
            for key in ("lower", "upper"):
                if key not in items:
                    raise node.place.error(f"the variable '{name}' has no '{key}' bound.")
            given = {key: item.plain() for key, item in items.items()}
            for key in ("points", "degree"):
                if key in items and not (isinstance(given[key], int) and given[key] > 0):
                    raise items[key].place.error(f"'{key}' is a whole number above zero, not {given[key]!r}.")
            variable = Variable(name, **{key: tuple(v) if isinstance(v, list) else v for key, v in given.items()})
            try:
                Space.of([variable], plant)
            except ModelError as error:
                raise _at(error, node) from None
            found.append(variable)
        return found

    def _objective(self) -> Objective:
        node = self.items["objective"]
        if isinstance(node.value, str):
            return Objective.read(node.value)
        terms = mapping(node, "'objective' is the name of a result, or results with their factors")
        for name, item in terms.items():
            if isinstance(item.value, bool) or not isinstance(item.value, (int, float)):
                raise item.place.error(f"the factor of '{name}' in the objective is a number, not {item.kind}.")
        return Objective({name: float(item.value) for name, item in terms.items()})

    def _constraints(self) -> list[Constraint]:
        found = []
        for node in as_list(self.items["constraints"]) if "constraints" in self.items else ():
            try:
                if isinstance(node.value, str):
                    found.append(Constraint.read(node.value))
                    continue
                items = mapping(node, "a constraint is a text, as in 'pitch < 5 deg', or a mapping with 'result'")
                check_keys(items, CONSTRAINT_KEYS, "a constraint")
                if "result" not in items:
                    raise node.place.error("the constraint has no 'result'.")
                given = {key: item.plain() for key, item in items.items()}
                if "cases" in given:
                    given["cases"] = tuple(str(item.plain()) for item in as_list(items["cases"]))
                for key in ("sharpness", "scale"):
                    if key in given and (isinstance(given[key], bool) or not isinstance(given[key], (int, float))):
                        raise items[key].place.error(f"'{key}' is a number, not {items[key].kind}.")
                found.append(Constraint(**given))
            except ModelError as error:
                raise _at(error, node) from None
        return found

    def _cases(self, model: Any) -> list[DesignCase]:
        if "cases" not in self.items:
            return [ALONE]
        found, others = [], dict[str, Any]()
        for name, node in mapping(self.items["cases"], "'cases' is a mapping of names").items():
            items = {} if node.value is None else mapping(node, f"the case '{name}' is a mapping")
            check_keys(items, CASE_KEYS, "a case")
            parameters: dict[str, Any] = {}
            other = None
            if "model" in items:
                named = f"{text(items, 'model')} {self._mapping('set', items)}"
                other = others[named] = others[named] if named in others else self._named(items).compile()
            elif "set" in items:
                raise items["set"].place.error("'set' is of a model, and the case names none; take 'parameters'.")
            for key, condition in (("wind", WIND), ("waves", WAVES)):
                if key in items:
                    if condition.part not in (other or model).root.parts:
                        raise items[key].place.error(f"'{key}': the model has no part '{condition.part}'.")
                    try:
                        parameters |= condition.parse(text(items, key), self.path.absolute().parent)
                    except ModelError as error:
                        raise items[key].place.error(str(error).replace("--", "")) from None
            if "parameters" in items:
                nodes = mapping(items["parameters"], "'parameters' is a mapping of paths and values")
                parameters |= {path: item.plain() for path, item in nodes.items()}
            weight = items["weight"].plain() if "weight" in items else 1.0
            if isinstance(weight, bool) or not isinstance(weight, (int, float)) or weight < 0:
                raise items["weight"].place.error(f"the weight of a case is zero or more, not {weight!r}.")
            found.append(DesignCase(name, parameters, float(weight), other))
        return found

    def _statistics(self) -> Statistics:
        if "statistics" not in self.items:
            return Statistics()
        items = mapping(self.items["statistics"], "'statistics' is a mapping")
        check_keys(items, STATISTIC_KEYS, "'statistics'")
        given: dict[str, Any] = {}
        for key, unit in (
            ("duration", "s"),
            ("quantile", "1"),
            ("exponent", "1"),
            ("lifetime", "s"),
            ("tolerance", "1"),
        ):
            if key in items:
                try:
                    given[key] = float(to_si(items[key].plain(), unit, key))
                except (ModelError, TypeError, ValueError) as error:
                    raise items[key].place.error(str(error)) from None
        if "environment" in items and "curve" not in items:
            raise items["environment"].place.error("'environment' is of an S-N curve, and there is no 'curve'.")
        if "curve" in items:
            try:
                given["curve"] = sn_curve(text(items, "curve"), text(items, "environment") or "air")
            except ModelError as error:
                raise items["curve"].place.error(str(error)) from None
        try:
            return Statistics(**given)
        except ModelError as error:
            at = items.get(str(error).partition(":")[0], self.items["statistics"])
            raise at.place.error(str(error)) from None

    def _optimiser(self) -> dict[str, Any]:
        if "optimiser" not in self.items:
            return {}
        items = mapping(self.items["optimiser"], "'optimiser' is a mapping")
        check_keys(items, OPTIMISER_KEYS, "'optimiser'")
        given = {key: node.plain() for key, node in items.items()}
        if "method" in given and given["method"] not in METHODS:
            raise items["method"].place.error(
                f"there is no optimiser '{given['method']}'{did_you_mean(str(given['method']), METHODS)}"
            )
        if given.get("slopes", SLOPES[0]) not in SLOPES:
            raise items["slopes"].place.error(f"slopes are by {one_of(SLOPES)}, not by '{given['slopes']}'.")
        for key in ("starts", "seed", "iterations"):
            if key in given and (isinstance(given[key], bool) or not isinstance(given[key], int) or given[key] < 0):
                raise items[key].place.error(f"'{key}' is a whole number, not {given[key]!r}.")
        if "tolerance" in given and not (isinstance(given["tolerance"], float) and given["tolerance"] > 0):
            raise items["tolerance"].place.error(f"'tolerance' is above zero, not {given['tolerance']!r}.")
        return given


def _at(error: ModelError, node: Node) -> ModelError:
    """The error with the line of a node, unless it has one already."""
    return error if re.search(r":\d", error.where) else node.place.error(str(error))


def _located(error: ModelError, top: Node) -> ModelError:
    """The error with the place of the first thing of the file that it names between quotes, or as a whole word."""
    if re.search(r":\d", error.where):
        return error
    message = str(error)
    names = [*re.findall(r"'([^']+)'", message), *(word for word in re.findall(r"[\w.\[\]]+", message) if "." in word)]
    for name in names:
        for words, place in _words(top):
            if words == name or re.search(rf"(?<![\w.]){re.escape(name)}(?![\w.])", words):
                return ModelFileError(message, where=str(place))
    return error


def _words(node: Node) -> Iterator[tuple[str, Place]]:
    """Keys and texts below a node, with their places."""
    for inner in node.walk():
        if isinstance(inner.value, dict):
            yield from ((key, item.place) for key, item in inner.value.items())
        elif isinstance(inner.value, str):
            yield inner.value, inner.place
