"""Steady operation of a turbine in steady wind: where the rotor and its controller balance. NumPy."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from fowtlib.components.aero.coefficient_table import CoefficientTable
from fowtlib.components.servo.torque_law import region_3_torque, torque_of
from fowtlib.language.errors import ModelError


@dataclass(frozen=True)
class OperatingPoint:
    """SI units; thrust along the rotor normal; aero_power is that of the rotor before losses."""

    wind_speed: float
    rotor_speed: float
    blade_pitch: float
    tip_speed_ratio: float
    thrust: float
    torque: float
    aero_power: float
    generator_torque: float


STANDSTILL = OperatingPoint(*[0.0] * 8)


@dataclass(frozen=True)
class SteadyTurbine:
    """What steady operation depends on: the rotor (table, radius along the blade, cone), the gear and the controller.

    law: the torque law, with the attributes of TorqueLaw; tilt: angle of the shaft to the wind [rad].
    """

    table: CoefficientTable
    radius: float
    law: Any
    gear_ratio: float
    precone: float = 0.0
    tilt: float = 0.0
    least_pitch: float = 0.0
    air_density: float = 1.225

    def loads(self, wind_speed: float, rotor_speed: Any, blade_pitch: Any) -> tuple[Any, Any]:
        """Thrust [N] and torque [N m] of the rotor at rest in this wind, at one speed and pitch or at many."""
        wind, R = wind_speed * np.cos(self.tilt), self.radius * np.cos(self.precone)
        C_t, C_q = self.table(rotor_speed * self.radius / wind, blade_pitch)
        pressure = self.air_density / 2 * np.pi * R**2 * wind**2
        return pressure * C_t, pressure * R * C_q

    def operating_point(self, wind_speed: float) -> OperatingPoint:
        """Speed and pitch of steady operation: generator torque below rated speed, pitch above.

        Raises ModelError where the wind is too weak or too strong for the controller and the table.
        """
        rated, wind = self.law.rated_speed / self.gear_ratio, wind_speed * np.cos(self.tilt)
        if wind_speed <= 0:
            raise self._outside(wind_speed)
        slowest, fastest = (tip * wind / self.radius for tip in self.table.tip_speed_ratio[[0, -1]])

        def surplus(rotor_speed: Any) -> Any:
            braking = self.gear_ratio * torque_of(self.gear_ratio * rotor_speed, self.law)
            return self.loads(wind_speed, rotor_speed, self.least_pitch)[1] - braking

        wanted = self.gear_ratio * float(region_3_torque(self.law.rated_speed, self.law))
        if slowest <= rated <= fastest and self.loads(wind_speed, rated, self.least_pitch)[1] > wanted:
            pitches = np.linspace(self.least_pitch, self.table.blade_pitch[-1], 200)
            pitch = _first_root(lambda beta: self.loads(wind_speed, rated, beta)[1] - wanted, pitches)
            if pitch is None:
                raise self._outside(wind_speed)
            return self._point(wind_speed, rated, pitch, wanted)
        if min(rated, fastest) < slowest:
            raise self._outside(wind_speed)
        speeds = np.linspace(min(rated, fastest), max(slowest, 1e-3), 400)
        speed = _first_root(lambda w: -surplus(w), speeds)
        if speed is None:
            raise self._outside(wind_speed)
        return self._point(wind_speed, speed, self.least_pitch, self.loads(wind_speed, speed, self.least_pitch)[1])

    def _point(self, wind: float, speed: float, pitch: float, torque: float) -> OperatingPoint:
        tip, thrust = speed * self.radius / (wind * np.cos(self.tilt)), self.loads(wind, speed, pitch)[0]
        found = wind, speed, pitch, tip, thrust, torque, torque * speed, torque / self.gear_ratio
        return OperatingPoint(*(float(value) for value in found))

    def _outside(self, wind: float) -> ModelError:
        tips = self.table.tip_speed_ratio
        return ModelError(
            f"there is no steady operation at {wind:g} m/s within the table of the rotor, tip speed ratios {tips[0]:g} "
            f"to {tips[-1]:g} and pitch to {np.degrees(self.table.blade_pitch[-1]):g} deg; to start elsewhere, give "
            f"rotor_speed_start and blade_pitch_start."
        )


def _first_root(function: Callable[[Any], Any], grid: np.ndarray) -> float | None:
    """The first root along a grid where a function, of one point or of many, turns from positive to negative."""
    from scipy.optimize import brentq

    values = function(grid)
    turns = (values[:-1] >= 0) & (values[1:] < 0)
    turns[0] |= values[0] == 0
    if not turns.any():
        return None
    first = int(np.argmax(turns))
    return float(brentq(function, grid[first], grid[first + 1], xtol=1e-12))
