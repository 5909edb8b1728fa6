"""`read_cases`: a file of load cases, with the line in every error.

A file holds `sets`; each is a product of what varies, and every row of it a `Case`. Its layout: docs/cases.md.
"""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path

from fowtlib.cases import conditional, lists, weights
from fowtlib.cases.case import Case
from fowtlib.cases.case_set import CaseSet
from fowtlib.cases.conditional import Distribution, Opener, Source
from fowtlib.cases.folder import Allowed, folder_of
from fowtlib.cases.lists import MOST_CASES, variable
from fowtlib.cases.names import Register
from fowtlib.cases.run_keys import RUN_KEYS, Layers, RunKeys
from fowtlib.cases.scope import SEED_NAMES, Scope, seeds_of
from fowtlib.cases.values import Item, scalar, word
from fowtlib.language.data_files import require_file
from fowtlib.language.errors import ModelFileError, did_you_mean
from fowtlib.modelfile import files
from fowtlib.modelfile.nodes import Node, Place, parse, read_text
from fowtlib.modelfile.specs import as_list, check_keys, check_version, mapping, text

VERSION = 1
KEY = "fowtlib_cases"
FIRST_LINE = f"a cases file begins with '{KEY}: {VERSION}'"
TOP_KEYS = (KEY, "title", "description", "model", "variables", "tables", "distributions", "defaults", "sets")
DEFAULT_KEYS = (*RUN_KEYS, "name", "seeds", "look_up", "values", "weight", "safety_factor", "steep_sea")
SET_KEYS = ("group", "vary", "weights", *DEFAULT_KEYS)
MOST_SEEDS = 10_000


def read_cases(
    path: str | os.PathLike[str],
    *,
    distributions: Mapping[str, Distribution] | None = None,
    open_distribution: Opener | None = None,
    text: str | None = None,
    allow: Allowed = (),
) -> CaseSet:
    """The cases of a file.

    distributions: joint distributions of wind and waves by the name under which the file looks them up, in place of
    those of its key `distributions`; open_distribution(site, height) makes those that this key describes.
    text: what is to be written into the file, to be read before it is.
    allow: folders in which the file may name models and data, beside its own and the shipped ones.
    Nothing is loaded and nothing runs: what the models say of the cases, `check_cases` finds.
    Raises ModelFileError: the file and line, what is wrong, what to do.
    """
    given = Path(path)
    require_file(given, ModelFileError)
    if text is None and not files.is_file(given):
        raise files.no_file(path)
    return _File(given, text, distributions or {}, open_distribution, allow).cases()


