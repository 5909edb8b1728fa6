"""Files that commands write: refused before the work when they cannot be written, named when they are there."""

from __future__ import annotations

import os
import sys
import tempfile
from datetime import datetime
from pathlib import Path

from fowtlib.language.errors import ModelError, one_of

RESULTS = (".nc", ".csv", ".outb")
TABLES = (".csv", ".json")
FIGURES = (".png", ".svg", ".pdf")
LONGEST = 220  # bytes of a name: of the 255 of a file system, with room for the names of journals


def check_new(path: Path | None, force: bool) -> None:
    """Refuse to write over a file that is there, unless told to."""
    if path is None or force or not path.exists():
        return
    when = datetime.fromtimestamp(path.stat().st_mtime).isoformat(" ", "minutes")
    what = f"{path.stat().st_size / 1e6:.3g} MB, of {when}"
    if path.suffix == ".nc":
        from fowtlib.solving.results import Result

        try:
            there = Result.open(path)
            name = there.attributes["title"] or there.attributes["model"]
            what = f"a run of {name} to {there.time[-1]:g} s, {there.attributes['status'].rstrip('.')}; {what}"
        except ModelError:
            pass
    raise ModelError(f"{path}: there is such a file already ({what}). To write over it: --force; or take another name.")


def check_target(path: Path | None, endings: tuple[str, ...]) -> None:
    """Refuse a file of another kind, or one that cannot be written."""
    if path is None:
        return
    if path.suffix not in endings:
        raise ModelError(f"{path}: the file must end in {one_of(endings)}.")
    if not path.parent.is_dir():
        raise ModelError(f"{path}: the folder {path.parent} does not exist; make it first, or choose another one.")
    if path.is_dir():
        raise ModelError(f"{path}: is a folder; choose another name.")
    try:
        if path.exists():
            path.open("ab").close()
        if len(os.fsencode(path.name)) > LONGEST:
            raise ModelError(f"{path.name[:40]}...: the name is too long; take one of at most {LONGEST} letters.")
        tempfile.TemporaryFile(dir=path.parent).close()
    except OSError as error:
        raise ModelError(f"{path}: cannot be written: {error.strerror or error}.") from None


def say_saved(*paths: Path | None) -> None:
    """Name the files that were written, on stderr."""
    for path in filter(None, paths):
        print(f"saved {path}", file=sys.stderr)
