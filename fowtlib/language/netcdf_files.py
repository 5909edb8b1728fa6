"""netCDF files (classic format, by scipy) whose variables and attributes carry checksums.

The attribute `checksum` of a variable is the BLAKE2b digest of its name, dimensions, kind, attributes and numbers; that
of the file is the digest of the other attributes, the dimensions and the names of all variables. A file in which no
checksum stands was made by something else, or by an earlier version; in all others each of them must fit.
"""

from __future__ import annotations

import hashlib
import io
import json
import os
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass
from functools import cache
from importlib.util import find_spec, module_from_spec, spec_from_file_location
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from scipy.io import netcdf_file

CHECKSUM = "checksum"
HEAD = ""  # stands for the attributes and names of a file, among the names of what is damaged
_LARGEST = 2**30  # bytes of a variable that has been cut off


@dataclass(frozen=True)
class Variable:
    """Numbers of a variable, and its attributes as texts and numbers, without the checksum."""

    values: np.ndarray
    attributes: Mapping[str, Any]


@dataclass(frozen=True)
class Contents:
    """What a file holds. damaged: names of the variables that are not as they were written; HEAD for the file."""

    attributes: Mapping[str, Any]
    variables: Mapping[str, Variable]
    damaged: tuple[str, ...]

    @property
    def damage(self) -> str:
        """What has changed, for a message: of what is damaged the first."""
        if HEAD in self.damaged:
            return "its attributes or names are not those that were written"
        return f"the numbers or the attributes of {self.damaged[0]} are not those that were written"


@cache
def _scipys_class() -> type[netcdf_file]:
    """`scipy.io.netcdf_file` from its file alone: with all of scipy.io it takes long to import, a tenth of a start."""
    package = find_spec("scipy")
    for folder in (package and package.submodule_search_locations) or ():
        spec = spec_from_file_location("fowtlib_netcdf_of_scipy", Path(folder, "io", "_netcdf.py"))
        if spec and spec.loader:
            with suppress(OSError, ImportError, AttributeError):  # another version of scipy has it elsewhere
                module = module_from_spec(spec)
                spec.loader.exec_module(module)
                return module.netcdf_file
    from scipy.io import netcdf_file

    return netcdf_file


def write_netcdf(path: Path, fill: Callable[[netcdf_file], None], version: int = 1) -> None:
    """Make a file, let `fill` put into it what it holds, and add the checksums. version: 2 for more than 2 GB."""
    with _scipys_class()(path, "w", version=version) as file:
        fill(file)
        for name, variable in file.variables.items():
            setattr(variable, CHECKSUM, _of_variable(name, variable))
        setattr(file, CHECKSUM, _of_head(file))


def add_variable(file: netcdf_file, name: str, kind: str, dims: tuple[str, ...], values: Any, **about: Any) -> None:
    """Put a variable into a file, and the dimensions that are new. about: its attributes."""
    for dim, size in zip(dims, np.shape(values), strict=True):
        if dim not in file.dimensions:
            file.createDimension(dim, size)
    variable = file.createVariable(name, kind, dims)
    variable.data[...] = values
    set_attributes(variable, about)


def set_attributes(owner: Any, attributes: Mapping[str, Any]) -> None:
    """Of a file or a variable: text, as UTF-8, and numbers are all that an attribute can hold."""
    for key, value in attributes.items():
        if isinstance(value, (int, float)) and not isinstance(value, bool):
            setattr(owner, key, np.float64(value) if isinstance(value, float) else np.int32(value))
        else:
            setattr(owner, key, str(value).encode())


def read_netcdf(path: str | Path, cut: bool = False) -> Contents:
    """Read a file whole and check it. cut: also one whose end is missing; what lay there counts as damaged.

    Raises OSError where it cannot be read, ValueError where it is no such file or nothing in it can be found.
    """
    with _Stream(path, cut) as stream:
        try:
            file = _scipys_class()(stream, "r", mmap=False)
            variables = {name: _variable(variable) for name, variable in file.variables.items()}
            return Contents(_plain(file._attributes), variables, tuple(_damaged(file)))
        except Exception as error:  # a damaged head leads scipy anywhere
            reason = (str(error).splitlines() or [type(error).__name__])[0]
            raise ValueError(f"not a netCDF file of format 3, or damaged ({reason[:120]})") from error


class _Stream(io.BufferedReader):
    """A file that never gives more than it has, however much is asked for; `filled`: zeros for what is cut off."""

    def __init__(self, path: str | Path, filled: bool):
        super().__init__(io.FileIO(path))
        self.size, self.filled = os.fstat(self.fileno()).st_size, filled

    def read(self, size: int | None = -1) -> bytes:
        there = max(0, self.size - self.tell())
        if size is None or size < 0:
            return super().read(there)
        data = super().read(min(size, there))
        # 4 bytes are a number of the head, which must be there: it says how much else to read
        return data.ljust(size, b"\0") if self.filled and 4 < size <= _LARGEST else data


def _damaged(file: netcdf_file) -> list[str]:
    holders = [file, *file.variables.values()]
    if not any(CHECKSUM in holder._attributes for holder in holders):
        return []
    found = [] if _text(file._attributes.get(CHECKSUM)) == _of_head(file) else [HEAD]
    return found + [
        name for name, variable in file.variables.items()
        if _text(variable._attributes.get(CHECKSUM)) != _of_variable(name, variable)
    ]  # fmt: skip


def _of_variable(name: str, variable: Any) -> str:
    data = np.ascontiguousarray(variable.data)
    about = [name, list(variable.dimensions), list(np.shape(variable.data)), data.dtype.str]
    return _digest([about, _told(variable._attributes)], data.reshape(-1).view(np.uint8))


def _of_head(file: netcdf_file) -> str:
    names = sorted(file.variables)  # scipy writes them in an order of its own
    return _digest([_told(file._attributes), sorted(file.dimensions.items()), names])


def _digest(what: Any, data: Any = b"") -> str:
    found = hashlib.blake2b(json.dumps(what).encode(), digest_size=16)
    found.update(data)
    return found.hexdigest()


def _told(attributes: Mapping[str, Any]) -> list[tuple[str, str, str]]:
    """Name, kind and bytes of each attribute but the checksum."""
    told = []
    for key, value in attributes.items():
        if key == CHECKSUM:
            continue
        if isinstance(value, (str, bytes)):
            content = value.encode() if isinstance(value, str) else value
            told.append((key, "text", content.rstrip(b"\0").hex()))
        else:
            number = np.asarray(value)
            number = number.astype(number.dtype.newbyteorder(">"))
            told.append((key, number.dtype.str, number.tobytes().hex()))
    return told


def _variable(variable: Any) -> Variable:
    data = np.asarray(variable.data)
    return Variable(data.astype(data.dtype.newbyteorder("=")), _plain(variable._attributes))


def _plain(attributes: Mapping[str, Any]) -> dict[str, Any]:
    plain = {key: value.item() if isinstance(value, np.generic) else value for key, value in attributes.items()}
    return {key: _text(value) if isinstance(value, bytes) else value for key, value in plain.items() if key != CHECKSUM}


def _text(value: Any) -> Any:
    return value.decode("utf-8", "replace") if isinstance(value, bytes) else value
