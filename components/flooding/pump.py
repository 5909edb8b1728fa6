"""A pump with a curve or with a flow that it is told."""

from __future__ import annotations

from fowtlib.components.flooding.pipe import TwoWaters
from fowtlib.components.flooding.throttle import signed_root
from fowtlib.language import OfferedEvent, RealInput, Scalar, assert_, assign, eq, event, on, param, port, var
from fowtlib.language import math as m
from fowtlib.language.errors import ParameterError

BACKFLOW = 1e-4  # of the flow that the same head drives forward: what a check valve lets back
SMALL = 1e-6  # of the head from shut-off to rated: below it the flow is linear, so that it is smooth at rest


class Pump(TwoWaters):
    """A pump from water_a to water_b, told by `command` from 0 to 1.

    mode "curve": command s is its speed over the rated one, and by the laws of affinity it lifts by s^2 H_0 - (H_0 -
    H_r) Q |Q| / Q_r^2, H_0 at shut-off and H_r at the rated flow Q_r. At rest it is a resistance, through which water
    runs back unless it has a check valve, which passes 1e-4 of that. mode "flow": Q = s Q_r whatever the head.
    hydraulic_power = rho g Q lift goes into the water; shaft_power is that over the efficiency, and zero where water
    runs through by itself: no turbine. A failure stops it. J. F. Gulich, Centrifugal Pumps (2010), ch. 4.
    """

    rated_flow: Scalar = param(unit="m^3/s", min=1e-12, doc="Q_r, flow at the rated point")
    rated_head: Scalar = param(default=0.0, unit="m", min=0, doc="H_r, lift at the rated point; of a curve")
    shutoff_head: Scalar = param(default=None, unit="m", min=0, doc="H_0, lift without flow; of a curve")
    mode: str = param(default="curve", choices=("curve", "flow"), doc="what the command gives: speed, or flow")
    check_valve: bool = param(default=True, doc="no water runs back through it; of a curve")
    efficiency: Scalar = param(default=0.7, min=1e-3, max=1, doc="hydraulic power over power at the shaft")
    density: Scalar = param(default=None, unit="kg/m^3", min=0, doc="density of the water; without: World's")

    failure: OfferedEvent = event(doc="the pump stops, whatever its command")
    repair: OfferedEvent = event(doc="it heeds its command again")

    command: RealInput = port(default=1.0, doc="speed over the rated one, or flow over the rated one, 0 to 1")
    running: Scalar = var(discrete=True, start=1.0, doc="1, or 0 after a failure")
    lift: Scalar = var(unit="m", state="never", doc="head at water_b less that at water_a")
    hydraulic_power: Scalar = var(unit="W", state="never", doc="into the water")
    shaft_power: Scalar = var(unit="W", state="never", doc="taken by the pump")

    def build(self):
        if self.mode == "flow":
            self.refuse_unused("shutoff_head", "rated_head", "check_valve", because="its mode is flow")
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
            flow = speed * self.rated_flow
        else:
            share = (self.shutoff_head * speed**2 - self.lift) / (self.shutoff_head - self.rated_head)
            passed = m.if_else(share > 0, 1, BACKFLOW) if self.check_valve else 1
            flow = self.rated_flow * passed * signed_root(share, SMALL)
        return [
            *self.through(),
            [eq(self.lift, -self.head_drop), eq(self.volume_flow, flow)],
            eq(self.hydraulic_power, rho * self.world.gravity * self.volume_flow * self.lift),
            eq(self.shaft_power, m.fmax(self.hydraulic_power, 0) / self.efficiency),
            [on(self.failure, assign(self.running, 0)), on(self.repair, assign(self.running, 1))],
            assert_(m.fmin(self.command, 1 - self.command) > -1e-9, "its command is {command}, and must be 0 to 1",
                    command=self.command),
        ]  # fmt: skip
