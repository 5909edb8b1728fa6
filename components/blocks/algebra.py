"""Blocks without memory: gain, sum, product, limiter, and vectors made of scalars."""

from __future__ import annotations

from fowtlib.language import Array, Component, Number, RealInput, RealOutput, Scalar, eq, param, port
from fowtlib.language import math as m

UNLIMITED = 1e30  # the default of a limit that is not there


class Gain(Component):
    """y = gain u."""

    units_within = {"gain": "y/u"}

    gain: Scalar = param(doc="factor")

    u: RealInput = port(doc="input")
    y: RealOutput = port(doc="output")

    def equations(self):
        return [eq(self.y, self.gain * self.u)]


class Sum(Component):
    """y = sum of gains[i] u[i]; gains = (1, -1) makes the difference of two signals."""

    units_within = {"gains": "y/u"}

    n: int = param(default=2, min=1, doc="number of inputs")
    gains: Array = param(default=lambda self: [1.0] * self.n, shape="n", doc="factor of each input")

    u: RealInput = port(size="n", doc="inputs")
    y: RealOutput = port(doc="output")

    def equations(self):
        return [eq(self.y, sum(self.gains[i] * self.u[i] for i in range(self.n)))]


class Product(Component):
    """y = u[0] u[1] ... u[n-1]."""

    n: int = param(default=2, min=1, doc="number of inputs")

    u: RealInput = port(size="n", doc="inputs")
    y: RealOutput = port(doc="output")

    def equations(self):
        product = self.u[0]
        for i in range(1, self.n):
            product = product * self.u[i]
        return [eq(self.y, product)]


class Limiter(Component):
    """y = u, held between lower and upper.

    Exact with rounding = 0 (the derivative jumps at the limits); otherwise the corners are rounded over about that
    width in u, y has all derivatives and differs from the exact limiter by at most rounding.
    """

    units_within = {"lower": "y", "upper": "y", "rounding": "y"}

    lower: Scalar = param(default=-UNLIMITED, doc="smallest output")
    upper: Scalar = param(default=UNLIMITED, doc="largest output")
    rounding: Number = param(default=0.0, min=0.0, doc="width of the rounded corners, in the unit of u; 0: exact")

    u: RealInput = port(doc="input")
    y: RealOutput = port(doc="output")

    def equations(self):
        if self.rounding > 0:
            return [eq(self.y, m.smooth_saturation(self.u, self.lower, self.upper, self.rounding))]
        return [eq(self.y, m.fmin(m.fmax(self.u, self.lower), self.upper))]


class Mux(Component):
    """A vector signal made of n scalar signals: y[i] = u[i]."""

    n: int = param(default=3, min=1, doc="number of scalars")

    u: RealInput = port(size="n", doc="scalars")
    y: RealOutput = port(shape="n", doc="vector")

    def equations(self):
        return [eq(self.y, m.vertcat(*(self.u[i] for i in range(self.n))))]


class Demux(Component):
    """The n scalars of a vector signal: y[i] = u[i]."""

    n: int = param(default=3, min=1, doc="number of scalars")

    u: RealInput = port(shape="n", doc="vector")
    y: RealOutput = port(size="n", doc="scalars")

    def equations(self):
        return [eq(self.y[i], self.u[i]) for i in range(self.n)]
