"""Full-field wind in TurbSim's binary format (`.bts`): reader and writer. Plain numpy.

A field is a plane of (y, z) points that the wind carries past with its mean speed. The file, little-endian:

    int16                id: 8 periodic in time, 7 not
    int32    x 4         points along z, points along y, tower points, time steps
    float32  x 6         dz, dy [m], dt [s], mean speed at hub height [m/s], hub height, height of the lowest row [m]
    float32  x 6         slope and offset of u, of v, of w: speed = (stored - offset) / slope
    int32, n x int8      length and text of a description
    int16                for each time step: for each z from below, for each y from starboard (-y): u, v, w;
                         then for each tower point from the grid downwards, spaced by dz at y = 0: u, v, w

The int16 numbers stay in the file: they are mapped into memory and decoded where they are needed, so that a field of
any length costs no memory. Source: B.J. Jonkman, TurbSim User's Guide v2.00 (NREL, 2014), appendix D.
"""

from __future__ import annotations

import math
import os
import struct
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fowtlib.language.data_files import require_file
from fowtlib.language.errors import ParameterError
from fowtlib.language.whole_files import write_whole

Floats = NDArray[np.float64]

PERIODIC, ENDING = 8, 7
COMPONENTS = ("u", "v", "w")
_HEADER = struct.Struct("<h4i12fi")
_LARGEST = 100_000  # of a grid size: beyond, the header is taken for nonsense
_LOW, _HIGH = -32768, 32767
_ABSURD = 1e5  # m/s between the lowest and the highest speed that a scale can tell


@dataclass(frozen=True)
class FieldGrid:
    """Size, spacing and scale of a field; see the module for the order of the numbers.

    y of the columns is symmetric about 0, z of the rows starts at `bottom`; `speed` [m/s] at `hub_height` [m] carries
    the plane along. slope [s/m] and offset belong to the stored numbers of u, v, w.
    """

    rows: int
    columns: int
    steps: int
    dz: float
    dy: float
    dt: float
    speed: float
    hub_height: float
    bottom: float
    slope: tuple[float, float, float] = (1.0, 1.0, 1.0)
    offset: tuple[float, float, float] = (0.0, 0.0, 0.0)
    tower_points: int = 0
    periodic: bool = True
    description: str = ""

    @property
    def y(self) -> Floats:
        """Lateral positions of the columns (columns,), m."""
        return (np.arange(self.columns) - (self.columns - 1) / 2) * self.dy

    @property
    def z(self) -> Floats:
        """Heights of the rows (rows,), m."""
        return self.bottom + np.arange(self.rows) * self.dz

    @property
    def tower_z(self) -> Floats:
        """Heights of the tower points (tower_points,) at y = 0, from the grid downwards, m."""
        return self.bottom - np.arange(1, self.tower_points + 1) * self.dz

    @property
    def duration(self) -> float:
        """Time until a periodic field repeats itself, or to the last sample of another one, s."""
        return self.dt * (self.steps if self.periodic else self.steps - 1)

    @property
    def points(self) -> int:
        """Number of points of the plane and the tower."""
        return self.rows * self.columns + self.tower_points

    def header(self) -> bytes:
        """The bytes of the file before its data."""
        text = self.description.encode("ascii", "replace")
        scale = [number for pair in zip(self.slope, self.offset, strict=True) for number in pair]
        sizes = (self.rows, self.columns, self.tower_points, self.steps)
        geometry = (self.dz, self.dy, self.dt, self.speed, self.hub_height, self.bottom)
        kind = PERIODIC if self.periodic else ENDING
        return _HEADER.pack(kind, *sizes, *geometry, *scale, len(text)) + text


