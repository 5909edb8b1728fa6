"""A rotor of coefficients in the turbulence of its whole disk, by one wind for each of its loads."""

from __future__ import annotations

import numpy as np

from fowtlib.components.aero.coefficient_rotor import CoefficientRotor
from fowtlib.components.aero.load_slopes import LoadSlopes, read_load_slopes
from fowtlib.components.environment.wind import Wind
from fowtlib.components.environment.wind.discs import DISC_WINDS, DiscSignals
from fowtlib.language import (
    Data,
    RealOutput,
    Scalar,
    at_start,
    data,
    der,
    eq,
    param,
    port,
    run_time_series,
    var,
)
from fowtlib.language import math as m
from fowtlib.language.expressions import value_of
from fowtlib.language.run_time import TurningRings


class EffectiveWindRotor(CoefficientRotor):
    """Rotor of steady coefficients, in winds that stand for what its turning blades feel of the turbulence.

    A wind for the thrust, one for the torque, and one each for the tilt and the yaw moment: the fluctuation at the
    blade elements, weighted by the slope of the load there. Over the disk eddies smaller than it are averaged, and the
    turning puts part of them at multiples of the blade passing frequency (0P, 3P, ...). Thrust and torque are

        1/2 rho A C_t(w R / U_F) U_F^2,   1/2 rho A R C_q(w R / U_Q) U_Q^2,   U the mean wind + own fluctuation - hub,

    the moments across the shaft, on the hub, are linear in theirs and in the angular velocity of the hub,

        M = B/2 sum_i m_i (v_M - r_i omega),   m_i = dM_i/du of an element of a blade that is up, B blades.

    slopes: how the turbine operates in each mean wind, and the slopes of its elements there. The rotor speed is taken
    as constant in the spectra, as that of the mean wind, and so are m_i in a run. Turbulence of the wind's own spectrum
    and coherence, in time and frequency; in a field, what the blades meet on their way at that rotor speed. Not
    included: shear, tower shadow, yawed inflow, v and w, dynamic inflow, the sum of once-per-turn forces in the plane
    of the disk. Source: J.M. Hegseth, thesis NTNU 2020:356, section 3 and appendix B (there the damping of the tilt has
    m_i in place of m_i r_i); A. Halfpenny, PhD thesis (1998).
    """

    slopes: Data[LoadSlopes] = data(read_load_slopes, doc="CSV of load_slopes, over the winds of operation")
    filtered: bool = param(default=False, doc="tip speed ratio with the filtered wind")
    blades: int = param(default=3, min=3, doc="number of blades")

    tilt_moment: RealOutput = port(unit="N*m", doc="moment of the air about the lateral axis of the hub")
    yaw_moment: RealOutput = port(unit="N*m", doc="moment of the air about the axis across that and the shaft, up")
    effective: Scalar = var(unit="m/s", shape=(4,), doc="fluctuation for thrust, torque, tilt and yaw moment")

    def turning_disc(self) -> TurningRings:
        """The rings of the blades in the mean wind of a run, and their weights: of thrust and torque, of the moment."""
        return value_of(self, "turning disc", self._turning_disc)

    def _turning_disc(self) -> TurningRings:
        slopes, station = self.operation(), self.wind.hubs[self.station]
        thrust, torque, moment = (values[0] for values in (slopes.thrust, slopes.torque, slopes.moment))
        uniform = np.stack([thrust / thrust.sum(), torque / torque.sum()])
        speed, centre = self.rotation * float(slopes.rotor_speed[0]), np.array([0.0, *station])
        return TurningRings(centre, slopes.radius, speed, self.blades, uniform, moment[None] / moment.sum())

    def operation(self) -> LoadSlopes:
        """The slopes in the mean wind of a run."""
        return self.slopes.at(float(self.wind.mean_at(self.station)))

    def moment_slopes(self) -> np.ndarray:
        """By the effective wind [m^4/s] and by the angular velocity of the hub [m^5/s], over the air density."""
        if self.wind.kind == "none":
            return np.zeros(2)
        slopes = self.operation()
        return self.blades / 2 * np.array([slopes.moment[0].sum(), slopes.moment[0] @ slopes.radius])

    def wind_along(self, n):
        return self.along(n) * (self.mean_speed() + self.effective[0])

    def torque_wind(self):
        n = self.normal()
        return self.along(n) * (self.mean_speed() + self.effective[1]) - m.dot(n, der(self.frame.r))

    def along(self, n):
        """Share of the speed of the wind that is along the normal."""
        return n[0] * m.cos(self.wind.bearing) + n[1] * m.sin(self.wind.bearing)

    def mean_speed(self):
        """Speed [m/s] at the station without its turbulence."""
        doc = "shares of the base and of the fluctuation of the station, and speed beside them"
        mean, wind = at_start("disc mean", 3, "", doc, _mean_of_disc), self.wind
        return mean[0] * wind.base[self.station] + mean[1] * wind.fluctuation[self.station] + mean[2]

    def moment_of_air(self, n):
        lateral = self.frame.R[:, 1]
        return self.tilt_moment * lateral + self.yaw_moment * m.cross(n, lateral)

    def equations(self):
        slopes = at_start("moment slopes", 2, "", "of the moment by wind and by turning, over the air density",
                          lambda rotor: rotor.moment_slopes())  # fmt: skip
        by_wind, by_turning = (self.in_air * self.world.air_density * slopes[k] for k in range(2))
        lateral = self.frame.R[:, 1]
        tilting, yawing = m.dot(lateral, self.frame.w), m.dot(m.cross(self.normal(), lateral), self.frame.w)
        signals = run_time_series(self.time, len(DISC_WINDS), "effective winds", DiscSignals())
        return [
            super().equations(),
            eq(self.effective, signals),
            eq(self.tilt_moment, by_wind * self.effective[2] - by_turning * tilting),
            eq(self.yaw_moment, by_wind * self.effective[3] - by_turning * yawing),
        ]

    def coefficients_in(self, hub_velocity):
        """Tip speed ratio and coefficients, each in its own wind."""
        ratio, air, of_thrust = self.looked_up(self.mean_wind - hub_velocity)
        of_torque = of_thrust if self.filtered else self.looked_up(self.torque_wind())[2]
        return [
            self.wind_from_front(self.mean_wind - hub_velocity, ratio, air),
            eq(self.tip_speed_ratio, ratio),
            [eq(self.thrust_coefficient, air * of_thrust[0]), eq(self.torque_coefficient, air * of_torque[1])],
        ]


def _mean_of_disc(rotor: EffectiveWindRotor) -> np.ndarray:
    """A gust at the station is one of the disc; turbulence there is not, nor what a field has at that point."""
    wind: Wind = rotor.wind
    if hasattr(type(wind), "field_density"):
        return np.array([0.0, 0.0, wind.mean_at(rotor.station)])
    return np.array([1.0, 0.0 if wind.turbulent or wind.station_series() is None else 1.0, 0.0])
