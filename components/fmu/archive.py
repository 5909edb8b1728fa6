"""The archive of an FMU, read with suspicion: nothing is written outside of its folder, nothing grows without limit."""

from __future__ import annotations

import stat
import zipfile
import zlib
from pathlib import Path, PurePosixPath

from fowtlib.language.errors import ModelError

MOST_ENTRIES = 20_000
MOST_UNPACKED = 2 * 10**9  # bytes of all files together
MOST_DESCRIPTION = 20 * 10**6  # bytes of modelDescription.xml
DESCRIPTION = "modelDescription.xml"
_PIECE = 1 << 20
_BROKEN = (zipfile.BadZipFile, zlib.error, EOFError, OSError, ValueError, RuntimeError, NotImplementedError,
           OverflowError, LookupError, MemoryError)  # fmt: skip


class Archive:
    """A zip file that has passed all checks that need no unpacking. Raises ModelError for one that has not."""

    def __init__(self, path: str | Path):
        self.path = Path(path)
        try:
            with zipfile.ZipFile(self.path) as file:
                entries = file.infolist()
        except FileNotFoundError:
            raise ModelError(f"there is no file '{self.path}'.") from None
        except IsADirectoryError:
            raise ModelError(f"'{self.path}' is a folder; an .fmu file is expected.") from None
        except _BROKEN as error:
            raise self.broken(f"it cannot be read as a zip archive ({error or type(error).__name__})") from None
        if len(entries) > MOST_ENTRIES:
            raise self.broken(f"it has {len(entries)} entries, more than the limit of {MOST_ENTRIES}")
        total = sum(entry.file_size for entry in entries)
        if total > MOST_UNPACKED:
            sizes = f"{total / 1e9:.3g} GB, more than the limit of {MOST_UNPACKED / 1e9:g} GB"
            raise self.broken(f"unpacked it has {sizes}")
        folders: dict[str, bool] = {}  # by name; one may be listed again and again, as `cmake -E tar` does
        for entry in entries:
            self._check(entry)
            name, folder = entry.filename.lower().rstrip("/"), entry.is_dir()
            if name in folders and not (folder and folders[name]):
                what = "two entries" if folder == folders[name] else "a folder and a file"
                raise self.broken(f"it has {what} '{entry.filename}'")
            folders[name] = folder
        self.names = [entry.filename for entry in entries]

    def broken(self, why: str) -> ModelError:
        """The error of a file that is not an FMU one can use."""
        return ModelError(f"'{self.path.name}' is not a usable FMU: {why}.")

    def _check(self, entry: zipfile.ZipInfo) -> None:
        name = entry.orig_filename
        parts = PurePosixPath(name).parts
        outside = not parts or name.startswith("/") or ".." in parts or ":" in parts[0]
        if outside or "\\" in name or not name.isprintable():
            raise self.broken(f"the entry {name!r} would be written outside of its folder")
        if stat.S_ISLNK(entry.external_attr >> 16):
            raise self.broken(f"the entry '{name}' is a symbolic link")
        if entry.flag_bits & 0x1:
            raise self.broken(f"the entry '{name}' is encrypted")

    def description(self) -> bytes:
        """The bytes of modelDescription.xml."""
        if DESCRIPTION not in self.names:
            raise self.broken(f"it has no {DESCRIPTION}")
        try:
            with zipfile.ZipFile(self.path) as file, file.open(DESCRIPTION) as stream:
                content = stream.read(MOST_DESCRIPTION + 1)
        except _BROKEN as error:
            raise self.broken(f"its {DESCRIPTION} cannot be unpacked ({error or type(error).__name__})") from None
        if len(content) > MOST_DESCRIPTION:
            raise self.broken(f"its {DESCRIPTION} is larger than the limit of {MOST_DESCRIPTION / 1e6:g} MB")
        return content

    def unpack(self, folder: Path) -> None:
        """Write all files below an empty folder; never more than their sizes in the archive say."""
        try:
            with zipfile.ZipFile(self.path) as file:
                for entry in file.infolist():
                    self._check(entry)
                    target = folder.joinpath(*PurePosixPath(entry.filename).parts)
                    if entry.is_dir():
                        target.mkdir(parents=True, exist_ok=True)
                        continue
                    target.parent.mkdir(parents=True, exist_ok=True)
                    self._write(file, entry, target)
        except _BROKEN as error:
            raise self.broken(f"it cannot be unpacked ({error or type(error).__name__})") from None

    def _write(self, file: zipfile.ZipFile, entry: zipfile.ZipInfo, target: Path) -> None:
        left = entry.file_size
        with file.open(entry) as stream, target.open("xb") as out:
            while piece := stream.read(_PIECE):
                left -= len(piece)
                if left < 0:
                    raise ValueError(f"'{entry.filename}' is larger than the archive says")
                out.write(piece)

    def platforms(self, identifier: str) -> list[str]:
        """The folders below binaries/ that hold a library of this name."""
        found = []
        for name in self.names:
            parts = PurePosixPath(name).parts
            if len(parts) == 3 and parts[0] == "binaries" and PurePosixPath(parts[2]).stem == identifier:
                found.append(parts[1])
        return sorted(set(found))
