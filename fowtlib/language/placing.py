"""Where the part stands that an error is about: file and line of the model file, from the path it begins with."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from fowtlib.language.errors import ModelError


def placed(error: ModelError, component: Any) -> ModelError:
    """The error with file and line of the part, at, below or above a component, with whose path its message begins.

    Of a part that another one makes for itself, as a line of a mooring system, it is the place of that one. As it is
    where it has a place already, begins with no path, or all of it was made in Python.
    """
    written = [part for part in (*component.walk(), *_owners(component)) if part.path and part.origins.get("")]
    about = [part for part in written if _begins(error.message, part.path)]
    origin = max(about, key=lambda part: len(part.path)).origins[""] if about and not error.where else None
    return error.at(origin) if origin else error


def _owners(component: Any) -> Iterator[Any]:
    """The parts that a component is a part of, from within."""
    while (component := component._parent) is not None:
        yield component


def _begins(message: str, path: str) -> bool:
    return message.startswith(path) and message[len(path) : len(path) + 1] in (":", ".", " ")
