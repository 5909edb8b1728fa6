"""Wind that changes from one speed to another."""

from __future__ import annotations

import numpy as np

from fowtlib.components.environment.wind.base import Wind
from fowtlib.language import Number, Series, param

SMOOTH = np.array([0.0, 0.0, 0.0, 10.0, -15.0, 6.0])
"""Coefficients of 10 s^3 - 15 s^4 + 6 s^5: from 0 to 1 for s in [0, 1], twice continuously differentiable."""


class StepWind(Wind, kind="step"):
    """The mean speed goes smoothly to `step_speed` within `step_duration` from `start_time` on."""

    start_time: Number = param(default=0.0, unit="s", min=0, bound=True, doc="start of the step")
    step_speed: Number = param(default=0.0, unit="m/s", min=0, bound=True, doc="speed afterwards, at reference_height")
    step_duration: Number = param(default=1.0, unit="s", min=1e-3, bound=True, doc="time of the change")

    def mean_series(self) -> Series | None:
        """The share of the mean speed falls to nothing, and the other speed rises."""
        self.require_speed()
        change = np.outer(SMOOTH, [-1.0, self.step_speed])
        change[0] += [1.0, 0.0]
        after = [0.0, self.step_speed]
        return Series.transition(self.start_time, self.step_duration, [1.0, 0.0], after, polynomial=change)
