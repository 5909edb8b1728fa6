"""A pump with a curve or with a flow that it is told."""

from __future__ import annotations

from typing import Any

from fowtlib.components.flooding import pump_curve
from fowtlib.components.flooding.pipe import TwoWaters
from fowtlib.components.flooding.throttle import signed_root, signed_square
from fowtlib.language import (
    Array,
    OfferedEvent,
    RealInput,
    Scalar,
    assert_,
    assign,
    eq,
    event,
    on,
    param,
    port,
    var,
    when,
)
from fowtlib.language import math as m
from fowtlib.language.errors import ParameterError

BACKFLOW = 1e-4  # of the greatest flow of the curve: what a check valve lets back under the fall of its lift
SMALL = 1e-6  # of that fall: below it the flow is linear in the head, and smooth at rest


class Pump(TwoWaters):
    """A pump from water_a to water_b, told by `command` from 0 to 1.

    mode "curve": command s is its speed over the rated one, and by the laws of affinity it lifts by s^2 H_0 - (H_0 -
    H_r) Q |Q| / Q_r^2, H_0 at shut-off and H_r at the rated flow Q_r; or as a `curve` of points says, between which the
    lift is linear in Q^2 (fowtlib.components.flooding.pump_curve). At rest it is a resistance, through which water
    runs back unless it has a check valve, which lets 1e-4 Q_r back under H_0 - H_r, in proportion to the head; of a
    curve Q_r and H_r are its last point. mode "flow": Q = s Q_r whatever the head. In line with a pipe that has inertia
    say `in_line`: the flow is given there, the head follows, and the check valve closes and opens by events.
    hydraulic_power = rho g Q lift goes into the water; shaft_power is that over the efficiency, and zero where water
    runs through by itself: no turbine. A failure stops it. J. F. Gulich, Centrifugal Pumps (2010), ch. 4.
    """

    units_within = {"curve": ("m^3/s", "m")}

    rated_flow: Scalar = param(default=None, unit="m^3/s", min=1e-12, doc="Q_r, flow at the rated point")
    rated_head: Scalar = param(default=0.0, unit="m", min=0, doc="H_r, lift at the rated point; of a curve")
    shutoff_head: Scalar = param(default=None, unit="m", min=0, doc="H_0, lift without flow; of a curve")
    curve: Array = param(
        default=None, doc="flows [m^3/s], from 0 on, and lifts [m] (n, 2) at the rated speed; for the three above"
    )
    mode: str = param(default="curve", choices=("curve", "flow"), doc="what the command gives: speed, or flow")
    check_valve: bool = param(default=True, doc="no water runs back through it; of a curve")
    in_line: bool = param(default=False, doc="a pipe with inertia is in line with it: flow is given, head follows")
    efficiency: Scalar = param(default=0.7, min=1e-3, max=1, doc="hydraulic power over power at the shaft")
    density: Scalar = param(default=None, unit="kg/m^3", min=0, doc="density of the water; without: World's")

    failure: OfferedEvent = event(doc="the pump stops, whatever its command")
    repair: OfferedEvent = event(doc="it heeds its command again")

    command: RealInput = port(default=1.0, doc="speed over the rated one, or flow over the rated one, 0 to 1")
    running: Scalar = var(discrete=True, start=1.0, doc="1, or 0 after a failure")
    closed: Scalar = var(discrete=True, doc="1 while the check valve of a pump in line is closed")
    lift: Scalar = var(unit="m", state="never", doc="head at water_b less that at water_a")
    hydraulic_power: Scalar = var(unit="W", state="never", doc="into the water")
    shaft_power: Scalar = var(unit="W", state="never", doc="taken by the pump")

    def build(self):
        if self.mode == "flow":
            unused = ("shutoff_head", "rated_head", "curve", "check_valve", "in_line")
            self.refuse_unused(*unused, because="its mode is flow")
        elif self.is_set("curve"):
            pump_curve.checked(self)
            self.refuse_unused("rated_flow", "rated_head", "shutoff_head", because="its curve is given")
            return
        if self.parameter_value("rated_flow") is None:
            raise ParameterError(f"{self.label}.rated_flow needs a value, or its curve.")
        if self.mode == "flow":
            return
        highest = self.parameter_value("shutoff_head")
        if highest is None or not highest > self.parameter_value("rated_head"):
            raise ParameterError(
                f"{self.label}.shutoff_head must be above its rated_head, from which its curve falls with the flow."
            )

    def curve_points(self) -> list[tuple[Any, Any]]:
        """Flows and lifts at the rated speed, from shut-off on."""
        if self.curve is None:
            return [(0.0, self.shutoff_head), (self.rated_flow, self.rated_head)]
        return [(self.curve[i, 0], self.curve[i, 1]) for i in range(pump_curve.checked(self))]

    def equations(self):
        speed = self.command * self.running
        rho = self.world.water_density if self.density is None else self.density
        told = self.mode == "flow"
        laws = [eq(self.volume_flow, speed * self.rated_flow)] if told else _along_the_curve(self, speed)
        valve = (1, -1) if self.in_line and self.check_valve else ()
        return [
            *self.through(),
            [eq(self.lift, -self.head_drop), *laws],
            eq(self.hydraulic_power, rho * self.world.gravity * self.volume_flow * self.lift),
            eq(self.shaft_power, m.fmax(self.hydraulic_power, 0) / self.efficiency),
            [when(self.volume_flow * sign < 0, assign(self.closed, (1 + sign) / 2)) for sign in valve],
            [on(self.failure, assign(self.running, 0)), on(self.repair, assign(self.running, 1))],
            assert_(m.fmin(self.command, 1 - self.command) > -1e-9, "its command is {command}, and must be 0 to 1",
                    command=self.command),
        ]  # fmt: skip


def _along_the_curve(pump: Pump, speed: Any) -> list[Any]:
    """Flow and lift of a pump with a curve."""
    points = pump.curve_points()
    (_, highest), (most, least) = points[0], points[-1]
    fall = highest - least
    if pump.in_line:
        flow = pump.volume_flow / most
        lift = pump_curve.lift_at(points, most**2 * signed_square(flow, SMALL), speed)
        if pump.check_valve:
            lift = m.if_else(pump.closed > 0.5, highest * speed**2 - fall * flow / BACKFLOW, lift)
        law = eq(pump.lift, lift)
    else:
        flow = signed_root(pump_curve.squared_flow(points, pump.lift, speed) / most**2, SMALL)
        short = highest * speed**2 - pump.lift
        flow = m.if_else(short < 0, BACKFLOW * short / fall, flow) if pump.check_valve else flow
        law = eq(pump.volume_flow, most * flow)
    if pump.curve is None:
        return [law]
    beyond = m.fmax(pump.volume_flow - most * speed, -2 * BACKFLOW * most - pump.volume_flow)
    return [law, assert_(beyond <= 1e-9 * most, _BEYOND, "warning", flow=pump.volume_flow, end=most * speed)]


_BEYOND = (
    "{flow} m3/s run through it, and its curve goes from 0 to {end} m3/s at its speed; beyond that it is continued by "
    "its last piece"
)
