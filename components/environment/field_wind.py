"""The wind of a full-field file in a model: the look-up as an external function, and what a model asks of the field.

The look-up runs in C (full_field.c); where there is no compiler, in NumPy (field_lookup.py). One library per number of
points serves every file: a file is an input of the function, a number under which it was made known.
"""

from __future__ import annotations

import ctypes
import hashlib
import math
import os
from functools import lru_cache
from pathlib import Path
from typing import Any

import casadi as ca
import numpy as np

from fowtlib.components.environment.field_file import read_field
from fowtlib.components.environment.field_lookup import FieldLookup
from fowtlib.language import ExternalFunction
from fowtlib.language import math as m
from fowtlib.language.equations import active
from fowtlib.language.errors import ParameterError
from fowtlib.language.native import compiler

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


def field_function(lookup: FieldLookup, points: int) -> ExternalFunction:
    """External function of the field's handle, the time [s] and the positions x, y, z [m] of each point, one by one.

    Gives u, v, w [m/s] of each point, and its sparse Jacobian. Beyond the edge it keeps the value of the edge, so that
    an iteration may look there. The functions for all files are the same; this one's file is known to it.
    """
    function = _function(points, compiler())
    if function.library is not None:
        handle, path = field_handle(lookup), os.path.abspath(lookup.field.path)
        cubic = int(lookup.interpolation == "cubic")
        if _symbol(function, "_open", ctypes.c_int)(
            ctypes.c_double(handle), os.fsencode(path), ctypes.c_double(lookup.shift), cubic
        ):
            raise ParameterError(_problem_in_c(function))
        function.function.files[handle] = Path(path), (float(lookup.shift), cubic)
    return function


@lru_cache(maxsize=64)
def _function(points: int, command: tuple[str, ...]) -> ExternalFunction:
    name = f"wind_field_{points}"
    text = (Path(__file__).parent / "full_field.c").read_text(encoding="utf-8")
    head = f"#define FIELD_NAME {name}\n#define FIELD_POINTS {points}\n"

    def evaluate(column: np.ndarray) -> np.ndarray:
        return _twin(column[0]).evaluate(column[2:].reshape(points, 3), column[1])[0].ravel()

    def slope(column: np.ndarray) -> np.ndarray:
        rate = _twin(column[0]).evaluate(column[2:].reshape(points, 3), column[1])[1]
        matrix = np.zeros((points, 3, 2 + 3 * points))
        for i in range(points):
            matrix[i, :, 1] = rate[i, :, 3]
            matrix[i, :, 2 + 3 * i : 5 + 3 * i] = rate[i, :, :3]
        return matrix.reshape(3 * points, -1)

    def explain() -> str:
        return _problem_in_c(function) if function.library else _problem_in_python()

    function = ExternalFunction(
        name, {"field": 1, "time": 1, "positions": 3 * points}, {"velocities": 3 * points}, source=head + text,
        python=evaluate, jacobian=slope, sparsity=_sparsity(points), explain=explain,
    )  # fmt: skip
    return function


def _sparsity(points: int) -> ca.Sparsity:
    """Of the Jacobian: nothing by the handle, everything by the time, a point by its own coordinates."""
    own = np.repeat(np.arange(3 * points).reshape(points, 3), 3, axis=0)
    starts = [0, 0, *range(3 * points, 12 * points + 1, 3)]
    return ca.Sparsity(3 * points, 2 + 3 * points, starts, [*range(3 * points), *own.ravel().tolist()])


def _symbol(function: ExternalFunction, suffix: str, result: Any) -> Any:
    found = getattr(_load(str(function.library)), function.name + suffix)
    found.restype = result
    return found


@lru_cache(maxsize=64)
def _load(library: str) -> ctypes.CDLL:
    """The library that CasADi has loaded: a process holds one for a path, and this keeps it."""
    return ctypes.CDLL(library)


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
    reason = "has changed since the model was compiled; compile it again"
    if now == (0, 0):
        reason = f"cannot be read any more: {os.strerror(2)}"
    _refused[:] = [f"{path}: the wind field {reason}."]
    raise RuntimeError(_refused[0])


def field_velocity(lookup: FieldLookup, time: Any, positions: Any, reach: str = "tower") -> Any:
    """Velocities (3, n) at `positions` (3, n), both along the axes of the field; while flattening.

    reach: down to the lowest row of the "plane", to the lowest point of the "tower", or to the "ground", to which the
    wind below both falls linearly to nothing. A run in which one of the points leaves this range stops there.
    """
    positions = ca.densify(ca.SX(positions))  # fixed points are numbers
    points, grid, lowest, fall = positions.shape[1], lookup.grid, lookup.lowest, 1.0
    if reach == "ground":
        fall = m.fmax(m.fmin(positions[2, :] / lowest, 1), 0) if lowest > 0 else 1.0
        positions = m.vertcat(positions[:2, :], m.fmax(positions[2, :], lowest))
    places = {"y": positions[1, :], "z": positions[2, :]}
    if not grid.periodic:
        places["time"] = time + (lookup.shift - positions[0, :]) / grid.speed
    for axis, (low, high) in lookup.covers.items():
        low = lowest if axis == "z" and reach != "plane" else low
        active().check_range(places[axis].T, low, high, "", axis, _outside(lookup, axis, low, high, points))
    function = field_function(lookup, points)
    result = function(field=field_handle(lookup), time=time, positions=positions)["velocities"]
    velocities = m.horzcat(*[result[3 * i : 3 * i + 3] for i in range(points)])
    return velocities * ca.repmat(fall, 3, 1) if reach == "ground" and lowest > 0 else velocities


def _outside(lookup: FieldLookup, axis: str, low: float, high: float, points: int) -> str:
    """What is said of a run that leaves the field."""
    who = "the point" if points == 1 else f"point {{number}} of {points}"
    if axis == "time":
        return (
            f"{who} needs the wind of time {{value}} s of the field {lookup.field.path}, which covers {low:g} to "
            f"{high:g} s; use a longer field, a periodic one, or another field_shift."
        )
    return (
        f"{who} is at {axis} = {{value}} m, and the wind field {lookup.field.path} covers {low:g} to {high:g} m; use a "
        "field that is larger than all rotors with their motion."
    )


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
