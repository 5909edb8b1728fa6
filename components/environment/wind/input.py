"""Wind from outside of the model."""

from __future__ import annotations

from typing import Any

from fowtlib.components.environment.wind.base import Wind
from fowtlib.language import Number, open_input, param


class InputWind(Wind, kind="input"):
    """The speed at each station is an input of the model; where nobody gives it, it is that of steady wind.

    Its equations differ from those of the other kinds, so that it is chosen before a model is compiled; the values of
    its inputs where nobody gives any belong to them.
    """

    mean_speed: Number = param(default=0.0, unit="m/s", min=0, doc="speed at reference_height where nobody gives one")
    shear_exponent: Number = param(default=0.0, doc="exponent of the power law")
    reference_height: Number = param(default=90.0, unit="m", min=0, doc="height of mean_speed: the hub")

    def speeds(self) -> tuple[Any, Any]:
        """The inputs, and no fluctuation."""
        mean, exponent = (float(self.parameter_value(name)) for name in ("mean_speed", "shear_exponent"))
        speeds = mean * (self.hubs[:, 1] / self.reference_height) ** exponent
        return open_input("speed_input", len(speeds), "m/s", "wind speed at each station", speeds), 0
