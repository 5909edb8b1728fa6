"""Continuous blocks with states: integrator, filters, actuators, linear systems.

`initialization` says where a block starts: "steady", at rest for the input it has at the start, or "value", at its
start values.
"""

from __future__ import annotations

import math

import numpy as np

from fowtlib.language import Array, Component, RealInput, RealOutput, Scalar, der, eq, initial, param, port, var
from fowtlib.language import math as m
from fowtlib.language.bounds import POSITIVE
from fowtlib.language.errors import ParameterError

STARTS = ("steady", "value")


class Integrator(Component):
    """dy/dt = gain u."""

    units_within = {"gain": "y/u", "y_start": "y"}

    gain: Scalar = param(default=1.0, unit="1/s", doc="factor")
    y_start: Scalar = param(default=0.0, doc="initial output")

    u: RealInput = port(doc="input")
    y: RealOutput = port(doc="output")

    x: Scalar = var(start=y_start, state="prefer", doc="integral")

    def equations(self):
        return [eq(der(self.x), self.gain * self.u), eq(self.y, self.x)]


class Derivative(Component):
    """Filtered derivative: y = gain s / (time_constant s + 1) u, by x' = (u - x) / time_constant, y = gain x'.

    Reference: Modelica.Blocks.Continuous.Derivative.
    """

    units_within = {"gain": "y/u"}

    gain: Scalar = param(default=1.0, unit="s", doc="factor")
    time_constant: Scalar = param(
        unit="s", min=POSITIVE, doc="time constant of the filter, well below that of the signal"
    )

    u: RealInput = port(doc="input")
    y: RealOutput = port(doc="output")

    x: Scalar = var(state="prefer", doc="filtered input")

    def equations(self):
        rate = (self.u - self.x) / self.time_constant
        return [eq(der(self.x), rate), eq(self.y, self.gain * rate), initial(self.x, self.u)]


def starts_steady(block) -> bool:
    """Whether a block starts at rest under its input. Raises ParameterError for a y_start that does not count then."""
    if block.initialization != "steady":
        return False
    block.refuse_unused("y_start", because="initialization is steady (value starts at y_start)")
    return True


def _start(block):
    """Start value of the output, where it does not start steady."""
    return block.y_start if block.initialization == "value" else 0.0


class FirstOrder(Component):
    """Lag of first order: time_constant y' + y = gain u."""

    units_within = {"gain": "y/u", "y_start": "y"}

    gain: Scalar = param(default=1.0, doc="steady gain")
    time_constant: Scalar = param(unit="s", min=0, doc="time constant")
    initialization: str = param(default="steady", choices=STARTS, doc="start at rest, or at y_start")
    y_start: Scalar = param(default=0.0, doc="initial output")

    u: RealInput = port(doc="input")
    y: RealOutput = port(doc="output")

    x: Scalar = var(start=lambda self: _start(self), state="prefer", doc="output")

    def equations(self):
        drive = self.gain * self.u
        steady = [initial(self.x, drive)] if starts_steady(self) else []
        return [eq(self.time_constant * der(self.x), drive - self.x), eq(self.y, self.x), steady]


class SecondOrderActuator(Component):
    """Lag of second order, for pitch, yaw and valve drives.

    y'' + 2 damping_ratio w0 y' + w0^2 y = w0^2 u with w0 = 2 pi natural_frequency. The output is twice
    differentiable even where the input jumps, so that it may prescribe an angle (AngleSource).
    """

    units_within = {"y_start": "y"}

    natural_frequency: Scalar = param(unit="Hz", min=POSITIVE, doc="undamped natural frequency")
    damping_ratio: Scalar = param(min=0, doc="damping ratio")
    initialization: str = param(default="steady", choices=STARTS, doc="start at rest, or at y_start with zero rate")
    y_start: Scalar = param(default=0.0, doc="initial output")

    u: RealInput = port(doc="commanded value")
    y: RealOutput = port(doc="actual value")

    x: Scalar = var(start=lambda self: _start(self), state="prefer", doc="actual value")
    rate: Scalar = var(state="prefer", doc="rate of the actual value")

    def equations(self):
        w0 = 2 * math.pi * self.natural_frequency
        return [
            eq(der(self.x), self.rate),
            eq(der(self.rate), w0 * (w0 * (self.u - self.x) - 2 * self.damping_ratio * self.rate)),
            eq(self.y, self.x),
            [initial(self.x, self.u), initial(self.rate, 0)] if starts_steady(self) else [],
        ]


