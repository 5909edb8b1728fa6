"""The air taken away from a rotor, from the start or at an instant."""

from __future__ import annotations

from fowtlib.language import Component, OfferedEvent, Scalar, assign, event, on, param, var


class AirLoads(Component):
    """Partial: a rotor whose loads from the air can be taken away by a word, to see what they do.

    Everything else stays: mass, spin, generator and control.
    """

    air_loads: Scalar = param(default=1.0, min=0, max=1, doc="share of the air's loads on the rotor; 0: none")

    air_off: OfferedEvent = event(doc="the air puts no loads on the rotor from now on")
    air_on: OfferedEvent = event(doc="the air puts all its loads on the rotor again")

    in_air: Scalar = var(discrete=True, start=air_loads, doc="share of the loads of the air")

    def switching(self):
        """What the events do."""
        return [on(self.air_off, assign(self.in_air, 0)), on(self.air_on, assign(self.in_air, 1))]
