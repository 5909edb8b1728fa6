"""Wind that turns slowly from one direction to another."""

from __future__ import annotations

import numpy as np

from fowtlib.components.environment.wind.steady import SteadyWind
from fowtlib.components.environment.wind.step import SMOOTH
from fowtlib.language import Number, Series, param


class VeeringWind(SteadyWind, kind="veer"):
    """The mean speed, whose direction turns smoothly by `turn` within `turn_duration` from `start_time` on.

    As 10 s^3 - 15 s^4 + 6 s^5; the fastest turn is 1.875 of the mean one. For weather over minutes; the IEC's extreme
    direction change is the kind "edc".
    """

    start_time: Number = param(default=0.0, unit="s", min=0, bound=True, doc="when the turn begins")
    turn: Number = param(default=0.0, unit="rad", bound=True, doc="from x towards y, added to direction")
    turn_duration: Number = param(default=300.0, unit="s", min=1e-3, bound=True, doc="time of the turn")

    def shape_series(self) -> Series | None:
        """The turn."""
        after = np.array([self.turn, 0.0, 0.0])
        change = np.outer(SMOOTH, after)
        return Series.transition(self.start_time, self.turn_duration, np.zeros(3), after, polynomial=change)
