"""The wind at points as an external function, over a station or from a full-field file, and what is asked of a field.

It runs in C (full_field.c); where there is no compiler, in NumPy (field_lookup.py). One library per number of points
serves every file and all other kinds of wind: a file is an input of the function, a number under which it was made
known when a run starts, and 0 stands for the power law over a station.
"""

from __future__ import annotations

import ctypes
import hashlib
import math
import os
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

import casadi as ca
import numpy as np

from fowtlib.components.environment.field_file import read_field
from fowtlib.components.environment.field_lookup import AXES, FieldLookup
from fowtlib.language import ExternalFunction
from fowtlib.language.errors import ParameterError
from fowtlib.language.externals import with_interface
from fowtlib.language.native import compiler, open_library

SHARED = ("field", "time", "base", "fluctuation", "shear_exponent", "direction", "up", "across", "height", "side")
"""Inputs of the function that all points share."""

SLOPES = slice(1, 8)
"""Those by which there are derivatives: time to across."""

LOWEST_HEIGHT = 1e-3  # of the station's: below, and under water, the power law keeps its value; as in full_field.c

Version = tuple[int, int]
"""Time of the last change [ns] and size [bytes] of a file; (0, 0) of one that is not there."""

_known: dict[float, tuple[str, float, str, Version]] = {}  # what a handle stands for, see field_handle; for NumPy
_refused: list[str] = []


def file_version(path: str) -> Version:
    """What tells that a file was written again."""
    try:
        status = Path(path).stat()
    except OSError:
        return 0, 0
    return status.st_mtime_ns, status.st_size


def open_field(path: str, shift: float | None, interpolation: str = "linear") -> FieldLookup:
    """The look-up of a `.bts` file; the same object as long as the file does not change."""
    return _open(path, shift, interpolation, file_version(path))


@lru_cache(maxsize=8)
def _open(path: str, shift: float | None, interpolation: str, version: Version) -> FieldLookup:
    return FieldLookup(read_field(path), shift, interpolation)


def forget_fields() -> None:
    """Let go of the look-ups that `open_field` keeps, and of the memory of files that are gone."""
    _open.cache_clear()


def field_handle(lookup: FieldLookup) -> float:
    """The number under which `field_function` knows a file, its version, its shift and its interpolation.

    It comes from these alone: a model that is used where its file was not made known finds no other file instead.
    """
    path = os.path.abspath(lookup.field.path)
    identity = path, lookup.shift, lookup.interpolation, file_version(path)
    digest = hashlib.sha256(repr(identity).encode()).digest()
    handle = float(int.from_bytes(digest[:6], "little"))  # 48 bits: exact in a double
    _known[handle] = identity
    return handle


@dataclass(frozen=True, eq=False)
class FieldData:
    """A field as what a run takes in at its start; see fowtlib.language.run_time.Source.

    numbers: handle; first and last y [m], z [m] and time [s] that are covered; shift [m]; 1/speed [s/m].
    """

    lookup: FieldLookup

    @property
    def numbers(self) -> tuple[float, ...]:
        """See above."""
        lookup = self.lookup
        ranges = [end for axis in AXES for end in lookup.covers.get(axis, (-math.inf, math.inf))]
        return field_handle(lookup), *ranges, lookup.shift, 1 / lookup.grid.speed, lookup.lowest

    @property
    def there(self) -> bool:
        """Whether its file still is, which may have been made for a run."""
        return Path(self.lookup.field.path).is_file()

    def open_in(self, function: ExternalFunction) -> FieldLookup:
        """Make the file known to a function of `wind_function`."""
        handle = field_handle(self.lookup)
        if function.library is not None:
            path, (shift, cubic) = self.file_for(function)
            opened = _symbol(function, "_open", ctypes.c_int)
            if opened(ctypes.c_double(handle), os.fsencode(path), ctypes.c_double(shift), cubic):
                raise ParameterError(_problem_in_c(function))
        return self.lookup

    def file_for(self, function: ExternalFunction) -> tuple[Path, tuple[float, int]]:
        """The file, its shift, and whether it is interpolated by cubics."""
        lookup = self.lookup
        return Path(os.path.abspath(lookup.field.path)), (float(lookup.shift), int(lookup.interpolation == "cubic"))


