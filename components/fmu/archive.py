"""The archive of an FMU, read with suspicion: nothing is written outside of its folder, nothing grows without limit."""

from __future__ import annotations

import stat
import unicodedata
import zipfile
import zlib
from pathlib import Path, PurePosixPath

from fowtlib.language.errors import ModelError

MOST_ENTRIES = 20_000
MOST_UNPACKED = 10**9  # bytes of all files together
MOST_RATIO = 100  # times the packed size; libraries and tables have 2 to 20, zeros have 1000
SMALL = 10**7  # bytes that may be unpacked at any ratio
LONGEST_NAME, LONGEST_PATH, DEEPEST = 200, 1000, 30  # bytes of a name, bytes and folders of a path
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
        self._check_sizes(entries)
        folders: dict[str, bool] = {}  # by name; one may be listed again and again, as `cmake -E tar` does
        for entry in entries:
            self._check(entry)
            name, folder = _compared(entry.filename), entry.is_dir()
            if name in folders and not (folder and folders[name]):
                what = "two entries" if folder == folders[name] else "a folder and a file"
                raise self.broken(f"it has {what} '{entry.filename}'")
            folders[name] = folder
        for entry in entries:
            for parent in PurePosixPath(_compared(entry.filename)).parents:
                if folders.get(str(parent)) is False:
                    raise self.broken(f"the entry '{entry.filename}' lies in '{parent}', which is a file")
        self.names = [entry.filename for entry in entries]

    def _check_sizes(self, entries: list[zipfile.ZipInfo]) -> None:
        """Refuse what would fill a disk; nothing is unpacked for that."""
        total, packed = sum(entry.file_size for entry in entries), self.path.stat().st_size
        if total > MOST_UNPACKED:
            sizes = f"{total / 1e9:.3g} GB, more than the limit of {MOST_UNPACKED / 1e9:g} GB"
            raise self.broken(f"unpacked it has {sizes}")
        for entry in entries:
            if entry.file_size > max(SMALL, MOST_RATIO * entry.compress_size):
                raise self.broken(_bomb(f"the entry {entry.filename[:100]!r}", entry.compress_size, entry.file_size))
        if total > max(SMALL, MOST_RATIO * packed):
            raise self.broken(_bomb("it", packed, total))
        if sum(entry.compress_size for entry in entries) > packed:
            raise self.broken("its entries are larger than itself: they overlap, or it is cut off")

    def broken(self, why: str) -> ModelError:
        """The error of a file that is not an FMU one can use."""
        return ModelError(f"'{self.path.name}' is not a usable FMU: {why}.")

    def _check(self, entry: zipfile.ZipInfo) -> None:
        name = entry.orig_filename
        parts = PurePosixPath(name).parts
        outside = not parts or name.startswith("/") or ".." in parts or ":" in parts[0]
        if outside or "\\" in name or not name.isprintable():
            raise self.broken(f"the entry {name[:100]!r} would be written outside of its folder")
        sizes = [len(part.encode("utf-8", "replace")) for part in parts]
        if max(sizes) > LONGEST_NAME or sum(sizes) > LONGEST_PATH or len(parts) > DEEPEST:
            raise self.broken(
                f"the entry '{name[:60]}...' has a path of {sum(sizes)} bytes in {len(parts)} parts; up to "
                f"{LONGEST_PATH} in {DEEPEST} parts of {LONGEST_NAME} are possible"
            )
        mode = entry.external_attr >> 16
        if stat.S_ISLNK(mode):
            raise self.broken(f"the entry '{name}' is a symbolic link")
        if entry.create_system == 3 and stat.S_IFMT(mode) not in (0, stat.S_IFREG, stat.S_IFDIR):
            raise self.broken(f"the entry '{name}' is neither a file nor a folder")
        if entry.compress_type not in (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED):
            raise self.broken(f"the entry '{name}' is packed by the method {entry.compress_type}, and FMI has deflate")
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


def _compared(name: str) -> str:
    """A name as a file system that folds letters sees it."""
    return unicodedata.normalize("NFC", name).casefold().rstrip("/")


def _bomb(what: str, packed: int, unpacked: int) -> str:
    return (
        f"{what} grows from {packed} to {unpacked} bytes when it is unpacked, more than the limit of {MOST_RATIO} times"
    )
