"""Controllers: PI with limits, anti-windup and gain schedule, continuous and sampled; sampled transfer functions."""

from __future__ import annotations

import numpy as np

from fowtlib.components.blocks.algebra import UNLIMITED
from fowtlib.components.blocks.dynamics import canonical_form
from fowtlib.language import (
    Array,
    Component,
    Number,
    RealInput,
    RealOutput,
    Scalar,
    assign,
    der,
    eq,
    param,
    port,
    sampled,
    var,
)
from fowtlib.language import math as m
from fowtlib.language.bounds import POSITIVE


class PI(Component):
    """PI controller with limits, anti-windup by back-calculation and a gain-schedule input.

    free = gain k_p u + integral part, y = free held between lower and upper. The gain acts on the integrand (a change
    of the gain does not move the output: integral part x, x' = gain k_i u + (y - free) / tracking_time) or on the
    integral (integral part gain x, x' = k_i u + (y - free) / (gain tracking_time), as in J. Jonkman et al. (2009),
    NREL/TP-500-38060, section 7.3).
    Anti-windup: K. Astrom, T. Hagglund (2006), Advanced PID Control, section 3.5.
    """

    units_within = dict.fromkeys(("proportional_gain", "integral_gain"), "y/u") | dict.fromkeys(
        ("lower", "upper", "integral_start"), "y"
    )

    proportional_gain: Scalar = param(doc="k_p, output per input")
    integral_gain: Scalar = param(unit="1/s", doc="k_i, output per input and second")
    lower: Scalar = param(default=-UNLIMITED, doc="smallest output")
    upper: Scalar = param(default=UNLIMITED, doc="largest output")
    tracking_time: Scalar = param(default=1.0, unit="s", min=POSITIVE, doc="time constant of the anti-windup")
    gain_on: str = param(default="integrand", choices=("integrand", "integral"), doc="what the gain multiplies")
    integral_start: Scalar = param(default=0.0, doc="initial integral part before the gain")

    u: RealInput = port(doc="control error, set point minus measurement (or the reverse for a negative plant)")
    gain: RealInput = port(default=1.0, doc="gain schedule, 1 when unconnected")
    y: RealOutput = port(doc="controller output, within the limits")

    x: Scalar = var(start=integral_start, state="prefer", doc="integral part")
    free: Scalar = var(doc="output before the limits")

    def equations(self):
        on_integral = self.gain_on == "integral"
        integral = self.gain * self.x if on_integral else self.x
        rate = self.integral_gain * self.u if on_integral else self.gain * self.integral_gain * self.u
        back = (self.y - self.free) / self.tracking_time
        return [
            eq(self.free, self.gain * self.proportional_gain * self.u + integral),
            eq(self.y, m.fmin(m.fmax(self.free, self.lower), self.upper)),
            eq(der(self.x), rate + (back / self.gain if on_integral else back)),
        ]


class Sampler(Component):
    """Sample and zero-order hold: y takes the value of u every `period` seconds."""

    period: Number = param(unit="s", min=POSITIVE, doc="sampling period")
    offset: Number = param(default=0.0, unit="s", doc="time of the first sample")

    u: RealInput = port(doc="continuous signal")
    y: RealOutput = port(doc="held signal")

    held: Scalar = var(discrete=True, doc="last sample")

    def equations(self):
        return [sampled(self.period, assign(self.held, self.u), offset=self.offset), eq(self.y, self.held)]


class SampledPI(Component):
    """PI controller that runs every `period` seconds and holds its output in between.

    integral[k] = integral[k-1] + period k_i u[k], held between lower and upper (the anti-windup of the NREL 5 MW
    controller); y[k] = k_p u[k] + integral[k], held likewise.
    """

    units_within = dict.fromkeys(("proportional_gain", "integral_gain"), "y/u") | dict.fromkeys(
        ("lower", "upper", "integral_start"), "y"
    )

    proportional_gain: Scalar = param(doc="k_p, output per input")
    integral_gain: Scalar = param(unit="1/s", doc="k_i, output per input and second")
    lower: Scalar = param(default=-UNLIMITED, doc="smallest output")
    upper: Scalar = param(default=UNLIMITED, doc="largest output")
    integral_start: Scalar = param(default=0.0, doc="integral part before the first sample")
    period: Number = param(unit="s", min=POSITIVE, doc="sampling period")
    offset: Number = param(default=0.0, unit="s", doc="time of the first sample")

    u: RealInput = port(doc="control error")
    y: RealOutput = port(doc="controller output, constant between samples")

    integral: Scalar = var(start=integral_start, discrete=True, doc="integral part")
    held: Scalar = var(discrete=True, doc="output of the last sample")

    def equations(self):
        def limited(value):
            return m.fmin(m.fmax(value, self.lower), self.upper)

        return [
            sampled(
                self.period,
                assign(self.integral, limited(self.integral + self.period * self.integral_gain * self.u)),
                assign(self.held, limited(self.proportional_gain * self.u + self.integral)),
                offset=self.offset,
            ),
            eq(self.y, self.held),
        ]


class DiscreteTransferFunction(Component):
    """y = numerator(z) / denominator(z) u every `period` seconds, held in between; starts from zero states."""

    in_own_units = {"": "its coefficients are numbers of its sampling period"}

    numerator: Array = param(structural=True, doc="coefficients, highest power of z first")
    denominator: Array = param(structural=True, doc="coefficients, highest power of z first")
    period: Number = param(unit="s", min=POSITIVE, doc="sampling period")
    offset: Number = param(default=0.0, unit="s", doc="time of the first sample")

    u: RealInput = port(doc="input")
    y: RealOutput = port(doc="output, constant between samples")

    x: Array = var(shape=lambda self: np.size(self.denominator) - 1, discrete=True, doc="state")
    held: Scalar = var(discrete=True, doc="output of the last sample")

    def equations(self):
        A, B, C, D = canonical_form(self.numerator, self.denominator)
        return [
            sampled(
                self.period,
                assign(self.held, m.dot(C, self.x) + D * self.u),
                assign(self.x, m.mtimes(A, self.x) + B * self.u),
                offset=self.offset,
            ),
            eq(self.y, self.held),
        ]
