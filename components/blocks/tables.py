"""Look-up tables with continuous derivatives."""

from __future__ import annotations

import numpy as np

from fowtlib.language import Array, Component, RealInput, RealOutput, eq, param, port, table1d, table2d


class Table1D(Component):
    """y = spline through the points (x[i], values[i]); the run stops with a message where u leaves the table.

    smoothness "c2": cubic spline; "c1": piecewise cubic that does not overshoot the points.
    """

    units_within = {"x": "u", "values": "y"}

    x: Array = param(structural=True, doc="rising abscissae")
    values: Array = param(structural=True, doc="one value per abscissa")
    smoothness: str = param(default="c2", choices=("c1", "c2"), doc="continuous derivatives")

    u: RealInput = port(doc="abscissa")
    y: RealOutput = port(doc="value")

    def equations(self):
        x, values = np.ravel(self.x), np.ravel(self.values)
        return [eq(self.y, table1d(self.u, x, values, name=self.path, smoothness=self.smoothness))]


class Table2D(Component):
    """z = smooth surface through values[i, j] at (x[i], y[j]); the run stops with a message where u or v leaves it."""

    units_within = {"x": "u", "y": "v", "values": "z"}

    x: Array = param(structural=True, doc="rising abscissae of the rows")
    y: Array = param(structural=True, doc="rising abscissae of the columns")
    values: Array = param(structural=True, doc="values, rows by columns")

    u: RealInput = port(doc="abscissa along the rows' direction x")
    v: RealInput = port(doc="abscissa along the columns' direction y")
    z: RealOutput = port(doc="value")

    def equations(self):
        x, y = np.ravel(self.x), np.ravel(self.y)
        return [eq(self.z, table2d(self.u, self.v, x, y, np.asarray(self.values), name=self.path))]