@dataclass(frozen=True, eq=False)
class WindField:
    """A `.bts` file: its grid, and its stored numbers (steps, points, 3) as int16, mapped into memory."""

    path: str
    grid: FieldGrid
    stored: NDArray[np.int16] = field(repr=False)

    @property
    def plane(self) -> NDArray[np.int16]:
        """The stored numbers of the grid (steps, rows, columns, 3)."""
        grid = self.grid
        return self.stored[:, : grid.rows * grid.columns].reshape(grid.steps, grid.rows, grid.columns, 3)

    @property
    def tower(self) -> NDArray[np.int16]:
        """The stored numbers of the tower (steps, tower_points, 3)."""
        return self.stored[:, self.grid.rows * self.grid.columns :]

    def blocks(self, size: int = 2**24) -> Iterator[tuple[int, NDArray[np.int16]]]:
        """First step and stored numbers (steps, points, 3) of one part of the file after another, of `size` bytes.

        Each has a mapping of its own, so that no more of a long file counts as memory of the process.
        """
        whole = self.stored
        count = max(1, size // (6 * self.grid.points))
        for start in range(0, self.grid.steps, count):
            shape = (min(count, self.grid.steps - start), *whole.shape[1:])
            mode, offset = whole.mode, whole.offset + start * 6 * self.grid.points
            yield start, np.memmap(self.path, "<i2", "r" if mode == "r" else "r+", offset, shape)

    def speeds(self, stored: ArrayLike) -> Floats:
        """Speeds [m/s] of stored numbers (..., 3)."""
        return (np.asarray(stored, dtype=float) - self.grid.offset) / self.grid.slope


def read_field(path: str | Path) -> WindField:
    """Open a `.bts` file; the data stay in the file. Raises ParameterError with the path and what is wrong in it."""
    path = str(path)
    require_file(path)
    try:
        with open(path, "rb") as file:
            start = file.read(_HEADER.size)
            if len(start) < _HEADER.size:
                raise ParameterError(f"{path}: {len(start)} bytes, less than the header of a .bts wind field.")
            kind, *numbers, length = _HEADER.unpack(start)
            if kind not in (PERIODIC, ENDING):
                other = " It may be one of Bladed (.wnd); TurbSim writes both." if kind == -99 else ""
                raise ParameterError(f"{path}: begins with {kind}, a .bts wind field begins with 7 or 8.{other}")
            if not 0 <= length <= _LARGEST:
                raise ParameterError(f"{path}: the description has {length} characters; the header is damaged.")
            text = file.read(length).decode("ascii", "replace").strip()
            size = file.seek(0, 2)
    except OSError as error:
        raise ParameterError(f"{path}: cannot read the wind field: {error.strerror}") from None
    (rows, columns, tower_points, steps), geometry, scale = numbers[:4], numbers[4:10], numbers[10:]
    grid = FieldGrid(
        rows, columns, steps, *geometry, tuple(scale[0::2]), tuple(scale[1::2]), tower_points, kind == PERIODIC, text
    )
    check_grid(path, grid)
    begin, wanted = _HEADER.size + length, grid.steps * grid.points * 6
    if size - begin < wanted:
        raise ParameterError(
            f"{path}: truncated: {size - begin} bytes of data, and {grid.steps} steps of {grid.points} points "
            f"need {wanted}; it ends in step {(size - begin) // (6 * grid.points) + 1}."
        )
    stored = np.memmap(path, dtype="<i2", mode="r", offset=begin, shape=(grid.steps, grid.points, 3))
    return WindField(path, grid, stored)


def create_field(path: str | Path, grid: FieldGrid) -> WindField:
    """A new file with the header of `grid` and zeros, its stored numbers open for writing; see `encode`."""
    check_grid(str(path), grid)
    try:
        return lay_out(path, grid)
    except OSError as error:
        raise ParameterError(f"{path}: cannot write the wind field: {error.strerror}") from None


def lay_out(path: str | Path, grid: FieldGrid) -> WindField:
    """As create_field, of a grid that is known to be right; OSError where there is no room for all of it."""
    header, size = grid.header(), grid.steps * grid.points * 6
    with open(path, "wb") as file:
        file.write(header)
        file.flush()
        if hasattr(os, "posix_fallocate"):  # a full disk is an error here, and would end the process later: SIGBUS
            os.posix_fallocate(file.fileno(), len(header), size)
        file.truncate(len(header) + size)
    shape = (grid.steps, grid.points, 3)
    return WindField(str(path), grid, np.memmap(path, dtype="<i2", mode="r+", offset=len(header), shape=shape))


def write_field(path: str | Path, grid: FieldGrid, speeds: ArrayLike, tower: ArrayLike | None = None) -> WindField:
    """Write speeds (steps, rows, columns, 3) and of the tower (steps, tower_points, 3) [m/s], scaled to their range.

    The file appears, or is replaced, when it is complete and on the disk. Raises WriteError.
    """
    plane = np.asarray(speeds)
    shapes = (grid.steps, grid.rows, grid.columns, 3), (grid.steps, grid.tower_points, 3)
    down = np.zeros(shapes[1]) if tower is None and not grid.tower_points else np.asarray(tower)
    if (plane.shape, down.shape) != shapes:
        raise ParameterError(f"{path}: speeds {plane.shape} and tower {down.shape}, the grid needs {shapes}.")
    values = np.concatenate([plane.reshape(grid.steps, -1, 3), down], axis=1)
    if not np.all(np.isfinite(values)):
        raise ParameterError(f"{path}: the speeds of a wind field must be finite numbers.")
    slope, offset = scale(values.min(axis=(0, 1)), values.max(axis=(0, 1)))
    scaled = FieldGrid(**{**grid.__dict__, "slope": slope, "offset": offset})
    check_grid(str(path), scaled)

    def fill(temporary: Path) -> None:
        new = lay_out(temporary, scaled)
        new.stored[:] = encode(values, slope, offset)
        new.stored.flush()

    write_whole(path, fill)
    return read_field(path)


def scale(low: ArrayLike, high: ArrayLike) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """Slope and offset of each component that use the whole range of int16 between its extremes [m/s], in float32."""
    low, high = np.asarray(low, dtype=float), np.asarray(high, dtype=float)
    least = 1e-3 * np.maximum(1, np.abs(low))  # float32 holds the offset of a component that hardly changes
    slope = ((_HIGH - _LOW) / np.maximum(high - low, least)).astype(np.float32)
    offset = (_LOW - slope.astype(float) * low).astype(np.float32)
    return tuple(map(float, slope)), tuple(map(float, offset))


def encode(speeds: ArrayLike, slope: ArrayLike, offset: ArrayLike) -> NDArray[np.int16]:
    """The int16 numbers of speeds [m/s]: nearest whole number of slope * speed + offset."""
    numbers = np.asarray(np.asarray(speeds) * np.asarray(slope) + np.asarray(offset))
    np.rint(numbers, out=numbers)
    return np.clip(numbers, _LOW, _HIGH, out=numbers).astype("<i2")


def check_grid(path: str, grid: FieldGrid) -> None:
    """Raise where a header cannot be one of a wind field."""
    least = {"rows": 1, "columns": 1, "steps": 2, "tower_points": 0}
    for name, smallest in least.items():
        largest = _LARGEST if name != "steps" else 2**31 - 1
        if not smallest <= getattr(grid, name) <= largest:
            raise ParameterError(f"{path}: {name} = {getattr(grid, name)} in the header of the wind field.")
    for name in ("dz", "dy", "dt", "speed"):
        value = getattr(grid, name)
        spread = {"dz": grid.rows > 1 or grid.tower_points > 0, "dy": grid.columns > 1}.get(name, True)
        if not math.isfinite(value) or (spread and value <= 0):
            raise ParameterError(f"{path}: {name} = {value:g} in the header of the wind field, expected more than 0.")
    for name in ("hub_height", "bottom"):
        if not math.isfinite(getattr(grid, name)):
            raise ParameterError(f"{path}: {name} = {getattr(grid, name):g} in the header of the wind field.")
    if grid.bottom < 0:
        raise ParameterError(
            f"{path}: the lowest row of the wind field is at z = {grid.bottom:g} m; heights in a .bts file are those "
            "above the ground or the sea, and not from the hub."
        )
    for name, slope, offset in zip(COMPONENTS, grid.slope, grid.offset, strict=True):
        if not (math.isfinite(slope) and math.isfinite(offset)) or slope == 0:
            raise ParameterError(
                f"{path}: the scale of {name} is damaged: slope = {slope:g}, offset = {offset:g}, "
                "expected finite numbers and a slope other than 0."
            )
        low, high = sorted((number - offset) / slope for number in (_LOW, _HIGH))
        if not (math.isfinite(low) and math.isfinite(high) and high - low < _ABSURD):
            raise ParameterError(
                f"{path}: the scale of {name} is damaged: with slope = {slope:g} and offset = {offset:g} its stored "
                f"numbers stand for speeds from {low:.3g} to {high:.3g} m/s."
            )
