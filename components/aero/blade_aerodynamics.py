"""The aerodynamic description of a blade: airfoils over the whole circle, and the elements of the blade."""

from __future__ import annotations

import csv
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from typing import Any

import numpy as np

from fowtlib.language.errors import ParameterError, did_you_mean

BLADE_COLUMNS = ("span_m", "length_m", "chord_m", "twist_deg", "curve_m", "sweep_m", "airfoil")
AIRFOIL_COLUMNS = ("airfoil", "angle_of_attack_deg", "lift_coefficient", "drag_coefficient", "moment_coefficient")


@dataclass(frozen=True, eq=False)
class Airfoil:
    """Steady lift, drag and pitching moment coefficients (quarter chord, nose up) over the angle of attack [rad].

    The angles increase from -pi to pi, (n,), because a parked or starting blade meets all of them; coefficients (n, 3).
    smooth: the monotone cubic of Fritsch and Carlson (1980) between the angles, else straight lines.
    """

    name: str
    angle: np.ndarray
    coefficients: np.ndarray
    smooth: bool = True

    def __post_init__(self):
        angle, values = np.asarray(self.angle, dtype=float), np.asarray(self.coefficients, dtype=float)
        object.__setattr__(self, "angle", angle)
        object.__setattr__(self, "coefficients", values)
        where = f"airfoil {self.name}"
        if angle.ndim != 1 or len(angle) < 3 or values.shape != (len(angle), 3):
            raise ParameterError(f"{where}: 3 angles or more, and lift, drag and moment at each, make an airfoil.")
        if not (np.all(np.isfinite(angle)) and np.all(np.isfinite(values))):
            raise ParameterError(f"{where}: angles and coefficients must be finite numbers.")
        falls = np.flatnonzero(np.diff(angle) <= 0)
        if falls.size:
            raise ParameterError(f"{where}: the angles must increase; {_degrees(angle[falls[0]])} is followed by "
                                 f"{_degrees(angle[falls[0] + 1])}.")  # fmt: skip
        if abs(angle[0] + np.pi) > 1e-6 or abs(angle[-1] - np.pi) > 1e-6:
            raise ParameterError(
                f"{where}: the angles of attack must span -180 deg to 180 deg, and these span {_degrees(angle[0])} to "
                f"{_degrees(angle[-1])}; continue the polar, by the method of Viterna and Corrigan for instance."
            )
        if np.abs(values[0] - values[-1]).max() > 0.02:
            raise ParameterError(f"{where}: -180 deg and 180 deg are one angle, and their coefficients differ.")

    @property
    def cubics(self) -> np.ndarray:
        """Coefficients by power of (angle - knot): (n - 1, 3, 4)."""
        from scipy.interpolate import PchipInterpolator

        if self.smooth:
            return np.moveaxis(PchipInterpolator(self.angle, self.coefficients, axis=0).c[::-1], 0, -1)
        lines = np.zeros((len(self.angle) - 1, 3, 4))
        lines[..., 0] = self.coefficients[:-1]
        lines[..., 1] = np.diff(self.coefficients, axis=0) / np.diff(self.angle)[:, None]
        return lines


