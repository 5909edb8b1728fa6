"""Results of a long computation on disk as they come, so that none is lost: to a failure, a key pressed, a bad path."""

from __future__ import annotations

import hashlib
import tempfile
import warnings
import zipfile
import zlib
from collections.abc import Callable
from pathlib import Path

import numpy as np

from fowtlib.language.errors import ModelError
from fowtlib.language.whole_files import WriteError, write_whole


class Store:
    """Arrays by name in a file `<target>.partial.npz` beside the target, kept for a computation with the same inputs.

    Without a target nothing is stored. Raises ModelError at once where the target could not be written later.
    """

    def __init__(self, target: str | Path | None, inputs: object):
        self.path = None if target is None else Path(f"{target}.partial.npz")
        self.digest = hashlib.sha256(repr(inputs).encode()).hexdigest()
        self.arrays: dict[str, np.ndarray] = {}
        if self.path is not None:
            _check(Path(target), self.path)
            self.arrays = self._read()

    def _read(self) -> dict[str, np.ndarray]:
        try:
            with np.load(self.path) as file:
                arrays = {name: file[name] for name in file.files}
        except (OSError, ValueError, EOFError, KeyError, zipfile.BadZipFile, zlib.error, NotImplementedError):
            return {}
        same = str(arrays.pop("inputs", "")) == self.digest
        return arrays if same else {}

    def once(self, name: str, make: Callable[[], np.ndarray]) -> np.ndarray:
        """What is stored under a name; else it is made and stored."""
        if name not in self.arrays:
            self.arrays[name] = make()
            self._write()
        return self.arrays[name]

    def _write(self) -> None:
        if self.path is None:
            return
        try:
            write_whole(self.path, lambda temporary: np.savez(temporary, inputs=self.digest, **self.arrays))
        except WriteError as error:  # of a full disk: it may have room again for the next piece
            warnings.warn(f"{error.message} The computation goes on, with its results in memory.", stacklevel=4)

    def finish(self) -> None:
        """The target is written: the file beside it has no further use."""
        if self.path is not None:
            self.path.unlink(missing_ok=True)


def _check(target: Path, partial: Path) -> None:
    if not target.parent.is_dir():
        raise ModelError(f"{target}: the folder {target.parent} does not exist; make it first, or choose another one.")
    try:
        with tempfile.TemporaryFile(dir=partial.parent):
            pass
        if target.exists():
            with target.open("ab"):
                pass
    except OSError as error:
        raise ModelError(f"{target}: cannot be written: {error.strerror or error}.") from None
