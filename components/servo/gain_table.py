"""Gains of a state feedback over a schedule, as data: a file, or made by fowtlib.control."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from fowtlib.components.servo.scheduled_table import ScheduledTable, read_table
from fowtlib.language.data_files import remembered


@dataclass(frozen=True, eq=False)
class GainTable(ScheduledTable):
    """u = trim - gains (y - set_points) - integral of integral_gains (y - set_points), over a schedule of k points.

    over: what the schedule runs over; points (k,) increase. measured, demands: names of the n signals y and of the m
    demands u. gains and integral_gains (k, m, n): of the integrals, zero for a signal that is not integrated.
    set_points (k, n): y at rest. trim (k, m): u at rest. SI. Raises ParameterError where the shapes do not fit.
    """

    kind: ClassVar[str] = "gains"
    called: ClassVar[str] = "a table of gains"
    lists: ClassVar[tuple[str, ...]] = ("measured", "demands")

    measured: tuple[str, ...]
    demands: tuple[str, ...]
    gains: np.ndarray
    integral_gains: np.ndarray
    set_points: np.ndarray
    trim: np.ndarray

    def shapes(self) -> dict[str, tuple[int, ...]]:
        k, n, m = np.size(self.points), len(self.measured), len(self.demands)
        return {"gains": (k, m, n), "integral_gains": (k, m, n), "set_points": (k, n), "trim": (k, m)}


@remembered()
def read_gains(path: str) -> GainTable:
    """The table of a file that `GainTable.save` wrote. Raises ParameterError with the path."""
    return read_table(GainTable, path)
