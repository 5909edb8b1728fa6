"""The code of fowtlib that decides what equations a model has: its digest, and what belongs to it."""

from __future__ import annotations

import hashlib
import os
import time
import types
from functools import cache
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from fowtlib.language.cache import version

_PACKAGES = ("fowtlib.language", "fowtlib.flattening", "fowtlib.modelfile", "fowtlib.components")
_VERSIONS = ("fowtlib", "numpy", "scipy", "casadi", "networkx")
_BEGAN = time.time()


class Unknown(Exception):
    """Nothing tells by which content a model is known again."""


@cache
def folders(packages: tuple[str, ...] = _PACKAGES) -> tuple[str, ...]:
    """Where the code of packages is."""
    found = []
    for name in packages:
        spec = find_spec(name)
        found += [os.path.realpath(place) for place in (spec and spec.submodule_search_locations) or ()]
    return tuple(f"{folder}{os.sep}" for folder in found)


@cache
def digest_of_own_code(*more: str) -> str:
    """Of all its texts, those of more packages, and of the versions of the packages it computes with.

    Raises Unknown where a text was written after this process has begun: what runs may be what stood there before.
    """
    digest = hashlib.sha256(repr([version(name) for name in _VERSIONS]).encode())
    for folder in folders(_PACKAGES + more):
        for path in sorted((*Path(folder).rglob("*.py"), *Path(folder).rglob("*.c"))):
            digest.update(f"\0{path.relative_to(folder)}\0".encode() + content_from_before(path))
    return digest.hexdigest()


def content_from_before(path: str | os.PathLike[str]) -> bytes:
    """The content of a file of code, which is older than this process. Raises Unknown."""
    try:
        state = os.stat(path)
        with open(path, "rb") as file:
            content = file.read()
    except (OSError, ValueError) as error:
        raise Unknown(f"{path}: {error}") from None
    if max(state.st_mtime, state.st_ctime) >= _BEGAN:
        raise Unknown(f"{path} was written after this process had begun")
    return content


@cache
def _is_own(file: str) -> bool:
    return os.path.realpath(file).startswith(folders())


def is_own(code: Any) -> bool:
    """Whether a module, or the code of a function, is fowtlib's, of which the digest is."""
    if isinstance(code, types.CodeType):
        return _is_own(code.co_filename)
    file = getattr(code, "__file__", None)
    return file is not None and _is_own(file)
