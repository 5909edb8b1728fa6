"""The electrical generator at the end of a drive train."""

from __future__ import annotations

from fowtlib.components.mechanics.connectors import Flange
from fowtlib.language import Component, RealInput, RealOutput, Scalar, der, eq, param, port, var


class Generator(Component):
    """Inertia with braking torques: inertia dw/dt = shaft torque - torque - brake; power = efficiency torque w."""

    inertia: Scalar = param(unit="kg*m^2", min=0, doc="moment of inertia about its shaft")
    efficiency: Scalar = param(default=1.0, min=0, max=1, doc="electrical over mechanical power")

    shaft: Flange = port(doc="high speed shaft")
    torque: RealInput = port(unit="N*m", doc="electromagnetic torque, positive when it brakes")
    brake: RealInput = port(unit="N*m", default=0.0, doc="torque of a brake on this shaft, positive when it brakes")
    speed: RealOutput = port(unit="rad/s", doc="generator speed")
    power: RealOutput = port(unit="W", doc="electrical power")

    phi: Scalar = var(unit="rad", state="avoid", doc="angle")

    def equations(self):
        return [
            eq(self.phi, self.shaft.phi),
            eq(self.speed, der(self.phi)),
            eq(self.inertia * der(self.speed), self.shaft.tau - self.torque - self.brake),
            eq(self.power, self.efficiency * self.torque * self.speed),
        ]
