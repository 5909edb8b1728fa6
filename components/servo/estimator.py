"""Estimated states: a copy of a linear model that measured signals correct."""

from __future__ import annotations

import numpy as np

from fowtlib.components.servo.estimator_table import EstimatorTable, read_estimators
from fowtlib.components.servo.schedule import flat, flat_shape, interpolated
from fowtlib.language import Array, Component, Data, RealInput, RealOutput, data, der, eq, initial, param, port, var
from fowtlib.language import math as m
from fowtlib.language.errors import ParameterError


def _columns(name):
    return lambda self: np.shape(getattr(self, name))[-1:]


def _zeros(name):
    return lambda self: np.zeros(_columns(name)(self))


class StateEstimator(Component):
    """States from inputs and outputs: x = x0 + z, z' = A z + B (u - u0) + L (y - y0 - C z - D (u - u0)).

    With L of fowtlib.control.kalman it is the stationary Kalman estimator about the rest x0, u0, y0. The matrices are
    tunable: A (n, n), B (n, inputs), C (outputs, n), D (outputs, inputs), L (n, outputs), in SI. It starts at x0.
    Source: A. E. Bryson and Y.-C. Ho, Applied Optimal Control (1975), chapter 12. Raises ParameterError where the
    shapes do not fit.
    """

    in_own_units = {"": "its matrices are numbers of its states, whose units nobody knows"}

    memory = "controller"

    A: Array = param(shape=lambda self: np.shape(self.A), doc="rates of the states by the states")
    B: Array = param(shape=lambda self: np.shape(self.B), doc="by the inputs")
    C: Array = param(shape=lambda self: np.shape(self.C), doc="outputs by the states")
    D: Array = param(
        default=lambda self: np.zeros((np.shape(self.C)[0], np.shape(self.B)[1])),
        shape=lambda self: (np.shape(self.C)[0], np.shape(self.B)[1]), doc="outputs by the inputs"
    )  # fmt: skip
    L: Array = param(shape=lambda self: np.shape(self.L), doc="gain of what the outputs differ by")
    u0: Array = param(default=_zeros("B"), shape=_columns("B"), doc="inputs at rest")
    y0: Array = param(default=_zeros("L"), shape=_columns("L"), doc="outputs at rest")
    x0: Array = param(default=_zeros("A"), shape=_columns("A"), doc="states at rest")

    u: RealInput = port(size=lambda self: np.shape(self.B)[1], doc="known inputs")
    y: RealInput = port(size=lambda self: np.shape(self.C)[0], doc="measured outputs")
    x: RealOutput = port(size=lambda self: np.shape(self.A)[0], doc="estimated states")

    z: Array = var(shape=_columns("A"), state="prefer", fixed=True, doc="x less its rest")

    def build(self):
        sizes = {name: np.shape(getattr(self, name)) for name in "ABCL"}
        if any(len(size) != 2 for size in sizes.values()):
            raise ParameterError(f"{self.label}: A, B, C and L are matrices; their shapes are {list(sizes.values())}.")
        n, inputs, outputs = sizes["A"][0], sizes["B"][1], sizes["C"][0]
        wanted = {"A": (n, n), "B": (n, inputs), "C": (outputs, n), "L": (n, outputs)}
        for name, shape in wanted.items():
            if sizes[name] != shape:
                raise ParameterError(f"{self.label}.{name} has the shape {sizes[name]}; {shape} fits the others.")

    def equations(self):
        u, y = (m.vertcat(*ports) - rest for ports, rest in ((self.u, self.u0), (self.y, self.y0)))
        missed = y - m.mtimes(self.C, self.z) - m.mtimes(self.D, u)
        rates = m.mtimes(self.A, self.z) + m.mtimes(self.B, u) + m.mtimes(self.L, missed)
        return [eq(der(self.z), rates), [eq(self.x[i], self.x0[i] + self.z[i]) for i in range(len(self.x))]]


def _table(name, doc):
    """An array of the table, as a tunable parameter."""
    return param(default=flat(name), shape=flat_shape(name), doc=doc)


class ScheduledEstimator(Component):
    """x' = A (x - x0) + B (u - u0) + L (y - y0 - C (x - x0) - D (u - u0)), all on straight lines over a schedule v.

    What is estimated is the state itself and not its distance from a rest: where the rest x0 moves with the schedule,
    as with the wind, x does not jump, and goes to the new rest as the plant does. Beyond the first and the last point
    all stays as there. It starts at the rest of the schedule at the start. The arrays come from the table, are tunable,
    and count in SI; rows of them hold a matrix of each point, row by row.
    Source: W. J. Rugh and J. S. Shamma, Automatica 36 (2000) 1401.
    """

    in_own_units = {"": "its matrices are numbers of its states, whose units nobody knows"}

    memory = "controller"

    table: Data[EstimatorTable] = data(read_estimators, doc="file of an EstimatorTable, or one itself")
    points: Array = param(
        default=lambda self: self.table.points, shape=lambda self: (len(self.table.points),), doc="its points"
    )
    A: Array = _table("A", "rates of the states by the states, of each point")
    B: Array = _table("B", "by the inputs")
    C: Array = _table("C", "outputs by the states")
    D: Array = _table("D", "outputs by the inputs")
    L: Array = _table("L", "gain of what the outputs differ by")
    x0: Array = _table("x0", "states at rest")
    u0: Array = _table("u0", "inputs at rest")
    y0: Array = _table("y0", "outputs at rest")

    schedule: RealInput = port(doc="v, where on the schedule it is")
    u: RealInput = port(size=lambda self: len(self.table.inputs), doc="known inputs, in the order of the table")
    y: RealInput = port(size=lambda self: len(self.table.outputs), doc="measured outputs, in the order of the table")
    x: RealOutput = port(size=lambda self: len(self.table.states), doc="estimated states, in the order of the table")

    estimate: Array = var(shape=lambda self: (len(self.table.states),), state="prefer", doc="x")

    def equations(self):
        n, inputs, p = len(self.x), len(self.u), len(self.y)

        def now(name, *shape):
            row = interpolated(self.schedule, self.points, getattr(self, name))
            if len(shape) == 1:
                return row
            rows, columns = shape
            return m.vertcat(*(row[i * columns : (i + 1) * columns].T for i in range(rows)))

        away = self.estimate - now("x0", n)
        u, y = m.vertcat(*self.u) - now("u0", inputs), m.vertcat(*self.y) - now("y0", p)
        missed = y - m.mtimes(now("C", p, n), away) - m.mtimes(now("D", p, inputs), u)
        rates = m.mtimes(now("A", n, n), away) + m.mtimes(now("B", n, inputs), u) + m.mtimes(now("L", n, p), missed)
        return [
            eq(der(self.estimate), rates),
            initial(self.estimate, now("x0", n)),
            [eq(self.x[i], self.estimate[i]) for i in range(n)],
        ]
