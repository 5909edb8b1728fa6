"""The wind at points as equations: over a station or in a field, with what a run that leaves the field is told."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import casadi as ca

from fowtlib.components.environment.field_wind import wind_function
from fowtlib.language import math as m
from fowtlib.language.declarations import join
from fowtlib.language.equations import active
from fowtlib.language.errors import StructureError


@dataclass(frozen=True)
class Flow:
    """The wind about one station, as symbols or numbers; see `wind_function` for what they mean.

    path: of the wind, for messages. time [s]; base, fluctuation [m/s]; shear_exponent; direction [rad], in which it
    blows now; gradient (2,) [1/s], up and across; side and height [m]: the place (y, z) of the station.
    """

    path: str
    time: Any
    base: Any = 0
    fluctuation: Any = 0
    shear_exponent: Any = 0
    direction: Any = 0
    gradient: Any = (0, 0)
    side: float = 0.0
    height: float = 1.0

    def velocities(self, r: ca.SX, field: ca.SX, reach: str = "tower") -> ca.SX:
        """Velocities (3, n) at positions (3, n); in a field along axes that are turned by the direction.

        field: its numbers, see `FieldData`. A run in which one of the points leaves it, as far down as `reach` says,
        stops there.
        """
        n = r.shape[1]
        handle, y_low, y_high, z_low, z_high, first, last, shift, per_speed, lowest = ca.vertsplit(field)
        fall = 1.0
        if reach == "ground":
            fall = m.if_else(lowest > 0, m.fmax(m.fmin(r[2, :] / m.fmax(lowest, 1e-3), 1), 0), 1)
            r = m.vertcat(r[:2, :], m.fmax(r[2, :], lowest))
        inside = m.rotation_z(self.direction).T @ r
        places = (
            ("y", inside[1, :], y_low, y_high),
            ("z", inside[2, :], z_low if reach == "plane" else lowest, z_high),
            ("time", self.time + (shift - inside[0, :]) * per_speed, first, last),
        )
        for axis, place, low, high in places:
            active().check_range(place.T, low, high, "", axis, _outside(self.path, axis, n))
        result = wind_function(n)(
            field=handle, time=self.time, base=self.base, fluctuation=self.fluctuation,
            shear_exponent=self.shear_exponent, direction=self.direction, up=self.gradient[0], across=self.gradient[1],
            height=self.height, side=self.side, positions=r,
        )["velocities"]  # fmt: skip
        velocities = m.horzcat(*[result[3 * i : 3 * i + 3] for i in range(n)])
        return velocities * ca.repmat(fall, 3, 1) if reach == "ground" else velocities


def positions(r: Any) -> ca.SX:
    """Positions (3, n) of points, which may be numbers; StructureError for another shape."""
    points = ca.densify(ca.SX(r))
    if points.shape[0] != 3:
        shape = f"{points.shape[0]} x {points.shape[1]}"
        raise StructureError(f"the wind is wanted at positions {shape}; give them as 3 x n.")
    return points


def _outside(path: str, axis: str, points: int) -> str:
    """What is said of a run that leaves the field."""
    who = "the point" if points == 1 else "point {number} of %d" % points  # noqa: UP031 braces for later
    file = "{%s}" % join(path, "file")  # noqa: UP031
    if axis == "time":
        return (
            f"{who} needs the wind of time {{value}} s of the field {file}, which covers {{low}} to {{high}} s; use a "
            "longer field, a periodic one, or another field_shift."
        )
    return (
        f"{who} is at {axis} = {{value}} m, and the wind field {file} covers {{low}} to {{high}} m; use a field that "
        "is larger than all rotors with their motion."
    )
