"""The curve of a pump through points of flow and lift, by the laws of affinity at any speed.

Between two points the lift is linear in the square of the flow, H = a - b Q^2. At the speed s over the rated one it
is H = a s^2 - b Q^2: the laws of affinity, H / s^2 over Q / s, hold without a division by the speed, down to rest.
Two points are the parabola of a pump of which the lift at shut-off and at the rated flow are known. Beyond its points a
curve goes on as its last piece: a run warns of it.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from fowtlib.language import math as m
from fowtlib.language.errors import ParameterError


def checked(pump: Any) -> int:
    """How many points the curve of a pump has; ParameterError where it is none."""
    points = np.asarray(pump.parameter_value("curve"), dtype=float)
    if points.ndim != 2 or points.shape[1] != 2 or len(points) < 2:
        raise ParameterError(f"{pump.label}.curve needs two rows or more of flow [m^3/s] and lift [m].")
    flows, lifts = points.T
    if flows[0] != 0 or not np.all(np.diff(flows) > 0):
        raise ParameterError(
            f"{pump.label}.curve: its flows must begin with 0 and rise from row to row; they are {flows.tolist()}."
        )
    if not np.all(np.diff(lifts) < 0):
        raise ParameterError(
            f"{pump.label}.curve: its lifts must fall from row to row, so that there is one flow for each; they are "
            f"{lifts.tolist()}. Of a curve that rises at first leave out what is left of its highest point."
        )
    return len(points)


def squared_flow(points: list[tuple[Any, Any]], lift: Any, speed: Any) -> Any:
    """Q |Q| [m^6/s^2] at a lift [m]; points: flows and lifts at the rated speed, from shut-off on."""
    found, last = 0.0, len(points) - 2
    for i, ((q, h), (following, lower)) in enumerate(zip(points, points[1:], strict=False)):
        fallen = h * speed**2 - lift
        fallen = fallen if i == 0 else m.fmax(fallen, 0)
        fallen = fallen if i == last else m.fmin(fallen, (h - lower) * speed**2)
        found = found + fallen * (following**2 - q**2) / (h - lower)
    return found


def lift_at(points: list[tuple[Any, Any]], squared: Any, speed: Any) -> Any:
    """Lift [m] of the flow whose Q |Q| is `squared`: the inverse of squared_flow."""
    lift, last = points[0][1] * speed**2, len(points) - 2
    for i, ((q, h), (following, lower)) in enumerate(zip(points, points[1:], strict=False)):
        more = squared - (q * speed) ** 2
        more = more if i == 0 else m.fmax(more, 0)
        more = more if i == last else m.fmin(more, (following**2 - q**2) * speed**2)
        lift = lift - more * (h - lower) / (following**2 - q**2)
    return lift
