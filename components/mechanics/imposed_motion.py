"""A frame that moves as a record says: six motions from a file, for what rides on it."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from fowtlib.components.mechanics.connectors import Frame
from fowtlib.components.mechanics.rotations import yaw_pitch_roll, yaw_pitch_roll_velocity
from fowtlib.language import Array, Component, Number, Series, Vector, der, eq, fix_orientation, param, port, var
from fowtlib.language.data_files import cells_of, lines_of, remembered
from fowtlib.language.declarations import join
from fowtlib.language.errors import ParameterError, UnitError, did_you_mean
from fowtlib.language.run_time import run_time_series
from fowtlib.language.units import to_si

BEYOND = 6  # samples by which a record is continued at both ends
MOTIONS = {"surge": "m", "sway": "m", "heave": "m", "roll": "rad", "pitch": "rad", "yaw": "rad"}


@dataclass(frozen=True, eq=False)
class MotionRecord:
    """Six motions (n, 6) [m, rad] in the order of MOTIONS, at start + i step [s]."""

    start: float
    step: float
    values: NDArray[np.float64]

    @property
    def end(self) -> float:
        """Time of the last sample, s."""
        return self.start + self.step * (len(self.values) - 1)


@remembered()
def read_motion(path: str) -> MotionRecord:
    """A record from a CSV file whose first line is such as time [s],surge [m],pitch [deg]; motions not in it are zero.

    Times rise by equal steps. Other columns are refused, so that none is overlooked. Raises ParameterError with path
    and line.
    """
    lines = lines_of(path, "the motions")
    if not lines:
        raise ParameterError(f"{path}: no motions; the first line names the columns: time [s],surge [m],pitch [deg].")
    number, head = lines[0]
    columns = [_column(cell, f"{path}:{number}") for cell in cells_of(head)]
    names = [name for name, _ in columns]
    if "time" not in names or len(set(names)) < len(names):
        raise ParameterError(f"{path}:{number}: one column is time [s], and each motion is there once.")
    table = np.zeros((len(lines) - 1, 1 + len(MOTIONS)))
    for row, (number, line) in enumerate(lines[1:]):
        cells = cells_of(line)
        try:
            numbers = np.array([float(cell) for cell in cells])
        except ValueError:
            numbers = np.array([np.nan])
        if len(numbers) != len(columns) or not np.isfinite(numbers).all():
            raise ParameterError(f"{path}:{number}: '{line.strip()}' is not a row of numbers under {head.strip()}.")
        for (name, factor), value in zip(columns, numbers, strict=True):
            table[row, 0 if name == "time" else 1 + list(MOTIONS).index(name)] = factor * value
    time, steps = table[:, 0], np.diff(table[:, 0])
    if len(time) < 4 or not np.all(steps > 0) or np.ptp(steps) > 0.01 * steps.mean():
        raise ParameterError(f"{path}: motions are given at four times or more, which rise by equal steps.")
    return MotionRecord(float(time[0]), float((time[-1] - time[0]) / (len(time) - 1)), table[:, 1:])


def _column(cell: str, where: str) -> tuple[str, float]:
    """The quantity under a heading, and the factor of its unit."""
    name, _, unit = cell.partition("[")
    name, unit = name.strip(), unit.strip().rstrip("]").strip()
    if name not in ("time", *MOTIONS):
        raise ParameterError(f"{where}: there is no motion '{name}'{did_you_mean(name, MOTIONS)}")
    wanted = MOTIONS.get(name, "s")
    if not unit:
        raise ParameterError(f"{where}: '{cell.strip()}' has no unit; write {name} [{wanted}].")
    try:
        return name, float(to_si(f"1 {unit}", wanted))
    except UnitError as error:
        raise ParameterError(f"{where}: {name}: {error}") from None


class ImposedMotion(Component):
    """A frame whose six motions are those of a record, whatever load it takes: a model that is towed or oscillated.

    surge, sway, heave are added to `r` in the axes of the world; roll, pitch, yaw turn the frame as FreeMotion has
    them, R = Rz(yaw) Ry(pitch) Rx(roll): yaw first, pitch about the new y axis, roll about the new x axis. So a record
    of a run of a floater moves a frame as the floater moved. Between the samples the motion is a spline with two
    continuous derivatives; t = 0 is the time `start` of the record, and the run stops at its end. In the first
    `build_up` seconds the motion grows from nothing, by 10 s^3 - 15 s^4 + 6 s^5.
    """

    in_own_units = {"file": "a record has seconds and metres of its own"}

    file: str = param(bound=True, doc="CSV file: time [s], surge [m], ... yaw [deg], see read_motion")
    r: Vector = param(default=(0, 0, 0), unit="m", doc="place of the frame, to which the motions are added, world")
    start: Number = param(default=None, unit="s", bound=True, doc="time of the record at t = 0; else its first")
    build_up: Number = param(default=0.0, unit="s", min=0, bound=True, doc="time in which it grows from nothing")

    frame: Frame = port(doc="the moved frame")

    position: Array = var(unit="m", shape=(3,), state="never", doc="surge, sway, heave")
    angles: Array = var(unit="rad", shape=(3,), state="never", doc="roll, pitch, yaw")

    def equations(self):
        ended = "the record of motions {%s} ends at {high} s" % join(self.path, "file")  # noqa: UP031 braces for later
        motion = run_time_series(self.time, 6, "motions", lambda it: it.series(), of=self, message=ended)
        roll, pitch, yaw = (self.angles[i] for i in range(3))
        return [
            eq(self.position, motion[:3]),
            eq(self.angles, motion[3:]),
            eq(self.frame.r, self.r + self.position),
            fix_orientation(
                self.frame, yaw_pitch_roll(roll, pitch, yaw), yaw_pitch_roll_velocity(pitch, yaw, der(self.angles))
            ),
        ]

    def series(self) -> Series:
        """The motions of a run, from t = 0 on."""
        record = read_motion(self.parameter_value("file"))
        start = self.parameter_value("start")
        start = record.start if start is None else start
        if not record.start <= start < record.end:
            raise ParameterError(
                f"{self.label}.start: {start:g} s lies outside of the record, {record.start:g} to {record.end:g} s."
            )
        begin = record.start - start
        series = Series.samples(
            _continued(record.values), record.step, begin - BEYOND * record.step,
            build_up=self.parameter_value("build_up"),
        )  # fmt: skip
        return replace(series, covers=(begin, record.end - start))


def _continued(values: NDArray[np.float64]) -> NDArray[np.float64]:
    """Some samples more at both ends, by the cubic nearest to the last ones: there, too, accelerations are right."""
    count = min(2 * BEYOND, len(values))
    grid, more = np.arange(count), np.arange(-BEYOND, 0)
    ends = [values[:count], values[::-1][:count]]
    before, after = (np.polynomial.polynomial.polyval(more, np.polynomial.polynomial.polyfit(grid, end, 3)).T
                     for end in ends)  # fmt: skip
    return np.vstack([before + values[0] - _at_end(ends[0]), values, (after + values[-1] - _at_end(ends[1]))[::-1]])


def _at_end(end: NDArray[np.float64]) -> NDArray[np.float64]:
    """The cubic at the last sample itself."""
    return np.polynomial.polynomial.polyfit(np.arange(len(end)), end, 3)[0]
