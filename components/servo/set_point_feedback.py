"""The set point of the rotor speed, moved with a floating platform."""

from __future__ import annotations

from fowtlib.components.mechanics.connectors import Frame
from fowtlib.components.servo.nacelle_velocity import velocity_along
from fowtlib.language import Component, RealOutput, Scalar, der, eq, initial, param, port, var
from fowtlib.language import math as m


class SetPointFeedback(Component):
    """change = pitch_rate_gain q + velocity_gain v + filtered_gain y, with y' = filter_frequency (v - y).

    q is the pitch rate of the platform (positive: its top moves downwind), v the horizontal velocity of the nacelle
    along its x axis. The pitch controller holds rated_speed (1 + change). A negative gain damps the platform: while it
    moves downwind the rotor shall turn slower, the blades pitch out of the wind, and the thrust falls.
    Source: J. M. Hegseth, thesis NTNU 2020:356, eq. 3.32-3.33. His CS1 has no gain, CS2, CS3 and CS4 have one of the
    three, in this order.
    """

    memory = "controller"

    pitch_rate_gain: Scalar = param(default=0.0, unit="s/rad", doc="change over the pitch rate of the platform")
    velocity_gain: Scalar = param(default=0.0, unit="s/m", doc="change over the velocity of the nacelle")
    filtered_gain: Scalar = param(default=0.0, unit="s/m", doc="change over the filtered velocity of the nacelle")
    filter_frequency: Scalar = param(default=0.2, unit="rad/s", min=1e-6, doc="corner of the low-pass, single pole")

    platform: Frame = port(doc="platform; x downwind, z up")
    nacelle: Frame = port(doc="nacelle or tower top; x downwind")
    change: RealOutput = port(doc="change of the set point over its rated value")

    pitch_rate: Scalar = var(unit="rad/s", doc="pitch rate of the platform")
    velocity: Scalar = var(unit="m/s", doc="velocity of the nacelle downwind")
    filtered: Scalar = var(unit="m/s", state="prefer", doc="filtered velocity of the nacelle")

    def equations(self):
        n, w = self.platform.R[:, 0], self.platform.w
        across = (n[0] * w[1] - n[1] * w[0]) / m.sqrt(n[0] ** 2 + n[1] ** 2)
        direct = self.pitch_rate_gain * self.pitch_rate + self.velocity_gain * self.velocity
        return [
            [eq(self.pitch_rate, across), eq(self.velocity, velocity_along(self.nacelle))],
            eq(der(self.filtered), self.filter_frequency * (self.velocity - self.filtered)),
            eq(self.change, direct + self.filtered_gain * self.filtered),
            initial(self.filtered, self.velocity),
            [eq(load, m.zeros(3)) for at in (self.platform, self.nacelle) for load in (at.f, at.t)],
        ]
