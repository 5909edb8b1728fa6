"""What a wind whose mean is that of data is in the mean, for the start of a run."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from fowtlib.components.environment.wind.base import Wind


def measured(wind: Wind) -> dict[str, Any]:
    """Steady wind of the mean at the first station, to 1 cm/s: fields of one speed and several seeds have one mean."""
    exponent = 0.0 if "shear_exponent" in wind.void else wind.parameter_value("shear_exponent")
    speed = wind.mean_at(0) / (wind.hubs[0, 1] / wind.reference_height) ** exponent
    return {"kind": "steady", "mean_speed": round(float(speed), 2)}
