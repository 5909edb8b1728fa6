"""Temporary folders that processes share while they run, and that nobody removes where the first of them is killed."""

from __future__ import annotations

import os
import shutil
import socket
import tempfile
import time
from contextlib import suppress
from pathlib import Path

try:
    import fcntl
except ImportError:  # Windows: no other program can tell whether a folder is in use, and none is taken away
    fcntl = None  # type: ignore[assignment]

LOCK = ".lock"
OLD = 3600.0  # s that nothing was put into or taken from a folder before it may be left over
_held: dict[Path, int] = {}
"""The locks of this process, by folder; the system lets them go when it ends, however it does."""


def hold(folder: Path) -> None:
    """Say that this process uses a folder, until it ends; any number of processes may."""
    if fcntl is None or folder in _held:
        return
    with suppress(OSError):
        _held[folder] = lock = _locked(folder, fcntl.LOCK_SH, os.O_CREAT)
        if not os.fstat(lock).st_size:
            os.write(lock, _machine())


def remove_left_over(prefix: str) -> None:
    """Delete the temporary folders of that name that no process holds.

    Only this user's, only those that were held once, and only old ones of this machine: a lock on a disk that several
    machines share may be unknown to the others, so that the lock file names the machine that made it.
    """
    if fcntl is None:
        return
    with suppress(OSError), os.scandir(tempfile.gettempdir()) as entries:
        for entry in entries:
            if entry.name.startswith(prefix):
                with suppress(OSError):
                    _remove(entry)


def _remove(entry: os.DirEntry[str]) -> None:
    folder, status = Path(entry.path), entry.stat(follow_symlinks=False)
    if not entry.is_dir(follow_symlinks=False) or status.st_uid != os.getuid() or folder in _held:
        return
    if time.time() - status.st_mtime < OLD:
        return
    lock = _locked(folder, fcntl.LOCK_EX)  # fails where a process holds it, and where none has ever said so
    if os.read(lock, 1000) == _machine():
        shutil.rmtree(folder, ignore_errors=True)
    os.close(lock)


def _machine() -> bytes:
    return socket.gethostname().encode()


def _locked(folder: Path, kind: int, more: int = 0) -> int:
    """A lock of a folder. Raises OSError where another process has one that does not go with it."""
    descriptor = os.open(folder / LOCK, os.O_RDWR | os.O_CLOEXEC | os.O_NOFOLLOW | more, 0o600)
    try:
        fcntl.flock(descriptor, kind | fcntl.LOCK_NB)
    except OSError:
        os.close(descriptor)
        raise
    return descriptor
