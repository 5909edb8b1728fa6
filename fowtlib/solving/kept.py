"""What takes long to make, kept on disk under a digest of everything that it is made from."""

from __future__ import annotations

import hashlib
import json
import os
import tempfile
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

from fowtlib.language.native import cache_folder

MOST = 40  # files of one name; the oldest go first


def kept(name: str, parts: Iterable[str], make: Callable[[], Any]) -> Any:
    """What `make` returns (numbers, texts, lists and dictionaries with texts as keys), made anew for other parts.

    parts: texts that determine the result, the source text of `make` among them. The files lie beside the compiled
    libraries. One that is damaged is made again, and where nothing can be written nothing is kept.
    """
    digest = hashlib.sha256()
    for part in parts:
        content = part.encode()
        digest.update(f"{len(content)} ".encode() + content)
    path = cache_folder() / f"{name}_{digest.hexdigest()[:40]}.json"
    try:
        check, _, text = path.read_text(encoding="utf-8").partition("\n")
        if check == _digest(text):
            return json.loads(text)
    except (OSError, ValueError):
        pass
    value = make()
    text = json.dumps(value)
    _write(path, f"{_digest(text)}\n{text}")
    for old in sorted(path.parent.glob(f"{name}_*.json"), key=_age)[MOST:]:
        old.unlink(missing_ok=True)
    return value


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
