"""A controller that is not part of the model."""

from __future__ import annotations

from fowtlib.components.servo.torque_law import TorqueLaw
from fowtlib.language import Component, RealInput, RealOutput, Scalar, eq, param, port


class ExternalControl(Component):
    """Blade pitch and generator torque come from outside: they are inputs of the model, and of its FMU.

    It stands in the place of a turbine's `control`. Without anybody outside they stay where they start. The pitch acts
    at once: who commands it also limits its rate.
    """

    pitch_start: Scalar = param(default=0.0, unit="rad", doc="blade pitch unless one is given")
    torque_start: Scalar = param(
        default=TorqueLaw.rated_torque, unit="N*m", doc="generator torque unless one is given; rated, of the NREL 5 MW"
    )

    generator_speed: RealInput = port(unit="rad/s", doc="generator speed, not used here: read it as a result")
    pitch_demand: RealInput = port(unit="rad", default=pitch_start, doc="blade pitch asked for")
    torque_demand: RealInput = port(unit="N*m", default=torque_start, doc="generator torque asked for")
    blade_pitch: RealOutput = port(unit="rad", doc="blade pitch")
    generator_torque: RealOutput = port(unit="N*m", doc="generator torque")

    def equations(self):
        return [eq(self.blade_pitch, self.pitch_demand), eq(self.generator_torque, self.torque_demand)]
