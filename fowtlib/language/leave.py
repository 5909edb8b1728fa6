"""Leave of the user for what a model file names: native code that it wants to run, folders that it wants to read.

A model file may come from anywhere. What it names as native code (a parameter declared `native`) runs with all rights
of the user, and so only with leave. Leave that was given once is kept in a file that a person can read, one line for
each: of native code by path and content, of a folder by the model file that may read in it.
"""

from __future__ import annotations

import json
import os
import sys
import time
import warnings
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from fowtlib.language.cache_folder import ownership_problem, user_home
from fowtlib.language.data_files import digest_of
from fowtlib.language.errors import ModelError, ParameterError

NATIVE, FOLDER = "native code", "folder"
_SHOWN = 12  # digits of a digest in messages
_MOST = 10**7  # bytes of the file


class FromModelFile(str):
    """The path of a file that a model file names, at `place`; with `leave` where the caller trusts the model file."""

    place: str = ""
    leave: bool = False

    @classmethod
    def at(cls, path: str, place: str, leave: bool) -> FromModelFile:
        """The path with the place that names it."""
        made = cls(path)
        made.place, made.leave = place, leave
        return made


def leave_file() -> Path:
    """Where leave is kept: fowtlib/trusted.jsonl in the user's folder of settings (XDG_CONFIG_HOME, ~/.config)."""
    given = os.environ.get("APPDATA" if sys.platform == "win32" else "XDG_CONFIG_HOME", "")
    home = Path(given) if os.path.isabs(given) else user_home() / ".config"
    return home / "fowtlib" / "trusted.jsonl"


def has_leave(path: str | Path) -> bool:
    """Whether native code may run: this path with this content."""
    return _native_entry(path, _digest(path)) is not None


def folders_of(model: Path) -> list[Path]:
    """The folders beyond its own in which a model file may read."""
    return [
        Path(entry["path"])
        for entry in _entries()
        if entry.get("leave") == FOLDER and entry.get("model") == str(model.resolve()) and "path" in entry
    ]


def give_folder(folder: Path, model: Path) -> Path:
    """Keep the leave of a model file to read in a folder and below; the folder, resolved."""
    found = folder.expanduser().resolve()
    if not found.is_dir():
        raise ParameterError(f"there is no folder '{folder}'.")
    if found not in folders_of(model):
        _add({"leave": FOLDER, "path": str(found), "model": str(model.resolve())})
    return found


def give_native(root: Any) -> list[str]:
    """Keep the leave of all native code that a model names; the paths that had none before."""
    fresh = []
    for _, path in native_code(root):
        if (digest := _digest(path)) and _native_entry(path, digest) is None:
            _add({"leave": NATIVE, "path": os.path.realpath(path), "sha256": digest})
            fresh.append(str(path))
    return fresh


def native_code(root: Any) -> Iterator[tuple[str, FromModelFile]]:
    """Paths of parameters, and the files that model files name there as native code."""
    from fowtlib.language.declarations import join

    for part in root.walk() if root is not None else ():
        for name, declared in part.parameters.items():
            if declared.native and isinstance(given := part.parameter_binding(name), FromModelFile):
                yield join(part.path, name), given


def require_leave(root: Any) -> None:
    """ModelError where a model names native code that has no leave; asked before anything of it is loaded."""
    for where, path in native_code(root):
        digest = "" if path.leave else _digest(path)
        if digest and _native_entry(path, digest) is None:
            before = any(entry.get("path") == os.path.realpath(path) for entry in _entries())
            what = "which has changed since it got leave" if before else "which runs with your rights and has no leave"
            error = ModelError(
                f"{where} names native code, {path} (sha256 {digest[:_SHOWN]}...), {what}. If you trust it, add "
                "--trust once, or load the model with fw.load(..., trust=True)."
            )
            raise error.at(path.place)


def _native_entry(path: str | Path, digest: str) -> dict[str, str] | None:
    wanted = {"leave": NATIVE, "path": os.path.realpath(path), "sha256": digest}
    return next((entry for entry in _entries() if wanted.items() <= entry.items()), None)


def _digest(path: str | Path) -> str:
    try:
        return digest_of(path)
    except OSError:
        return ""  # who loads it says what is wrong


def _entries() -> list[dict[str, str]]:
    """What is kept; nothing where others could have written it."""
    path = leave_file()
    problem = ownership_problem(path)
    if not problem and path.stat().st_size > _MOST:
        problem = "is too large"
    if problem:
        if problem != "is gone":
            warnings.warn(f"{path}: this file {problem}; the leave in it does not count.", stacklevel=2)
        return []
    found = []
    for number, line in enumerate(path.read_text(encoding="utf-8", errors="replace").splitlines(), 1):
        try:
            entry = json.loads(line) if line.strip() else {}
        except (ValueError, RecursionError):
            entry = None
        if not isinstance(entry, dict):
            warnings.warn(f"{path}:{number}: this line is damaged; the leave in it does not count.", stacklevel=2)
            continue
        found.append(entry)
    return found


def _add(entry: dict[str, str]) -> None:
    path = leave_file()
    _entries()  # says what is wrong with the file
    line = json.dumps(entry | {"given": time.strftime("%Y-%m-%d %H:%M:%S")}, ensure_ascii=False) + "\n"
    try:
        path.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
        if problem := ownership_problem(path).replace("is gone", ""):
            raise ModelError(f"{path}: this file {problem}, and leave cannot be kept in it; correct or delete it.")
        handle = os.open(path, os.O_WRONLY | os.O_APPEND | os.O_CREAT, 0o600)
        with os.fdopen(handle, "ab") as file:
            file.write(line.encode())
            file.flush()
            os.fsync(handle)
    except OSError as error:
        raise ModelError(f"{path}: the leave cannot be kept: {error.strerror or error}.") from None
