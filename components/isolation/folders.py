"""Folders for the files of one session, that do not outlive it: not even a session that was killed."""

from __future__ import annotations

import os
import shutil
import tempfile
import time
from contextlib import suppress
from pathlib import Path

try:
    import fcntl
except ImportError:  # Windows: there a session that is killed leaves its folder, and no other program can tell
    fcntl = None  # type: ignore[assignment]

PREFIX = "fowtlib_session_"
NEW = "fowtlib_new_"  # not locked yet; for an instant only
OLD = 86400.0  # s after which a folder of that name is a leftover
_held: dict[Path, int] = {}  # the locks of this process
_swept = False


def private_folder() -> Path:
    """A new folder that only this user may enter. This process holds a lock in it until it calls `remove` or ends.

    The first call deletes the folders of processes that ended without deleting theirs: those that nobody locks.
    """
    _sweep_once()
    new = Path(tempfile.mkdtemp(prefix=NEW))
    if fcntl is None:
        return new
    lock = _lock(new)
    folder = new.with_name(PREFIX + new.name.removeprefix(NEW))
    new.rename(folder)  # only now it may be taken for a leftover, and is not, for it is locked
    if lock is not None:
        _held[folder] = lock
    return folder


def remove(folder: Path) -> None:
    """Delete a folder of `private_folder` with all that is in it."""
    shutil.rmtree(folder, ignore_errors=True)
    lock = _held.pop(folder, None)
    if lock is not None:
        os.close(lock)


def _lock(folder: Path) -> int | None:
    """The lock of a folder, None where another process holds it or it is gone."""
    try:
        descriptor = os.open(folder / "lock", os.O_RDWR | os.O_CREAT | os.O_CLOEXEC | os.O_NOFOLLOW, 0o600)
    except OSError:
        return None
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:
        os.close(descriptor)
        return None
    return descriptor


def _sweep_once() -> None:
    global _swept
    if _swept or fcntl is None:
        return
    _swept = True
    with suppress(OSError), os.scandir(tempfile.gettempdir()) as entries:
        for entry in entries:
            if entry.name.startswith((PREFIX, NEW)):
                with suppress(OSError):
                    _sweep(entry)


def _sweep(entry: os.DirEntry[str]) -> None:
    status = entry.stat(follow_symlinks=False)
    if not entry.is_dir(follow_symlinks=False) or status.st_uid != os.getuid():
        return
    folder = Path(entry.path)
    if entry.name.startswith(NEW):
        if time.time() - status.st_mtime > OLD:
            shutil.rmtree(folder, ignore_errors=True)
    elif folder not in _held and (lock := _lock(folder)) is not None:
        shutil.rmtree(folder, ignore_errors=True)
        os.close(lock)
