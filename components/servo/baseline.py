"""The baseline controller of a variable-speed turbine: speed filter, blade pitch, generator torque."""

from __future__ import annotations

import math

from fowtlib.components.blocks import FirstOrder
from fowtlib.components.servo.peak_shaving import LeastPitch, PeakShaving, read_least_pitch
from fowtlib.components.servo.pitch_controller import PitchController
from fowtlib.components.servo.sampled import SampledPitchController, SampledTorqueController
from fowtlib.components.servo.torque_controller import TorqueController
from fowtlib.components.servo.turbine_controller import TurbineController
from fowtlib.language import Data, Number, RealInput, Scalar, data, like, param, port
from fowtlib.language.errors import ParameterError

PITCH = ("proportional_gain", "integral_gain", "rated_speed", "yaw_gain", "integrated_change", "pitch_start")


class BaselineController(TurbineController):
    """Pitch and torque controller of the NREL 5 MW turbine behind one low-pass filter of the generator speed.

    Continuous in time, or with `sample_period` the sampled controllers of sampled.py. The torque takes the collective
    part of the pitch, so that a pitch of the yaw control does not raise it. Parameters not listed here are those of the
    parts `pitch` and `torque`. Source: J. Jonkman et al., NREL/TP-500-38060 (2009), chapter 7.
    """

    proportional_gain: Scalar = param(unit="s", doc="pitch controller: K_P at zero pitch")
    integral_gain: Scalar = param(doc="pitch controller: K_I at zero pitch")
    yaw_gain: Scalar = param(
        default=0.0, doc="pitch per yaw angle, with the sign of the rotor's y; see PitchController"
    )
    pitch_per_velocity: Scalar = like(PitchController.velocity_gain)
    torque_per_velocity: Scalar = like(TorqueController.velocity_gain)
    integrated_change: Scalar = like(PitchController.integrated_change)
    rated_speed: Scalar = param(default="1173.7 rpm", unit="rad/s", doc="rated generator speed")
    region_3: str = param(
        default="constant_torque", choices=("constant_torque", "constant_power"), doc="what is held above rated speed"
    )
    filter_frequency: Scalar = param(default=0.25, unit="Hz", min=0, doc="corner of the speed filter, single pole")
    sample_period: Number = param(default=None, unit="s", min=1e-6, doc="sampling period; without it continuous")
    peak_shaving: Data[LeastPitch] = data(
        read_least_pitch, default=None, doc="CSV with a least pitch over the power, see PeakShaving; without it none"
    )
    pitch_start: Scalar = param(default=0.0, unit="rad", doc="initial blade pitch")
    speed_start: Scalar = param(default=0.0, unit="rad/s", doc="sampled: initial generator speed")

    yaw: RealInput = port(default=0.0, unit="rad", doc="yaw angle of the platform, for the yaw control")
    velocity: RealInput = port(default=0.0, unit="m/s", doc="velocity of the nacelle downwind, for floating feedback")
    set_point_change: RealInput = port(default=0.0, doc="change of the speed that is held over rated_speed")

    def build(self):
        pitch = {name: getattr(self, name) for name in PITCH} | {"velocity_gain": self.pitch_per_velocity}
        torque = {"rated_speed": self.rated_speed, "region_3": self.region_3, "velocity_gain": self.torque_per_velocity}
        if self.sample_period is None:
            self.speed_filter = FirstOrder(time_constant=1 / (2 * math.pi * self.filter_frequency))
            self.connect(self.generator_speed, self.speed_filter.u)
            self.pitch, self.torque = PitchController(**pitch), TorqueController(**torque)
            speed = self.speed_filter.y
        else:
            samples = {name: getattr(self, name) for name in ("filter_frequency", "speed_start")}
            samples["period"] = self.sample_period
            self.pitch = SampledPitchController(**pitch, **samples)
            self.torque = SampledTorqueController(**torque, **samples)
            speed = self.generator_speed
        for pair in ((speed, self.pitch.speed), (speed, self.torque.speed), (self.yaw, self.pitch.yaw),
                     (self.velocity, self.pitch.velocity), (self.velocity, self.torque.velocity),
                     (self.set_point_change, self.pitch.set_point_change)):  # fmt: skip
            self.connect(*pair)
        self.connect(self.pitch.collective, self.torque.collective)
        self.shave(speed)
        self.connect(self.pitch.blade_pitch, self.blade_pitch)
        self.connect(self.torque.torque, self.generator_torque)

    def shave(self, speed):
        """The least pitch by the power, where one is given."""
        if self.peak_shaving is None:
            return
        if self.sample_period is not None:
            raise ParameterError(f"{self.label}: peak_shaving is continuous in time; leave sample_period out.")
        self.shaving = PeakShaving(table=self.peak_shaving)
        for pair in ((speed, self.shaving.speed), (self.torque.torque, self.shaving.torque),
                     (self.shaving.raised, self.pitch.raised), (self.shaving.raised, self.torque.raised)):  # fmt: skip
            self.connect(*pair)
