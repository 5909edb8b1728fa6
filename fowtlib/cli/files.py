"""Files that commands write: refused before the work when they cannot be written, named when they are there."""

from __future__ import annotations

import argparse
import sys
import tempfile
from datetime import datetime
from pathlib import Path

from fowtlib.language.errors import ModelError, one_of

RESULTS = (".nc", ".csv", ".outb")
TABLES = (".csv", ".json")
FIGURES = (".png", ".svg", ".pdf")
LONGEST_NAME = 220  # bytes: of the 255 of a file system, with room for what temporary files add


def declare_force(parser: argparse.ArgumentParser) -> None:
    """Add `--force`, to every command that writes files."""
    parser.add_argument("--force", action="store_true", help="write over files that are there already")


def check_target(path: Path | None, endings: tuple[str, ...], force: bool) -> None:
    """Refuse a file of another kind, one that cannot be written, and without `force` one that is there already."""
    if path is None:
        return
    if len(str(path.name).encode("utf-8", "surrogateescape")) > LONGEST_NAME:
        raise ModelError(f"{path.name[:40]}...: the name is too long; take one of at most {LONGEST_NAME} letters.")
    if "\0" in path.name:
        raise ModelError("a name of a file cannot hold a zero byte; choose another one.")
    if path.suffix not in endings:
        raise ModelError(f"{path}: the file must end in {one_of(endings)}.")
    try:
        if not path.parent.is_dir():
            raise ModelError(f"{path}: the folder {path.parent} does not exist; make it first, or choose another one.")
        if path.is_dir():
            raise ModelError(f"{path}: is a folder; choose another name.")
        there = path.exists()
        if there:
            path.open("ab").close()
        tempfile.TemporaryFile(dir=path.parent).close()
    except OSError as error:
        raise ModelError(f"{path}: cannot be written: {error.strerror or error}.") from None
    if there and not force:
        raise ModelError(f"{path} is there already: {_what_stands(path)}. Write over it with --force, or choose "
                         f"another name{_resumable(path)}.")  # fmt: skip


def in_place_of(path: Path) -> str:
    """Of a name that the program has chosen, before the work: words about what is there and will be written anew."""
    return f" in place of {_what_stands(path)}" if path.exists() else ""


def _what_stands(path: Path) -> str:
    """What a file is, in a few words."""
    state = path.stat()
    words = [f"{state.st_size} bytes of {datetime.fromtimestamp(state.st_mtime):%Y-%m-%d %H:%M}"]
    if path.suffix in (".nc", ".outb") and state.st_size:
        from fowtlib.solving.results import Result

        try:
            result = Result.open(path)
        except ModelError:
            return words[0]
        name = result.attributes.get("model") or "a model"
        words.insert(0, f"{name}, {result.time[0]:g} to {result.time[-1]:g} s")
    return ", ".join(words)


def _resumable(path: Path) -> str:
    return f", or go on from it with --resume {path} --output ANOTHER.nc" if path.suffix == ".nc" else ""


def say_saved(*paths: Path | None) -> None:
    """Name the files that were written, on stderr."""
    for path in filter(None, paths):
        print(f"saved {path}", file=sys.stderr)