class ButterworthLowPass(Component):
    """Low-pass of any order with maximally flat pass band: |H| = 1 / sqrt(1 + (f / cutoff_frequency)^(2 order)).

    Sections of second order in series with damping ratios sin((2k - 1) pi / (2 order)), k = 1..order/2, and one of
    first order before them where the order is odd. Reference: S. Butterworth (1930), Wireless Engineer 7, 536-541.
    """

    units_within = {"y_start": "y"}

    order: int = param(default=2, min=1, max=20, doc="order")
    cutoff_frequency: Scalar = param(unit="Hz", min=POSITIVE, doc="frequency of -3 dB")
    initialization: str = param(default="steady", choices=STARTS, doc="start at rest, or at y_start")
    y_start: Scalar = param(default=0.0, doc="initial output")

    u: RealInput = port(doc="input")
    y: RealOutput = port(doc="filtered input")

    x: Array = var(
        shape="order", start=lambda self: self.at_rest(), state="prefer", doc="output and scaled rate of each section"
    )

    def second_order_sections(self):
        """Index of the first state of each section of second order."""
        return range(self.order % 2, self.order, 2)

    def at_rest(self):
        """States of all sections at rest with the output y_start."""
        return [0.0 if i - 1 in self.second_order_sections() else _start(self) for i in range(self.order)]

    def equations(self):
        w0, x, into = 2 * math.pi * self.cutoff_frequency, self.x, self.u
        equations, steady = [], []
        if self.order % 2:
            equations += [eq(der(x[0]), w0 * (into - x[0]))]
            steady += [initial(x[0], self.u)]
            into = x[0]
        for k, i in enumerate(self.second_order_sections()):
            damping = math.sin((2 * k + 1) * math.pi / (2 * self.order))
            equations += [eq(der(x[i]), w0 * x[i + 1])]
            equations += [eq(der(x[i + 1]), w0 * (into - x[i] - 2 * damping * x[i + 1]))]
            steady += [initial(x[i], self.u), initial(x[i + 1], 0)]
            into = x[i]
        return [equations, eq(self.y, into), steady if starts_steady(self) else []]


class BandPass(Component):
    """Second-order band pass, 1 at its frequency w0: y / u = 2 zeta w0 s / (s^2 + 2 zeta w0 s + w0^2).

    What is left of u without it, u - y, is a notch. It starts at rest, with y = 0.
    """

    frequency: Scalar = param(unit="Hz", min=POSITIVE, doc="centre")
    damping_ratio: Scalar = param(default=0.5, min=0, doc="zeta: half of the width over the centre")

    u: RealInput = port(doc="input")
    y: RealOutput = port(doc="what passes")

    x: Scalar = var(state="prefer", doc="what passes")
    held: Scalar = var(state="prefer", doc="integral of what passes times w0")

    def equations(self):
        w0 = 2 * math.pi * self.frequency
        return [
            eq(der(self.x), w0 * (2 * self.damping_ratio * (self.u - self.x) - self.held)),
            eq(der(self.held), w0 * self.x),
            eq(self.y, self.x),
        ]


