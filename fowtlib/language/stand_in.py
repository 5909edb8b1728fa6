"""A folder for what is kept while one process runs, where the cache folder cannot be written to.

So it is in a container whose home is read-only, or on a disk without room. Processes that this one starts use the same
folder, which they find in their environment; with the first process it goes. Where that is killed, it goes when a later
process makes one of its own, or puts something into its cache, and nobody uses it any more.
"""

from __future__ import annotations

import atexit
import errno
import os
import shutil
import tempfile
import threading
import warnings
from pathlib import Path

from fowtlib.language.left_over import hold, remove_left_over

VARIABLE = "FOWTLIB_CACHE_STAND_IN"
"""For processes that this one starts: the folder that cannot be written to and the one instead, two lines."""

PREFIX = "fowtlib_cache_"

_UNWRITABLE = (errno.EACCES, errno.EROFS, errno.ENOSPC, errno.EDQUOT)
_lock = threading.Lock()


class Refused(PermissionError):
    """The folder could be written to, but is not safe."""


def is_unwritable(error: OSError) -> bool:
    """Whether the system does not let this user write there."""
    return error.errno in _UNWRITABLE and not isinstance(error, Refused)


def stand_in(folder: Path) -> Path | None:
    """The folder used instead of this one; None where there is none."""
    named, _, instead = os.environ.get(VARIABLE, "").partition("\n")
    if not (instead and named == str(folder) and os.path.isabs(instead)):
        return None
    hold(Path(instead))
    return Path(instead)


def make_stand_in(folder: Path, error: OSError) -> Path:
    """A new folder to be used instead of this one, which is said once. Raises the error where there is no room."""
    with _lock:
        if found := stand_in(folder):
            return found
        try:
            remove_left_over(PREFIX)
            made = Path(tempfile.mkdtemp(prefix=PREFIX))
        except OSError:
            raise error from None
        hold(made)
        os.environ[VARIABLE] = f"{folder}\n{made}"
        atexit.register(_remove, made, os.getpid())
    warnings.warn(
        f"{folder}: this cache folder cannot be written to ({error.strerror}); {made} is used until this program ends, "
        "so that compiled code is made again each time. The environment variable FOWTLIB_CACHE names another folder.",
        stacklevel=2,
    )
    return made


def _remove(made: Path, process: int) -> None:
    if os.getpid() == process:  # not a process that was forked
        shutil.rmtree(made, ignore_errors=True)
