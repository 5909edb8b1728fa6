"""Results that must not be lost: where a file cannot be written there is another place, and the journal stays."""

from __future__ import annotations

import tempfile
from contextlib import suppress
from itertools import chain, count
from pathlib import Path
from typing import TYPE_CHECKING

from fowtlib.language.errors import ModelError

if TYPE_CHECKING:
    from fowtlib.solving.results import Result
    from fowtlib.solving.results.journal import Journal


def free_name(stem: str | Path) -> Path:
    """A name of a result that is not there yet."""
    names = (Path(f"{stem}{number}.nc") for number in chain([""], (f"_{k}" for k in count(2))))
    return next(path for path in names if not path.exists())


def save(result: Result, path: Path, journal: Journal | None) -> tuple[Path | None, str]:
    """Save a result, elsewhere if it must be; take the journal away when the result lies there or beside it.

    Where it lies, None if nowhere; and in words what went wrong and what is kept where, "" where all is well.
    """
    try:
        place, words = result.save(path), ""
    except ModelError as error:
        place, words = _beside(result, path), str(error)
    if place:
        if journal:
            journal.remove()
        return place, words and f"{words}\nThe results are saved in {place} instead."
    place = _in_temporary_folder(result, path)
    if place:
        words += f"\nThe results are saved in {place} instead."
    else:
        words += f"\nThey cannot be saved in the temporary folder either ({_temporary_folder()})."
    return place, words + (_kept(journal) if journal else "")


def _beside(result: Result, path: Path) -> Path | None:
    """What the format of a file cannot hold goes into a netCDF file beside it."""
    if path.suffix == ".nc":
        return None
    with suppress(ModelError):
        return result.save(free_name(path.with_suffix("")))
    return None


def _in_temporary_folder(result: Result, path: Path) -> Path | None:
    folder = None
    try:
        folder = Path(tempfile.mkdtemp(prefix="fowtlib_results_"))
        return result.save(folder / f"{path.stem}.nc")
    except (ModelError, OSError):
        if folder:
            folder.rmdir()
        return None


def _temporary_folder() -> str:
    try:
        return tempfile.gettempdir()
    except OSError:
        return "there is none"


def _kept(journal: Journal) -> str:
    """What a journal holds, in words; one in which nothing can be read goes."""
    from fowtlib.solving.results.journal import read_journal

    time = ()
    with suppress(ModelError):
        time = read_journal(journal.path).time
    if not len(time):
        with suppress(OSError):
            journal.remove()
        return ""
    return f"\nThose up to t = {time[-1]:g} s are kept in {journal.path}; to go on from there: --resume {journal.path}"
