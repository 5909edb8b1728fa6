"""Natural modes over the wind: the Campbell diagram of a model at rest, or in steady operation.

At each wind the modes are those of the mean in multi-blade coordinates (`natural_modes`). From one wind to the next a
mode is followed by its shape: with the right and left eigenvectors r and l of the linear models of two winds, the
likeness of mode i of one and mode j of the other is

    |l_i r_j| |l_j r_i| / (|l_i r_i| |l_j r_j|),

1 for the same mode and 0 for another one. It is a modal assurance criterion (R. J. Allemang and D. L. Brown, Proc. 1st
Int. Modal Analysis Conf. (1982) 110) in which metres and radians may stand side by side. The modes of two winds are
paired such that the sum of the likenesses is largest.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from fowtlib.analysis.plants import plant_of
from fowtlib.language.errors import ModelError, SimulationError, did_you_mean
from fowtlib.language.units import to_si
from fowtlib.solving import NaturalMode, mean_state
from fowtlib.solving.modes import modes_of_mean
from fowtlib.solving.results.drawing import COLORS, INK, drawing, drawing_style, save_figure
from fowtlib.solving.results.tables import write_table

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

WIND = "wind.mean_speed"
LIKE = 0.3  # likeness below which a mode is not the one before
MULTIPLES = (1, 3, 6, 9)  # of the rotor speed, that are drawn


@dataclass(frozen=True, eq=False)
class ModeLine:
    """One mode over the values: name, frequency [Hz] and damping ratio (n,), NaN where there is none like it.

    likeness (n,): to the mode at the value before, NaN at the first.
    """

    name: str
    frequency: np.ndarray
    damping_ratio: np.ndarray
    likeness: np.ndarray = field(repr=False)


@dataclass(frozen=True, eq=False)
class Campbell:
    """Modes over the values (n,) of a parameter; rotor_speed (n, rotors) [rad/s]; lines: lowest frequency first."""

    over: str
    unit: str
    values: np.ndarray
    rotor_speed: np.ndarray
    lines: tuple[ModeLine, ...]

    def __getitem__(self, name: str) -> ModeLine:
        for line in self.lines:
            if line.name == name:
                return line
        raise ModelError(f"there is no mode '{name}'; there are {', '.join(line.name for line in self.lines)}.")

    def below(self, frequency: float) -> Campbell:
        """Those of the modes that lie below a frequency [Hz] somewhere."""
        kept = tuple(line for line in self.lines if np.nanmin(line.frequency) < frequency)
        return Campbell(self.over, self.unit, self.values, self.rotor_speed, kept)

    @property
    def unstable(self) -> list[tuple[str, float]]:
        """Names of the modes that grow, with the first value at which they do."""
        found = []
        for line in self.lines:
            growing = np.flatnonzero(np.nan_to_num(line.damping_ratio, nan=1.0) < 0)
            if growing.size:
                found.append((line.name, float(self.values[growing[0]])))
        return found

    def heads(self) -> tuple[str, ...]:
        """The columns of `rows`."""
        return (f"{self.over} [{self.unit}]", "rotor speed [rpm]", "motion", "frequency [Hz]", "damping ratio",
                "likeness")  # fmt: skip

    def rows(self) -> list[list[Any]]:
        """One row for each mode at each value."""
        rpm = self.rotor_speed * 30 / np.pi
        return [[float(value), float(rpm[k, 0]) if rpm.shape[1] else 0.0, line.name, float(line.frequency[k]),
                 float(line.damping_ratio[k]), float(line.likeness[k])]
                for k, value in enumerate(self.values) for line in self.lines
                if np.isfinite(line.frequency[k])]  # fmt: skip

    def save(self, path: str | Path) -> Path:
        """Write `rows` as .csv."""
        return write_table(Path(path), self.heads(), self.rows(), "a Campbell diagram")

    def plot(self, path: str | Path | None = None, title: str = "") -> Figure:
        """Frequencies with multiples of the rotor speed, and damping, over the values."""
        if not self.lines:
            raise ModelError("there is nothing to plot: no mode oscillates there.")
        name = "wind speed" if self.over == WIND else self.over
        with drawing_style():
            figure = drawing(10.0, 5.6 + 0.2 * len(title.splitlines()))
            left, right = figure.subplots(1, 2)
            for k, line in enumerate(self.lines):
                marker = "os^vD"[k // len(COLORS) % 5]
                style = {"color": COLORS[k % len(COLORS)], "marker": marker, "ms": 3.5, "lw": 1.2}
                left.plot(self.values, line.frequency, **style)
                right.plot(self.values, 100 * line.damping_ratio, label=line.name, **style)
            top = 1.08 * max(float(np.nanmax(line.frequency)) for line in self.lines)
            _multiples(left, self.values, self.rotor_speed, top)
            left.set_ylim(0.0, top)
            right.set_yscale("symlog", linthresh=1.0)
            right.axhline(0.0, color=INK, lw=0.8)
            left.set_ylabel("natural frequency, not turning [Hz]")
            right.set_ylabel("damping ratio [%]")
            for axis in (left, right):
                axis.margins(x=0.03)
                axis.set_xlabel(f"{name} [{self.unit}]")
            figure.legend(loc="outside lower center", ncols=3, fontsize=7.5)
            if title:
                figure.suptitle(title, x=0.01, ha="left", fontsize=10.5, fontweight="bold")
        return save_figure(figure, path)

    def __repr__(self) -> str:
        ends = f"{self.values[0]:g} to {self.values[-1]:g} {self.unit}"
        return f"<Campbell: {len(self.lines)} modes, {self.over} {ends}>"


def _multiples(axis: Axes, values: np.ndarray, speed: np.ndarray, top: float) -> None:
    for column in speed.T[: 1 if np.allclose(speed, speed[:, :1], rtol=0.01) else None]:
        for multiple in MULTIPLES:
            frequency = multiple * np.abs(column) / (2 * np.pi)
            if frequency.min() < top:
                axis.plot(values, frequency, color="#888888", lw=0.9, ls="--", zorder=0)
                axis.annotate(f"{multiple}P", (values[-1], min(frequency[-1], top)), fontsize=7.5, color="#666666",
                              xytext=(3, -3), textcoords="offset points", annotation_clip=False)  # fmt: skip


def campbell(model: Any, values: Sequence[float], *, over: str = WIND, parameters: Mapping[str, Any] | None = None,
             progress: Callable[[int, int], None] | None = None) -> Campbell:  # fmt: skip
    """The natural modes of a model, or of a compiled one, at several winds, each followed from one to the next.

    values      of the parameter `over`, in SI or with units, one after the other
    parameters  further ones, for all values
    progress    called with (done, all)
    Modes of filters, controllers and radiated waves are left out. A model is taken in the mean of its wind and waves.
    Raises SimulationError, which names the value, where there is no mean state.
    """
    plant = plant_of(model.in_the_mean() if hasattr(model, "in_the_mean") else model)
    known = plant.dae.parameters
    if over not in known:
        raise ModelError(f"the model has no tunable parameter '{over}' over which its modes could be followed"
                         f"{did_you_mean(over, list(known))}")  # fmt: skip
    unit = known[over].unit
    values = np.atleast_1d(np.asarray(to_si(values, unit, over), dtype=float))
    if not values.size:
        raise ModelError(f"{over}: no value is given.")
    state, points = None, []
    for k, value in enumerate(values.tolist()):
        try:
            before = state if over == WIND else None  # another parameter may be a start value, as of a rotor speed
            state = mean_state(plant, {**(parameters or {}), over: value}, start=before)
            points.append(_Point.of(plant, state))
        except SimulationError as error:
            raise error.at(f"{over} = {value:g} {unit}") from None
        if progress is not None:
            progress(k + 1, len(values))
    rotors = max(len(point.speeds) for point in points)
    speed = np.array([[*point.speeds, *[0.0] * (rotors - len(point.speeds))] for point in points])
    return Campbell(over, unit, values, speed.reshape(len(values), rotors), _lines(points))


@dataclass(frozen=True, eq=False)
class _Point:
    """The modes at one value: names, right (n, m) and left (m, n) eigenvectors with left_i right_i = 1."""

    modes: list[NaturalMode]
    right: np.ndarray
    left: np.ndarray
    states: tuple[str, ...]
    speeds: tuple[float, ...]

    @staticmethod
    def of(plant: Any, state: Any) -> _Point:
        modes, found = modes_of_mean(plant, state)
        modes = [mode for mode in modes if mode.motion and mode.oscillates]
        values, right = np.linalg.eig(found.linear.matrices["A"])
        left = np.linalg.pinv(right)
        chosen = [int(np.argmin(np.abs(values - mode.eigenvalue))) for mode in modes]
        return _Point(modes, right[:, chosen], left[chosen], tuple(found.linear.states), found.speeds)

    def likeness(self, other: _Point) -> np.ndarray:
        """Of each mode here to each one there: (m, k)."""
        if self.states != other.states:
            kept = [path for path in self.states if path in set(other.states)]
            here, there = ([point.states.index(path) for path in kept] for point in (self, other))
        else:
            here = there = list(range(len(self.states)))
        return np.abs(self.left[:, here] @ other.right[there]) * np.abs(other.left[:, there] @ self.right[here]).T


def _lines(points: Sequence[_Point]) -> tuple[ModeLine, ...]:
    """Modes of one value after the other that are alike."""
    from scipy.optimize import linear_sum_assignment

    n = len(points)
    open_lines: dict[int, list[tuple[int, NaturalMode, float]]] = {}
    lines: list[list[tuple[int, NaturalMode, float]]] = []
    for k, point in enumerate(points):
        now: dict[int, list[tuple[int, NaturalMode, float]]] = {}
        if k:
            table = points[k - 1].likeness(point)
            for i, j in zip(*linear_sum_assignment(table, maximize=True), strict=True):
                if table[i, j] > LIKE:
                    open_lines[i].append((k, point.modes[j], float(table[i, j])))
                    now[j] = open_lines[i]
        for j, mode in enumerate(point.modes):
            if j not in now:
                now[j] = [(k, mode, float("nan"))]
                lines.append(now[j])
        open_lines = now
    found, used = [], Counter()
    for line in lines:
        name = Counter(mode.name.partition(", with ")[0] for _, mode, _ in line).most_common(1)[0][0]
        used[name] += 1
        name = name if used[name] == 1 else f"{name} ({used[name]})"
        table = np.full((3, n), np.nan)
        for k, mode, likeness in line:
            table[:, k] = mode.frequency, mode.damping_ratio, likeness
        found.append(ModeLine(name, *table))
    return tuple(sorted(found, key=lambda line: float(np.nanmean(line.frequency))))
