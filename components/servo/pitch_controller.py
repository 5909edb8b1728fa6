"""Collective blade pitch: gain-scheduled PI on the generator speed, and the yaw control of multi-rotor platforms."""

from __future__ import annotations

from fowtlib.components.servo.antiwindup import held_within
from fowtlib.components.servo.scheduled_gains import ScheduledGains
from fowtlib.components.servo.torque_law import larger
from fowtlib.language import RealInput, RealOutput, Scalar, der, eq, param, port, var
from fowtlib.language import math as m


class PitchController(ScheduledGains):
    """Blade pitch = G (K_P e + x) with e = speed - rated_speed, x' = K_I e, G = 1 / (1 + pitch / doubling_pitch).

    As in the original, G multiplies the integral too, so that the gains for small changes are those at zero pitch over
    1 + 2 pitch / doubling_pitch. With `scheduled: gains` it is G K_P e + x with x' = G K_I e, see ScheduledGains.
    Limits of pitch and pitch rate; the pitch follows its command with response_time as long as that asks for less than
    the greatest rate. Anti-windup: G x stays within the limits of the pitch, because x' fades out within
    antiwindup_band of a limit and only towards it; so the pitch leaves the limit when the speed error changes sign.
    The corners of the lower limit and of the yaw control are rounded over pitch_rounding.
    Source: J. Jonkman et al., NREL/TP-500-38060 (2009), section 7.3; floating gains: NREL/TP-500-47535 (2010), section
    6. ONSHORE_GAINS and FLOATING_GAINS hold the gains.

    Yaw control (PI-P): pitch + max(0, -yaw_gain yaw), which takes thrust off a rotor that moves downwind when the
    platform yaws (positive: counter-clockwise from above). The gain has the sign of the rotor's y: positive for the
    left one, looking downwind. Source: O. El Beshbichi, thesis, Univ. of Stavanger (2023), eq. 4.11-4.12, gain 1.5.

    Floating feedback: velocity_gain times the velocity of the nacelle downwind is added before the lower limit, which
    takes thrust off while it moves downwind: damping of the platform's pitch that the control of the speed takes away.
    Source: J. Jonkman, AIAA-2008-1358; N. Abbas et al., Wind Energ. Sci. 7 (2022) 53, section 2.5.

    Moved set point: the speed that the proportional part holds is rated_speed (1 + set_point_change), that of the
    integral rated_speed (1 + integrated_change set_point_change). The change is that of a SetPointFeedback.
    """

    memory = "controller"

    rated_speed: Scalar = param(default="1173.7 rpm", unit="rad/s", doc="generator speed that is held")
    least_pitch: Scalar = param(default=0.0, unit="rad", doc="lower limit")
    greatest_pitch: Scalar = param(default="90 deg", unit="rad", doc="upper limit")
    greatest_rate: Scalar = param(default="8 deg/s", unit="rad/s", min=0, doc="limit of the pitch rate")
    response_time: Scalar = param(default=0.05, unit="s", min=1e-3, doc="time constant of the pitch")
    antiwindup_band: Scalar = param(default="0.1 deg", unit="rad", min=1e-6, doc="range before a limit of the integral")
    pitch_rounding: Scalar = param(default="0.1 deg", unit="rad", min=1e-6, doc="width of rounded corners")
    yaw_gain: Scalar = param(default=0.0, doc="pitch per yaw angle, with the sign of the rotor's y")
    velocity_gain: Scalar = param(default=0.0, unit="rad*s/m", doc="pitch per velocity of the nacelle downwind")
    integrated_change: Scalar = param(
        default=0.0, doc="share of the change of the set point in the integral; 0: the proportional part alone moves"
    )
    pitch_start: Scalar = param(default=0.0, unit="rad", doc="initial pitch")

    speed: RealInput = port(unit="rad/s", doc="filtered generator speed")
    yaw: RealInput = port(default=0.0, unit="rad", doc="yaw angle of the platform")
    velocity: RealInput = port(default=0.0, unit="m/s", doc="velocity of the nacelle, downwind")
    raised: RealInput = port(default=0.0, unit="rad", doc="added to the lower limit: peak shaving")
    set_point_change: RealInput = port(default=0.0, doc="change of the speed that is held over rated_speed")
    blade_pitch: RealOutput = port(unit="rad", doc="blade pitch")
    collective: RealOutput = port(unit="rad", doc="blade pitch without the part of the yaw control")

    pitch: Scalar = var(unit="rad", start=pitch_start, fixed=True, state="prefer", doc="blade pitch")
    integral: Scalar = var(
        unit="rad", start=lambda self: self.integral_of(self.pitch_start), fixed=True, state="prefer",
        doc="K_I times the integral of the speed error",
    )  # fmt: skip
    yaw_part: Scalar = var(unit="rad", doc="pitch added by the yaw control")
    command: Scalar = var(unit="rad", doc="pitch asked for")

    def yaw_pitch(self):
        """max(0, -yaw_gain yaw) = (|yaw_gain| |yaw| - yaw_gain yaw) / 2, with a rounded corner."""
        size = larger(self.yaw, -self.yaw, self.pitch_rounding, m)
        return (m.abs(self.yaw_gain) * size - self.yaw_gain * self.yaw) / 2

    def errors(self, speed):
        """Speed errors of the proportional part and of the integral."""
        change = self.rated_speed * self.set_point_change
        return speed - self.rated_speed - change, speed - self.rated_speed - self.integrated_change * change

    def equations(self):
        rate, asked, share = self.law(*self.errors(self.speed), self.pitch, self.integral)
        least, band = self.least_pitch + self.raised, self.antiwindup_band
        grows = held_within(rate, self.integral, least / share, self.greatest_pitch / share, band)
        free = asked + self.velocity_gain * self.velocity
        above = larger(free, least, self.pitch_rounding, m) + self.yaw_part
        rate = (self.command - self.pitch) / self.response_time
        return [
            eq(der(self.integral), grows),
            eq(self.yaw_part, self.yaw_pitch()),
            eq(self.command, m.fmin(above, self.greatest_pitch)),
            eq(der(self.pitch), m.fmin(m.fmax(rate, -self.greatest_rate), self.greatest_rate)),
            [eq(self.blade_pitch, self.pitch), eq(self.collective, self.pitch - self.yaw_part)],
        ]


ONSHORE_GAINS = {"proportional_gain": 0.01882681, "integral_gain": 0.008068634}
"""Land-based NREL 5 MW: natural frequency 0.6 rad/s, damping ratio 0.7."""

FLOATING_GAINS = {"proportional_gain": 0.006275604, "integral_gain": 0.0008965149}
"""NREL 5 MW on OC3-Hywind: natural frequency 0.2 rad/s, damping ratio 0.7."""
