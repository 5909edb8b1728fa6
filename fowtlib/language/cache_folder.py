"""The folder of what is made once and kept: compiled libraries, texts, numbers.

It belongs to the user alone, because what lies in it is run: no other user may own it or write to it, and whatever is
taken from it is checked against a digest first. What was used last stays longest when its size passes the limit. Where
it cannot be written to, a temporary folder stands in for it.
"""

from __future__ import annotations

import errno
import hashlib
import os
import re
import shutil
import stat
import sys
import tempfile
import time
import warnings
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path

from fowtlib.language.errors import ParameterError
from fowtlib.language.left_over import remove_left_over
from fowtlib.language.stand_in import PREFIX, Refused, is_unwritable, make_stand_in, stand_in
from fowtlib.language.whole_files import sync_folder

LIMIT = 500.0  # MB, where FOWTLIB_CACHE_LIMIT says nothing else
SUFFIX = "dll" if sys.platform == "win32" else "so"
_YOUNG = 600.0  # s: what was used since then is not pruned, another process may be about to open it
_ABANDONED = 3600.0  # s: what a process was writing before then is not written any more
_OURS = re.compile(r"([A-Za-z]\w*?)_([0-9a-f]{12,40})(_[0-9a-f]{32})?\.(so|dll|c|json|packed)")
_WORK = "making_"
_OTHERS = stat.S_IRWXG | stat.S_IRWXO
_OTHERS_WRITE = stat.S_IWGRP | stat.S_IWOTH


@dataclass(frozen=True)
class Entry:
    """What belongs to one content: its kind, files, size [bytes] and the time of its last use [s]."""

    kind: str
    files: tuple[Path, ...]
    size: int
    used: float

    def remove(self) -> None:
        """Delete its files; another process may have done so before."""
        for path in self.files:
            _discard(path)


def cache_folder() -> Path:
    """Where things are kept: `named_folder`, or what stands in for it in this process. Raises as that one."""
    folder = named_folder()
    return stand_in(folder) or folder


def named_folder() -> Path:
    """FOWTLIB_CACHE, else fowtlib/native in the user's cache folder; always absolute.

    Raises PermissionError for a relative FOWTLIB_CACHE: what is run must not depend on the working folder.
    """
    if own := os.environ.get("FOWTLIB_CACHE"):
        if not os.path.isabs(own):
            raise Refused(errno.EPERM, "FOWTLIB_CACHE is not an absolute path", own)
        return Path(own)
    if sys.platform == "win32":
        given = os.environ.get("LOCALAPPDATA", "")
        home = Path(given) if os.path.isabs(given) else user_home() / "AppData" / "Local"
    else:
        given = os.environ.get("XDG_CACHE_HOME", "")
        home = Path(given) if os.path.isabs(given) else user_home() / ".cache"
    return home / "fowtlib" / "native"


def user_home() -> Path:
    """The home of the user; where HOME is no absolute path, that of the password database."""
    try:
        home = Path.home()
        if not home.is_absolute():
            import pwd

            home = Path(pwd.getpwuid(os.getuid()).pw_dir)
    except (RuntimeError, KeyError, ImportError):
        home = Path()
    if not home.is_absolute():
        raise Refused(errno.EPERM, "HOME is not an absolute path", str(home))
    return home


def private_folder() -> Path:
    """The cache folder, made if need be, of which it is certain that only this user can write to it.

    Where it cannot be written to that is a temporary one. Raises OSError where neither can be had.
    """
    folder = named_folder()
    if instead := stand_in(folder):
        return _private(instead)
    try:
        found = _private(folder)
        if not os.access(found, os.W_OK):
            raise PermissionError(errno.EACCES, "no permission", str(folder))
    except OSError as error:
        if not is_unwritable(error):
            raise
        return _private(make_stand_in(folder, error))
    return found


def give_up(error: OSError) -> bool:
    """Whether, after this error, a temporary folder stands in for one on a disk without room, and is worth a trial."""
    folder = named_folder()
    if error.errno not in (errno.ENOSPC, errno.EDQUOT) or stand_in(folder):
        return False
    make_stand_in(folder, error)
    return True


def _private(folder: Path) -> Path:
    folder.parent.mkdir(parents=True, exist_ok=True)
    folder.mkdir(mode=0o700, exist_ok=True)
    if sys.platform == "win32":
        return folder  # the profile of a user is closed to others
    _check_above(folder)
    state = folder.stat()
    if state.st_uid != os.getuid():
        raise Refused(errno.EPERM, "it belongs to another user", str(folder))
    if state.st_mode & _OTHERS:
        _close(folder, state.st_mode)
    return folder


def _check_above(folder: Path) -> None:
    """No other user can put another folder in the place of this one."""
    for above in folder.resolve().parents:
        state = above.stat()
        if state.st_mode & stat.S_IWOTH and not state.st_mode & stat.S_ISVTX:
            raise Refused(errno.EPERM, f"everybody can write to {above}, which it lies in", str(folder))


def _close(folder: Path, mode: int) -> None:
    """Take the rights of others away; of what they may have written nothing is kept."""
    strange = [name for name in os.listdir(folder) if not _OURS.fullmatch(name) and not name.startswith(_WORK)]
    if strange and os.environ.get("FOWTLIB_CACHE"):
        rights = f"others have rights to it (mode {stat.S_IMODE(mode):o})"
        why = f"{rights}, and it holds files of another kind, such as '{strange[0]}'"
        raise Refused(errno.EPERM, why, str(folder))
    folder.chmod(0o700)
    if folder.stat().st_mode & _OTHERS:
        raise Refused(errno.EPERM, "others have rights to it that cannot be taken away", str(folder))
    if mode & _OTHERS_WRITE:
        found = entries(folder)
        for entry in found:
            entry.remove()
        if found:
            warnings.warn(
                f"{folder}: others could write to this folder; what was kept there is made again.", stacklevel=2
            )


