"""Feedback of several signals to several demands, its gains scheduled; a controller that is told its pitch."""

from __future__ import annotations

import numpy as np

from fowtlib.components.blocks import FirstOrder
from fowtlib.components.servo.antiwindup import held_within
from fowtlib.components.servo.gain_table import GainTable, read_gains
from fowtlib.components.servo.pitch_controller import PitchController
from fowtlib.components.servo.schedule import flat, flat_shape, interpolated
from fowtlib.components.servo.torque_controller import TorqueController
from fowtlib.components.servo.torque_law import larger
from fowtlib.components.servo.turbine_controller import TurbineController
from fowtlib.language import (
    Array,
    Component,
    Data,
    RealInput,
    RealOutput,
    Scalar,
    data,
    der,
    eq,
    like,
    param,
    port,
    var,
)
from fowtlib.language import math as m


class ScheduledFeedback(Component):
    """u = trim - K (y - y0) + x, x' = -K_i (y - y0); trim, y0, K and K_i on straight lines between the points of v.

    So a regulator with integral action whose gains change with the schedule v, such as the wind: the gain acts on what
    is integrated, and nothing jumps where v passes a point; beyond the first and the last point all stay as there.
    trim + x stays between the limits of the demand: x' fades out within antiwindup_band of a limit, only towards it.
    The arrays come from the table, are tunable, and count in SI.
    Source: W. J. Rugh and J. S. Shamma, Automatica 36 (2000) 1401.
    """

    in_own_units = {"": "its gains are numbers in the units of its signals"}

    memory = "controller"

    table: Data[GainTable] = data(read_gains, doc="file of a GainTable, or one itself")
    points: Array = param(
        default=lambda self: self.table.points, shape=lambda self: (len(self.table.points),), doc="its points"
    )
    gains: Array = param(default=flat("gains"), shape=flat_shape("gains"), doc="K of each point, row by row")
    integral_gains: Array = param(default=flat("integral_gains"), shape=flat_shape("gains"), doc="K_i of each point")
    set_points: Array = param(default=flat("set_points"), shape=flat_shape("set_points"), doc="y0 of each point")
    trim: Array = param(default=flat("trim"), shape=flat_shape("trim"), doc="demands of each point at rest")
    lowest: Scalar = param(default=-1e30, doc="lower limit of trim and integral")
    highest: Scalar = param(default=1e30, doc="upper limit of trim and integral")
    antiwindup_band: Scalar = param(default=2e-3, min=1e-9, doc="range before a limit of the integral")
    initial_integral: Array = param(
        default=lambda self: np.zeros(len(self.table.demands)), shape=lambda self: (len(self.table.demands),),
        doc="x at the start"
    )  # fmt: skip

    schedule: RealInput = port(doc="v, where on the schedule it is")
    measured: RealInput = port(size=lambda self: len(self.table.measured), doc="y, in the order of the table")
    demand: RealOutput = port(size=lambda self: len(self.table.demands), doc="u, in the order of the table")
    mean: RealOutput = port(doc="mean of all demands: the collective part")

    integral: Array = var(
        shape=lambda self: (len(self.table.demands),), start=initial_integral, fixed=True, state="prefer", doc="x"
    )

    def equations(self):
        count, demands = len(self.measured), len(self.demand)

        def scheduled(table):
            return interpolated(self.schedule, self.points, table)

        away = m.vertcat(*self.measured) - scheduled(self.set_points)
        pull, drive = (
            [sign * m.dot(row[k * count : (k + 1) * count], away) for k in range(demands)]
            for sign, row in ((1, scheduled(self.gains)), (-1, scheduled(self.integral_gains)))
        )
        trim, equations = scheduled(self.trim), []
        for k in range(demands):
            rest = trim[k] + self.integral[k]
            grows = held_within(drive[k], rest, self.lowest, self.highest, self.antiwindup_band)
            equations += [eq(der(self.integral[k]), grows), eq(self.demand[k], rest - pull[k])]
        return [*equations, eq(self.mean, sum(self.demand) / demands)]


class PitchDrive(Component):
    """The pitch follows a demand within limits of pitch and rate, with response_time while that asks for less.

    The corner of the lower limit is rounded over pitch_rounding.
    """

    memory = "controller"

    least_pitch: Scalar = like(PitchController.least_pitch)
    greatest_pitch: Scalar = like(PitchController.greatest_pitch)
    greatest_rate: Scalar = like(PitchController.greatest_rate)
    response_time: Scalar = like(PitchController.response_time)
    pitch_rounding: Scalar = like(PitchController.pitch_rounding, doc="width of the rounded corner")
    pitch_start: Scalar = like(PitchController.pitch_start)

    demand: RealInput = port(unit="rad", doc="pitch asked for")
    blade_pitch: RealOutput = port(unit="rad", doc="blade pitch")

    pitch: Scalar = var(unit="rad", start=pitch_start, fixed=True, state="prefer", doc="blade pitch")

    def equations(self):
        allowed = m.fmin(larger(self.demand, self.least_pitch, self.pitch_rounding, m), self.greatest_pitch)
        rate = (allowed - self.pitch) / self.response_time
        return [
            eq(der(self.pitch), m.fmin(m.fmax(rate, -self.greatest_rate), self.greatest_rate)),
            eq(self.blade_pitch, self.pitch),
        ]


class DemandedController(TurbineController):
    """A turbine whose pitch is told from outside, as by a ScheduledFeedback of all rotors; its torque is its own.

    The torque follows the filtered speed, and the collective pitch, so that a pitch against yaw does not raise it.
    """

    rated_speed: Scalar = like(TorqueController.rated_speed)
    region_3: str = like(TorqueController.region_3)
    filter_frequency: Scalar = param(default=0.25, unit="Hz", min=1e-6, doc="corner of the speed filter, single pole")
    pitch_start: Scalar = param(default=0.0, unit="rad", doc="initial blade pitch")

    pitch_demand: RealInput = port(unit="rad", doc="pitch asked for")
    collective: RealInput = port(unit="rad", doc="collective part of it")

    def build(self):
        self.speed_filter = FirstOrder(time_constant=1 / (2 * np.pi * self.filter_frequency))
        self.torque = TorqueController(rated_speed=self.rated_speed, region_3=self.region_3)
        self.pitch = PitchDrive(pitch_start=self.pitch_start)
        for pair in (
            (self.generator_speed, self.speed_filter.u), (self.speed_filter.y, self.torque.speed),
            (self.collective, self.torque.collective), (self.pitch_demand, self.pitch.demand),
            (self.pitch.blade_pitch, self.blade_pitch), (self.torque.torque, self.generator_torque),
        ):  # fmt: skip
            self.connect(*pair)
