"""What takes long to make, kept on disk under a digest of everything that it is made from."""

from __future__ import annotations

import hashlib
import json
import sys
from collections.abc import Callable, Iterable
from functools import cache
from importlib.metadata import version as version_of
from pathlib import Path
from typing import Any

import numpy as np

from fowtlib.language import cache_folder as store


def cached(name: str, parts: Iterable[str | np.ndarray], make: Callable[[], Any]) -> Any:
    """What `make` returns (numbers, texts, lists and dictionaries with texts as keys), made anew for other parts.

    parts: texts and arrays of numbers that determine the result; `sources` gives those of the code that makes it. The
    files lie beside the compiled libraries. One that is damaged is made again, which is said, and where nothing can be
    written nothing is kept. Arrays in what `make` returns become lists.
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
    key = f"{name}_{digest.hexdigest()[:40]}"
    store.limit()  # a wrong one is said before the work
    try:
        if path := store.find(key, "json"):
            return json.loads(path.read_bytes())
    except (OSError, ValueError):
        pass
    text = json.dumps(make(), default=lambda value: value.tolist())
    try:
        with store.workshop() as folder:
            fresh = folder / "fresh.json"
            fresh.write_text(text, encoding="utf-8")
            store.keep(key, "json", fresh)
        store.prune()
    except OSError:
        pass
    return json.loads(text)


def sources(*modules: str) -> list[str]:
    """Source texts of imported modules, and versions of the packages whose numbers they take."""
    files = [Path(sys.modules[name].__file__).read_text(encoding="utf-8") for name in modules]
    return [*files, *(version(name) for name in ("numpy", "scipy", "casadi"))]


@cache
def version(package: str) -> str:
    """Version of an installed package."""
    return version_of(package)
