"""What a wind is in the mean, for the start of a run."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from fowtlib.components.environment.wind.base import Wind


def steady(wind: Wind, measured: bool) -> dict[str, Any]:
    """Steady wind of the mean speed, and of the shear that the kind has by itself.

    measured: its mean is that of data, at the first station; to 1 cm/s, so that fields of one speed and several seeds
    have one mean.
    """
    exponent = 0.0 if "shear_exponent" in wind.void else float(wind.parameter_value("shear_exponent"))
    found: dict[str, Any] = {"kind": "steady"}
    if exponent and not wind.is_set("shear_exponent"):
        found["shear_exponent"] = exponent
    if measured:
        speed = wind.mean_at(0) / (wind.hubs[0, 1] / wind.reference_height) ** exponent
        found["mean_speed"] = round(float(speed), 2)
    return found
