"""What tells the pumps of a floating piston to raise or to lower it."""

from __future__ import annotations

from fowtlib.components.flooding.connectors import Water
from fowtlib.components.mechanics.connectors import TranslationalFlange
from fowtlib.language import (
    Component,
    OfferedEvent,
    RealInput,
    RealOutput,
    Scalar,
    assign,
    der,
    eq,
    event,
    on,
    param,
    port,
    var,
    when,
)
from fowtlib.language import math as m


class LiftingCommand(Component):
    """Commands, 0 to 1, of the two pumps of a shaft: up (into the shaft) and down (out of it).

    `lift` raises until the piston is at `top`, or held there, and more slowly on the last way, where the command falls
    to `slowest`. `lower` fills the shaft while the piston is held, until it is let go, and then drains. `drain` pumps
    the shaft out until the water in it stands `least_head` above its floor. `hold` stops both. The pumps follow with
    the lag `time_constant`.
    """

    top: Scalar = param(unit="m", doc="position of the piston at which raising ends")
    slow_way: Scalar = param(default="1 m", unit="m", min=1e-3, doc="last way to the top, on which it slows down")
    slowest: Scalar = param(default=0.1, min=1e-3, max=1, doc="command at the top")
    least_head: Scalar = param(default="1 m", unit="m", min=0, doc="water above the floor at which draining ends")
    floor: Scalar = param(unit="m", doc="height of the floor of the shaft above the still water level, at rest")
    time_constant: Scalar = param(default="5 s", unit="s", min=1e-3, doc="lag of the pumps")
    direction_start: Scalar = param(default=0.0, min=-1, max=1, doc="1 raises, -1 drains, 0 holds at the start")

    lift: OfferedEvent = event(doc="the shaft is filled until the piston is at the top")
    lower: OfferedEvent = event(doc="the shaft is filled until the piston is let go, and then pumped out")
    drain: OfferedEvent = event(doc="the shaft is pumped out")
    hold: OfferedEvent = event(doc="the pumps stop")

    axis: TranslationalFlange = port(doc="axis of the slide of the piston")
    water: Water = port(doc="an opening in the floor of the shaft, whose head is measured")
    held: RealInput = port(default=0.0, doc="1 when the piston is held at the top, else 0")
    up: RealOutput = port(doc="command of the pump into the shaft")
    down: RealOutput = port(doc="command of the pump out of the shaft")

    direction: Scalar = var(discrete=True, start=direction_start, doc="1 raises, -1 drains, 0 holds")
    filling: Scalar = var(discrete=True, start=0.0, doc="1: it is filled until the piston is let go")
    command: Scalar = var(start=0.0, state="prefer", doc="up, or down where it is negative")

    def equations(self):
        rising, draining = m.fmax(self.direction, 0), m.fmax(-self.direction, 0)
        way = (self.top - self.axis.s) / self.slow_way
        left = (self.water.head - self.floor - self.least_head) / self.slow_way
        slow = m.fmax(m.fmin(way, 1), m.fmax(self.slowest, self.filling))
        arrived = m.fmax(m.fmin(way, 0.5 - self.held), self.filling)
        return [
            eq(self.time_constant * der(self.command), rising * slow - draining - self.command),
            [eq(self.up, m.fmax(self.command, 0)), eq(self.down, m.fmax(-self.command, 0))],
            [eq(self.axis.f, 0), eq(self.water.volume_flow, 0)],
            on(self.lift, assign(self.direction, 1), assign(self.filling, 0)),
            on(self.lower, assign(self.direction, 1), assign(self.filling, 1)),
            on(self.drain, assign(self.direction, -1), assign(self.filling, 0)),
            on(self.hold, assign(self.direction, 0)),
            when(self.filling * (1.5 - self.held) > 1, assign(self.direction, -1), assign(self.filling, 0)),
            when(rising * arrived + (1 - rising) < 0, assign(self.direction, 0)),
            when(draining * left + (1 - draining) < 0, assign(self.direction, 0)),
        ]
