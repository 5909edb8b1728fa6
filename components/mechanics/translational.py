"""One-dimensional translation: what stops, holds or rubs a slide, joined to its axis. Positions in m, forces in N.

A part here sits between a slide and its carrier: what it gives to the sliding side, its reaction takes from the other.
"""

from __future__ import annotations

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


class EndStop(Component):
    """A stop that a slide runs against: Hertzian stiffness with damping in proportion to it; it never pulls.

    force = F_ref (depth/depth_ref)^1.5 (1 + 1.5 alpha rate), zero where that is negative, with the depth of
    penetration and its rate. A slow impact at the speed v comes back with (1 - alpha v) v.
    Source: K.H. Hunt and F.R.E. Crossley, J. Appl. Mech. 42 (1975) 440-445, eqs. 11 and 20.
    """

    side: str = param(default="below", choices=("below", "above"), doc="where the stop is: under the slide or over it")
    place: Scalar = param(default=0.0, unit="m", doc="position of the slide at which it touches the stop")
    reference_force: Scalar = param(unit="N", min=0, doc="slow force at the reference depth; 0: no stop")
    reference_depth: Scalar = param(default="10 mm", unit="m", min=1e-6, doc="depth of penetration of that force")
    restitution_loss: Scalar = param(default=0.2, unit="s/m", min=0, doc="alpha: share of speed lost per impact speed")

    axis: TranslationalFlange = port(doc="axis of the slide")
    lost_power: RealOutput = port(unit="W", doc="power that the stop takes out")

    depth: Scalar = var(unit="m", state="never", doc="how far the slide is in the stop; negative: the way left")
    force: Scalar = var(unit="N", doc="force of the stop on the slide, away from the stop")
    energy: Scalar = var(unit="J", doc="elastic energy in the stop")
    impacts: Scalar = var(discrete=True, start=0.0, doc="how often the slide has come to the stop")
    impact_speed: Scalar = var(unit="m/s", discrete=True, start=0.0, doc="speed at the last time")

    def equations(self):
        away = 1 if self.side == "below" else -1
        rate = -away * der(self.axis.s)
        share = m.fmax(self.depth, 0.0) / self.reference_depth
        elastic = self.reference_force * share**1.5
        return [
            eq(self.depth, away * (self.place - self.axis.s)),
            eq(self.force, elastic * m.fmax(1 + 1.5 * self.restitution_loss * rate, 0.0)),
            eq(self.energy, elastic * m.fmax(self.depth, 0.0) / 2.5),
            eq(self.axis.f, -away * self.force),
            eq(self.lost_power, (self.force - elastic) * rate),
            when(self.depth > 0, assign(self.impacts, self.impacts + 1), assign(self.impact_speed, rate)),
        ]


class Latch(Component):
    """A latch that holds a slide where it caught it, by a stiff spring and damper; it catches at its place.

    Once told to `close`, it catches the slide at once if that is within `reach` of its place, else when it next comes
    there from below. `open` lets it go, and withdraws what `close` said.
    """

    place: Scalar = param(unit="m", doc="position of the slide at which the latch may catch it")
    reach: Scalar = param(default="50 mm", unit="m", min=1e-6, doc="how far from its place it still catches")
    stiffness: Scalar = param(unit="N/m", min=0, doc="stiffness of the closed latch")
    damping: Scalar = param(default=0.0, unit="N*s/m", min=0, doc="damping of the closed latch")
    closed_start: Scalar = param(default=0.0, min=0, max=1, doc="1: it is closed at the start, at its place")
    ready_start: Scalar = param(default=0.0, min=0, max=1, doc="1: it has been told to close at the start")

    close: OfferedEvent = event(doc="it closes, as soon as the slide is there")
    open: OfferedEvent = event(doc="it lets the slide go")

    axis: TranslationalFlange = port(doc="axis of the slide")
    lost_power: RealOutput = port(unit="W", doc="power that the damper of the latch takes out")
    shut: RealOutput = port(doc="1 when it holds the slide, else 0")

    ready: Scalar = var(discrete=True, start=ready_start, doc="1 when it has been told to close")
    closed: Scalar = var(discrete=True, start=closed_start, doc="1 when it holds the slide")
    held: Scalar = var(unit="m", discrete=True, start=place, doc="position at which it caught the slide")
    force: Scalar = var(unit="N", doc="force on the slide, towards +s")
    energy: Scalar = var(unit="J", doc="elastic energy in the latch")

    def equations(self):
        s, v = self.axis.s, der(self.axis.s)
        here = m.abs(s - self.place) < self.reach
        caught = m.if_else(here, 1.0, 0.0)
        waits = self.ready * (1 - self.closed)
        arrived = waits * ((s - self.place) / self.reach + 1) - (1 - waits)  # negative while nothing is waited for
        return [
            eq(self.force, -self.closed * (self.stiffness * (s - self.held) + self.damping * v)),
            eq(self.energy, self.closed * self.stiffness * (s - self.held) ** 2 / 2),
            eq(self.axis.f, -self.force),
            [eq(self.lost_power, self.closed * self.damping * v**2), eq(self.shut, self.closed)],
            when(arrived > 0, assign(self.closed, caught), assign(self.held, s)),
            on(self.close, assign(self.ready, 1), assign(self.closed, caught), assign(self.held, s)),
            on(self.open, assign(self.ready, 0), assign(self.closed, 0)),
        ]


class SlidingFriction(Component):
    """Dry and viscous friction of a slide: force = -(mu N tanh(v/v_0) + c v).

    N is the sum of the loads that press on it, and at least `preload`. Below the speed v_0 the dry part is smoothed: a
    slide that should stick creeps by a part of v_0.
    """

    coefficient: Scalar = param(default=0.0, min=0, doc="mu of dry friction")
    preload: Scalar = param(default=0.0, unit="N", min=0, doc="load with which it is pressed on always")
    viscous: Scalar = param(default=0.0, unit="N*s/m", min=0, doc="c")
    smooth_speed: Scalar = param(default="1 mm/s", unit="m/s", min=1e-9, doc="v_0")

    axis: TranslationalFlange = port(doc="axis of the slide")
    load: RealInput = port(unit="N", default=0.0, doc="load that presses on it, zero when unconnected")
    lost_power: RealOutput = port(unit="W", doc="power that it takes out")

    force: Scalar = var(unit="N", doc="force on the slide, towards +s")

    def equations(self):
        v = der(self.axis.s)
        dry = self.coefficient * (self.preload + self.load) * m.tanh(v / self.smooth_speed)
        return [
            eq(self.force, -dry - self.viscous * v),
            eq(self.axis.f, -self.force),
            eq(self.lost_power, -self.force * v),
        ]
