"""The hub: cone, pitch bearings and their drives."""

from __future__ import annotations

import math

from fowtlib.components.aero import RotorSide
from fowtlib.components.mechanics import Frame, RigidBody, TwoFrames
from fowtlib.components.turbine.actuators import ActuatedBearing
from fowtlib.language import (
    Number,
    RealInput,
    RealOutput,
    Scalar,
    eq,
    param,
    part,
    parts,
    port,
    rotation,
    shapes,
)
from fowtlib.language import math as m


class BladeMount(TwoFrames):
    """Rigid: from the hub centre (x along the shaft) to a blade root before its pitch bearing (z along the blade).

    R = Rx(azimuth) Ry(-precone): at azimuth 0 the blade points along z; a positive cone moves the tips to -x, upwind.
    """

    azimuth: Scalar = param(default=0.0, unit="rad", doc="place of the blade around the shaft, about x")
    precone: Scalar = param(default=0.0, unit="rad", doc="cone angle, tips towards -x")
    radius: Scalar = param(default=0.0, unit="m", doc="distance of the root from the shaft, along the blade")

    def equations(self):
        a, b = self.frame_a, self.frame_b
        R = m.rotation_x(self.azimuth) @ m.rotation_y(-self.precone)
        arm = a.R @ (R @ m.vertcat(0, 0, self.radius))
        return [eq(b.r, a.r + arm), rotation(a, b, R, m.zeros(3)), self.transmit(arm)]


class Hub(RotorSide):
    """Rigid hub with `blades` coned blade roots, each behind a pitch bearing with a drive of second order.

    Pitch is positive to feather: the leading edge turns upwind. rotation = 1 is clockwise seen from upwind (about +x).
    Blade 1 points up at zero azimuth, blade 2 is the next ahead of it (the order of OpenFAST).
    Masses of the NREL 5 MW: NREL/TP-500-38060, table 4-1.
    """

    mode_names = {"bearing_*": "blade pitch drive"}

    blades: int = param(default=3, min=1, doc="number of blades")
    rotation: int = param(default=1, choices=(1, -1), doc="1: clockwise seen from upwind, -1: counter-clockwise")
    precone: Scalar = param(default=0.0, unit="rad", doc="cone angle, tips away from the tower")
    radius: Scalar = param(unit="m", min=0, doc="distance of the blade roots from the shaft")
    mass: Scalar = param(default=0.0, unit="kg", min=0, doc="mass of the hub")
    inertia: Scalar = param(default=0.0, unit="kg*m^2", min=0, doc="moment of inertia of the hub about the shaft")
    centre_of_mass: Scalar = param(default=0.0, unit="m", doc="centre of mass along the shaft, to the tower")
    pitch_frequency: Scalar = param(default=5.0, unit="Hz", min=0, doc="natural frequency of the pitch drives")
    pitch_damping: Scalar = param(default=0.02, min=0, doc="damping ratio of the pitch drives")
    pitch_rate: Number = param(default=None, unit="rad/s", min=1e-9, doc="greatest pitch rate; without it: no limit")

    frame: Frame = port(doc="hub centre, turning; x downwind along the shaft")
    roots: Frame = port(size="blades", doc="blade roots, pitched")
    pitch_command: RealInput = port(size="blades", unit="rad", default=0.0, doc="commanded pitch of each blade")
    pitch: RealOutput = port(size="blades", unit="rad", doc="pitch of each blade")

    body: RigidBody = part(
        RigidBody, mass=mass, inertia=((inertia, 0, 0), (0, 0, 0), (0, 0, 0)),
        r_cm=lambda self: (self.side * self.centre_of_mass, 0, 0),
    )  # fmt: skip

    mounts: list[BladeMount] = parts(
        BladeMount, size="blades", name="mount", precone=lambda self: self.side * self.precone, radius=radius,
        each=lambda self, k: {"azimuth": self.rotation * 2 * math.pi * k / self.blades},
    )  # fmt: skip
    bearings: list[ActuatedBearing] = parts(
        ActuatedBearing, size="blades", name="bearing", n=lambda self: (0, 0, -self.rotation),
        natural_frequency=pitch_frequency, damping_ratio=pitch_damping, rate_limit=pitch_rate,
    )  # fmt: skip

    def build(self):
        self.connect(self.frame, self.body.frame_a)
        for k, (mount, bearing) in enumerate(zip(self.mounts, self.bearings, strict=True)):
            self.connect(self.frame, mount.frame_a)
            self.connect(mount.frame_b, bearing.frame_a)
            self.connect(bearing.frame_b, self.roots[k])
            self.connect(self.pitch_command[k], bearing.command)
            self.connect(bearing.angle, self.pitch[k])

    def drawing(self) -> shapes.Drawing:
        diameter = 2.2 * self.parameter_value("radius")
        return [shapes.Ball(self.frame, diameter=diameter, material="nacelle")] if diameter else []
