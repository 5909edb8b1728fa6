"""Which files a model file may name: those beside and below it, shipped ones, and those in folders the user named."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from fowtlib.language import leave
from fowtlib.language.errors import ModelFileError


@dataclass(frozen=True)
class Permit:
    """What one file may; `trust`: it may also name native code, wherever it is. of, by: words for messages."""

    folders: tuple[Path, ...]
    trust: bool = False
    of: str = "model file"
    by: str = "fw.load"

    def require(self, path: Path, name: str, *, native: bool = False) -> None:
        """ModelFileError for a path, resolved, that may not be read; nothing is said of what is there."""
        if any(path.is_relative_to(folder) for folder in self.folders):
            return
        if native and (self.trust or leave.has_leave(path)):
            return
        raise ModelFileError(
            f"'{name}' is refused: it lies outside of the folder of the {self.of}. To let it be read, allow its "
            f"folder: --allow {path.parent}, or {self.by}(..., allow=['{path.parent}']) in Python."
        )


def permit_for(model: Path, shipped: Path, allow: Sequence[str | os.PathLike[str]], trust: bool) -> Permit:
    """The permit of a model file: allow and FOWTLIB_DATA_PATH name folders, and so does the leave that is kept."""
    folders = [model.absolute().parent, shipped, *leave.folders_of(model)]
    for text in filter(None, os.environ.get("FOWTLIB_DATA_PATH", "").split(os.pathsep)):
        if not os.path.isabs(text):
            raise ModelFileError(f"FOWTLIB_DATA_PATH: '{text}' is not an absolute path.")
        folders.append(Path(text))
    for item in [allow] if isinstance(allow, (str, os.PathLike)) else allow:
        folder = Path(item).expanduser()
        if not folder.is_dir():
            raise ModelFileError(f"allow: there is no folder '{item}'.")
        folders.append(folder)
    return Permit(tuple(folder.resolve() for folder in folders), trust)
