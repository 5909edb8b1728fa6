"""The binary output files of OpenFAST (.outb): writer of form 4, reader of all four forms.

Layout, little endian: int16 form; form 4: int16 length L of a name (10 in the others); int32 channels n, int32 times m;
float64 first time and step (form 1: scale and offset of the times); without form 3: float32 scales (n), float32 offsets
(n); int32 length of the description, the description; n + 1 names and n + 1 units of L bytes, time first; form 1: int32
times (m); the values by time, (m, n): float64 in form 3, else int16 that stand for (integer - offset) / scale.
The layout is that of NWTC's ReadFASTbinary (B. Jonkman, 2012) and of the readers that followed it.
"""

from __future__ import annotations

import struct
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from fowtlib.language.errors import ModelError

WITH_TIME, WITHOUT_TIME, NO_COMPRESSION, LENGTH_OF_NAMES = 1, 2, 3, 4
SHORT_NAME = 10  # of the forms that do not give the length of their names
LARGEST = 1e30  # a float32 scale can hold more, but nothing in a turbine is
_FULL = 32000  # of 32767: room for an offset that is rounded to float32
_OFFSET = 2.0**32  # beyond, that rounding would be as large as the room


@dataclass(frozen=True)
class Channels:
    """What an .outb file holds: time [s] (m,), names and units of the n channels, values (m, n), and a description."""

    time: np.ndarray
    names: tuple[str, ...]
    units: tuple[str, ...]
    values: np.ndarray
    description: str = ""


def write_outb(path: Path, channels: Channels) -> None:
    """Write the compressed form 4, which OpenFAST itself writes: int16 between the extremes of each channel.

    The error of a value is below 1/60000 of the range of its channel, or 2e-10 of its size if that is more. Raises
    ModelError: times that are not evenly spaced, values that are not finite or beyond 1e30.
    """
    step = _even_step(channels.time)
    scale, offset = _scaling(channels)
    names = [text.encode("ascii", "replace") for text in ("Time", *channels.names)]
    units = [f"({text})".encode("ascii", "replace") for text in ("s", *channels.units)]
    length = max(SHORT_NAME, *map(len, names), *map(len, units))
    description = channels.description.encode("ascii", "replace")
    packed = np.rint(channels.values * scale.astype(float) + offset.astype(float)).astype("<i2")
    with path.open("wb") as file:
        file.write(struct.pack("<hhii", LENGTH_OF_NAMES, length, len(channels.names), channels.time.size))
        file.write(struct.pack("<dd", channels.time[0], step))
        file.write(scale.tobytes() + offset.tobytes())
        file.write(struct.pack("<i", len(description)) + description)
        file.write(b"".join(text.ljust(length) for text in (*names, *units)))
        file.write(packed.tobytes())


def read_outb(path: str | Path) -> Channels:
    """Read an .outb file of any form. Raises ModelError when it is none, or cut off."""
    try:
        data = Path(path).read_bytes()
    except OSError as error:
        raise ModelError(f"{path}: cannot be read: {error.strerror}.") from None
    at = 0

    def take(kind: str, count: int) -> np.ndarray:
        nonlocal at
        size = np.dtype(kind).itemsize * count
        if count < 0 or at + size > len(data):
            raise ModelError(f"{path}: is not a binary output file of OpenFAST, or it is cut off.")
        at += size
        return np.frombuffer(data, kind, count, at - size)

    form = int(take("<i2", 1)[0])
    if form not in (WITH_TIME, WITHOUT_TIME, NO_COMPRESSION, LENGTH_OF_NAMES):
        raise ModelError(f"{path}: is not a binary output file of OpenFAST: it begins with {form}, not with 1 to 4.")
    length = int(take("<i2", 1)[0]) if form == LENGTH_OF_NAMES else SHORT_NAME
    n, m = map(int, take("<i4", 2))
    first, second = map(float, take("<f8", 2))
    compressed = form != NO_COMPRESSION
    scale, offset = (take("<f4", n).astype(float) for _ in range(2)) if compressed else (np.ones(n), np.zeros(n))
    description = _text(take("u1", int(take("<i4", 1)[0])))
    names, units = ([_text(row) for row in take("u1", length * (n + 1)).reshape(-1, length)] for _ in range(2))
    time = (take("<i4", m) - second) / first if form == WITH_TIME else first + second * np.arange(m)
    values = (take("<i2" if compressed else "<f8", m * n).reshape(m, n) - offset) / scale
    return Channels(time, tuple(names[1:]), tuple(unit.strip("()") for unit in units[1:]), values, description)


def _text(characters: np.ndarray) -> str:
    return characters.tobytes().decode("latin-1").strip().replace("\N{MIDDLE DOT}", "-")


def _even_step(time: np.ndarray) -> float:
    step = float(time[-1] - time[0]) / max(time.size - 1, 1)
    uneven = np.flatnonzero(np.abs(time - time[0] - step * np.arange(time.size)) > 1e-3 * step)
    if uneven.size:
        gaps = np.diff(time)
        k = int(np.argmax(np.abs(gaps - np.median(gaps))))
        raise ModelError(
            f"the file format knows evenly spaced times only, and these are not: {time[k]:g} s is followed by "
            f"{time[k + 1]:g} s. Save as .nc or .csv, or simulate for a multiple of the output step."
        )
    return step


def _scaling(channels: Channels) -> tuple[np.ndarray, np.ndarray]:
    """float32 scale and offset of each channel, such that every value becomes an int16."""
    for name, column in zip(channels.names, channels.values.T, strict=True):
        wrong = np.flatnonzero(~(np.abs(column) <= LARGEST))
        if wrong.size:
            raise ModelError(
                f"the value of {name} at {channels.time[wrong[0]]:g} s is {column[wrong[0]]:g}, which the file "
                "format cannot hold. Save as .nc or .csv."
            )
    low, high = channels.values.min(axis=0), channels.values.max(axis=0)
    middle, half = (low + high) / 2, (high - low) / 2
    with np.errstate(divide="ignore"):
        scale = np.minimum(np.minimum(_FULL / half, _OFFSET / np.abs(middle)), LARGEST)
    scale = np.where((half == 0) & (middle == 0), 1.0, scale).astype("<f4")
    return scale, (-middle * scale.astype(float)).astype("<f4")
