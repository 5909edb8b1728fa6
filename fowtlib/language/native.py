"""C code of external functions: compiled once, kept in a cache by its content, unloaded when nobody uses it any more.

It stands on the first floor because external functions do: a component hands over C text, and everything above finds a
library. The name of a library is a digest of the text, the flags and the compiler with its version, so that it is never
stale, and a digest of its own content, which is checked before it is loaded. So no two contents share a path (the
dynamic loader hands out a library it has already loaded from the same path).
"""

from __future__ import annotations

import _ctypes
import atexit
import ctypes
import errno
import gc
import hashlib
import importlib.util
import os
import shlex
import shutil
import signal
import subprocess
import sys
import threading
import warnings
import weakref
from contextlib import suppress
from functools import lru_cache
from pathlib import Path

from fowtlib.language import cache_folder as store
from fowtlib.language.errors import CompilerError, ParameterError

EXPORT = '#define EXPORT __attribute__((visibility("default")))\n'
"""In front of C text: what stands behind EXPORT is seen from outside of the library, and nothing else."""

FLAGS = ("-std=c11", "-O2", "-fPIC", "-shared", "-fvisibility=hidden", "-fno-math-errno")
NO_COMPILER = (
    "no C compiler was found. Install gcc or clang (Debian, Ubuntu: apt install gcc), name one in the environment "
    "variable FOWTLIB_CC, or take the compiler of the Python package ziglang: pip install 'fowtlib[compiler]'."
)


@lru_cache(maxsize=8)
def _find(named: str | None) -> tuple[str, ...]:
    if named is not None:
        try:
            words = shlex.split(named)
        except ValueError as error:
            raise CompilerError(f"the environment variable FOWTLIB_CC is {named!r}, not a command: {error}.") from None
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


def compile_library(text: str, name: str, *, optimization: str = "-O2") -> Path:
    """The path of the shared library made of C text; compiled now if the cache does not have it, or not unharmed.

    name is for people: it begins the file's name and stands in messages. The text is kept beside the library. Raises
    CompilerError without a compiler, or with the compiler's words when the text is wrong.
    """
    command = compiler()
    if not command:
        raise CompilerError(f"{name} needs its C code compiled, and {no_compiler()}")
    flags, key = _flags(optimization), _key(text, name, optimization, command)
    begun = _begun.get((text, optimization))
    if begun and begun is not threading.current_thread():
        if not begun.taken.acquire(blocking=False):  # else it waits for others, and leaves it to us
            begun.join()
        _begun.pop((text, optimization), None)
    store.limit()  # a wrong one is said before the work
    try:
        if library := store.find(key, store.SUFFIX):
            return library
        with store.workshop() as folder:
            source, fresh = folder / "source.c", folder / f"fresh.{store.SUFFIX}"
            source.write_text(EXPORT + text, encoding="utf-8")
            run_compiler([*command, *flags, str(source), "-o", str(fresh), "-lm"], name)
            library = store.keep(key, store.SUFFIX, fresh)
            os.replace(source, library.with_name(f"{key}.c"))
        store.prune()
    except OSError as error:
        if store.give_up(error):
            return compile_library(text, name, optimization=optimization)
        raise CompilerError(
            f"{name}: cannot write the compiled library to {error.filename or store.cache_folder()}: {error.strerror}; "
            "the environment variable FOWTLIB_CACHE names another folder."
        ) from None
    return library


def _flags(optimization: str) -> list[str]:
    return [optimization if flag == "-O2" else flag for flag in FLAGS]


def _key(text: str, name: str, optimization: str, command: tuple[str, ...]) -> str:
    """The name under which a library is kept."""
    parts = (EXPORT, text, *_flags(optimization), *command, _version(command))
    return f"{name}_{hashlib.sha256(chr(0).join(parts).encode()).hexdigest()[:20]}"


class _Begun(threading.Thread):
    """Compiles a library. taken: held by the one who does it, this thread or who could not wait for it."""

    def __init__(self, text: str, name: str, optimization: str):
        super().__init__(name=f"compiler of {name}")
        self.taken = threading.Lock()
        self._asked = text, name, optimization

    def run(self) -> None:
        text, name, optimization = self._asked
        with _spare, suppress(CompilerError, ParameterError, OSError):
            if threading.main_thread().is_alive() and self.taken.acquire(blocking=False):
                compile_library(text, name, optimization=optimization)


