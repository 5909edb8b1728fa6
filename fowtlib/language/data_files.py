"""Data files: text of any encoding as lines, and readers that remember what they read while the file is the same."""

from __future__ import annotations

import codecs
import csv
import hashlib
import os
import stat
import time
from collections import OrderedDict
from collections.abc import Callable, Sequence
from functools import lru_cache, wraps
from inspect import signature
from pathlib import Path
from typing import Any, TypeVar

from fowtlib.language.errors import ParameterError

Reader = TypeVar("Reader", bound=Callable[..., Any])
_REMEMBERED = 32  # results of one reader
_RACY = 2.0  # s within which a file system may give two versions of a file the same time
_digests: dict[str, tuple[tuple[int, ...], float, str]] = {}


def require_file(path: str | os.PathLike[str], error: type[Exception] = ParameterError) -> None:
    """Refuse what is there and is no file of data: folders, devices, pipes, what the system shows of its processes."""
    try:
        mode = os.stat(path).st_mode
    except (OSError, ValueError):
        return  # who reads it says what is wrong
    kinds = {stat.S_IFDIR: "a folder", stat.S_IFIFO: "a pipe", stat.S_IFSOCK: "a socket", stat.S_IFCHR: "a device"}
    kind = kinds.get(stat.S_IFMT(mode), "a device")
    if stat.S_ISREG(mode):
        real = os.path.realpath(path)
        if not real.startswith(("/proc/", "/sys/")):
            return
        kind = "not stored, but shown by the system"
    raise error(f"'{os.fspath(path)}' is {kind}; a file of data is expected.")


def text_of(path: str | os.PathLike[str], what: str = "the file", error: type[Exception] = ParameterError) -> str:
    """The text of a file, with line feeds only.

    UTF-8 with or without a byte order mark, UTF-16 with one, and else the Latin alphabet of Windows, which spreadsheets
    write; line ends of any system. Raises `error` with the path for a file that cannot be read or is no text.
    """
    require_file(path, error)
    try:
        content = Path(path).read_bytes()
    except OSError as problem:
        raise error(f"{os.fspath(path)}: cannot read {what}: {problem.strerror or problem}") from None
    text = _decoded(content)
    if text is None or "\0" in text:
        raise error(f"{os.fspath(path)}: cannot read {what}: this is not a text file")
    return text.replace("\r\n", "\n").replace("\r", "\n")


def _decoded(content: bytes) -> str | None:
    if content.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        encodings = ["utf-16"]
    else:
        encodings = ["utf-8-sig", "cp1252"]
    for encoding in encodings:
        try:
            return content.decode(encoding)
        except UnicodeDecodeError:
            continue
    return None


def lines_of(
    path: str | os.PathLike[str], what: str = "the file", error: type[Exception] = ParameterError
) -> list[tuple[int, str]]:
    """The lines of a table with their numbers, counted from 1; without blank lines and those that start with #."""
    numbered = enumerate(text_of(path, what, error).split("\n"), 1)
    return [(number, line) for number, line in numbered if line.strip() and not line.lstrip().startswith("#")]


def cells_of(line: str) -> list[str]:
    """The cells of a line of a CSV, without the spaces around them, also around quotes."""
    return [cell.strip() for cell in next(csv.reader([line], skipinitialspace=True))]


def number_rows(
    path: str | os.PathLike[str], names: Sequence[str], what: str, error: type[Exception] = ParameterError
) -> list[list[float]]:
    """The numbers of a CSV under the columns of these names, row by row; other columns are not read.

    Raises the error, with path and line, for a column that is missing and a row that is none of numbers.
    """
    lines, place = lines_of(path, what, error), os.fspath(path)
    if not lines:
        raise error(f"{place}: no {what.removeprefix('the ')}; the columns {', '.join(names)} are needed.")
    header = cells_of(lines[0][1])
    missing = [name for name in names if name not in header]
    if missing:
        raise error(f"{place}:{lines[0][0]}: column {missing[0]} is missing; there are {', '.join(header)}.")
    rows = []
    for number, line in lines[1:]:
        cells = dict(zip(header, cells_of(line), strict=False))
        try:
            rows.append([float(cells[name]) for name in names])
        except (KeyError, ValueError):
            words = f"'{line.strip()}' is not a row of numbers under {', '.join(header)}."
            raise error(f"{place}:{number}: {words}") from None
    return rows


def is_number(text: str) -> bool:
    """Whether a text is a number as Python reads it, also inf and nan."""
    try:
        float(text)
    except ValueError:
        return False
    return True


def digest_of(path: str | os.PathLike[str]) -> str:
    """SHA-256 of the content of a file; computed anew where the file may have changed. Raises OSError."""
    name, now = os.path.abspath(path), time.time()
    state = os.stat(name)
    version = (state.st_mtime_ns, state.st_ctime_ns, state.st_size, state.st_ino)
    if name in _digests:
        known, read_at, digest = _digests[name]
        if known == version and read_at - max(version[:2]) / 1e9 > _RACY:
            return digest
    with open(name, "rb") as file:
        digest = hashlib.file_digest(file, "sha256").hexdigest()
    _digests[name] = (version, now, digest)
    return digest


def remembered(*files: str) -> Callable[[Reader], Reader]:
    """Decorator of a reader: the same object for the same arguments, while the content of the files is the same.

    files: the arguments that are paths of files; by default the first one. Other arguments must be hashable. A file
    that cannot be read is the business of the reader.
    """

    def decorate(read: Reader) -> Reader:
        given = signature(read)
        paths = files or (next(iter(given.parameters)),)
        kept: OrderedDict[Any, Any] = OrderedDict()

        @wraps(read)
        def remembering(*arguments: Any, **options: Any) -> Any:
            bound = given.bind(*arguments, **options)
            bound.apply_defaults()
            values = dict(bound.arguments)
            for name in paths:
                if isinstance(values[name], (str, os.PathLike)):
                    require_file(values[name])
            try:
                contents = {name: (os.fspath(values[name]), digest_of(values[name])) for name in paths}
            except (OSError, TypeError):
                return read(*arguments, **options)
            key = tuple((values | contents).items())
            if key not in kept:
                kept[key] = read(*arguments, **options)
                while len(kept) > _REMEMBERED:
                    kept.popitem(last=False)
            kept.move_to_end(key)
            return kept[key]

        return remembering  # type: ignore[return-value]

    return decorate


def files_of(root: Any) -> dict[str, str]:
    """The files that the parameters of a model name, by the paths of the parameters."""
    found = {}
    for part in root.walk() if root is not None else ():
        for name in _may_be_files(type(part)):
            given = part.parameter_binding(name)
            if isinstance(given, str) and given and os.path.isfile(given):
                found[f"{part.path}.{name}" if part.path else name] = given
    return found


@lru_cache(maxsize=1000)
def _may_be_files(of: Any) -> tuple[str, ...]:
    """The parameters of a class of components whose value may be the name of a file."""
    items = of.parameters.items()
    return tuple(name for name, item in items if (item.annotation is str and item.choices is None) or item.is_data)


def data_parameters(root: Any) -> dict[str, str]:
    """Of those files, the ones that are declared as data."""
    owners = {path: path.rpartition(".") for path in files_of(root)}
    return {
        path: file
        for path, file in files_of(root).items()
        if root.find(owners[path][0]).parameters[owners[path][2]].is_data
    }


def named(path: str) -> str:
    """A file by its name and the digest of its content, not by its place."""
    try:
        return f"{Path(path).name} sha256:{digest_of(path)}"
    except OSError:
        return Path(path).name
