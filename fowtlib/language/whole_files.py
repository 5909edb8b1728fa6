"""Files that are whole or not there: written under another name, put on the disk (fsync), then renamed."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Callable
from pathlib import Path

from fowtlib.language.errors import ModelError


class WriteError(ModelError):
    """A file cannot be written: no room on the disk, no permission, a folder that is gone."""


def write_whole(path: str | Path, write: Callable[[Path], object]) -> Path:
    """Let `write` make a file of another name in the same folder, and put it on the disk in place of `path`.

    What stood there stays until the new file is complete. A link stays a link. Raises WriteError where the system
    refuses; what else `write` raises goes on, and no half file is left.
    """
    path = Path(path)
    try:
        target = Path(os.path.realpath(path))
        handle, name = tempfile.mkstemp(prefix=".fowtlib.", suffix=path.suffix, dir=target.parent)
        os.close(handle)
        temporary = Path(name)
        try:
            write(temporary)
            umask = os.umask(0)
            os.umask(umask)
            temporary.chmod(0o666 & ~umask)
            _to_disk(temporary, target)
        finally:
            temporary.unlink(missing_ok=True)
    except OSError as error:
        raise WriteError(f"{path}: cannot be written: {error.strerror or error}.") from error
    return path


def write_text(path: str | Path, text: str) -> Path:
    """Write a text, in UTF-8 with its own line ends, as `write_whole` does."""
    return write_whole(path, lambda temporary: temporary.write_bytes(text.encode("utf-8")))


def replace_file(path: Path, data: bytes) -> None:
    """Write a file of the user alone, whole and to the disk; OSError where that fails, and the old one stays."""
    handle, name = tempfile.mkstemp(prefix=".fowtlib.", dir=path.parent)
    temporary = Path(name)
    try:
        with os.fdopen(handle, "wb") as file:
            file.write(data)
        _to_disk(temporary, path)
    finally:
        temporary.unlink(missing_ok=True)


def sync_folder(folder: Path) -> None:
    """Put the names in a folder on the disk, where the system can."""
    if os.name != "posix":
        return
    handle = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(handle)
    except OSError:  # some file systems of networks cannot
        pass
    finally:
        os.close(handle)


def _to_disk(temporary: Path, target: Path) -> None:
    with temporary.open("r+b") as file:
        os.fsync(file.fileno())
    temporary.replace(target)
    sync_folder(target.parent)
