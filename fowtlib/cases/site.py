"""A site: what named sets of load cases need to know of wind and waves at a place, from a file."""

from __future__ import annotations

import math
import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from fowtlib.cases import conditional
from fowtlib.cases.conditional import Table
from fowtlib.cases.scope import Scope
from fowtlib.cases.values import scalar
from fowtlib.language.data_files import require_file
from fowtlib.language.errors import ModelError, ModelFileError, did_you_mean
from fowtlib.modelfile import files
from fowtlib.modelfile.nodes import Node, parse, read_text
from fowtlib.modelfile.specs import check_keys, mapping, text

KEY, VERSION = "fowtlib_site", 1
FIRST_LINE = f"a site begins with '{KEY}: {VERSION}'"
KEYS = (KEY, "title", "source", "water_depth", "hub_height", "wind", "normal_sea", "severe_sea", "extreme_sea")
SEAS = ("normal_sea", "severe_sea")
SEA_COLUMNS = ("wind_speed", "Hs", "Tp")
YEARS = ("1", "50")
DEFAULT = "norway_5"


@dataclass(frozen=True)
class Site:
    """weibull: scale [m/s] and shape of the mean wind at hub_height [m]; tables of Hs and Tp over it; extreme seas."""

    name: str
    title: str
    source: str
    weibull: tuple[float, float]
    hub_height: float
    seas: Mapping[str, Table]
    extreme: Mapping[str, tuple[float, float]]
    water_depth: float | None = None


def shipped_sites() -> list[str]:
    """Names of the sites that come with fowtlib."""
    return sorted(path.stem for path in (files.models_folder() / "data" / "sites").glob("*.yaml"))


def read_site(source: str | os.PathLike[str]) -> Site:
    """A shipped site by its name, or that of a file; ModelFileError with file and line."""
    path = Path(source)
    if not files.is_file(path):
        if path.suffix or len(path.parts) > 1:
            raise ModelFileError(f"there is no file '{source}'.")
        if str(source) not in shipped_sites():
            raise ModelFileError(f"there is no site '{source}', nor a file{did_you_mean(str(source), shipped_sites())}")
        path = files.data_path(f"sites/{source}.yaml")
    require_file(path, ModelFileError)
    name = files.shown(path)
    top = parse(read_text(path, name), name, FIRST_LINE)
    items = mapping(top, f"{FIRST_LINE}, and is a mapping")
    if KEY not in items or items[KEY].value != VERSION:
        raise top.place.error(f"this is not a site of this version; {FIRST_LINE}.")
    check_keys(items, KEYS, "a site")
    for key in ("wind", "hub_height", "normal_sea"):
        if key not in items:
            raise top.place.error(f"the key '{key}' is missing; a site has {', '.join(KEYS[1:])}.")
    scope = Scope(top.place, {})
    return Site(
        path.stem, text(items, "title") or path.stem, text(items, "source"), _weibull(items["wind"], scope),
        scalar(items["hub_height"], "hub_height", scope, "m"),
        {key: _sea(key, items[key], scope, path.parent) for key in SEAS if key in items},
        _extreme(items.get("extreme_sea"), scope),
        scalar(items["water_depth"], "water_depth", scope, "m") if "water_depth" in items else None,
    )  # fmt: skip


def _weibull(node: Node, scope: Scope) -> tuple[float, float]:
    form = "{weibull: {scale: 11.7 m/s, shape: 2}}"
    items = mapping(node, f"'wind' is a mapping: {form}")
    check_keys(items, ("weibull",), "'wind' of a site")
    if "weibull" not in items:
        raise node.place.error(f"'wind' of a site is {form}.")
    inner = mapping(items["weibull"], "'weibull' is a mapping: scale, shape")
    check_keys(inner, ("scale", "shape"), "'weibull'")
    numbers = []
    for key, unit in (("scale", "m/s"), ("shape", "1")):
        if key not in inner:
            raise items["weibull"].place.error(f"'weibull' needs '{key}'.")
        value = scalar(inner[key], key, scope, unit)
        if not (value > 0 and math.isfinite(value)):
            raise inner[key].place.error(f"weibull: {key} is {value:g}, and must be above zero.")
        numbers.append(value)
    return numbers[0], numbers[1]


def _sea(key: str, node: Node, scope: Scope, folder: Path) -> Table:
    made = conditional.table(key, node, scope, folder, [])
    if (made.argument, *made.columns) != SEA_COLUMNS:
        raise node.place.error(f"'{key}' has the columns {', '.join(SEA_COLUMNS)}, in this order.")
    for name in ("Hs", "Tp"):
        if np.any(made.values[name] <= 0):
            raise node.place.error(f"'{key}': '{name}' holds what is not above zero.")
    return made


def _extreme(node: Node | None, scope: Scope) -> dict[str, tuple[float, float]]:
    if node is None:
        return {}
    seas = {}
    form = "{1: {Hs: 11 m, Tp: 14 s}, 50: {Hs: 15 m, Tp: 16 s}}"
    for years, item in mapping(node, f"'extreme_sea' is a mapping by return period: {form}").items():
        if years not in YEARS:
            raise item.place.error(f"extreme_sea: there are return periods of 1 and 50 years, not '{years}'.")
        inner = mapping(item, f"extreme_sea is {form}")
        check_keys(inner, ("Hs", "Tp"), "an extreme sea")
        if len(inner) < 2:
            raise item.place.error("an extreme sea needs 'Hs' and 'Tp'.")
        seas[years] = scalar(inner["Hs"], "Hs", scope, "m"), scalar(inner["Tp"], "Tp", scope, "s")
        if min(seas[years]) <= 0:
            raise item.place.error(f"extreme_sea of {years} years: Hs and Tp must be above zero.")
    return seas


def site_error(site: Site, what: str, number: str) -> ModelError:
    """The error of a load case that needs more than a site says."""
    return ModelFileError(f"DLC {number} needs {what}, and the site '{site.name}' does not say it.")