@dataclass(frozen=True, eq=False)
class BladeAerodynamics:
    """The elements of a blade, from root to tip; all arrays (n,), a node in the middle of each element.

    radius [m]: from the rotor axis along the pitch axis of the unconed blade; length [m] of the element, by default
    with borders half way between the nodes, from hub_radius to tip_radius; chord [m]; twist [rad], positive to feather;
    curve, sweep [m]: place of the aerodynamic centre beside the pitch axis, downwind and to the trailing edge.
    """

    hub_radius: float
    tip_radius: float
    radius: np.ndarray
    chord: np.ndarray
    twist: np.ndarray
    airfoil: Sequence[str]
    airfoils: Mapping[str, Airfoil]
    length: np.ndarray | None = None
    curve: np.ndarray | None = None
    sweep: np.ndarray | None = None
    where: str = field(default="blade", repr=False)

    def __post_init__(self):
        radius = np.asarray(self.radius, dtype=float)
        n = radius.size
        length = self._half_way(radius) if self.length is None else self.length
        arrays = {"radius": radius, "chord": self.chord, "twist": self.twist, "length": length,
                  "curve": np.zeros(n) if self.curve is None else self.curve,
                  "sweep": np.zeros(n) if self.sweep is None else self.sweep}  # fmt: skip
        for name, value in arrays.items():
            array = np.asarray(value, dtype=float)
            if array.shape != (n,) or n < 1 or not np.all(np.isfinite(array)):
                raise ParameterError(f"{self.where}: {name} must be {n} finite numbers, one for each element.")
            object.__setattr__(self, name, array)
        self._check(radius, n)

    def _half_way(self, radius: np.ndarray) -> np.ndarray:
        return np.diff(np.concatenate([[self.hub_radius], (radius[1:] + radius[:-1]) / 2, [self.tip_radius]]))

    def _check(self, radius: np.ndarray, n: int) -> None:
        falls = np.flatnonzero(np.diff(radius) <= 0)
        if falls.size:
            i = falls[0]
            raise ParameterError(
                f"{self.where}: the elements must go outward; {radius[i]:g} m is followed by {radius[i + 1]:g} m."
            )
        if not 0 < self.hub_radius < radius[0] or not radius[-1] < self.tip_radius:
            raise ParameterError(
                f"{self.where}: the elements lie from {radius[0]:g} m to {radius[-1]:g} m, which must be inside of the "
                f"hub radius {self.hub_radius:g} m and the tip radius {self.tip_radius:g} m."
            )
        if np.any(self.chord <= 0) or np.any(self.length <= 0):
            raise ParameterError(f"{self.where}: chord and length of every element must be positive.")
        blade = self.tip_radius - self.hub_radius
        if abs(self.length.sum() - blade) > 0.01 * blade:
            raise ParameterError(
                f"{self.where}: the elements are {self.length.sum():g} m long together, and the blade is {blade:g} m."
            )
        if len(self.airfoil) != n:
            raise ParameterError(f"{self.where}: {n} elements and {len(self.airfoil)} names of airfoils.")
        for name in self.airfoil:
            if name not in self.airfoils:
                raise ParameterError(f"{self.where}: there is no airfoil '{name}'{did_you_mean(name, self.airfoils)}")


@lru_cache(maxsize=8)
def read_airfoils(path: str, smooth: bool = True) -> dict[str, Airfoil]:
    """Airfoils of a CSV with the columns of AIRFOIL_COLUMNS; lines that start with # are comments."""
    rows: dict[str, list[list[float]]] = {}
    for name, *numbers in _table(path, AIRFOIL_COLUMNS, words=("airfoil",)):
        rows.setdefault(name, []).append(numbers)
    arrays = {name: np.array(values) for name, values in rows.items()}
    try:
        return {name: Airfoil(name, np.radians(a[:, 0]), a[:, 1:], smooth) for name, a in arrays.items()}
    except ParameterError as error:
        raise error.at(path) from None


def read_blade(
    path: str, airfoils: str, hub_radius: float, tip_radius: float, smooth: bool = True
) -> BladeAerodynamics:
    """Blade of a CSV with the columns of BLADE_COLUMNS; span counts from the blade root, at hub_radius."""
    rows = list(zip(*_table(path, BLADE_COLUMNS, words=("airfoil",)), strict=True))
    span, length, chord, twist, curve, sweep = (np.array(column, dtype=float) for column in rows[:6])
    return BladeAerodynamics(
        hub_radius, tip_radius, hub_radius + span, chord, np.radians(twist), rows[6], read_airfoils(airfoils, smooth),
        length, curve, sweep, where=path,
    )  # fmt: skip


def _table(path: str, columns: Sequence[str], words: Sequence[str]) -> list[list[Any]]:
    """The rows of a CSV in the order of `columns`; all of them are numbers but the words."""
    try:
        with open(path, newline="", encoding="utf-8") as file:
            lines = [(number, line) for number, line in enumerate(file, 1) if line.strip() and line[0] != "#"]
    except OSError as error:
        raise ParameterError(f"cannot read {path}: {error.strerror}.") from None
    header = [name.strip() for name in next(csv.reader([lines[0][1]]))] if lines else []
    if sorted(header) != sorted(columns) or len(lines) < 2:
        raise ParameterError(f"{path}: the columns {', '.join(columns)} are needed, and rows under them.")
    rows = []
    for number, line in lines[1:]:
        cells = dict(zip(header, next(csv.reader([line])), strict=False))
        try:
            rows.append([cells[name].strip() if name in words else float(cells[name]) for name in columns])
        except (KeyError, ValueError):
            raise ParameterError(f"{path}:{number}: '{line.strip()}' is not a row of {', '.join(header)}.") from None
    return rows


def _degrees(angle: float) -> str:
    return f"{np.degrees(angle):g} deg"