_begun: dict[tuple[str, str], _Begun] = {}
_spare = threading.Semaphore(max(1, (os.cpu_count() or 1) - 1))  # one core is for what is done beside


def begin_library(text: str, name: str, *, optimization: str = "-O2") -> None:
    """Compile beside other work what `compile_library` will be asked for soon, which then waits for it.

    What goes wrong is not said here: it goes wrong again when the library is asked for. A process that ends earlier
    waits for the compilers that run, and no other one is begun.
    """
    command = compiler()
    if not command or (text, optimization) in _begun:
        return
    key = _key(text, name, optimization, command)
    with suppress(OSError):
        if not any(store.cache_folder().glob(f"{key}_*.{store.SUFFIX}")):
            _begun[text, optimization] = thread = _Begun(text, name, optimization)
            thread.start()


class Library(ctypes.CDLL):
    """A shared library that is closed when nobody holds it any more, nor any of its functions.

    Who keeps the address of a function as a number has to hold the library, too.
    """

    def __init__(self, path: str):
        super().__init__(path)
        weakref.finalize(self, _unused.append, self._handle).atexit = False


_libraries: weakref.WeakValueDictionary[str, Library] = weakref.WeakValueDictionary()
_MANY = _many = 32
_unused: list[int] = []  # what was thrown away together with a library may still call it to say goodbye


def open_library(path: str | Path) -> Library:
    """The library of a path, opened once; those that nobody holds any more are closed now. Raises OSError."""
    global _many
    found = _libraries.get(str(path))
    if found is None and len(_libraries) >= _many:
        gc.collect()  # plants are circles of objects, and Python does not see how much hangs on them
        _many = _MANY + 2 * len(_libraries)
    with suppress(IndexError):  # another thread was faster
        while _unused:
            _close(_unused.pop())
    if found is None:
        found = _libraries[str(path)] = Library(str(path))
    return found


def _close(handle: int) -> None:
    if sys.platform == "win32":
        _ctypes.FreeLibrary(handle)
    else:
        _ctypes.dlclose(handle)


def load_library(text: str, name: str, *, optimization: str = "-O2") -> tuple[Path, Library]:
    """`compile_library`, and the library opened before another process can clear the cache."""
    for again in (True, True, False):
        path = compile_library(text, name, optimization=optimization)
        try:
            return path, open_library(path)
        except OSError as error:
            if path.is_file() or not again:
                raise CompilerError(f"{name}: the compiled library {path} cannot be loaded: {error}.") from None
    raise AssertionError


@lru_cache(maxsize=8)
def _version(command: tuple[str, ...]) -> str:
    return subprocess.run([*command, "--version"], capture_output=True, text=True).stdout


def run_compiler(command: list[str], name: str) -> None:
    """Run a command of a compiler; CompilerError with its first words of error, behind the name of what is compiled."""
    status, said = _finished(command)
    if status:
        lines = [line for line in said.splitlines() if line.strip()]
        if os.strerror(errno.ENOSPC) in said:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC), command[command.index("-o") + 1])
        first = next((line for line in lines if "error" in line), lines[0] if lines else "no message")
        raise CompilerError(f"{name}: its C code does not compile with {command[0]} (exit status {status}): {first}")


_running: set[subprocess.Popen[str]] = set()


def _finished(command: list[str]) -> tuple[int, str]:
    """The exit status of a compiler and what it said; where that is not waited for, the compiler ends, too."""
    if sys.platform == "win32":
        process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
    else:  # in a group of their own, as gcc is one process and its compiler another
        process = subprocess.Popen(
            command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True, process_group=0
        )
    with process:
        _running.add(process)
        try:
            said = process.communicate()[1]
        except BaseException:
            _end(process)
            raise
        finally:
            _running.discard(process)
    return process.returncode, said


def _end(process: subprocess.Popen[str]) -> None:
    with suppress(OSError):
        if sys.platform == "win32":
            process.terminate()
        else:
            os.killpg(process.pid, signal.SIGTERM)  # gcc deletes what it has begun


@atexit.register
def _end_all() -> None:
    """Of a process that does not wait for what it compiles beside."""
    for process in tuple(_running):
        _end(process)
