"""A pump with a curve or with a flow that it is told."""

from __future__ import annotations

from fowtlib.components.flooding.pipe import TwoWaters
from fowtlib.components.flooding.throttle import signed_root, signed_square
from fowtlib.language import OfferedEvent, RealInput, Scalar, assert_, assign, eq, event, on, param, port, var, when
from fowtlib.language import math as m
from fowtlib.language.errors import ParameterError

BACKFLOW = 1e-4  # of the rated flow: what a check valve lets back under the head from shut-off to rated
SMALL = 1e-6  # of the head between shut-off and rated: below it the flow is linear in the head, and smooth at rest


class Pump(TwoWaters):
    """A pump from water_a to water_b, told by `command` from 0 to 1.

    mode "curve": command s is its speed over the rated one, and by the laws of affinity it lifts by s^2 H_0 - (H_0 -
    H_r) Q |Q| / Q_r^2, H_0 at shut-off and H_r at the rated flow Q_r. At rest it is a resistance, through which water
    runs back unless it has a check valve, which lets 1e-4 Q_r back under H_0 - H_r, in proportion to the head. mode
    "flow": Q = s Q_r whatever the head. In line with a pipe that has inertia say `in_line`: the flow is given there,
    the head follows, and the check valve closes and opens by events. hydraulic_power = rho g Q lift goes into the
    water; shaft_power is that over the efficiency, and zero where water runs through by itself: no turbine. A failure
    stops it. J. F. Gulich, Centrifugal Pumps (2010), ch. 4.
    """

    rated_flow: Scalar = param(unit="m^3/s", min=1e-12, doc="Q_r, flow at the rated point")
    rated_head: Scalar = param(default=0.0, unit="m", min=0, doc="H_r, lift at the rated point; of a curve")
    shutoff_head: Scalar = param(default=None, unit="m", min=0, doc="H_0, lift without flow; of a curve")
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
            self.refuse_unused("shutoff_head", "rated_head", "check_valve", "in_line", because="its mode is flow")
            return
        highest = self.parameter_value("shutoff_head")
        if highest is None or not highest > self.parameter_value("rated_head"):
            raise ParameterError(
                f"{self.label}.shutoff_head must be above its rated_head, from which its curve falls with the flow."
            )

    def equations(self):
        speed = self.command * self.running
        rho = self.world.water_density if self.density is None else self.density
        if self.mode == "flow":
            law = eq(self.volume_flow, speed * self.rated_flow)
        elif self.in_line:
            flow = self.volume_flow / self.rated_flow
            share = signed_square(flow, SMALL)
            share = m.if_else(self.closed > 0.5, flow / BACKFLOW, share) if self.check_valve else share
            law = eq(self.lift, self.shutoff_head * speed**2 - (self.shutoff_head - self.rated_head) * share)
        else:
            share = (self.shutoff_head * speed**2 - self.lift) / (self.shutoff_head - self.rated_head)
            flow = signed_root(share, SMALL)
            flow = m.if_else(share < 0, BACKFLOW * share, flow) if self.check_valve else flow
            law = eq(self.volume_flow, self.rated_flow * flow)
        valve = (1, -1) if self.in_line and self.check_valve else ()
        return [
            *self.through(),
            [eq(self.lift, -self.head_drop), law],
            eq(self.hydraulic_power, rho * self.world.gravity * self.volume_flow * self.lift),
            eq(self.shaft_power, m.fmax(self.hydraulic_power, 0) / self.efficiency),
            [when(self.volume_flow * sign < 0, assign(self.closed, (1 + sign) / 2)) for sign in valve],
            [on(self.failure, assign(self.running, 0)), on(self.repair, assign(self.running, 1))],
            assert_(m.fmin(self.command, 1 - self.command) > -1e-9, "its command is {command}, and must be 0 to 1",
                    command=self.command),
        ]  # fmt: skip