class StateSpace(Component):
    """x' = A x + B u, y = C x + D u, with vectors u (columns of B) and y (rows of C).

    Raises ParameterError where the shapes of A, B, C and D do not fit.
    """

    in_own_units = {"": "its coefficients are numbers of its states, whose units nobody knows"}

    A: Array = param(structural=True, doc="system matrix, n x n")
    B: Array = param(structural=True, doc="input matrix, n x inputs")
    C: Array = param(structural=True, doc="output matrix, outputs x n")
    D: Array = param(default=lambda self: np.zeros((len(self.C), len(self.B[0]))), structural=True, doc="feed-through")
    x_start: Array = param(default=lambda self: np.zeros(len(self.A)), doc="initial state")

    u: RealInput = port(shape=lambda self: len(self.B[0]), doc="inputs")
    y: RealOutput = port(shape=lambda self: len(self.C), doc="outputs")

    x: Array = var(shape=lambda self: len(self.A), start=x_start, state="prefer", doc="state")

    def build(self):
        n, inputs, outputs = len(self.A), len(self.B[0]), len(self.C)
        wanted = {"A": (n, n), "B": (n, inputs), "C": (outputs, n), "D": (outputs, inputs)}
        for name, shape in wanted.items():
            if np.shape(getattr(self, name)) != shape:
                given = np.shape(getattr(self, name))
                raise ParameterError(f"StateSpace.{name} has the shape {given}; {shape} fits the others.")

    def equations(self):
        x, u = self.x, self.u
        return [
            eq(der(x), m.mtimes(self.A, x) + m.mtimes(self.B, u)),
            eq(self.y, m.mtimes(self.C, x) + m.mtimes(self.D, u)),
        ]


def canonical_form(numerator, denominator):
    """A (n x n), B, C (n), D of numerator / denominator, both in falling powers: the controllable canonical form.

    Raises ParameterError: a leading zero of the denominator, a numerator of higher degree, or no state at all.
    """
    num, den = np.ravel(numerator).astype(float), np.ravel(denominator).astype(float)
    n = len(den) - 1
    if n < 1 or den[0] == 0 or len(num) > n + 1:
        raise ParameterError(
            f"the transfer function {list(num)} / {list(den)} is not proper: the denominator needs a first coefficient "
            "other than 0 and at least the degree of the numerator, and of 1."
        )
    num, den = np.concatenate([np.zeros(n + 1 - len(num)), num]) / den[0], den / den[0]
    A = np.eye(n, k=1)
    A[-1] = -den[:0:-1]
    B = np.eye(n)[-1]
    return A, B, (num[1:] - den[1:] * num[0])[::-1], num[0]


class TransferFunction(Component):
    """y = numerator(s) / denominator(s) u, coefficients in falling powers of s; starts from zero states.

    The states are those of the controllable canonical form, which is ill-conditioned for high orders with distant
    poles: write such a filter as several blocks in series.
    """

    in_own_units = {"": "its coefficients are numbers of its states, whose units nobody knows"}

    numerator: Array = param(structural=True, doc="coefficients, highest power of s first")
    denominator: Array = param(structural=True, doc="coefficients, highest power of s first")

    u: RealInput = port(doc="input")
    y: RealOutput = port(doc="output")

    x: Array = var(shape=lambda self: np.size(self.denominator) - 1, state="prefer", doc="state")

    def equations(self):
        A, B, C, D = canonical_form(self.numerator, self.denominator)
        return [eq(der(self.x), m.mtimes(A, self.x) + B * self.u), eq(self.y, m.dot(C, self.x) + D * self.u)]


class SlewRateLimiter(Component):
    """Follows u with a limited rate: y' = (u - y) / time_constant, held between -falling_rate and rising_rate.

    A continuous limiter must lag to know its rate: slow inputs come out late by time_constant. Keep it well below the
    times that matter, and not smaller than needed: every jump of u costs steps of that length.
    """

    units_within = {"rising_rate": "y", "falling_rate": "y", "y_start": "y"}

    rising_rate: Scalar = param(unit="1/s", min=0, doc="largest rate of y")
    falling_rate: Scalar = param(default=rising_rate, unit="1/s", min=0, doc="largest rate of fall of y, positive")
    time_constant: Scalar = param(default=0.02, unit="s", min=POSITIVE, doc="lag within the rate limits")
    initialization: str = param(default="steady", choices=STARTS, doc="start at u, or at y_start")
    y_start: Scalar = param(default=0.0, doc="initial output")

    u: RealInput = port(doc="input")
    y: RealOutput = port(doc="output")

    x: Scalar = var(start=lambda self: _start(self), state="prefer", doc="output")

    def equations(self):
        rate = (self.u - self.x) / self.time_constant
        steady = [initial(self.x, self.u)] if starts_steady(self) else []
        return [eq(der(self.x), m.fmin(m.fmax(rate, -self.falling_rate), self.rising_rate)), eq(self.y, self.x), steady]
