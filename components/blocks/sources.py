"""Signals that depend on time only."""

from __future__ import annotations

import math

from fowtlib.language import (
    Array,
    Component,
    Number,
    OfferedEvent,
    RealOutput,
    Scalar,
    assign,
    eq,
    event,
    on,
    param,
    port,
    time_series,
    var,
    when,
)
from fowtlib.language import math as m


class Constant(Component):
    """y = value, a scalar or a vector."""

    units_within = {"value": "y"}

    value: Array = param(doc="constant value")

    y: RealOutput = port(shape=lambda self: self.shape_of(type(self).value), doc="output")

    def equations(self):
        return [eq(self.y, self.value)]


class Sine(Component):
    """y = offset + amplitude sin(2 pi frequency t + phase)."""

    units_within = {"amplitude": "y", "offset": "y"}

    amplitude: Scalar = param(default=1.0, doc="amplitude")
    frequency: Scalar = param(unit="Hz", min=0, doc="frequency")
    phase: Scalar = param(default=0.0, unit="rad", doc="phase at t = 0")
    offset: Scalar = param(default=0.0, doc="mean value")

    y: RealOutput = port(doc="output")

    def equations(self):
        angle = 2 * math.pi * self.frequency * self.time + self.phase
        return [eq(self.y, self.offset + self.amplitude * m.sin(angle))]


class Step(Component):
    """y = offset before start_time, offset + height after it; the jump is an event, where the integrator restarts."""

    units_within = {"height": "y", "offset": "y"}

    height: Scalar = param(default=1.0, doc="height of the step")
    start_time: Scalar = param(default=0.0, unit="s", doc="time of the step")
    offset: Scalar = param(default=0.0, doc="value before the step")

    trigger: OfferedEvent = event(doc="the step comes now, whatever start_time says")

    y: RealOutput = port(doc="output")

    raised: Scalar = var(discrete=True, start=1 - m.sign(m.fmax(start_time, 0.0)), doc="1 after the step, else 0")

    def equations(self):
        return [
            when(self.time > self.start_time, assign(self.raised, 1.0)),
            on(self.trigger, assign(self.raised, 1.0)),
            eq(self.y, self.offset + self.height * self.raised),
        ]


class Ramp(Component):
    """y rises from offset by height, linearly within `duration` from start_time on, and stays there."""

    units_within = {"height": "y", "offset": "y"}

    height: Scalar = param(default=1.0, doc="height of the ramp")
    duration: Scalar = param(unit="s", min=0, doc="time of the rise")
    start_time: Scalar = param(default=0.0, unit="s", doc="time at which the rise begins")
    offset: Scalar = param(default=0.0, doc="value before the ramp")

    y: RealOutput = port(doc="output")

    def equations(self):
        share = (self.time - self.start_time) / self.duration
        return [eq(self.y, self.offset + self.height * m.fmin(m.fmax(share, 0.0), 1.0))]


class TimeTable(Component):
    """Samples at equal steps of time, joined by a cubic spline with continuous second derivative.

    The run stops at the end of the table, unless it is periodic; the period is the number of samples times the step.
    """

    units_within = {"values": "y"}

    values: Array = param(structural=True, doc="samples")
    step: Number = param(unit="s", doc="time between samples")
    start_time: Number = param(default=0.0, unit="s", doc="time of the first sample")
    periodic: bool = param(default=False, doc="repeat the table for ever")

    y: RealOutput = port(doc="output")

    def equations(self):
        start, step = self.start_time, self.step
        value = time_series(self.time, start, step, self.values, periodic=self.periodic, name=self.path)
        return [eq(self.y, value)]
