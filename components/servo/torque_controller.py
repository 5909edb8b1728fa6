"""Variable-speed generator torque."""

from __future__ import annotations

from fowtlib.components.servo import torque_law
from fowtlib.language import Component, RealInput, RealOutput, Scalar, assert_, der, eq, initial, param, port, var
from fowtlib.language import math as m
from fowtlib.language.bounds import POSITIVE
from fowtlib.language.errors import ParameterError


class TorqueController(Component):
    """Generator torque by the law of torque_law.py, with limits of torque and torque rate.

    While the collective pitch is above region_3_pitch the torque is that of region 3 at any speed from region_2_speed
    on, which smooths the power; the change-over is spread over pitch_transition, where the original switches. Down to
    cut_in_speed it fades out: a generator at standstill is not connected. Torque follows its command with
    response_time as long as that asks for less than the greatest rate. Defaults: NREL 5 MW (NREL/TP-500-38060, 2009,
    table 7-2), with the constant torque of its OC3-Hywind version (NREL/TP-500-47535, 2010, section 6).
    Speeds within excluded_range of excluded_speed are passed through without staying (exclusion of torque_law.py).
    velocity_gain times the velocity of the nacelle downwind is taken off, which holds the speed of a rotor whose air
    fails; only where the generator turns and between zero and the greatest torque.
    """

    memory = "controller"

    cut_in_speed: Scalar = param(default="670 rpm", unit="rad/s", doc="generator speed below which there is no torque")
    region_2_speed: Scalar = param(default="871 rpm", unit="rad/s", doc="generator speed at which region 2 starts")
    region_3_speed: Scalar = param(default="1161.963 rpm", unit="rad/s", doc="generator speed at which region 3 starts")
    rated_speed: Scalar = param(default="1173.7 rpm", unit="rad/s", doc="rated generator speed")
    rated_torque: Scalar = param(default=43093.55, unit="N*m", min=0, doc="rated generator torque")
    region_2_constant: Scalar = param(
        default="0.0255764 N*m/rpm^2", unit="N*m*s^2/rad^2", min=0, doc="torque over speed squared in region 2"
    )
    slip: Scalar = param(default=0.1, min=0, doc="slip in region 2.5")
    excluded_speed: Scalar = param(
        default=None, unit="rad/s", min=POSITIVE, doc="generator speed in the middle of a band to be left out"
    )
    excluded_range: Scalar = param(
        default=None, unit="rad/s", min=POSITIVE, doc="how far that band reaches to both sides"
    )
    region_3: str = param(
        default="constant_torque", choices=("constant_torque", "constant_power"), doc="what is held above rated speed"
    )
    region_3_pitch: Scalar = param(default="1 deg", unit="rad", doc="collective pitch above which region 3 holds")
    pitch_transition: Scalar = param(default="1 deg", unit="rad", min=1e-6, doc="pitch range of the change-over")
    greatest_torque: Scalar = param(default=47402.91, unit="N*m", min=0, doc="limit of the torque")
    greatest_rate: Scalar = param(default=15000.0, unit="N*m/s", min=0, doc="limit of the torque rate")
    response_time: Scalar = param(default=0.05, unit="s", min=1e-3, doc="time constant of the torque")
    velocity_gain: Scalar = param(default=0.0, unit="N*s", doc="torque taken off per velocity of the nacelle downwind")

    speed: RealInput = port(unit="rad/s", doc="filtered generator speed")
    collective: RealInput = port(default=0.0, unit="rad", doc="blade pitch without the part of the yaw control")
    raised: RealInput = port(default=0.0, unit="rad", doc="pitch of peak shaving, which does not count for region 3")
    velocity: RealInput = port(default=0.0, unit="m/s", doc="velocity of the nacelle, downwind")
    torque: RealOutput = port(unit="N*m", doc="generator torque")

    actual: Scalar = var(unit="N*m", state="prefer", doc="generator torque")
    command: Scalar = var(unit="N*m", doc="torque asked for")

    def asked(self, speed):
        """Torque asked for at a filtered generator speed."""
        by_speed, above = torque_law.torque_of(speed, self, m), torque_law.region_3_torque(speed, self, m)
        pitched = _step((self.collective - self.raised - self.region_3_pitch) / self.pitch_transition + 0.5)
        turns = _step((speed - self.cut_in_speed) / (self.region_2_speed - self.cut_in_speed))
        lawful = by_speed + (above - by_speed) * pitched * turns
        floating = turns * self.velocity_gain * self.velocity
        return m.fmin(m.fmax(lawful - floating, 0), self.greatest_torque)

    def equations(self):
        inside = band(self)
        rate = (self.command - self.actual) / self.response_time
        return [
            eq(self.command, self.asked(self.speed)),
            eq(der(self.actual), m.fmin(m.fmax(rate, -self.greatest_rate), self.greatest_rate)),
            eq(self.torque, self.actual),
            initial(self.actual, self.command),
            *inside,
        ]


def band(controller):
    """An excluded band is given whole, and lies within region 2."""
    names = ("excluded_speed", "excluded_range")
    given = [controller.parameter_value(name) is not None for name in names]
    if not any(given):
        return []
    if not all(given):
        there, missing = sorted(names, key=lambda name: not given[names.index(name)])
        raise ParameterError(
            f"{controller.label}.{there} needs {missing} as well: the band is the one about the other."
        )
    low, high = (controller.excluded_speed + sign * controller.excluded_range for sign in (-1, 1))
    end = controller.region_3_speed / (1 + controller.slip)
    inside = m.fmin(low - controller.region_2_speed, end - high)
    return [assert_(inside > 0, _BAND, low=low, high=high, start=controller.region_2_speed, end=end)]


_BAND = (
    "the excluded band is from {low} to {high} rad/s of the generator, and region 2, where it has to lie, from "
    "{start} to {end} rad/s"
)


def _step(way):
    """From 0 at 0 to 1 at 1, with a continuous slope."""
    inside = m.fmin(m.fmax(way, 0), 1)
    return inside**2 * (3 - 2 * inside)
