"""A site: what named sets of load cases need to know of wind and waves at a place, from a file."""

from __future__ import annotations

import math
import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol

import numpy as np
from scipy.optimize import brentq
from scipy.special import ndtri

from fowtlib.cases import conditional, weights
from fowtlib.cases.conditional import Table
from fowtlib.cases.folder import Folder, folder_of
from fowtlib.cases.scope import Scope
from fowtlib.cases.values import scalar
from fowtlib.components.environment.waves import steepest_sea
from fowtlib.language.data_files import require_file, text_of
from fowtlib.language.errors import ModelError, ModelFileError
from fowtlib.modelfile import files
from fowtlib.modelfile.nodes import Node, parse, read_text
from fowtlib.modelfile.specs import check_keys, mapping, text

KEY, VERSION = "fowtlib_site", 1
FIRST_LINE = f"a site begins with '{KEY}: {VERSION}'"
KEYS = (KEY, "title", "source", "water_depth", "hub_height", "wind", "normal_sea", "severe_sea", "extreme_sea")
SEAS = ("normal_sea", "severe_sea")
SEA_COLUMNS = ("wind_speed", "Hs", "Tp")
YEARS = ("1", "50")
FASTEST = 40.0  # wind speed [m/s] up to which the tables of a joint distribution go


class Joint(Protocol):
    """A joint distribution of wind at the hub, Hs and Tp, as those of fowtlib.metocean.

    averaging: of a state [s]; the laws have mean(), median(), isf(q), and from_normal(z), to_normal(x), which turn
    quantiles of the standard normal distribution into values and back; that of the wind has scale [m/s] and shape.
    """

    averaging: float
    water_depth: float | None
    wind_speed: Any

    def wave_height(self, wind_speed: float) -> Any:
        """Law of Hs [m] given the wind [m/s]."""

    def peak_period(self, wind_speed: float, wave_height: float) -> Any:
        """Law of Tp [s] given both."""

    def marginal(self, variable: str) -> Any:
        """Law of one variable alone."""


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


def is_site_file(path: Path) -> bool:
    """Whether this is a file of tables of a site; others are of joint distributions."""
    return files.is_file(path) and any(line.startswith(f"{KEY}:") for line in text_of(path).split("\n"))


def read_site(source: str | os.PathLike[str]) -> Site:
    """The site of a file with tables; ModelFileError with file and line."""
    path = Path(source)
    require_file(path, ModelFileError)
    if not files.is_file(path):
        raise files.no_file(source)
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
        {key: _sea(key, items[key], scope, folder_of(path)) for key in SEAS if key in items},
        _extreme(items.get("extreme_sea"), scope),
        scalar(items["water_depth"], "water_depth", scope, "m") if "water_depth" in items else None,
    )  # fmt: skip


def site_from(joint: Joint, hub_height: float, name: str, title: str = "", source: str = "") -> Site:
    """A site from a joint distribution for wind at hub_height [m].

    Normal sea: the mean of Hs given the wind. Severe sea: Hs on the contour of 50 years by IFORM at each wind, one
    state for each `averaging`. Extreme seas: quantiles of the marginal distribution of Hs, with the wind of the highest
    sea on the contour of that period. Tp is the median, or the shortest with which the sea is no steeper than
    DNV-RP-C205 knows, where that is longer.
    """
    per_year = 365.25 * 24 * 3600 / joint.averaging
    beta = {years: float(-ndtri(1 / (int(years) * per_year))) for years in YEARS}
    highest = float(joint.wind_speed.from_normal(beta["50"]))
    speeds = np.array([v for v in np.arange(2.0, FASTEST + 1, 2.0) if v < highest])
    normal = [float(joint.wave_height(v).mean()) for v in speeds]
    severe = [float(_on_contour(joint, v, beta["50"])) for v in speeds]

    def sea(key: str, heights: list[float]) -> Table:
        heights = [round(h, 2) for h in heights]
        periods = np.array([_period(joint, v, h) for v, h in zip(speeds, heights, strict=True)])
        return Table(key, "wind_speed", ("Hs", "Tp"), speeds, {"Hs": np.array(heights), "Tp": periods},
                     dict.fromkeys(SEA_COLUMNS))  # fmt: skip

    marginal, extreme = joint.marginal("wave_height"), {}
    for years in YEARS:
        height = round(float(marginal.isf(1 / (int(years) * per_year))), 2)
        winds = np.linspace(0.05, 0.999, 400) * float(joint.wind_speed.from_normal(beta[years]))
        wind = max(winds, key=lambda v, years=years: _on_contour(joint, v, beta[years]))
        extreme[years] = height, _period(joint, wind, height)
    weibull = float(joint.wind_speed.scale), float(joint.wind_speed.shape)
    seas = {"normal_sea": sea("normal_sea", normal), "severe_sea": sea("severe_sea", severe)}
    return Site(name, title or name, source, weibull, hub_height, seas, extreme, joint.water_depth)


def _on_contour(joint: Joint, wind: float, beta: float) -> float:
    """Hs that goes with a wind speed on the contour of radius beta in standard normal space."""
    z = float(joint.wind_speed.to_normal(wind))
    return float(joint.wave_height(wind).from_normal(math.sqrt(max(beta**2 - z**2, 0.0))))


def _period(joint: Joint, wind: float, height: float) -> float:
    """The median of Tp, or the shortest that the limit of steepness allows; rounded up."""
    shortest = float(brentq(lambda t: steepest_sea(t) - height, 0.01, 60.0))
    return math.ceil(max(float(joint.peak_period(wind, height).median()), shortest) * 100) / 100


def _weibull(node: Node, scope: Scope) -> tuple[float, float]:
    form = "{weibull: {scale: 11.7 m/s, shape: 2}}"
    items = mapping(node, f"'wind' is a mapping: {form}")
    check_keys(items, ("weibull",), "'wind' of a site")
    if "weibull" not in items:
        raise node.place.error(f"'wind' of a site is {form}.")
    law = weights.law("weibull", items["weibull"], scope)
    return law["scale"], law["shape"]


def _sea(key: str, node: Node, scope: Scope, folder: Folder) -> Table:
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
