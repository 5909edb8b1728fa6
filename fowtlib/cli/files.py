"""Files that commands write: refused before the work when they cannot be written, named when they are there."""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path

from fowtlib.language.errors import ModelError, one_of

RESULTS = (".nc", ".csv", ".outb")
TABLES = (".csv", ".json")
FIGURES = (".png", ".svg", ".pdf")
LONGEST_NAME = 220  # bytes: of the 255 of a file system, with room for what temporary files add


def check_target(path: Path | None, endings: tuple[str, ...]) -> None:
    """Refuse a file of another kind, or one that cannot be written."""
    if path is None:
        return
    if len(str(path.name).encode("utf-8", "surrogateescape")) > LONGEST_NAME:
        raise ModelError(f"{path.name[:40]}...: the name is too long; take one of at most {LONGEST_NAME} letters.")
    if path.suffix not in endings:
        raise ModelError(f"{path}: the file must end in {one_of(endings)}.")
    if not path.parent.is_dir():
        raise ModelError(f"{path}: the folder {path.parent} does not exist; make it first, or choose another one.")
    if path.is_dir():
        raise ModelError(f"{path}: is a folder; choose another name.")
    try:
        if path.exists():
            path.open("ab").close()
        tempfile.TemporaryFile(dir=path.parent).close()
    except OSError as error:
        raise ModelError(f"{path}: cannot be written: {error.strerror or error}.") from None


def say_saved(*paths: Path | None) -> None:
    """Name the files that were written, on stderr."""
    for path in filter(None, paths):
        print(f"saved {path}", file=sys.stderr)
