"""The aerodynamic description of a blade: airfoils over the whole circle, and the elements of the blade."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from fowtlib.components.aero.monotone_cubics import monotone_cubics
from fowtlib.language.data_files import cells_of, lines_of, remembered
from fowtlib.language.errors import ParameterError, did_you_mean
from fowtlib.language.similarity import Similarity
from fowtlib.language.whole_files import write_text

BLADE_COLUMNS = ("span_m", "length_m", "chord_m", "twist_deg", "curve_m", "sweep_m", "airfoil")
AIRFOIL_COLUMNS = ("airfoil", "angle_of_attack_deg", "lift_coefficient", "drag_coefficient", "moment_coefficient")


@dataclass(frozen=True, eq=False)
class Airfoil:
    """Steady lift, drag and pitching moment coefficients (quarter chord, nose up) over the angle of attack [rad].

    The angles increase from -pi to pi, (n,), because a parked or starting blade meets all of them; coefficients (n, 3).
    smooth: the monotone cubic of Fritsch and Carlson (1980) between the angles, else straight lines. where, lines: the
    file and the line of every angle, for messages. Raises ParameterError.
    """

    name: str
    angle: np.ndarray
    coefficients: np.ndarray
    smooth: bool = True
    where: str = field(default="", repr=False)
    lines: Sequence[int] = field(default=(), repr=False)

    def __post_init__(self):
        angle, values = np.asarray(self.angle, dtype=float), np.asarray(self.coefficients, dtype=float)
        object.__setattr__(self, "angle", angle)
        object.__setattr__(self, "coefficients", values)
        if angle.ndim != 1 or len(angle) < 3 or values.shape != (len(angle), 3):
            raise self._wrong(0, "3 angles or more, and lift, drag and moment at each, make an airfoil.")
        wild = np.flatnonzero(~(np.isfinite(angle) & np.isfinite(values).all(axis=1)))
        if wild.size:
            raise self._wrong(wild[0], "angles and coefficients must be finite numbers.")
        falls = np.flatnonzero(np.diff(angle) <= 0)
        if falls.size:
            i = falls[0]
            raise self._wrong(
                i + 1, f"the angles must increase; {_degrees(angle[i])} is followed by {_degrees(angle[i + 1])}."
            )
        if abs(angle[0] + np.pi) > 1e-6 or abs(angle[-1] - np.pi) > 1e-6:
            short = 0 if abs(angle[0] + np.pi) > 1e-6 else -1
            raise self._wrong(
                short, f"the angles of attack must span -180 deg to 180 deg, and these span {_degrees(angle[0])} to "
                f"{_degrees(angle[-1])}; continue the polar, by the method of Viterna and Corrigan for instance.",
            )  # fmt: skip
        jump = np.abs(values[0] - values[-1])
        if jump.max() > 0.02:
            k = int(jump.argmax())
            raise self._wrong(
                -1, f"-180 deg and 180 deg are one angle, and their {('lift', 'drag', 'moment')[k]} coefficients are "
                f"{values[0, k]:g} and {values[-1, k]:g}; make them the same.",
            )  # fmt: skip

    def _wrong(self, row: int, message: str) -> ParameterError:
        return ParameterError(f"airfoil {self.name}: {message}", where=_place(self.where, self.lines, row))

    @cached_property
    def cubics(self) -> np.ndarray:
        """Coefficients by power of (angle - knot): (n - 1, 3, 4)."""
        if self.smooth:
            return monotone_cubics(self.angle, self.coefficients)
        lines = np.zeros((len(self.angle) - 1, 3, 4))
        lines[..., 0] = self.coefficients[:-1]
        lines[..., 1] = np.diff(self.coefficients, axis=0) / np.diff(self.angle)[:, None]
        return lines

    def at(self, angle: ArrayLike) -> np.ndarray:
        """The coefficients at an angle between -pi and pi, (3,), or at several, (n, 3)."""
        angle = np.asarray(angle, dtype=float)
        i = np.clip(np.searchsorted(self.angle, angle, side="right") - 1, 0, len(self.angle) - 2)
        return np.einsum("...jk,...k->...j", self.cubics[i], (angle - self.angle[i])[..., None] ** np.arange(4))


class Airfoils(dict[str, Airfoil]):
    """Airfoils by name, as a file has them."""

    def in_similarity(self, similarity: Similarity) -> Airfoils:
        """The same: coefficients over angles have no dimension."""
        return self


@dataclass(frozen=True, eq=False)
class BladeAerodynamics:
    """The elements of a blade, from root to tip; all arrays (n,), a node in the middle of each element.

    radius [m]: from the rotor axis along the pitch axis of the unconed blade; length [m] of the element, by default
    with borders half way between the nodes, from hub_radius to tip_radius; chord [m]; twist [rad], positive to feather;
    curve, sweep [m]: place of the aerodynamic centre beside the pitch axis, downwind and to the trailing edge. where,
    lines: the file and the line of every element, for messages. Raises ParameterError.
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
    lines: Sequence[int] = field(default=(), repr=False)

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
                wild = np.flatnonzero(~np.isfinite(array)) if array.shape == (n,) and n else []
                place = self._place(wild[0]) if len(wild) else self.where
                raise ParameterError(f"{name} must be {n} finite numbers, one for each element.", where=place)
            object.__setattr__(self, name, array)
        self._check(radius, n)

    def fitting(self, label: str, airfoils: Any, **radii: float | None) -> BladeAerodynamics:
        """The blade itself, for a part that says something about it too; ParameterError where that is another thing."""
        if airfoils is not None and not _same(airfoils, self.airfoils):
            raise ParameterError(f"{label}.airfoils: the blade that is given has airfoils of its own.")
        for name, given in radii.items():
            own = getattr(self, name)
            if given is not None and abs(own - given) > 1e-9 * abs(given):
                raise ParameterError(f"{label}.{name} is {given:g} m, and that of the blade {own:g} m.")
        return self

    ending = ".csv"

    def in_similarity(self, similarity: Similarity) -> BladeAerodynamics:
        """The blade in another scale with the same airfoils, whatever the Reynolds number says; angles stay."""
        similarity.refuse_other_wind("the loads of a blade are in proportion where the wind is to the other speeds")
        lengths = ("hub_radius", "tip_radius", "radius", "chord", "length", "curve", "sweep")
        return replace(self, **{name: getattr(self, name) * similarity.factor("m") for name in lengths})

    def write(self, path: str | Path) -> None:
        """Write a CSV that read_blade reads, with the airfoils in their own file. Raises WriteError."""
        span, twist = self.radius - self.hub_radius, np.degrees(self.twist)
        columns = (span, self.length, self.chord, twist, self.curve, self.sweep)
        rows = [",".join([*(f"{value:.17g}" for value in row), name])
                for *row, name in zip(*columns, self.airfoil, strict=True)]  # fmt: skip
        write_text(path, "\n".join([",".join(BLADE_COLUMNS), *rows]) + "\n")

    def _half_way(self, radius: np.ndarray) -> np.ndarray:
        return np.diff(np.concatenate([[self.hub_radius], (radius[1:] + radius[:-1]) / 2, [self.tip_radius]]))

    def _place(self, element: int) -> str:
        return _place(self.where, self.lines if len(self.lines) == len(self.radius) else (), element)

    def _check(self, radius: np.ndarray, n: int) -> None:
        falls = np.flatnonzero(np.diff(radius) <= 0)
        if falls.size:
            i = falls[0]
            raise ParameterError(
                f"the elements must go outward; {radius[i]:g} m is followed by {radius[i + 1]:g} m.",
                where=self._place(i + 1),
            )
        if not 0 < self.hub_radius < radius[0] or not radius[-1] < self.tip_radius:
            raise ParameterError(
                f"the elements lie from {radius[0]:g} m to {radius[-1]:g} m, which must be inside of the hub radius "
                f"{self.hub_radius:g} m and the tip radius {self.tip_radius:g} m.",
                where=self._place(0 if not 0 < self.hub_radius < radius[0] else n - 1),
            )
        for name in ("chord", "length"):
            low = np.flatnonzero(getattr(self, name) <= 0)
            if low.size:
                raise ParameterError(
                    f"the {name} of an element must be positive, and at {radius[low[0]]:g} m it is "
                    f"{getattr(self, name)[low[0]]:g} m.",
                    where=self._place(low[0]),
                )
        blade = self.tip_radius - self.hub_radius
        if abs(self.length.sum() - blade) > 0.01 * blade:
            raise ParameterError(
                f"the elements are {self.length.sum():g} m long together, and the blade is {blade:g} m.",
                where=self.where,
            )
        if len(self.airfoil) != n:
            raise ParameterError(f"{n} elements and {len(self.airfoil)} names of airfoils.", where=self.where)
        for i, name in enumerate(self.airfoil):
            if name not in self.airfoils:
                raise ParameterError(
                    f"there is no airfoil '{name}'{did_you_mean(name, self.airfoils)}", where=self._place(i)
                )


