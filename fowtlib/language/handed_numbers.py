"""Numbers that a compiled external function finds by a handle: put into its library, or into a file beside an FMU."""

from __future__ import annotations

import ctypes
import weakref
from pathlib import Path

import numpy as np

from fowtlib.language import cache_folder as store
from fowtlib.language.errors import ParameterError
from fowtlib.language.externals import ExternalFunction
from fowtlib.language.native import open_library


def problem(function: ExternalFunction) -> str:
    """What the library of a function found wrong with the last numbers or arguments; empty: nothing."""
    found = getattr(open_library(function.library), f"{function.name}_problem")
    found.restype = ctypes.c_char_p
    text = found().decode("utf-8", "replace")
    return f"{text}." if text else ""


def load(function: ExternalFunction, handle: float, block: np.ndarray, owner: object) -> weakref.finalize:
    """Give the library of a function these numbers, until their owner is gone. Raises ParameterError: what is wrong."""
    library, numbers = open_library(function.library), np.ascontiguousarray(block)
    opened, close = getattr(library, f"{function.name}_load"), getattr(library, f"{function.name}_close")
    close.restype, close.argtypes = None, [ctypes.c_double]
    if opened(ctypes.c_double(handle), ctypes.c_void_p(numbers.ctypes.data), ctypes.c_longlong(numbers.size)):
        raise ParameterError(problem(function))
    return weakref.finalize(owner, close, handle)


def kept_file(name: str, ending: str, content: bytes) -> Path:
    """A file with this content in the folder of what is kept. Raises ParameterError where it cannot be written."""
    try:
        path = store.find(name, ending)
        if path is None or path.read_bytes() != content:
            with store.workshop() as folder:
                fresh = folder / f"fresh.{ending}"
                fresh.write_bytes(content)
                path = store.keep(name, ending, fresh)
    except OSError as error:
        if store.give_up(error):
            return kept_file(name, ending, content)
        raise ParameterError(
            f"{error.filename or store.cache_folder()}: cannot be written: {error.strerror or error}."
        ) from None
    return path
