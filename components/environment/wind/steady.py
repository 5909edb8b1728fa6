"""Steady wind."""

from __future__ import annotations

from fowtlib.components.environment.wind.base import Wind
from fowtlib.language import Series


class SteadyWind(Wind, kind="steady"):
    """The mean speed, at all times."""

    def mean_series(self) -> Series | None:
        """The whole mean speed."""
        self.require_speed()
        return Series.constant([1.0, 0.0])