@remembered()
def read_airfoils(path: str, smooth: bool = True) -> Airfoils:
    """Airfoils of a CSV with the columns of AIRFOIL_COLUMNS; lines that start with # are comments.

    The rows of an airfoil are in the order of their angles. Raises ParameterError with path and line.
    """
    rows: dict[str, list[list[float]]] = {}
    for line, (name, *numbers) in _table(path, AIRFOIL_COLUMNS, words=("airfoil",)):
        rows.setdefault(name, []).append([line, *numbers])
    arrays = {name: np.array(values) for name, values in rows.items()}
    return Airfoils({name: Airfoil(name, np.radians(a[:, 1]), a[:, 2:], smooth, path, a[:, 0].astype(int).tolist())
                     for name, a in arrays.items()})  # fmt: skip


@remembered("path", "airfoils")
def read_blade(
    path: str, airfoils: str, hub_radius: float, tip_radius: float, smooth: bool = True
) -> BladeAerodynamics:
    """Blade of a CSV with the columns of BLADE_COLUMNS; span counts from the blade root, at hub_radius.

    Raises ParameterError with path and line.
    """
    lines, rows = zip(*_table(path, BLADE_COLUMNS, words=("airfoil",)), strict=True)
    columns = list(zip(*rows, strict=True))
    span, length, chord, twist, curve, sweep = (np.array(column, dtype=float) for column in columns[:6])
    return BladeAerodynamics(
        hub_radius, tip_radius, hub_radius + span, chord, np.radians(twist), columns[6],
        read_airfoils(airfoils, smooth), length, curve, sweep, where=path, lines=lines,
    )  # fmt: skip


