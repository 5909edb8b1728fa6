"""A rotor described by steady thrust and torque coefficients."""

from __future__ import annotations

import numpy as np

from fowtlib.components.aero import outlines
from fowtlib.components.aero.coefficient_table import REMEDY, CoefficientTable, read_coefficients
from fowtlib.components.aero.rotor import Rotor
from fowtlib.components.blocks import ButterworthLowPass
from fowtlib.components.environment.wind import Wind
from fowtlib.components.environment.world import World
from fowtlib.components.mechanics.attitude import heading_at_start
from fowtlib.language import (
    Data,
    RealOutput,
    Scalar,
    assert_,
    at_start,
    data,
    der,
    eq,
    outer,
    param,
    port,
    table2d,
    var,
)
from fowtlib.language import math as m
from fowtlib.language.bounds import POSITIVE
from fowtlib.language.shapes import Drawing

BEHIND = (
    "the mean wind is from behind the rotor, and its coefficients hold for wind from the front; turn the turbine into "
    "the wind, or take a rotor of blade elements. Where its floater has turned, in yaw or over, look at what holds it: "
    "`fowt sheet` shows its stiffness."
)
ACROSS = (
    "the wind blows across the rotor: {along} m/s of it go along the shaft, too little for the tip speed ratio of "
    "{ratio}, which no table covers; turn the turbine or the wind, so that it comes from the front, or take a rotor of "
    "blade elements. Where its floater has turned, in yaw or over, look at what holds it: `fowt sheet` shows its "
    "stiffness."
)


class HubWind(Rotor):
    """Partial: a rotor in the wind of its hub, along its normal, and its low-pass filtered mean."""

    station: int = param(default=0, min=0, doc="number of the wind's station at this hub")
    filtered: bool = param(default=True, doc="tip speed ratio with the filtered wind")
    filter_order: int = param(default=2, min=1, doc="order of the Butterworth filter")
    cutoff_frequency: Scalar = param(default=0.0033, unit="Hz", min=0, doc="-3 dB frequency of the filter")
    wind_start: Scalar = param(
        default=lambda self: self.mean_along_shaft(),
        unit="m/s", doc="filtered wind at the start; its default takes the frame as turned along x",
    )  # fmt: skip

    wind: Wind = outer(Wind)
    normal_wind: RealOutput = port(unit="m/s", doc="undisturbed wind at the hub along the rotor normal")
    mean_wind: RealOutput = port(unit="m/s", doc="normal_wind, filtered: the wind of the tip speed ratio")

    relative_wind: Scalar = var(unit="m/s", doc="wind less the velocity of the hub, along the rotor normal")

    def build(self):
        if not self.filtered:
            self.refuse_unused("filter_order", "cutoff_frequency", "wind_start", because="filtered is false")
        else:
            filter_design = {"order": self.filter_order, "cutoff_frequency": self.cutoff_frequency}
            start = {"initialization": "value", "y_start": self.wind_start}
            self.low_pass = ButterworthLowPass(**filter_design, **start)
            self.connect(self.normal_wind, self.low_pass.u)
            self.connect(self.low_pass.y, self.mean_wind)

    def mean_along_shaft(self) -> float:
        """Mean wind [m/s] along the shaft, without pitch and roll of what carries it: where its filter starts."""
        wind = self.wind
        yaw = wind.parameter_value("direction") - heading_at_start(self, "frame")
        turned = np.cos(yaw) * np.cos(self.parameter_value("tilt"))
        return float(wind.mean_at(self.station) * turned)

    def wind_along(self, n):
        """Undisturbed wind [m/s] along the rotor normal n that makes the thrust."""
        return m.dot(n, self.wind.velocity(self.frame.r, self.station))

    def equations(self):
        n, hub = self.normal(), self.frame.r
        return [
            super().equations(),
            eq(self.normal_wind, self.wind_along(n)),
            [] if self.filtered else eq(self.mean_wind, self.normal_wind),
            eq(self.relative_wind, self.normal_wind - m.dot(n, der(hub))),
        ]


