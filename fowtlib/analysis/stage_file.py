"""Stages of construction from a YAML file.

    stages:
      - name: base afloat
        members: [base]
      - name: column cast
        members: [column]
        levels: {base.ore: -57 m}
        masses: {crane: {mass: 40 t, place: [0, 0, -18 m]}}
    clearance: 2 m      # below the keel
    least: 1 m          # GM at every stage
    slack: [column.water]

What is left out is nothing, 0, 0 and all. `null` in place of a level or a mass takes it out again.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from fowtlib.analysis.afloat_models import ALL
from fowtlib.analysis.stages import Point, Stage
from fowtlib.language.data_files import text_of
from fowtlib.language.errors import ModelFileError, did_you_mean
from fowtlib.language.units import to_si

_TOP, _STAGE = ("stages", "clearance", "least", "slack"), ("name", "members", "levels", "masses")
_MASS = ("mass", "place")


@dataclass(frozen=True)
class StageFile:
    """What a file of stages says: as the arguments of `construction_stages`."""

    stages: tuple[Stage, ...]
    clearance: float = 0.0
    least: float = 0.0
    slack: str | tuple[str, ...] = ALL


def read_stages(path: str | Path) -> StageFile:
    """The stages of a file. Raises ModelFileError, with the path, for what is no such file."""
    import yaml  # slow to import

    try:
        given = yaml.safe_load(text_of(Path(path), "the stages"))
    except yaml.YAMLError as error:
        raise ModelFileError(f"{path}: it is no YAML: {str(error).splitlines()[0]}.") from None
    top = _entries(path, "the file", given, _TOP)
    rows = top.get("stages")
    if not isinstance(rows, list) or not rows:
        raise ModelFileError(f"{path}: it has no list of stages; write 'stages:' and below it '- name: ...'.")
    slack = top.get("slack", ALL)
    return StageFile(
        tuple(_stage(path, k, row) for k, row in enumerate(rows)),
        *(float(to_si(top.get(name, 0.0), "m", f"{path}: {name}")) for name in ("clearance", "least")),
        slack if isinstance(slack, str) else tuple(map(str, slack or ())),
    )  # fmt: skip


def _stage(path: str | Path, number: int, row: Any) -> Stage:
    about = f"stage {number + 1}"
    entries = _entries(path, about, row, _STAGE)
    name = str(entries.get("name", about))
    members = entries.get("members") or ()
    levels = _entries(path, f"{name}: levels", entries.get("levels") or {})
    masses = _entries(path, f"{name}: masses", entries.get("masses") or {})
    return Stage(
        name, (members,) if isinstance(members, str) else tuple(map(str, members)),
        {key: None if value is None else float(to_si(value, "m", f"{path}: {name}: level of {key}"))
         for key, value in levels.items()},
        {key: _mass(path, f"{name}: {key}", value) for key, value in masses.items()},
    )  # fmt: skip


def _mass(path: str | Path, about: str, value: Any) -> tuple[float, Point] | None:
    if value is None:
        return None
    entries = _entries(path, about, value, _MASS)
    if missing := [name for name in _MASS if name not in entries]:
        raise ModelFileError(f"{path}: {about} has no {missing[0]}; write {{mass: 400 t, place: [0, 0, 20 m]}}.")
    place = np.ravel(np.asarray(to_si(entries["place"], "m", f"{path}: {about}: place"), dtype=float))
    if place.shape != (3,):
        raise ModelFileError(f"{path}: {about}: its place is three coordinates, x, y and z.")
    x, y, z = place.tolist()
    return float(to_si(entries["mass"], "kg", f"{path}: {about}: mass")), (x, y, z)


def _entries(path: str | Path, about: str, value: Any, known: tuple[str, ...] = ()) -> Mapping[str, Any]:
    if not isinstance(value, dict):
        raise ModelFileError(f"{path}: {about} must be entries 'name: value'.")
    for key in value:
        if known and key not in known:
            raise ModelFileError(f"{path}: {about} has no entry '{key}'{did_you_mean(str(key), known)}")
    return value
