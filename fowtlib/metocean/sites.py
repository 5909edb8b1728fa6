"""Sites: files with the parameters of a joint distribution, and scatter tables.

A site is a YAML file beside this module, known by its name, or a file of one's own; a scatter table is a CSV file.
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import MISSING, fields
from importlib.resources import files
from pathlib import Path
from typing import Any

from fowtlib.language.data_files import text_of
from fowtlib.language.errors import NotFoundError, ParameterError, did_you_mean
from fowtlib.language.units import to_si
from fowtlib.metocean.joint import ConditionalModel
from fowtlib.metocean.scatter import ScatterTable, read_scatter

_UNITS = {"wind_scale": "m/s", "reference_height": "m", "averaging": "s", "height": "m", "water_depth": "m"}
_WORDS = ("title", "source", "notes")
_ENDINGS = (".yaml", ".yml", ".csv")


def shipped() -> list[str]:
    """Names of the sites that come with fowtlib."""
    return sorted(
        path.name.removesuffix(".yaml")
        for path in files(__package__).joinpath("sites").iterdir()
        if path.name.endswith(".yaml")
    )


def site(name: str | os.PathLike[str]) -> ConditionalModel:
    """The joint distribution of a shipped site, or of a file (.yaml) with the same keys.

    NotFoundError for an unknown name, ParameterError for a file that is not a site; a scatter table has no contours,
    see `environment`.
    """
    found = environment(name)
    if isinstance(found, ScatterTable):
        raise ParameterError(
            f"{os.fspath(name)}: a scatter table has classes and no contours; give the file of a joint "
            "distribution (.yaml)."
        )
    return found


def environment(name: str | os.PathLike[str]) -> ConditionalModel | ScatterTable:
    """A site by its name or file, or a scatter table (.csv)."""
    text = os.fspath(name)
    path = Path(text)
    if path.suffix.lower() == ".csv":
        return read_scatter(path)
    if path.suffix.lower() in _ENDINGS:
        return _read(path, path.stem)
    if text not in shipped():
        raise NotFoundError(f"there is no site '{text}'{did_you_mean(text, shipped())} Or give a file: .yaml or .csv.")
    return _read(Path(str(files(__package__).joinpath("sites", f"{text}.yaml"))), text)


def open_distribution(name: str | os.PathLike[str], height: float) -> ConditionalModel | ScatterTable:
    """A site for wind speeds at a height [m], the hub; those of a scatter table count as such."""
    found = environment(name)
    return found if isinstance(found, ScatterTable) else found.at(height)


def _read(path: Path, name: str) -> ConditionalModel:
    import yaml

    try:
        data = yaml.safe_load(text_of(path, "the site"))
    except yaml.YAMLError as error:
        mark = getattr(error, "problem_mark", None)
        place = f"{path}:{mark.line + 1}" if mark else str(path)
        raise ParameterError(f"this is not YAML: {getattr(error, 'problem', None) or error}.", where=place) from None
    if not isinstance(data, Mapping):
        raise ParameterError("a site is a mapping of parameters and their values.", where=str(path))
    known = {item.name: item for item in fields(ConditionalModel) if item.name != "name"}
    values: dict[str, Any] = {}
    for key, value in data.items():
        if key == "notes":
            continue
        if str(key).startswith("fowtlib"):
            raise ParameterError(f"this is no site: a file with '{key}' is of another kind.", where=str(path))
        if key not in known:
            raise ParameterError(f"a site has no '{key}'{did_you_mean(str(key), [*known, 'notes'])}", where=str(path))
        values[key] = value if key in _WORDS else _number(key, value, str(path))
    for key, item in known.items():
        if key not in values and item.default is MISSING:
            raise ParameterError(f"the site lacks '{key}'.", where=str(path))
    try:
        return ConditionalModel(**values, name=name)
    except ParameterError as error:
        error.where = str(path)
        raise


def _number(key: str, value: Any, where: str) -> Any:
    """A number, one with a unit as text, or three of them."""
    kind = str(next(item.type for item in fields(ConditionalModel) if item.name == key))
    three = kind == "Three"
    if three != isinstance(value, list) or (three and len(value) != 3):
        raise ParameterError(
            f"'{key}' is {'a list of three numbers' if three else 'one number'}, not {value}.", where=where
        )
    try:
        if three:
            if any(isinstance(item, bool) for item in value):
                raise ValueError
            return tuple(float(item) for item in value)
        return float(to_si(value, _UNITS[key], where)) if key in _UNITS else float(value)
    except (TypeError, ValueError):
        raise ParameterError(f"'{key}' is to be a number, not {value}.", where=where) from None
