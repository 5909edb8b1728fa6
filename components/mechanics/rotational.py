"""One-dimensional rotation: parts of a drive train, joined by flanges. Angles in rad, torques in N m."""

from __future__ import annotations

from fowtlib.components.mechanics.connectors import Flange
from fowtlib.components.mechanics.interfaces import TwoFlanges
from fowtlib.language import Component, RealInput, RealOutput, Scalar, der, eq, param, port, var
from fowtlib.language import math as m


class Inertia(TwoFlanges):
    """A rotor on a rigid shaft: J dw/dt = sum of the torques at its two flanges.

    Reference: Modelica.Mechanics.Rotational.Components.Inertia.
    """

    inertia: Scalar = param(unit="kg*m^2", min=0, doc="moment of inertia about the shaft")
    phi_start: Scalar = param(default=0.0, unit="rad", doc="initial angle")
    w_start: Scalar = param(default=0.0, unit="rad/s", doc="initial angular velocity")

    phi: Scalar = var(unit="rad", start=phi_start, state="prefer", doc="angle")
    w: Scalar = var(unit="rad/s", start=w_start, state="prefer", doc="angular velocity")

    def equations(self):
        a, b = self.flange_a, self.flange_b
        return [
            [eq(a.phi, self.phi), eq(b.phi, self.phi)],
            eq(der(self.phi), self.w),
            eq(self.inertia * der(self.w), a.tau + b.tau),
        ]


class IdealGear(TwoFlanges):
    """Gear without inertia, loss or play: flange_a turns `ratio` times as fast as flange_b; power passes unchanged.

    phi_a = ratio phi_b, 0 = ratio tau_a + tau_b. With ratio = 97 for a wind turbine the generator is on flange_a. The
    reaction of the housing, -(tau_a + tau_b), goes to the ground.
    Reference: Modelica.Mechanics.Rotational.Components.IdealGear.
    """

    ratio: Scalar = param(doc="speed of flange_a over speed of flange_b; negative when they turn against each other")

    def equations(self):
        a, b = self.flange_a, self.flange_b
        return [eq(a.phi, self.ratio * b.phi), eq(b.tau, -self.ratio * a.tau)]


class TorsionSpringDamper(TwoFlanges):
    """Linear torsion spring and damper between two flanges.

    tau_b = stiffness (phi_b - phi_a - phi_zero) + damping (w_b - w_a) = -tau_a.
    Reference: Modelica.Mechanics.Rotational.Components.SpringDamper.
    """

    stiffness: Scalar = param(unit="N*m/rad", min=0, doc="torsional stiffness")
    damping: Scalar = param(default=0.0, unit="N*m*s/rad", min=0, doc="torsional damping")
    phi_zero: Scalar = param(default=0.0, unit="rad", doc="angle phi_b - phi_a without load")

    twist: Scalar = var(unit="rad", state="avoid", doc="angle phi_b - phi_a")

    def equations(self):
        a, b = self.flange_a, self.flange_b
        return [
            eq(self.twist, b.phi - a.phi),
            eq(b.tau, self.stiffness * (self.twist - self.phi_zero) + self.damping * (der(b.phi) - der(a.phi))),
            eq(a.tau, -b.tau),
        ]


class BearingFriction(Component):
    """Friction of a bearing whose housing stands still, or moves with the other side of the hinge that it is part of.

    The torque on the turning part is -friction_torque w / sqrt(w^2 + creep_speed^2) - damping w: Coulomb's friction
    with its jump at rest made smooth. Where less than the friction torque pulls at it the bearing does not stand, but
    creeps: at half of that torque with 0.58 of the creep speed.
    """

    friction_torque: Scalar = param(default=0.0, unit="N*m", min=0, doc="torque of friction while it turns")
    creep_speed: Scalar = param(default=1e-4, unit="rad/s", min=1e-9, doc="speed at which the friction is 71 % of that")
    damping: Scalar = param(default=0.0, unit="N*m*s/rad", min=0, doc="torque that grows with the speed, over it")

    flange: Flange = port(doc="the turning part")

    w: Scalar = var(unit="rad/s", doc="speed of the bearing")
    torque: Scalar = var(unit="N*m", doc="torque on the turning part, against its motion")

    def equations(self):
        share = self.w / m.smooth_abs(self.w, self.creep_speed)
        return [
            eq(self.w, der(self.flange.phi)),
            eq(self.torque, -self.friction_torque * share - self.damping * self.w),
            eq(self.flange.tau, -self.torque),
        ]


