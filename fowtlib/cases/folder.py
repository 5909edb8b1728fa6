"""The folder of a cases file: where relative names of files begin, and which files it may name."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from fowtlib.modelfile import files
from fowtlib.modelfile.permit import Permit, permit_for

Allowed = str | os.PathLike[str] | Sequence[str | os.PathLike[str]]


@dataclass(frozen=True)
class Folder:
    """A folder, and what may be read from there: files in it and below, shipped ones, and those of allowed folders."""

    path: Path
    permit: Permit

    def find(self, name: str) -> Path:
        """The file of a name, which must be there; ModelFileError without a place."""
        return files.find_data(name, self.path, self.permit)

    def allowed(self, name: str) -> Path:
        """The whole path of a name, whether there is such a file or not."""
        return files.data_place(name, self.path, self.permit)


def folder_of(file: Path, allow: Allowed = ()) -> Folder:
    """The folder of a file; `allow` names further ones that it may read from."""
    permit = permit_for(file, files.models_folder(), allow, trust=False)
    return Folder(file.absolute().parent, replace(permit, of="cases file", by="fw.read_cases"))