def _same(one: Mapping[str, Airfoil], other: Mapping[str, Airfoil]) -> bool:
    """Whether these are the same airfoils, by their numbers."""
    if one is other or one.keys() != other.keys():
        return one is other
    pairs = [(one[name], other[name]) for name in one]
    return all(a.smooth == b.smooth and np.array_equal(a.angle, b.angle)
               and np.array_equal(a.coefficients, b.coefficients) for a, b in pairs)  # fmt: skip


def _place(where: str, lines: Sequence[int], row: int) -> str:
    return f"{where}:{lines[row]}" if where and len(lines) else where


def _table(path: str, columns: Sequence[str], words: Sequence[str]) -> list[tuple[int, list[Any]]]:
    """Line numbers and rows of a CSV, in the order of `columns`; all of them are numbers but the words."""
    lines = lines_of(path, "the table")
    header = cells_of(lines[0][1]) if lines else []
    if sorted(header) != sorted(columns) or len(lines) < 2:
        raise ParameterError(f"{path}: the columns {', '.join(columns)} are needed, and rows under them.")
    rows = []
    for number, line in lines[1:]:
        cells = dict(zip(header, cells_of(line), strict=False))
        try:
            rows.append((number, [cells[name] if name in words else float(cells[name]) for name in columns]))
        except (KeyError, ValueError):
            raise ParameterError(f"{path}:{number}: '{line.strip()}' is not a row of {', '.join(header)}.") from None
    return rows


def _degrees(angle: float) -> str:
    return f"{np.degrees(angle):g} deg"
