"""Numbers of text files that Fortran programs read and write, and errors that name file and line."""

from __future__ import annotations

import math
from pathlib import Path

from fowtlib.components.hydro.errors import HydrodynamicDataError


def wrong(path: Path, line: int | None, message: str) -> HydrodynamicDataError:
    """An error about a file, and about a line of it where there is one."""
    return HydrodynamicDataError(f"{path}:{line}: {message}" if line else f"{path}: {message}")


def number_of(path: Path, line: int, word: str, hint: str = "") -> float:
    """A finite number, also with the exponent D; hint: follows "is not a number". Raises HydrodynamicDataError."""
    try:
        value = float(word.replace("D", "E").replace("d", "e")) if "_" not in word else math.nan
    except ValueError:
        raise wrong(path, line, f"'{word}' is not a number{hint}") from None
    if not math.isfinite(value):
        raise wrong(path, line, f"'{word}' is not a finite number")
    return value
