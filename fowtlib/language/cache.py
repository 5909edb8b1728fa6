"""What takes long to make, kept on disk under a digest of everything that it is made from."""

from __future__ import annotations

import hashlib
import json
import os
import sys
import tempfile
from collections.abc import Callable, Iterable
from functools import cache
from importlib.metadata import version as version_of
from pathlib import Path
from typing import Any

import numpy as np

from fowtlib.language.native import cache_folder

MOST = 40  # files of one name; the oldest go first


def cached(name: str, parts: Iterable[str | np.ndarray], make: Callable[[], Any]) -> Any:
    """What `make` returns (numbers, texts, lists and dictionaries with texts as keys), made anew for other parts.

    parts: texts and arrays of numbers that determine the result; `sources` gives those of the code that makes it. The
    files lie beside the compiled libraries. One that is damaged is made again, and where nothing can be written nothing
    is kept. Arrays in what `make` returns become lists.
    """
    digest = hashlib.sha256()
    for part in parts:
        if isinstance(part, np.ndarray):
            if part.dtype.kind not in "fiucb":
                raise TypeError("an array of numbers is expected")
            digest.update(f"{part.dtype.str} {part.shape} ".encode() + part.tobytes())
        else:
            content = part.encode()
            digest.update(f"{len(content)} ".encode() + content)
    path = cache_folder() / f"{name}_{digest.hexdigest()[:40]}.json"
    try:
        check, _, text = path.read_text(encoding="utf-8").partition("\n")
        if check == _digest(text):
            return json.loads(text)
    except (OSError, ValueError):
        pass
    text = json.dumps(make(), default=lambda value: value.tolist())
    _write(path, f"{_digest(text)}\n{text}")
    for old in sorted(path.parent.glob(f"{name}_*.json"), key=_age)[MOST:]:
        old.unlink(missing_ok=True)
    return json.loads(text)


def sources(*modules: str) -> list[str]:
    """Source texts of imported modules, and versions of the packages whose numbers they take."""
    files = [Path(sys.modules[name].__file__).read_text(encoding="utf-8") for name in modules]
    return [*files, *(version(name) for name in ("numpy", "scipy", "casadi"))]


@cache
def version(package: str) -> str:
    """Version of an installed package."""
    return version_of(package)


def _digest(text: str) -> str:
    return hashlib.sha256(text.encode()).hexdigest()


def _age(path: Path) -> float:
    try:
        return -path.stat().st_mtime
    except OSError:  # another process has removed it
        return 0.0


def _write(path: Path, text: str) -> None:
    """The whole file or none, also for other processes."""
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(dir=path.parent) as folder:
            fresh = Path(folder) / path.name
            fresh.write_text(text, encoding="utf-8")
            os.replace(fresh, path)
    except OSError:
        return
