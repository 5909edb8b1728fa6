"""A turbine whose rotor is a thrust: what a study of a floater needs at the least."""

from __future__ import annotations

from fowtlib.components.aero import RotorSide, ThrustRotor, outlines
from fowtlib.components.mechanics import Frame, RigidBody
from fowtlib.components.turbine.start import give_default
from fowtlib.language import Matrix, RealOutput, Scalar, Vector, like, param, part, port
from fowtlib.language.shapes import Drawing


class ThrustTurbine(RotorSide):
    """A ThrustRotor and the mass of rotor and nacelle as one body, in place of a RotorNacelle.

    There is no rotor speed, so that there are no power, no torque and no gyroscopic moment. Downwind of its tower the
    body is turned round about z.
    """

    mass: Scalar = param(unit="kg", min=0, doc="mass of rotor and nacelle")
    inertia: Matrix = like(
        RigidBody.inertia, default=((0, 0, 0), (0, 0, 0), (0, 0, 0)), doc="inertia tensor about the centre of mass"
    )
    centre_of_mass: Vector = param(default=(0, 0, 0), unit="m", doc="from the hub, resolved in the frame")
    air_loads: Scalar = like(ThrustRotor.air_loads)

    frame: Frame = port(doc="hub; x downwind")
    thrust: RealOutput = port(unit="N", doc="rotor thrust")

    rotor: ThrustRotor = part(ThrustRotor)
    body: RigidBody = part(RigidBody, mass=mass, inertia=inertia, r_cm=centre_of_mass)

    def build(self):
        self.connect(self.frame, self.rotor.frame)
        self.connect(self.rotor.thrust, self.thrust)
        self.carry(self.frame, self.body)
        give_default(self.rotor, "downwind", self.downwind)
        give_default(self.rotor, "air_loads", self.air_loads)

    def drawing(self) -> Drawing:
        return [*outlines.housing(self.frame, self.rotor), *self.rotor.drawing()]
