"""What can be opened and shut: valves of water, vents of air."""

from __future__ import annotations

from typing import Any

from fowtlib.components.environment.world import World
from fowtlib.components.flooding.connectors import Air
from fowtlib.components.flooding.pipe import TwoWaters
from fowtlib.language import (
    Component,
    OfferedEvent,
    RealInput,
    Scalar,
    assert_,
    assign,
    eq,
    event,
    on,
    outer,
    param,
    port,
    var,
)
from fowtlib.language import math as m

SMALL_HEAD = 1e-4  # m, over which the flow through a hole is linear in the head, so that it is smooth at rest
SMALL_PRESSURE = 1.0  # Pa, of air


class Throttle(Component):
    """Partial: an area that a signal opens, 0 to 1, and that the events `turn` and `shut` of a run set to a share."""

    area: Scalar = param(unit="m^2", min=0, doc="area when open")
    discharge_coefficient: Scalar = param(default=0.61, min=0, max=1, doc="C_d; 0.61 of a sharp edge")
    opening_start: Scalar = param(default=1.0, min=0, max=1, doc="share that is open at the start, times the signal")

    turn: OfferedEvent = event(
        doc="it is turned to a share of the signal", to=param(default=1.0, min=0, max=1, doc="share that is open")
    )
    shut: OfferedEvent = event(doc="it is shut")

    opening: RealInput = port(default=1.0, doc="share that is open, 0 to 1")
    turned: Scalar = var(discrete=True, start=opening_start, doc="share to which it is turned")

    def open_area(self) -> tuple[Any, list[Any]]:
        """C_d times the area that is open now [m^2], and what belongs to it."""
        return self.discharge_coefficient * self.area * self.opening * self.turned, [
            on(self.turn, assign(self.turned, self.turn.to)),
            on(self.shut, assign(self.turned, 0)),
            assert_(m.fmin(self.opening, 1 - self.opening) > -1e-9, "its opening is {opening}, and must be 0 to 1",
                    opening=self.opening),
        ]  # fmt: skip


class Valve(TwoWaters, Throttle):
    """A valve or an orifice: volume_flow = C_d A sqrt(2 g head_drop), both ways; it can be shut."""

    def equations(self):
        area, more = self.open_area()
        flow = area * m.sqrt(2 * self.world.gravity) * signed_root(self.head_drop, SMALL_HEAD)
        return [*self.through(), eq(self.volume_flow, flow), *more]


class Vent(Throttle):
    """A pipe from the air of a sealed tank to the open air: mass flow C_d A sqrt(2 rho dp), both ways; it can be shut.

    rho: density of the open air. Air that does not change its density much on the way: the run warns above a pressure
    of `greatest_pressure`, a tenth of the atmosphere.
    """

    greatest_pressure: Scalar = param(
        default=1e4, unit="Pa", min=0, doc="pressure in the tank up to which the law holds"
    )

    world: World = outer(World)
    air: Air = port(doc="the sealed tank")

    def equations(self):
        area, more = self.open_area()
        flow = area * m.sqrt(2 * self.world.air_density) * signed_root(self.air.pressure, SMALL_PRESSURE)
        told = "air of {pressure} Pa passes, more than greatest_pressure, above which it is compressible"
        size = m.if_else(area > 0, m.abs(self.air.pressure), 0)
        return [
            eq(self.air.mass_flow, flow),
            *more,
            assert_(size <= self.greatest_pressure, told, "warning", pressure=self.air.pressure),
        ]


def signed_root(x: Any, small: Any) -> Any:
    """Root of |x| with the sign of x; linear below `small`, and smooth."""
    return x / (x**2 + small**2) ** 0.25
