"""Water through pipes: friction, losses of fittings, and inertia."""

from __future__ import annotations

from typing import Any

from fowtlib.components.environment.world import World
from fowtlib.components.flooding.connectors import Water
from fowtlib.language import Component, Scalar, der, eq, outer, param, port, var
from fowtlib.language import math as m

STILL = 1.0  # Reynolds number below which the speed counts as this: the law stays laminar, and smooth at rest


class TwoWaters(Component):
    """Partial: a part between two waters that keeps its volume; what comes in at water_a leaves at water_b."""

    world: World = outer(World)
    water_a: Water = port(doc="where positive flow comes in")
    water_b: Water = port(doc="where it leaves")

    volume_flow: Scalar = var(unit="m^3/s", doc="from water_a to water_b")
    head_drop: Scalar = var(unit="m", state="never", doc="head at water_a less that at water_b")

    def through(self) -> list[Any]:
        """The equations that all of them have."""
        a, b = self.water_a, self.water_b
        return [
            [eq(a.volume_flow, self.volume_flow), eq(b.volume_flow, -self.volume_flow)],
            eq(self.head_drop, a.head - b.head),
        ]


class Pipe(TwoWaters):
    """A full round pipe: head_drop = (f L / D + K) v |v| / (2 g), and with `inertia` + L / (g A) dQ/dt.

    f: friction factor of Darcy for all flows, laminar (64 / Re) to rough, by S. W. Churchill, Chemical Engineering 84
    (1977), no. 24, 91-92. K: sum of the losses of inlet, bends and outlet (1), on the velocity head. The places of its
    ends do not matter, and what it holds is no water of the tanks: put its mass into a body.
    """

    length: Scalar = param(unit="m", min=0, doc="length")
    diameter: Scalar = param(unit="m", min=1e-6, doc="inner diameter")
    roughness: Scalar = param(default=5e-5, unit="m", min=0, doc="equivalent sand roughness of the wall")
    loss_factor: Scalar = param(default=1.5, min=0, doc="K, of inlet, bends and outlet together")
    viscosity: Scalar = param(default=1.19e-6, unit="m^2/s", min=1e-9, doc="kinematic; sea water of 15 deg C: 1.19e-6")
    inertia: bool = param(default=False, doc="the water in it takes time to speed up: its flow is a state")

    speed: Scalar = var(unit="m/s", state="never", doc="mean over the section")

    def equations(self):
        area, g = m.pi / 4 * self.diameter**2, self.world.gravity
        speed = m.smooth_abs(self.speed, STILL * self.viscosity / self.diameter)
        friction = friction_factor(speed * self.diameter / self.viscosity, self.roughness / self.diameter)
        lost = (friction * self.length / self.diameter + self.loss_factor) * self.speed * speed / (2 * g)
        slow = self.length / (g * area) * der(self.volume_flow) if self.inertia else 0.0
        return [*self.through(), eq(self.volume_flow, area * self.speed), eq(self.head_drop, lost + slow)]


def friction_factor(reynolds: Any, roughness: Any) -> Any:
    """Friction factor of Darcy; roughness: over the diameter. Churchill (1977): smooth over all flows."""
    a = (-2.457 * m.log((7 / reynolds) ** 0.9 + 0.27 * roughness)) ** 16
    return 8 * ((8 / reynolds) ** 12 + (a + (37530 / reynolds) ** 16) ** -1.5) ** (1 / 12)