NO_FIELD = (0.0, *[-math.inf, math.inf] * 3, 0.0, 0.0, -math.inf)
"""The numbers of a wind without a field; see FieldData."""


def wind_function(points: int) -> ExternalFunction:
    """External function of the velocities u, v, w [m/s] at points, world; the same for all kinds of wind.

    Its inputs: the handle of a field, or 0; time [s]; base and fluctuation [m/s] of a station, shear_exponent,
    direction [rad], gradients up and across [1/s], height and side (z and y [m]) of the station; the positions x, y, z
    [m] of each point, world. Over a station it blows along the direction with
    base (z/height)^shear_exponent + fluctuation + up (z - height) + across (y' - side), y' along the turned y axis; in
    a field with its velocities, turned by the direction. Beyond the edge of a field it keeps the value of the edge, so
    that an iteration may look there.
    """
    return _function(points, compiler())


def field_function(lookup: FieldLookup, points: int) -> ExternalFunction:
    """`wind_function` with a field made known to it."""
    function = wind_function(points)
    FieldData(lookup).open_in(function)
    return function


@lru_cache(maxsize=64)
def _function(points: int, command: tuple[str, ...]) -> ExternalFunction:
    name = f"wind_field_{points}"
    text = (Path(__file__).parent / "full_field.c").read_text(encoding="utf-8")
    sparsity = _sparsity(points)

    def evaluate(column: np.ndarray) -> np.ndarray:
        return _twin_values(column, points)[0]

    def slope(column: np.ndarray) -> np.ndarray:
        return _twin_values(column, points)[1]

    def explain() -> str:
        return _problem_in_c(function) if function.library else _problem_in_python()

    function = ExternalFunction(
        name, {**dict.fromkeys(SHARED, 1), "positions": 3 * points}, {"velocities": 3 * points},
        source=with_interface(name, sparsity, text), beside=True, python=evaluate, jacobian=slope, sparsity=sparsity,
        explain=explain,
    )  # fmt: skip
    return function


def _sparsity(points: int) -> ca.Sparsity:
    """Of the Jacobian: nothing by handle and station, everything by what else is shared, a point by its coordinates."""
    n, full = 3 * points, SLOPES.stop - SLOPES.start
    own = np.repeat(np.arange(n).reshape(points, 3), 3, axis=0).ravel().tolist()
    without = [full * n] * (len(SHARED) - SLOPES.stop)
    starts = [0, *range(0, full * n + 1, n), *without, *range(full * n + 3, (full + 3) * n + 1, 3)]
    return ca.Sparsity(n, len(SHARED) + n, starts, [*range(n)] * full + own)


