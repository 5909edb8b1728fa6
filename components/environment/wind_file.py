"""Wind speeds on a uniform time grid, and their CSV file."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fowtlib.language.data_files import is_number, text_of
from fowtlib.language.errors import ParameterError

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class WindSeries:
    """Longitudinal speeds on a uniform time grid: values (n, stations) [m/s] at start + i step [s].

    A periodic series stands for all times and repeats after n steps; any other ends with its last sample.
    """

    start: float
    step: float
    values: Floats
    periodic: bool

    @property
    def time(self) -> Floats:
        """Sample times (n,), s."""
        return self.start + self.step * np.arange(len(self.values))

    @property
    def end(self) -> float:
        """Time of the last sample, or of the first repetition, s."""
        return self.start + self.step * (len(self.values) - (0 if self.periodic else 1))


def read_series(path: str, stations: int, *, what: str = "wind file", quantity: str = "speed") -> WindSeries:
    """Wind speeds from a CSV file with the columns time [s], speed at the first station [m/s], at the second, ...

    One speed column serves any number of stations. Times rise by equal steps. There may be one header line; blank lines
    and lines that begin with # are skipped. Raises ParameterError with file:line for anything else: a word or nan, a
    wrong number of columns, uneven times; with the path for a file that cannot be read. `what` and `quantity` are words
    of the messages, for files of other things.
    """
    rows: list[list[float]] = []
    lines: list[int] = []
    text = text_of(path, f"the {what}").split("\n")
    header = False
    for line, content in enumerate(text, start=1):
        content = content.strip()
        if not content or content.startswith("#"):
            continue
        cells = [cell.strip() for cell in content.split(",")]
        if len(cells) < 2:
            raise ParameterError(f"{path}:{line}: 1 column, expected time and {quantity}, separated by commas")
        if not rows and not header and not any(is_number(cell) for cell in cells):
            header = True
            continue
        where = f"{path}:{line}"
        for column, cell in enumerate(cells, start=1):
            if not (is_number(cell) and math.isfinite(float(cell))):
                raise ParameterError(f"{where}: column {column} is {cell!r}, expected a number")
        if len(cells) not in (2, 1 + stations):
            every = f"{1 + stations}, time and the speed at every station"
            wanted = f"2, time and {quantity}" if stations == 1 else every
            raise ParameterError(f"{where}: {len(cells)} columns, expected {wanted}")
        if rows and len(cells) != len(rows[0]):
            raise ParameterError(f"{where}: {len(cells)} columns, but line {lines[0]} has {len(rows[0])}")
        rows.append([float(cell) for cell in cells])
        lines.append(line)
    if len(rows) < 4:
        raise ParameterError(f"{path}: {len(rows)} lines of data, expected at least 4")
    table = np.array(rows)
    _check_times(path, table[:, 0], lines)
    step = (table[-1, 0] - table[0, 0]) / (len(table) - 1)
    values = np.broadcast_to(table[:, 1:], (len(table), stations)) if table.shape[1] == 2 else table[:, 1:]
    return WindSeries(float(table[0, 0]), float(step), np.array(values), periodic=False)


def _check_times(path: str, time: Floats, lines: list[int]) -> None:
    """Raise unless the times rise by equal steps: within a tenth of a step of the even grid, for rounded numbers."""
    steps = np.diff(time)
    if np.any(steps <= 0):
        i = int(np.argmax(steps <= 0))
        raise ParameterError(f"{path}:{lines[i + 1]}: time {time[i + 1]:g} s does not come after {time[i]:g} s")
    even = np.linspace(time[0], time[-1], len(time))
    if np.max(np.abs(time - even)) > 0.1 * (even[1] - even[0]):
        usual = float(np.median(steps))
        i = int(np.argmax(np.abs(steps - usual)))
        raise ParameterError(
            f"{path}:{lines[i + 1]}: time rises by {steps[i]:g} s here and by {usual:g} s elsewhere; "
            "resample the series to equal steps"
        )