class CoefficientRotor(HubWind):
    """Rotor with thrust 1/2 rho A C_t U^2 and torque 1/2 rho A R C_q U^2, from tables over tip speed ratio and pitch.

    U is the wind less the velocity of the hub, both along the rotor normal. The tip speed ratio w radius / U_f takes
    the low-pass filtered wind less the velocity of the hub, so that C_t and C_q follow the mean wind and not its
    turbulence; with filtered=False U itself, the quasi-static rotor. In a Wind of kind "none" the rotor feels no air.
    Outside of its table the run stops, and in a mean wind from behind, for which no table holds. A table for starting,
    idling and parked rotors goes through tip speed ratio 0 and to feathered blades; `extended` continues it to higher
    tip speed ratios only. Not included: shear over the disk, yawed inflow (the wind across has no part), dynamic
    inflow. Every rotor of a model has its own station of the Wind.
    """

    coefficients: Data[CoefficientTable] = data(
        read_coefficients, using=("extended",), doc="CSV with the coefficients, see read_coefficients, or a whole table"
    )
    extended: bool = param(default=False, doc="estimate coefficients above the tip speed ratios of the table")
    radius: Scalar = param(unit="m", min=POSITIVE, doc="tip radius along the blade, of the tip speed ratio")
    precone: Scalar = param(default=0.0, unit="rad", doc="cone angle: R = radius cos(precone), A = pi R^2")
    lowest_wind: Scalar = param(
        default=0.5, unit="m/s", min=POSITIVE, doc="least speed the tip speed ratio is divided by"
    )

    world: World = outer(World)
    tip_speed_ratio: Scalar = var(doc="tip speed ratio")
    thrust_coefficient: Scalar = var(doc="C_t")
    torque_coefficient: Scalar = var(doc="C_q")

    def felt_disk(self) -> tuple[int, float]:
        """Station, and radius [m] about it within which the wind counts: that at the hub alone."""
        return self.station, 0.0

    def disk_diameter(self) -> float:
        """Of the disk [m]."""
        return float(2 * self.parameter_value("radius") * np.cos(self.parameter_value("precone")))

    def drawing(self) -> Drawing:
        angles = (self.side * self.parameter_value(name) for name in ("tilt", "precone"))
        return outlines.typical_rotor(self, self.parameter_value("radius"), *angles)

    def equations(self):
        R = self.radius * m.cos(self.precone)
        return [
            super().equations(),
            eq(self.thrust, self.force_in(self.relative_wind) * self.thrust_coefficient),
            eq(self.torque, self.force_in(self.torque_wind()) * R * self.torque_coefficient),
            self.coefficients_in(m.dot(self.normal(), der(self.frame.r))),
        ]

    def force_in(self, U):
        """Pressure of a relative wind on the disk, with its sign: 1/2 rho A U |U| [N]."""
        return self.world.air_density / 2 * m.pi * (self.radius * m.cos(self.precone)) ** 2 * U * m.abs(U)

    def torque_wind(self):
        """Relative wind [m/s] that makes the torque."""
        return self.relative_wind

    def coefficients_in(self, hub_velocity):
        """Tip speed ratio and coefficients, for the velocity of the hub along the rotor normal."""
        ratio, air, C = self.looked_up(self.mean_wind - hub_velocity)
        return [
            self.wind_from_front(self.mean_wind - hub_velocity, ratio, air),
            eq(self.tip_speed_ratio, ratio),
            [eq(self.thrust_coefficient, air * C[0]), eq(self.torque_coefficient, air * C[1])],
        ]

    def wind_from_front(self, speed, ratio, air):
        """Conditions on the wind along the shaft, told before the edge of the table, of which they say the cause."""
        table = self.coefficients.tip_speed_ratio
        beside = m.fmax(float(table[0]) - ratio, ratio - float(table[-1]))  # of the table, below zero within it
        return [
            assert_(self.mean_wind > -self.lowest_wind, BEHIND),
            assert_(air * m.fmin(self.lowest_wind - speed, beside) <= 0, ACROSS, along=speed, ratio=ratio),
        ]

    def looked_up(self, speed):
        """Tip speed ratio in a wind [m/s], share of the air, and both coefficients."""
        table, names = self.coefficients, ("tip speed ratio", "blade pitch [rad]")
        grid = (table.tip_speed_ratio, table.blade_pitch, table.values)
        air = at_start("air", doc="0 without any wind, else 1", compute=lambda rotor: rotor.wind.kind != "none")
        air *= self.in_air
        ratio = air * self.w * self.radius / m.fmax(speed, self.lowest_wind)
        places = zip((ratio, self.blade_pitch), grid, strict=False)
        inside = [air * value + (1 - air) * float(edges[0]) for value, edges in places]  # no air: anywhere in it
        return ratio, air, table2d(*inside, *grid, name=f"coefficients of {self.path}", arguments=names, remedy=REMEDY)
