"""What can happen to a mooring line: it is lost."""

from __future__ import annotations

from fowtlib.language import Component, OfferedEvent, Scalar, assign, event, facts, on, var
from fowtlib.language import math as m


class Losable(Component):
    """Partial: a line between two points that may be lost; then it pulls no more at either end.

    What is left of it weighs nothing.
    """

    loss: OfferedEvent = event(doc="the line breaks: its tension is gone at both ends")

    intact: Scalar = var(discrete=True, start=1.0, doc="1, and 0 when the line is lost")

    def facts(self) -> list[facts.Fact]:
        return [facts.Reading(name) for name in ("tension", "anchor_tension") if name in self.variables]


class LosableLine(Losable):
    """Partial: a line with unknowns of its own, which stay solved as they were at its loss, for where its ends were."""

    last_distance: Scalar = var(unit="m", discrete=True, start=0.0, doc="horizontal distance of its ends at its loss")
    last_rise: Scalar = var(unit="m", discrete=True, start=0.0, doc="vertical distance of its ends at its loss")

    def reach(self, distance, rise):
        """Horizontal and vertical distance of its ends: as they are, or as they were at its loss."""
        there = self.intact > 0.5
        return m.if_else(there, distance, self.last_distance), m.if_else(there, rise, self.last_rise)

    def when_lost(self, distance, rise):
        """What happens then."""
        return on(self.loss, assign(self.intact, 0), assign(self.last_distance, distance), assign(self.last_rise, rise))
