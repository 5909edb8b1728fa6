"""Values by path, as people give them, and paths with stars."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from fowtlib.language.component import Component
from fowtlib.language.declarations import join
from fowtlib.language.errors import ParameterError

EVERY = "*"
"""In a path, for any letters of a name."""


def by_path(values: Any, what: str = "parameters") -> dict[str, Any]:
    """What is given by path, as a dict of its own. Raises ParameterError where it is something else."""
    if not isinstance(values, Mapping):
        raise ParameterError(
            f"{what} are given by path, as in {{'wind.mean_speed': 8}}, and this is a {type(values).__name__}: "
            f"{values!r}."
        )
    for path in values:
        if not isinstance(path, str):
            raise ParameterError(f"{what}: a path is a text, as in 'wind.mean_speed', and {path!r} is not.")
    return dict(values)


def start_by_path(values: Any, of_state: str) -> dict[str, Any]:
    """Start values by path, of a state that is sought; of_state: the argument that takes a whole state."""
    if values is not None and not isinstance(values, Mapping):
        raise ParameterError(
            f"start: start values are given by path, as in {{'platform.motion.surge': '5 m'}}, and this is a "
            f"{type(values).__name__}: {values!r}. A State goes to {of_state}=, a Result or a word to simulate."
        )
    return by_path(values or {}, "start")


def names_of(values: Any, what: str = "outputs") -> list[str]:
    """Names or paths that are given as a list. Raises ParameterError where they are one text, or no texts."""
    if isinstance(values, str):
        raise ParameterError(f"{what} are a list of names, as in [{values!r}], not a text.")
    names = list(values) if isinstance(values, Iterable) else [None]
    if not all(isinstance(name, str) for name in names):
        raise ParameterError(f"{what} are a list of names, as in ['pitch'], not {values!r}.")
    return names


def meant(what: str, paths: Sequence[str]) -> list[str]:
    """The paths of events that a text can mean: the one that it is, or all that end as it does; * is any letters.

    Names in the middle of a path may be left out; those that are given stand in its order.
    """
    names = [re.compile(re.escape(name).replace(re.escape(EVERY), ".*")) for name in what.split(".")]
    return [what] if what in paths else [path for path in paths if _within(names, path.split("."))]


def _within(names: Sequence[re.Pattern[str]], path: Sequence[str]) -> bool:
    left = iter(path)
    return bool(names[-1].fullmatch(path[-1])) and all(any(name.fullmatch(known) for known in left) for name in names)


def spread_out(values: Mapping[str, Any], root: Component) -> dict[str, Any]:
    """Values by path, those of paths with stars at every parameter that fits; whole paths have the last word.

    "*.idling" are the parameters `idling` of all parts. Raises ParameterError where none fits.
    """
    starred = {path: value for path, value in values.items() if EVERY in path}
    if not starred:
        return dict(values)
    known = [join(part.path, name) for part in root.walk() for name in part.parameters]
    found: dict[str, Any] = {}
    for path, value in starred.items():
        fits = meant(path, known)
        if not fits:
            raise ParameterError(f"no part has a parameter that fits '{path}'.")
        found |= dict.fromkeys(fits, value)
    return found | {path: value for path, value in values.items() if path not in starred}
