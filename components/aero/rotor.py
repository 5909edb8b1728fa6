"""What every rotor on a rigid shaft has: its speed equation and the loads it passes to the body that carries it."""

from __future__ import annotations

from fowtlib.components.aero.air_loads import AirLoads
from fowtlib.components.aero.rotor_side import RotorSide
from fowtlib.components.mechanics.connectors import Flange, Frame
from fowtlib.language import RealInput, RealOutput, Scalar, der, eq, param, port, var
from fowtlib.language import math as m


class Rotor(RotorSide, AirLoads):
    """Rotor with one degree of freedom, its azimuth: inertia dw/dt = torque + shaft torque. Partial.

    The rotor normal n points downwind and, by the tilt, down; of a rotor downwind of its tower, up. Speed, torque and
    power are positive when the rotor drives the shaft, in either sense of rotation. The body of the frame takes the
    thrust along n; what the rotor puts into the shaft, because the drive train stands on that body (reaction_torque);
    and the moment -w_frame x h of the spin h = rotation inertia w n (gyroscopic). Both can be switched off, to compare
    with models that have the thrust only.

    A subclass writes thrust and torque, both times in_air; the mass of the rotor belongs to the body.
    """

    mode_names = {"phi": "rotor rotation", "w": "rotor rotation"}

    inertia: Scalar = param(unit="kg*m^2", min=0, doc="moment of inertia about the shaft")
    tilt: Scalar = param(default=0.0, unit="rad", doc="shaft tilt, positive when the end of the hub points up")
    rotation: int = param(default=1, choices=(1, -1), doc="1: turns clockwise seen looking downwind, -1: the other way")
    reaction_torque: bool = param(default=True, doc="the frame takes the torque that goes into the shaft")
    gyroscopic: bool = param(default=True, doc="the frame takes the gyroscopic moment")
    w_start: Scalar = param(default=0.0, unit="rad/s", doc="initial speed of the rotor")

    frame: Frame = port(doc="hub; x along the horizontal projection of the shaft, downwind")
    shaft: Flange = port(doc="low speed shaft; positive in the sense of rotation")
    blade_pitch: RealInput = port(unit="rad", doc="collective blade pitch, positive to feather")

    thrust: RealOutput = port(unit="N", doc="thrust along the rotor normal, downwind")
    torque: RealOutput = port(unit="N*m", doc="aerodynamic torque")
    aero_power: RealOutput = port(unit="W", doc="aerodynamic power")

    phi: Scalar = var(unit="rad", state="prefer", doc="azimuth of the rotor")
    w: Scalar = var(unit="rad/s", start=w_start, fixed=True, state="prefer", doc="speed of the rotor")

    def normal(self):
        """The rotor normal, world."""
        return self.frame.R @ m.vertcat(m.cos(self.tilt), 0, -self.side * m.sin(self.tilt))

    def moment_of_air(self, n):
        """Moment of the air on the hub across the shaft, world; none where the thrust acts at the hub."""
        return m.zeros(3)

    def equations(self):
        n, frame, shaft = self.normal(), self.frame, self.shaft
        moment = -self.rotation * shaft.tau * n if self.reaction_torque else m.zeros(3)
        if self.gyroscopic:
            moment = moment - m.cross(frame.w, self.rotation * self.inertia * self.w * n)
        moment = moment + self.moment_of_air(n)
        return [
            [eq(shaft.phi, self.phi), eq(der(self.phi), self.w)],
            eq(self.inertia * der(self.w), self.torque + shaft.tau),
            eq(self.aero_power, self.torque * self.w),
            [eq(frame.f, -self.thrust * n), eq(frame.t, -moment)],
            self.switching(),
        ]