def _twin_values(column: np.ndarray, points: int) -> tuple[np.ndarray, np.ndarray]:
    """Velocities and Jacobian in NumPy."""
    handle, time, base, fluctuation, shear, direction, up, across, height, side = column[: len(SHARED)]
    r, c, s = column[len(SHARED) :].reshape(points, 3), math.cos(direction), math.sin(direction)
    by_shared, own = np.zeros((SLOPES.stop - SLOPES.start, points, 3)), np.zeros((points, 3, 3))
    if handle:
        world = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])  # from the axes of the field
        places = r @ world
        velocity, rate = _twin(handle).evaluate(places, time)
        values = velocity @ world.T
        own = world @ rate[:, :, :3] @ world.T
        by_shared[0] = rate[:, :, 3] @ world.T
        turning = np.column_stack([places[:, 1], -places[:, 0], 0 * places[:, 0]])
        by_shared[4] = np.einsum("pij,pj->pi", rate[:, :, :3], turning) @ world.T
        by_shared[4] += np.column_stack([-values[:, 1], values[:, 0], 0 * values[:, 0]])
    else:
        along, given = np.array([c, s, 0.0]), r[:, 2] / height
        level = np.fmax(given, LOWEST_HEIGHT)
        power = level**shear
        above, beside = r[:, 2] - height, c * r[:, 1] - s * r[:, 0] - side
        values = (base * power + fluctuation + (up * above + across * beside))[:, None] * along
        by_shared[1:4] = np.stack([power, np.ones(points), base * power * np.log(level)])[:, :, None] * along
        by_shared[4] = np.column_stack([-values[:, 1], values[:, 0], 0 * values[:, 0]])
        by_shared[4] -= across * (r @ along)[:, None] * along
        by_shared[5:7] = np.stack([above, beside])[:, :, None] * along
        upwards = np.where(given > LOWEST_HEIGHT, base * shear * power / (level * height), 0.0)
        own[:, :, 2] = (upwards + up)[:, None] * along
        own[:, :, :2] = across * np.outer(along, [-s, c])
    matrix = np.zeros((points, 3, len(SHARED) + 3 * points))
    matrix[:, :, SLOPES] = np.moveaxis(by_shared, 0, 2)
    for i in range(points):
        first = len(SHARED) + 3 * i
        matrix[i, :, first : first + 3] = own[i]
    return values.ravel(), matrix.reshape(3 * points, -1)


def _symbol(function: ExternalFunction, suffix: str, result: Any) -> Any:
    found = getattr(open_library(function.library), function.name + suffix)
    found.restype = result
    return found


def _problem_in_c(function: ExternalFunction) -> str:
    text = _symbol(function, "_problem", ctypes.c_char_p)().decode("utf-8", "replace")
    return f"{text}." if text else ""


def _problem_in_python() -> str:
    return _refused.pop() if _refused else ""


def _twin(handle: float) -> FieldLookup:
    """The look-up in NumPy of a handle; an error where the file has changed, as in C."""
    path, shift, interpolation, version = _known[handle]
    now = file_version(path)
    if now == version:
        return _open(path, shift, interpolation, version)
    reason = "has changed since it was opened; start the run again"
    if now == (0, 0):
        reason = f"cannot be read any more: {os.strerror(2)}"
    _refused[:] = [f"{path}: the wind field {reason}."]
    raise RuntimeError(_refused[0])


def check_mean(lookup: FieldLookup) -> None:
    """ParameterError where u has no mean: some programs write the turbulence alone. From about 200 planes."""
    grid, plane = lookup.grid, lookup.field.plane
    mean = float(lookup.field.speeds(plane[:: max(1, grid.steps // 200)].mean(axis=(0, 1, 2)))[0])
    if mean < 0.1 * grid.speed:
        raise ParameterError(
            f"{lookup.field.path}: the mean of u is {mean:.3g} m/s, and {grid.speed:g} m/s in the header of the wind "
            "field; add the mean wind to the turbulence in it."
        )


def require_range(lookup: FieldLookup, y_range: tuple[float, float], z_range: tuple[float, float], who: str) -> None:
    """ParameterError unless the field covers the ranges [m], both along its axes."""
    missing = []
    for axis, (first, last) in (("y", y_range), ("z", z_range)):
        low, high = lookup.covers[axis]
        margin = 1e-6 * (high - low)
        if not (low - margin <= first <= last <= high + margin):
            missing.append((axis, first, last, low, high))
    if missing:
        needs = " and ".join(f"{axis} = {first:g} to {last:g} m" for axis, first, last, _, _ in missing)
        has = " and ".join(f"{low:g} to {high:g} m" for *_, low, high in missing)
        remedy = f"at least {2 * math.ceil(max(abs(y) for y in y_range)):g} m wide, and {math.floor(z_range[0]):g} to "
        raise ParameterError(
            f"{lookup.field.path}: the wind field is too small: {who} needs {needs}, and the field covers {has}; make "
            f"one {remedy}{math.ceil(z_range[1]):g} m high, and more for the motion of a floating platform."
        )
