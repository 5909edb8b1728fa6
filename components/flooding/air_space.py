"""Trapped air over the water of a sealed tank: p = p_atm (density / density at atmosphere)^n."""

from __future__ import annotations

from typing import Any

from fowtlib.components.flooding.connectors import Air
from fowtlib.language import Scalar, assert_, der, eq, port, var

PARAMETERS = ("air_volume", "atmospheric_pressure", "air_mass_start", "polytropic_exponent")  # of a sealed tank


def declare(tank: Any) -> None:
    """The mass of the air as a state, and a port for a vent; nothing joined to it: no air comes or goes."""
    tank.declare("air_mass", Scalar, var(unit="kg", state="always", start=_start, doc="mass of the trapped air"))
    tank.declare("air", Air, port(optional=True, doc="pipe to the air of the tank"))


def laws(tank: Any) -> list[Any]:
    """Mass balance and pressure of the air."""
    room, rho, outside = space(tank, tank.volume), tank.world.air_density, tank.atmospheric_pressure
    return [
        eq(der(tank.air_mass), tank.air.mass_flow),
        eq(tank.air_pressure, outside * (tank.air_mass / (rho * room)) ** tank.polytropic_exponent - outside),
        eq(tank.air.pressure, tank.air_pressure),
        assert_(tank.air_mass > 0, "its trapped air is used up: {mass} kg are left; close the vent before",
                mass=tank.air_mass),
    ]  # fmt: skip


def space(tank: Any, volume: Any) -> Any:
    """Volume of the air [m^3] over a volume of water."""
    return tank.vessel().capacity + tank.air_volume - volume


def _start(tank: Any) -> Any:
    if tank.is_set("air_mass_start"):
        return tank.air_mass_start
    return tank.world.air_density * space(tank, tank.volume_start)
