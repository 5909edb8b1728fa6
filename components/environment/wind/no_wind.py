"""No wind."""

from __future__ import annotations

from typing import Any

from fowtlib.components.environment.wind.base import Wind


class NoWind(Wind, kind="none"):
    """No wind; rotors with coefficients feel no air at all."""

    void = ("mean_speed",)

    def in_the_mean(self) -> dict[str, Any]:
        """Nothing: it is the same at all times."""
        return {}

    def drawing(self):
        return []

    def mean_at(self, station: int = 0) -> float:
        """0."""
        return 0.0
