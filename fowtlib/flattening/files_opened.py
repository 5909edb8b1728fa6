"""Which files are opened in between: what is written with the content of a file is not known by code and values."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from fowtlib.language import cache_folder as store

_CODE = (".py", ".pyc", ".so", ".pyd", ".dll", ".c")
_listening: list[set[str]] = []
_hooked: list[bool] = []


@contextmanager
def files_opened(listen: bool) -> Iterator[set[str]]:
    """The files that this process opens, without code and what is kept; none where nobody listens."""
    found: set[str] = set()
    if not listen:
        yield found
        return
    if not _hooked:
        sys.addaudithook(_heard)  # there is no way to take it away
        _hooked.append(True)
    _listening.append(found)
    try:
        yield found
    finally:
        _listening.remove(found)


def _heard(event: str, arguments: tuple[Any, ...]) -> None:
    if not _listening or event not in ("open", "os.listdir", "os.scandir", "subprocess.Popen", "socket.connect"):
        return
    name = arguments[0] if arguments else None
    text = os.fsdecode(name) if event == "open" and isinstance(name, (str, bytes)) else event
    if text.endswith(_CODE):
        return
    path = os.path.realpath(text)
    if not path.startswith(f"{os.path.realpath(store.cache_folder())}{os.sep}"):
        for found in _listening:
            found.add(path)