class _File:
    """Reads one file."""

    def __init__(
        self, path: Path, content: str | None, distributions: Mapping[str, Distribution], opened: Opener | None,
        allow: Allowed,
    ):  # fmt: skip
        self.path, self.folder = path, folder_of(path, allow)
        name = files.shown(path)
        self.top = parse(read_text(path, name) if content is None else content, name, FIRST_LINE)
        self.items = mapping(self.top, f"{FIRST_LINE}, and is a mapping")
        check_version(self.items, self.top.place, KEY, VERSION, FIRST_LINE)
        check_keys(self.items, TOP_KEYS, "a cases file")
        self.files: list[Path] = [path.resolve()]
        self.run_keys = RunKeys(self.folder)
        self.register = Register()
        self.used: set[str] = set()
        self.variables = self._variables()
        self.sources = self._sources(distributions, opened)
        self.defaults = self._defaults()

    def cases(self) -> CaseSet:
        """All cases; what nobody uses is refused."""
        if "sets" not in self.items:
            raise self.top.place.error("the key 'sets' is missing: a list of sets of cases.")
        made: list[Case] = []
        places: dict[str, Mapping[str, Place]] = {}
        steep: set[str] = set()
        nodes = as_list(self.items["sets"])
        if not nodes:
            raise self.items["sets"].place.error("'sets' is empty: there is no case.")
        for number, node in enumerate(nodes, start=1):
            items = mapping(node, "a set of cases is a mapping, with 'vary' for what varies in it")
            check_keys(items, SET_KEYS, "a set of cases")
            for case, where, allowed in _Set(self, items, node.place, number).cases(len(made)):
                made.append(case)
                places[case.name] = where
                steep |= {case.name} if allowed else set()
        self._check_used()
        found = dict.fromkeys([*self.files, *self.run_keys.files])
        title = text(self.items, "title") or self.path.stem
        return CaseSet(self.path, title, tuple(made), tuple(found), places, frozenset(steep))

    def _variables(self) -> dict[str, Item]:
        if "variables" not in self.items:
            return {}
        nodes = mapping(self.items["variables"], "'variables' is a mapping of names and values")
        for name, node in nodes.items():
            variable(name, node.place)
        scope = Scope(self.top.place, {}, nodes)
        return {name: scope.item(name) for name in nodes}

    def _sources(self, given: Mapping[str, Distribution], opened: Opener | None) -> dict[str, Source]:
        found: dict[str, Source] = {name: conditional.Joint(name, item) for name, item in given.items()}
        scope = Scope(self.top.place, self.variables, used=self.used)
        for key in ("tables", "distributions"):
            for name, node in mapping(self.items[key], f"'{key}' is a mapping").items() if key in self.items else ():
                if name in found and name not in given:
                    raise node.place.error(f"'{name}' is the name of a table and of a distribution.")
                if key == "tables":
                    found[name] = conditional.table(name, node, scope, self.folder, self.files)
                elif name not in given:
                    found[name] = conditional.joint(name, node, scope, self.folder, self.files, opened)
        return found

    def _defaults(self) -> dict[str, Node]:
        items: dict[str, Node] = {}
        if "defaults" in self.items:
            items |= mapping(self.items["defaults"], "'defaults' is a mapping with keys of a set")
            check_keys(items, DEFAULT_KEYS, "'defaults'")
        if "model" in self.items:
            if "model" in items:
                raise items["model"].place.error("the model is given twice: at the top and in 'defaults'.")
            items["model"] = self.items["model"]
        return items

    def _check_used(self) -> None:
        for key in ("variables", "tables", "distributions"):
            for name, node in mapping(self.items[key], "").items() if key in self.items else ():
                if name not in self.used:
                    what = {"variables": "variable", "tables": "table", "distributions": "distribution"}[key]
                    raise node.place.error(f"nothing uses the {what} '{name}'.")


