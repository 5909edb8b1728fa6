"""A rotor that is a thrust and nothing else: no speed, no torque, no controller."""

from __future__ import annotations

from fowtlib.components.aero import outlines
from fowtlib.components.aero.air_loads import AirLoads
from fowtlib.components.aero.rotor_side import RotorSide
from fowtlib.components.aero.thrust_curve import ThrustCurve, read_thrust_curve
from fowtlib.components.blocks import BandPass
from fowtlib.components.environment.wind import Wind
from fowtlib.components.environment.world import World
from fowtlib.components.mechanics.connectors import Frame
from fowtlib.language import (
    Data,
    Number,
    RealOutput,
    Scalar,
    at_start,
    data,
    der,
    eq,
    outer,
    param,
    port,
    table1d,
    var,
)
from fowtlib.language import math as m
from fowtlib.language.bounds import POSITIVE
from fowtlib.language.shapes import Drawing


class ThrustRotor(RotorSide, AirLoads):
    """Rotor with the thrust 1/2 rho A C_t(U) U^2 along its normal, U the wind less the velocity of the hub, along it.

    C_t comes from the curve of the turbine in steady operation, so that rotor and controller answer at once. Above
    rated wind speed the thrust then falls with the relative wind and drives the platform's pitch, which a controller
    made for a floating turbine does not: with notch_frequency, that of the pitch, a notch takes this frequency out of
    the velocity of the hub, fully at 1 m/s above notch_wind and not at all below it. Outside of the curve the run
    stops. In a Wind of kind "none" the rotor feels no air. The method of TDHMill (O. El Beshbichi, thesis, University
    of Stavanger, 2023, eq. 2.16 and 2.17).
    """

    curve: Data[ThrustCurve] = data(read_thrust_curve, doc="CSV with C_t over the wind speed, see read_thrust_curve")
    radius: Scalar = param(unit="m", min=POSITIVE, doc="tip radius along the blade")
    precone: Scalar = param(default=0.0, unit="rad", doc="cone angle: A = pi (radius cos(precone))^2")
    tilt: Scalar = param(default=0.0, unit="rad", doc="shaft tilt, positive when the end of the hub points up")
    station: int = param(default=0, min=0, doc="number of the wind's station at this hub")
    notch_frequency: Number = param(default=None, unit="Hz", min=1e-4, doc="centre of the notch; without it: no notch")
    notch_width: Scalar = param(default=0.5, min=1e-3, doc="damping ratio of the notch: half its width over its centre")
    notch_wind: Scalar = param(default=11.4, unit="m/s", min=0, doc="wind above which there is a notch")

    world: World = outer(World)
    wind: Wind = outer(Wind)
    frame: Frame = port(doc="hub; x along the horizontal projection of the shaft, downwind")
    thrust: RealOutput = port(unit="N", doc="thrust along the rotor normal, downwind")
    normal_wind: RealOutput = port(unit="m/s", doc="undisturbed wind at the hub along the rotor normal")
    velocity: RealOutput = port(unit="m/s", doc="velocity of the hub along the rotor normal")

    relative_wind: Scalar = var(unit="m/s", doc="wind less the velocity of the hub that counts, along the rotor normal")
    thrust_coefficient: Scalar = var(doc="C_t")

    def build(self):
        if self.notch_frequency is None:
            self.refuse_unused("notch_width", "notch_wind", because="there is no notch_frequency")
            return
        self.notch = BandPass(frequency=self.notch_frequency, damping_ratio=self.notch_width)
        self.connect(self.velocity, self.notch.u)

    def felt_disk(self) -> tuple[int, float]:
        """Station, and radius [m] about it within which the wind counts: that at the hub alone."""
        return self.station, 0.0

    def drawing(self) -> Drawing:
        angles = (self.side * self.parameter_value(name) for name in ("tilt", "precone"))
        return outlines.still_rotor(self.frame, self.parameter_value("radius"), *angles)

    def equations(self):
        n = self.frame.R @ m.vertcat(m.cos(self.tilt), 0, -self.side * m.sin(self.tilt))
        area = m.pi * (self.radius * m.cos(self.precone)) ** 2
        U = self.relative_wind
        return [
            self.switching(),
            eq(self.normal_wind, m.dot(n, self.wind.velocity(self.frame.r, self.station))),
            eq(self.velocity, m.dot(n, der(self.frame.r))),
            eq(U, self.normal_wind - self.velocity + self.taken_out()),
            eq(self.thrust_coefficient, self.in_air * self.coefficient(U)),
            eq(self.thrust, self.world.air_density / 2 * area * self.thrust_coefficient * U * m.abs(U)),
            [eq(self.frame.f, -self.thrust * n), eq(self.frame.t, m.zeros(3))],
        ]

    def taken_out(self):
        """Velocity of the hub that the thrust does not feel."""
        if self.notch_frequency is None:
            return 0
        above = m.fmin(m.fmax(self.normal_wind - self.notch_wind, 0), 1)
        return above**2 * (3 - 2 * above) * self.notch.y

    def coefficient(self, U):
        """C_t of the curve; 0 without any wind."""
        air = at_start("air", doc="0 without any wind, else 1", compute=lambda rotor: rotor.wind.kind != "none")
        curve = self.curve
        inside = air * U + (1 - air) * float(curve.wind_speed[0])
        name, argument = f"thrust curve of {self.path}", "relative wind [m/s]"
        grid = (curve.wind_speed, curve.thrust_coefficient)
        return air * table1d(inside, *grid, name=name, argument=argument, smoothness="c1")
