"""The structural and bound parameters of a model, by which two runs are known to be of the same one."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from fowtlib.language.data_files import named
from fowtlib.language.declarations import join


def structural_values(root: Any) -> dict[str, Any]:
    """The structural and bound parameters of all parts by path, ready for JSON; a file by its name, not its place."""
    parts = root.walk() if root is not None else ()
    return {
        join(part.path, name): _data(part, name) if field.is_data else plain(part.parameter_value(name))
        for part in parts
        for name, field in part.parameters.items()
        if not field.tunable
    }


def _data(part: Any, name: str) -> Any:
    given = part.parameter_binding(name)
    return named(given) if isinstance(given, str) and given else plain(given)


def plain(value: Any) -> Any:
    """The value of a parameter in what JSON can hold; a file by its name."""
    if isinstance(value, str):
        return Path(value).name if Path(value).is_absolute() else value
    if isinstance(value, np.ndarray | np.generic):
        return value.tolist()
    if isinstance(value, list | tuple):
        return [plain(item) for item in value]
    if isinstance(value, dict):
        return {str(key): plain(item) for key, item in value.items()}
    return value if value is None or isinstance(value, bool | int | float) else type(value).__name__
