"""Fields that are made for a run, and not kept: a few files in a folder of the process that goes with it."""

from __future__ import annotations

import atexit
import hashlib
import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

from fowtlib.components.environment.field_wind import forget_fields
from fowtlib.components.isolation.folders import private_folder, remove

KEPT = 2  # fields of one process at a time; 25 x 25 points of 600 s at 20 Hz take 45 MB

_folder: list[Path] = []
_files: list[Path] = []  # the last one used is the last


def made_field(description: dict[str, Any], make: Callable[[Path], object]) -> Path:
    """The file of the field with this description; `make` writes it to a path where it is not there.

    description: all that the field depends on, in what JSON can hold.
    """
    name = hashlib.blake2b(json.dumps(description, sort_keys=True).encode(), digest_size=16).hexdigest() + ".bts"
    if not _folder or not _folder[0].is_dir():
        _folder[:], _files[:] = [private_folder()], []
        atexit.register(remove, _folder[0])
    path = _folder[0] / name
    if path in _files:
        _files.remove(path)
    else:
        make(path)
        while len(_files) >= KEPT:
            forget_fields()
            _files.pop(0).unlink(missing_ok=True)
    _files.append(path)
    return path
