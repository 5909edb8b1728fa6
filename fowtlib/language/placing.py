"""Where the part stands that an error is about: file and line of the model file, from the path it begins with."""

from __future__ import annotations

from typing import Any

from fowtlib.language.errors import ModelError


def placed(error: ModelError, component: Any) -> ModelError:
    """The error with file and line of the part, at or below a component, with whose path its message begins.

    As it is where it has a place already, begins with no path, or the part was made in Python.
    """
    about = [part for part in component.walk() if part.path and _begins(error.message, part.path)]
    origin = max(about, key=lambda part: len(part.path)).origins.get("") if about and not error.where else None
    return error.at(origin) if origin else error


def _begins(message: str, path: str) -> bool:
    return message.startswith(path) and message[len(path) : len(path) + 1] in (":", ".", " ")