class FixedFlange(Component):
    """A shaft end held at a fixed angle. Reference: Modelica.Mechanics.Rotational.Components.Fixed."""

    phi: Scalar = param(default=0.0, unit="rad", doc="angle")

    flange: Flange = port(doc="the held end")

    def equations(self):
        return [eq(self.flange.phi, self.phi)]


class TorqueSource(Component):
    """A torque given by a signal; positive turns the part joined to the flange forward.

    The reaction goes to the ground. Reference: Modelica.Mechanics.Rotational.Sources.Torque.
    """

    flange: Flange = port(doc="where the torque acts")
    torque: RealInput = port(unit="N*m", doc="torque on the part joined to the flange")

    def equations(self):
        return [eq(self.flange.tau, -self.torque)]


class AngleSource(Component):
    """A prescribed angle. The signal must be twice differentiable in time: a SecondOrderActuator's output, or a Sine.

    Reference: Modelica.Mechanics.Rotational.Sources.Position (exact).
    """

    flange: Flange = port(doc="the driven end")
    phi: RealInput = port(unit="rad", doc="angle of the flange")

    def equations(self):
        return [eq(self.flange.phi, self.phi)]


class SpeedSource(Component):
    """A prescribed angular velocity. The signal must be differentiable in time (FirstOrder, a Sine, not a Step).

    Reference: Modelica.Mechanics.Rotational.Sources.Speed (exact).
    """

    phi_start: Scalar = param(default=0.0, unit="rad", doc="initial angle")

    flange: Flange = port(doc="the driven end")
    w: RealInput = port(unit="rad/s", doc="angular velocity of the flange")

    phi: Scalar = var(unit="rad", start=phi_start, state="prefer", doc="angle of the flange")

    def equations(self):
        return [eq(self.flange.phi, self.phi), eq(der(self.phi), self.w)]


class AngleSensor(Component):
    """Angle of a flange; takes no torque. Reference: Modelica.Mechanics.Rotational.Sensors.AngleSensor."""

    flange: Flange = port(doc="flange that is measured")
    phi: RealOutput = port(unit="rad", doc="angle")

    def equations(self):
        return [eq(self.phi, self.flange.phi), eq(self.flange.tau, 0)]


class SpeedSensor(Component):
    """Angular velocity of a flange; takes no torque. Reference: Modelica.Mechanics.Rotational.Sensors.SpeedSensor."""

    flange: Flange = port(doc="flange that is measured")
    w: RealOutput = port(unit="rad/s", doc="angular velocity")

    def equations(self):
        return [eq(self.w, der(self.flange.phi)), eq(self.flange.tau, 0)]


class TorqueSensor(TwoFlanges):
    """Torque and power that pass from flange_a to flange_b, which it joins rigidly.

    Reference: Modelica.Mechanics.Rotational.Sensors.TorqueSensor and PowerSensor.
    """

    torque: RealOutput = port(unit="N*m", doc="torque of side a on side b")
    power: RealOutput = port(unit="W", doc="power from side a to side b")

    def equations(self):
        a, b = self.flange_a, self.flange_b
        return [
            eq(b.phi, a.phi),
            eq(b.tau, -a.tau),
            eq(self.torque, a.tau),
            eq(self.power, a.tau * der(a.phi)),
        ]
