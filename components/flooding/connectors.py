"""The connectors of water inside: `Water` for pipes and tanks, `Air` for what is above the water in a closed tank."""

from __future__ import annotations

from fowtlib.language import Connector, flow, potential


class Water(Connector):
    """An opening through which water passes, full of water: total head and volume flow.

    head = z + (p - p_atm) / (rho g) [m], z and the pressure p of the same point, over the still water level and over
    the air. In water at rest it is the same everywhere, whatever the place of the opening and however the body lies
    that carries it: a pipe between two tanks on two moving bodies needs no place of its ends, only their heads. The
    head of a tank is its free surface, that of the calm sea is zero. The velocity head at an opening is left out: what
    a jet loses is in the loss factors of pipes and orifices. Volume flow is positive into the component. Both sides of
    a connection carry water of one density.
    """

    head = potential(unit="m", doc="height over the still water level plus pressure above the air over rho g")
    volume_flow = flow(unit="m^3/s", doc="water into the component")


class Air(Connector):
    """An opening to the air of a closed tank: its pressure, and mass flow, positive into the component."""

    pressure = potential(unit="Pa", doc="pressure above the atmosphere")
    mass_flow = flow(unit="kg/s", doc="air into the component")
