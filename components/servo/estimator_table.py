"""Estimators over a schedule, as data: a file, or made by fowtlib.control."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from fowtlib.components.servo.scheduled_table import ScheduledTable, read_table
from fowtlib.language.data_files import remembered


@dataclass(frozen=True, eq=False)
class EstimatorTable(ScheduledTable):
    """x' = A (x - x0) + B (u - u0) + L (y - y0 - C (x - x0) - D (u - u0)), over a schedule of k points.

    over: what the schedule runs over; points (k,) increase. states, inputs, outputs: names of the n states x, of the m
    known inputs u and of the p measured outputs y. A (k, n, n), B (k, n, m), C (k, p, n), D (k, p, m), L (k, n, p);
    x0 (k, n), u0 (k, m), y0 (k, p) at rest. SI. Raises ParameterError where the shapes do not fit.
    """

    kind: ClassVar[str] = "estimators"
    called: ClassVar[str] = "a table of estimators"
    lists: ClassVar[tuple[str, ...]] = ("states", "inputs", "outputs")

    states: tuple[str, ...]
    inputs: tuple[str, ...]
    outputs: tuple[str, ...]
    A: np.ndarray
    B: np.ndarray
    C: np.ndarray
    D: np.ndarray
    L: np.ndarray
    x0: np.ndarray
    u0: np.ndarray
    y0: np.ndarray

    def shapes(self) -> dict[str, tuple[int, ...]]:
        k, n, m, p = np.size(self.points), len(self.states), len(self.inputs), len(self.outputs)
        return {"A": (k, n, n), "B": (k, n, m), "C": (k, p, n), "D": (k, p, m), "L": (k, n, p),
                "x0": (k, n), "u0": (k, m), "y0": (k, p)}  # fmt: skip


@remembered()
def read_estimators(path: str) -> EstimatorTable:
    """The table of a file that `EstimatorTable.save` wrote. Raises ParameterError with the path."""
    return read_table(EstimatorTable, path)