class _Set:
    """Reads one set of a file."""

    def __init__(self, file: _File, items: dict[str, Node], place: Place, number: int):
        self.file, self.items, self.place, self.number = file, items, place, number
        self.layers: Layers = (file.defaults, items)
        self.given = {**file.defaults, **items}
        self.group = text(items, "group")
        self.values = {**_mapping(file.defaults, "values"), **_mapping(items, "values")}
        self.outer = Scope(place, file.variables, used=file.used)  # what is the same in all cases of the set
        self.product = lists.product(items.get("vary"), self.outer, file.folder, file.files)
        self.seeds = self._seeds()
        self.sources = self._look_up()
        self._check_names()
        self.count = self.product.size * (self.seeds or 1)

    def cases(self, before: int) -> Iterator[tuple[Case, Mapping[str, Place], bool]]:
        """Each case, where its values stand, and whether its sea may be steep."""
        if "model" not in self.given:
            raise self.place.error("the set has no model; give 'model' at the top of the file, or here.")
        if before + self.count > MOST_CASES:
            raise self.place.error(
                f"with this set of {self.count} cases the file has {before + self.count}; the limit is {MOST_CASES}."
            )
        rows = [{**row, **seeds} for row in self.product for seeds in self._realisations(row)]
        scopes = [Scope(self.place, {**self.file.variables, **row}, self.values, self.sources) for row in rows]
        made = [self._case(scope, row) for scope, row in zip(scopes, rows, strict=True)]
        shares = self._weights(rows, [case.weight for case, _, _ in made], scopes)
        used = set().union(*(scope.used for scope in scopes))
        self._check_used(used)
        shared: dict[str, Place] = made[0][1] if made else {}
        for (case, places, steep), scope, row, weight in zip(made, scopes, rows, shares, strict=True):
            name, labels = self._name(scope), self._labels(scope, row)
            yield replace(case, name=name, labels=labels, weight=weight), shared if places == shared else places, steep
        self.file.used |= set().union(*(scope.used for scope in scopes))

    def _case(self, scope: Scope, row: Mapping[str, Item]) -> tuple[Case, dict[str, Place], bool]:
        fields, places = self.file.run_keys.read(self.layers, scope)
        fields["weight"] = self._number("weight", scope, zero=True)
        fields["safety_factor"] = self._number("safety_factor", scope)
        steep = self._steep()
        return Case(name="", group=self.group, **fields), places, steep

    def _number(self, key: str, scope: Scope, zero: bool = False) -> float:
        if key not in self.given:
            return 1.0
        value = scalar(self.given[key], key, scope, "1")
        if not (0 < value < float("inf") or (zero and value == 0)):
            bound = "zero or more" if zero else "above zero"
            raise self.given[key].place.error(f"{key} is {value:g}; it must be {bound}.")
        return value

    def _steep(self) -> bool:
        node = self.given.get("steep_sea")
        if node is not None and node.value not in ("allow", "refuse"):
            raise node.place.error("steep_sea is 'allow' or 'refuse'.")
        return node is not None and node.value == "allow"

    def _seeds(self) -> int:
        node = self.given.get("seeds")
        if node is None:
            return 0
        count = scalar(node, "seeds", self.outer, "1")
        if not (count.is_integer() and 1 <= count <= MOST_SEEDS):
            raise node.place.error(f"seeds is {count:g}; it is their number, a whole one from 1 to {MOST_SEEDS}.")
        return int(count)

    def _realisations(self, row: Mapping[str, Item]) -> list[dict[str, Item]]:
        return seeds_of(row, self.seeds) if self.seeds else [{}]

    def _look_up(self) -> list[Source]:
        node = self.given.get("look_up")
        found = []
        for item in as_list(node) if node is not None and node.value is not None else ():
            name = word(item, "look_up", self.outer)
            if name not in self.file.sources:
                raise item.place.error(
                    f"look_up: there is no table and no distribution '{name}'{did_you_mean(name, self.file.sources)}"
                )
            self.file.used.add(name)
            found.append(self.file.sources[name])
        return found

    def _check_names(self) -> None:
        """No variable has two origins."""
        origins: dict[str, str] = dict.fromkeys(self.file.variables, "the key 'variables' of the file")
        more = [("vary", self.product.names), ("seeds", SEED_NAMES if self.seeds else ()), ("values", self.values)]
        more += [(f"look_up ('{source.columns[0]}' and so on)", source.columns) for source in self.sources]
        for what, names in more:
            for name in names:
                if name in origins:
                    raise self.place.error(f"'{name}' is given twice: by {origins[name]} and by {what}.")
                origins[name] = what
        for name, node in self.values.items():
            variable(name, node.place)

    def _check_used(self, used: set[str]) -> None:
        """What varies must change something in the cases beside their names."""
        for name in self.product.names:
            if name not in used:
                raise self.items["vary"].place.error(
                    f"'{name}' varies, and nothing in the cases depends on it; use it in a value, as in "
                    f"'wind: {{mean_speed: {name}}}'."
                )
        if self.seeds and not used & set(SEED_NAMES):
            raise self.given["seeds"].place.error(
                "there are seeds, and no case uses one; write 'seed: seed' in 'wind' and 'seed: wave_seed' in 'sea'."
            )
        for name, node in _mapping(self.items, "values").items():
            if name not in used:
                raise node.place.error(f"nothing uses the value '{name}'.")
        if "look_up" in self.items:
            for source in self.sources:
                if not used & set(source.columns):
                    names = ", ".join(source.columns)
                    raise self.items["look_up"].place.error(f"nothing uses what is looked up: {names}.")

    def _weights(self, rows: list[dict[str, Item]], factors: list[float], scopes: list[Scope]) -> list[float]:
        if "weights" not in self.items:
            return factors
        node = self.items["weights"]
        found = weights.read(node, self.product.names, self.outer, self.file.folder, self.file.files)
        for scope in scopes:
            scope.used |= set(found.of)
        return found.given(rows, factors)

    def _name(self, scope: Scope) -> str:
        if "name" not in self.given:
            return self.file.register.add(self.file.register.numbered(self.group), self.place)
        name = word(self.given["name"], "name", scope)
        return self.file.register.add(name, self.given["name"].place)

    @staticmethod
    def _labels(scope: Scope, row: Mapping[str, Item]) -> dict[str, str | int | float]:
        return {name: item.label for name, item in {**row, **scope.found}.items() if not isinstance(item.label, bool)}


def _mapping(items: Mapping[str, Node], key: str) -> dict[str, Node]:
    return mapping(items[key], f"'{key}' is a mapping of names and formulas") if key in items else {}
