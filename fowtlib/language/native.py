"""C code of external functions: compiled once, kept in a cache by its content.

It stands on the first floor because external functions do: a component hands over C text, and everything above finds a
library. A library is kept under a name that is a digest of the text, the flags and the compiler with its version, so
that it is never stale, and no two contents share a path (the dynamic loader hands out a library it has already loaded
from the same path).
"""

from __future__ import annotations

import hashlib
import importlib.util
import os
import shlex
import shutil
import subprocess
import sys
import tempfile
import warnings
from functools import lru_cache
from pathlib import Path

from fowtlib.language.errors import CompilerError

EXPORT = '#define EXPORT __attribute__((visibility("default")))\n'
"""In front of C text: what stands behind EXPORT is seen from outside of the library, and nothing else."""

FLAGS = ("-std=c11", "-O2", "-fPIC", "-shared", "-fvisibility=hidden")
NO_COMPILER = (
    "no C compiler was found. Install gcc or clang (Debian, Ubuntu: apt install gcc), name one in the environment "
    "variable FOWTLIB_CC, or take the compiler of the Python package ziglang: pip install 'fowtlib[compiler]'."
)


@lru_cache(maxsize=8)
def _find(named: str | None) -> tuple[str, ...]:
    if named is not None:
        words = shlex.split(named)
        return tuple(words) if words and shutil.which(words[0]) else ()
    for word in ("gcc", "clang", "cc"):
        if shutil.which(word):
            return (word,)
    return (sys.executable, "-m", "ziglang", "cc") if importlib.util.find_spec("ziglang") else ()


def no_compiler() -> str:
    """Why there is no compiler, and what to do; one line."""
    named = os.environ.get("FOWTLIB_CC")
    return NO_COMPILER if named is None else f"FOWTLIB_CC names '{named}', which is no program here: {NO_COMPILER}"


def compiler() -> tuple[str, ...]:
    """The command of the C compiler: FOWTLIB_CC, else gcc, clang, cc, the ziglang package; empty when there is none."""
    return _find(os.environ.get("FOWTLIB_CC"))


@lru_cache(maxsize=64)
def say_once(message: str) -> None:
    """Warn of what runs slowly without a compiler, once in a process."""
    warnings.warn(message, RuntimeWarning, stacklevel=4)


def cache_folder() -> Path:
    """Where libraries are kept: FOWTLIB_CACHE, else fowtlib/native in the user's cache folder."""
    if own := os.environ.get("FOWTLIB_CACHE"):
        return Path(own)
    if sys.platform == "win32":
        home = os.environ.get("LOCALAPPDATA") or Path.home() / "AppData" / "Local"
    else:
        home = os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
    return Path(home) / "fowtlib" / "native"


def compile_library(text: str, name: str, *, optimization: str = "-O2") -> Path:
    """The path of the shared library made of C text; compiled now if the cache does not have it.

    name is for people: it begins the file's name and stands in messages. The text is kept beside the library. Raises
    CompilerError without a compiler, or with the compiler's words when the text is wrong.
    """
    command = compiler()
    if not command:
        raise CompilerError(f"{name} needs its C code compiled, and {no_compiler()}")
    flags = [optimization if flag == "-O2" else flag for flag in FLAGS]
    digest = hashlib.sha256("\0".join((EXPORT, text, *flags, *command, _version(command))).encode()).hexdigest()
    library = cache_folder() / f"{name}_{digest[:20]}.{'dll' if sys.platform == 'win32' else 'so'}"
    if library.is_file():
        return library
    try:
        library.parent.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(dir=library.parent) as folder:
            source, fresh = Path(folder) / "source.c", Path(folder) / library.name
            source.write_text(EXPORT + text, encoding="utf-8")
            run_compiler([*command, *flags, str(source), "-o", str(fresh), "-lm"], name)
            os.replace(source, library.with_suffix(".c"))
            os.replace(fresh, library)  # at once: another process sees a whole library or none
    except OSError as error:
        raise CompilerError(
            f"{name}: cannot write the compiled library to {library.parent}: {error.strerror}; the environment "
            "variable FOWTLIB_CACHE names another folder."
        ) from None
    return library


@lru_cache(maxsize=8)
def _version(command: tuple[str, ...]) -> str:
    return subprocess.run([*command, "--version"], capture_output=True, text=True).stdout


def run_compiler(command: list[str], name: str) -> None:
    """Run a command of a compiler; CompilerError with its first words of error, behind the name of what is compiled."""
    run = subprocess.run(command, capture_output=True, text=True)
    if run.returncode:
        lines = [line for line in run.stderr.splitlines() if line.strip()]
        first = next((line for line in lines if "error" in line), lines[0] if lines else "no message")
        raise CompilerError(
            f"{name}: its C code does not compile with {command[0]} (exit status {run.returncode}): {first}"
        )
