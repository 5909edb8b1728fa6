"""A frame that is moved: oscillation of a given period, for what rides on it."""

from __future__ import annotations

from fowtlib.components.mechanics.connectors import Frame
from fowtlib.components.mechanics.rotations import unit_axis
from fowtlib.language import Component, Scalar, Vector, eq, fix_orientation, param, port, var
from fowtlib.language import math as m

BUILD_UP = 2
"""Periods in which the motion grows from nothing."""


class ForcedOscillation(Component):
    """A frame that moves to and fro along an axis without turning, whatever load it takes.

    displacement = speed_amplitude/omega sin(omega t), omega = 2 pi/period, which grows from nothing in the first two
    periods by 10 p^3 - 15 p^4 + 6 p^5. For what a rotor puts against such a motion: fowtlib.frequency.aerodynamics.
    """

    r: Vector = param(default=(0, 0, 0), unit="m", doc="mean position of the frame, world")
    n: Vector = param(default=(1, 0, 0), structural=True, doc="axis of the motion, world (any length)")
    speed_amplitude: Scalar = param(default=0.0, unit="m/s", min=0, doc="amplitude of the velocity")
    period: Scalar = param(default=60.0, unit="s", min=1e-3, doc="period")

    frame: Frame = port(doc="the moved frame")

    speed: Scalar = var(unit="m/s", discrete=True, start=speed_amplitude, doc="amplitude of the velocity; 0: no motion")
    displacement: Scalar = var(unit="m", state="never", doc="along the axis")

    def start_place(self):
        return self.parameter_value("r")

    def in_the_mean(self):
        return {"speed_amplitude": 0.0}

    def equations(self):
        grown = m.fmin(self.time / (BUILD_UP * self.period), 1)
        grown = grown**3 * (10 - 15 * grown + 6 * grown**2)
        omega = 2 * m.pi / self.period
        return [
            eq(self.displacement, self.speed / omega * grown * m.sin(omega * self.time)),
            eq(self.frame.r, self.r + unit_axis(self.n) * self.displacement),
            fix_orientation(self.frame, m.eye(3), m.zeros(3)),
        ]
