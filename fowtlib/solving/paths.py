"""Values by path, as people give them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from fowtlib.language.errors import ParameterError


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