def find(name: str, suffix: str) -> Path | None:
    """The file kept under this name; one that is damaged or not the user's is deleted, which is said."""
    folder = private_folder()
    if folder != named_folder() and (path := _find_beneath(name, suffix)):
        return path
    for path in sorted(folder.glob(f"{name}_*.{suffix}")):
        if not _OURS.fullmatch(path.name):
            continue
        problem = _problem(path)
        if not problem:
            touch(path)
            return path
        _discard(path)
        if problem != "is gone":
            warnings.warn(f"{path}: this file {problem}; it is made again.", stacklevel=2)
    return None


def _find_beneath(name: str, suffix: str) -> Path | None:
    """What a folder that cannot be written to holds, as that of a container's image: only what is the user's alone."""
    folder = named_folder()
    with suppress(OSError):
        _check_above(folder)
        state = folder.stat()
        if state.st_uid == os.getuid() and not state.st_mode & _OTHERS_WRITE:
            for path in sorted(folder.glob(f"{name}_*.{suffix}")):
                if _OURS.fullmatch(path.name) and not _problem(path):
                    return path
    return None


def keep(name: str, suffix: str, made: Path) -> Path:
    """Move a file to its place, under the name and a digest of its content: whole or not at all, after a crash, too."""
    made.chmod(0o600)
    with made.open("rb") as file:
        digest = hashlib.file_digest(file, "sha256").hexdigest()[:32]
        os.fsync(file.fileno())
    folder = private_folder()
    path = folder / f"{name}_{digest}.{suffix}"
    os.replace(made, path)
    sync_folder(folder)
    return path


@contextmanager
def workshop() -> Iterator[Path]:
    """A folder for what is being made, beside its later place."""
    with tempfile.TemporaryDirectory(dir=private_folder(), prefix=_WORK, ignore_cleanup_errors=True) as folder:
        yield Path(folder)


def _problem(path: Path) -> str:
    """What is wrong with a file that was kept; "" where nothing is."""
    if problem := ownership_problem(path):
        return problem
    try:
        with path.open("rb") as file:
            digest = hashlib.file_digest(file, "sha256").hexdigest()[:32]
    except OSError as error:
        return f"cannot be read ({error.strerror})"
    if path.stem.endswith(f"_{digest}"):
        return ""
    return "is damaged" if path.stat().st_size else "is empty"


def ownership_problem(path: Path) -> str:
    """Why a file is not one that this user alone has written; "" where it is."""
    try:
        state = path.lstat()
    except OSError:
        return "is gone"
    if not stat.S_ISREG(state.st_mode):
        return "is not a regular file"
    if sys.platform == "win32":
        return ""
    if state.st_uid != os.getuid():
        return "belongs to another user"
    return "can be written by others" if state.st_mode & _OTHERS_WRITE else ""


def touch(path: Path) -> None:
    """Note that a file was used now."""
    with suppress(OSError):
        os.utime(path)


def _discard(path: Path) -> None:
    try:
        if path.is_dir() and not path.is_symlink():
            shutil.rmtree(path)
        else:
            path.unlink(missing_ok=True)
    except FileNotFoundError:
        pass


def limit() -> float:
    """The size [bytes] above which what was used longest ago goes; FOWTLIB_CACHE_LIMIT gives it in MB."""
    text = os.environ.get("FOWTLIB_CACHE_LIMIT")
    try:
        value = LIMIT if text is None else float(text)
    except ValueError:
        value = -1.0
    if not 0 <= value < float("inf"):
        raise ParameterError(f"FOWTLIB_CACHE_LIMIT is '{text}'; a number of MB is expected, for example 500.")
    return 1e6 * value


def entries(folder: Path | None = None) -> list[Entry]:
    """All that is kept, what was used last first; unfinished work of processes that are gone is of the kind ''."""
    found: dict[tuple[str, str], list[Path]] = {}
    folder = folder or cache_folder()
    for path in folder.iterdir() if folder.is_dir() else ():
        if match := _OURS.fullmatch(path.name):
            found.setdefault((match[1], match[2]), []).append(path)
        elif path.name.startswith(_WORK) and _age(path) > _ABANDONED:
            found[_WORK, path.name] = [path]
    made = []
    for (kind, _), files in found.items():
        inside = [inner for path in files for inner in (path, *path.rglob("*")) if not inner.is_dir()]
        sizes = [_size(path) for path in inside]
        made.append(Entry("" if kind == _WORK else kind, tuple(files), sum(sizes), time.time() - min(map(_age, files))))
    return sorted(made, key=lambda entry: -entry.used)


def prune() -> None:
    """Delete what was used longest ago until the rest is within the limit, and what was left half made.

    And the folders that stood in for one that could not be written to, of processes that were killed.
    """
    remove_left_over(PREFIX)
    most, total, now = limit(), 0, time.time()
    for entry in entries():
        total += entry.size
        if not entry.kind or (total > most and now - entry.used > _YOUNG):
            try:
                entry.remove()
            except OSError:  # in use, on Windows
                continue
            total -= entry.size


def clear() -> list[Entry]:
    """Delete everything that is kept; what was deleted."""
    found = entries()
    for entry in found:
        entry.remove()
    return found


def _age(path: Path) -> float:
    try:
        return time.time() - path.lstat().st_mtime
    except OSError:
        return 0.0


def _size(path: Path) -> int:
    try:
        return path.lstat().st_size
    except OSError:
        return 0
