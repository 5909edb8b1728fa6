"""Blade pitch and generator torque as a computer sets them: once in every sample, held in between."""

from __future__ import annotations

import math

from fowtlib.components.servo.pitch_controller import PitchController
from fowtlib.components.servo.torque_controller import TorqueController, band
from fowtlib.components.servo.torque_law import torque_of
from fowtlib.language import Number, Scalar, assign, eq, param, sampled, var
from fowtlib.language import math as m


def _held(value, low, high):
    return m.fmin(m.fmax(value, low), high)


def _filtered(controller):
    """Next sample of the single-pole low-pass of the speed, exact for a speed that is held."""
    forget = m.exp(-2 * math.pi * controller.filter_frequency * controller.period)
    return forget * controller.filtered + (1 - forget) * controller.speed


class SampledTorqueController(TorqueController):
    """The torque law once in every sample, with the limit of the rate from sample to sample; it filters the speed.

    Source: J. Jonkman et al., NREL/TP-500-38060 (2009), sections 7.1, 7.2 and 7.4. With the solver idas
    every sample is a restart, which is slow; the solver fixed steps from sample to sample.
    """

    period: Number = param(default=0.0125, unit="s", min=1e-6, doc="sampling period")
    filter_frequency: Scalar = param(default=0.25, unit="Hz", min=0, doc="corner of the speed filter, single pole")
    speed_start: Scalar = param(default=0.0, unit="rad/s", doc="initial filtered speed")
    torque_start: Scalar = param(
        default=lambda self: torque_of(self.speed_start, self, m), unit="N*m", doc="initial torque"
    )

    filtered: Scalar = var(unit="rad/s", start=speed_start, discrete=True, doc="filtered generator speed")
    held: Scalar = var(unit="N*m", start=torque_start, discrete=True, doc="torque of the last sample")

    def equations(self):
        self.refuse_unused("response_time", because="the torque follows at once in a sample")
        inside, step = band(self), self.greatest_rate * self.period
        limited = _held(self.asked(self.filtered), self.held - step, self.held + step)
        return [
            sampled(self.period, assign(self.filtered, _filtered(self)), assign(self.held, limited)),
            [eq(self.command, self.asked(self.filtered)), eq(self.actual, self.held), eq(self.torque, self.held)],
            *inside,
        ]


class SampledPitchController(PitchController):
    """PI and yaw control once in every sample, with the limit of the rate from sample to sample; it filters the speed.

    In each sample: filter, integral of the speed error held where its part of the pitch reaches a limit, PI with the
    gain of the last pitch, limits. Source: J. Jonkman et al., NREL/TP-500-38060 (2009), sections 7.1, 7.3 and 7.4.
    With the solver idas every sample is a restart, which is slow; the solver fixed steps from sample to sample.
    """

    period: Number = param(default=0.0125, unit="s", min=1e-6, doc="sampling period")
    filter_frequency: Scalar = param(default=0.25, unit="Hz", min=0, doc="corner of the speed filter, single pole")
    speed_start: Scalar = param(default=0.0, unit="rad/s", doc="initial filtered speed")

    filtered: Scalar = var(unit="rad/s", start=speed_start, discrete=True, doc="filtered generator speed")
    summed: Scalar = var(
        unit="rad",
        start=lambda self: self.integral_of(self.pitch_start),
        discrete=True,
        doc="K_I times the sum of the speed errors",
    )
    held: Scalar = var(unit="rad", start=lambda self: self.pitch_start, discrete=True, doc="pitch of the last sample")

    def equations(self):
        self.refuse_unused("response_time", because="the pitch follows at once in a sample")
        self.refuse_unused("antiwindup_band", because="the sampled integral is held at its limits")
        rate, asked, share = self.law(*self.errors(self.filtered), self.held, self.summed)
        summed = self.summed + rate * self.period
        wanted = asked + self.velocity_gain * self.velocity
        command = _held(
            _held(wanted, self.least_pitch, m.inf) + self.yaw_pitch(), self.least_pitch, self.greatest_pitch
        )
        step = self.greatest_rate * self.period
        return [
            sampled(
                self.period,
                assign(self.filtered, _filtered(self)),
                assign(self.summed, _held(summed, self.least_pitch / share, self.greatest_pitch / share)),
                assign(self.held, _held(command, self.held - step, self.held + step)),
            ),
            [eq(self.command, command), eq(self.yaw_part, self.yaw_pitch()), eq(self.integral, self.summed)],
            [
                eq(self.pitch, self.held),
                eq(self.blade_pitch, self.held),
                eq(self.collective, self.held - self.yaw_part),
            ],
        ]
