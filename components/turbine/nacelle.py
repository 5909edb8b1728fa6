"""Nacelle and drive train: from the tower top to the hub."""

from __future__ import annotations

from fowtlib.components.aero import RotorSide
from fowtlib.components.mechanics import (
    FixedRotation,
    FixedTranslation,
    Flange,
    Frame,
    IdealGear,
    LoadSensor,
    Revolute,
    RigidBody,
    TorsionSpringDamper,
)
from fowtlib.components.servo import Generator
from fowtlib.components.turbine.actuators import ActuatedBearing
from fowtlib.language import (
    Component,
    Matrix,
    Number,
    RealInput,
    RealOutput,
    Scalar,
    Vector,
    eq,
    initial,
    like,
    param,
    part,
    port,
    shapes,
)
from fowtlib.language import math as m
from fowtlib.language.bounds import POSITIVE


class Nacelle(RotorSide):
    """Yaw bearing with its drive, nacelle body, tilted shaft with its bearing, load sensor at the hub.

    The hub lies `overhang` upwind of the yaw axis along the shaft, which crosses that axis `shaft_height` above the
    tower top; a positive tilt raises the hub. With `downwind` the nacelle is turned round by 180 deg, and its hub lies
    downwind. The torque of the drive train reacts on the nacelle; the angular momentum
    of the high speed shaft is left out (1/97 of the acceleration torque of the generator for the NREL 5 MW).
    Example: NREL/TP-500-38060, table 4-1.
    """

    mode_names = {"yaw.*": "nacelle yaw drive", "bearing.*": "rotor rotation"}

    mass: Scalar = param(default=0.0, unit="kg", min=0, doc="mass, without hub and blades")
    centre_of_mass: Vector = param(default=(0, 0, 0), unit="m", doc="from the tower top, resolved in the nacelle")
    inertia: Matrix = like(
        RigidBody.inertia, default=((0, 0, 0), (0, 0, 0), (0, 0, 0)), doc="inertia tensor about the centre of mass"
    )
    shaft_height: Scalar = param(default=0.0, unit="m", doc="height of the shaft above the tower top, on the yaw axis")
    tilt: Scalar = param(default=0.0, unit="rad", doc="tilt of the shaft, hub up")
    overhang: Scalar = param(default=0.0, unit="m", doc="distance of the hub from the yaw axis, along the shaft")
    rotation: int = param(default=1, choices=(1, -1), doc="1: clockwise seen from upwind, -1: counter-clockwise")
    azimuth_start: Scalar = param(default=0.0, unit="rad", doc="initial azimuth of blade 1; 0 is up")
    rotor_speed_start: Scalar = param(default=0.0, unit="rad/s", doc="initial rotor speed")
    yaw_frequency: Scalar = param(default=3.0, unit="Hz", min=0, doc="natural frequency of the yaw drive")
    yaw_damping: Scalar = param(default=0.02, min=0, doc="damping ratio of the yaw drive")
    yaw_rate: Number = param(default=None, unit="rad/s", min=1e-9, doc="greatest yaw rate; without it: no limit")

    frame_a: Frame = port(doc="tower top")
    hub: Frame = port(doc="hub centre, turning with the rotor; x downwind along the shaft")
    shaft: Flange = port(optional=True, doc="low speed shaft, to the drive train; turns freely when unconnected")
    yaw_command: RealInput = port(unit="rad", default=0.0, doc="commanded yaw angle, about z of the tower top")
    azimuth: RealOutput = port(unit="rad", doc="azimuth of blade 1")
    rotor_speed: RealOutput = port(unit="rad/s", doc="rotor speed, positive in the sense of rotation")
    shaft_torque: RealOutput = port(unit="N*m", doc="torque of the rotor on the shaft, positive when it drives")
    shaft_bending_moment: RealOutput = port(unit="N*m", doc="size of the bending moment of the shaft at the hub")

    yaw: ActuatedBearing = part(
        ActuatedBearing, natural_frequency=yaw_frequency, damping_ratio=yaw_damping, rate_limit=yaw_rate
    )
    body: RigidBody = part(RigidBody, mass=mass, inertia=inertia, r_cm=centre_of_mass)
    tilted: FixedRotation = part(FixedRotation, n=lambda self: (0, self.side, 0), angle=tilt, r=(0, 0, shaft_height))
    arm: FixedTranslation = part(FixedTranslation, r=lambda self: (-self.side * self.overhang, 0, 0))
    bearing: Revolute = part(
        Revolute, n=lambda self: (self.rotation, 0, 0), phi_start=azimuth_start, w_start=rotor_speed_start
    )
    cut: LoadSensor = part(LoadSensor)

    def build(self):
        for a, b in (
            (self.frame_a, self.yaw.frame_a), (self.yaw_command, self.yaw.command),
            (self.yaw.frame_b, self.tilted.frame_a), (self.tilted.frame_b, self.arm.frame_a),
            (self.arm.frame_b, self.bearing.frame_a), (self.bearing.frame_b, self.cut.frame_a),
            (self.cut.frame_b, self.hub), (self.bearing.flange, self.shaft),
        ):  # fmt: skip
            self.connect(a, b)
        self.carry(self.yaw.frame_b, self.body)

    def drawing(self) -> shapes.Drawing:
        """A box around the shaft, from behind the hub over the tower; nothing for a hub on the yaw axis."""
        length, height = self.parameter_value("overhang"), self.parameter_value("shaft_height")
        if length <= 0:
            return []
        centre, size = (0.65 * self.side * length, 0, height), (2.6 * length, 0.85 * length, 0.85 * length)
        shaft = shapes.Tube(self.hub, [(0, 0, 0), (0.4 * self.side * length, 0, 0)], 0.3 * length, material="nacelle")
        return [shapes.Box(self.yaw.frame_b, centre, size, material="nacelle"), shaft]

    def equations(self):
        moment = self.cut.torque
        return [
            eq(self.azimuth, self.bearing.phi),
            eq(self.rotor_speed, self.bearing.w),
            eq(self.shaft_torque, -self.rotation * moment[0]),
            eq(self.shaft_bending_moment, m.sqrt(moment[1] ** 2 + moment[2] ** 2)),
        ]


class Drivetrain(Component):
    """Elastic low speed shaft, ideal gear, generator: two inertias with a torsion spring between them.

    The spring starts without twist and the generator at the speed of the rotor. Values of the NREL 5 MW: stiffness
    8.676e8 N m/rad, damping 6.215e6 N m s/rad, ratio 97 (NREL/TP-500-38060, table 5-1).
    """

    mode_names = {"*": "drivetrain torsion"}

    gear_ratio: Scalar = param(min=POSITIVE, doc="generator speed over rotor speed")
    stiffness: Scalar = param(unit="N*m/rad", min=0, doc="torsional stiffness, on the low speed side")
    damping: Scalar = param(default=0.0, unit="N*m*s/rad", min=0, doc="torsional damping, on the low speed side")
    generator_inertia: Scalar = param(unit="kg*m^2", min=0, doc="moment of inertia about the high speed shaft")
    generator_efficiency: Scalar = param(default=1.0, min=0, max=1, doc="electrical over mechanical power")
    rotor_speed_start: Scalar = param(default=0.0, unit="rad/s", doc="initial speed, on the low speed side")

    shaft: Flange = port(doc="low speed shaft")
    generator_torque: RealInput = port(unit="N*m", default=0.0, doc="electromagnetic torque, positive when it brakes")
    brake: RealInput = port(unit="N*m", default=0.0, doc="torque of a brake on the high speed shaft")
    generator_speed: RealOutput = port(unit="rad/s", doc="generator speed")
    generator_power: RealOutput = port(unit="W", doc="electrical power")

    torsion: TorsionSpringDamper = part(TorsionSpringDamper, stiffness=stiffness, damping=damping)
    gear: IdealGear = part(IdealGear, ratio=gear_ratio)
    generator: Generator = part(Generator, inertia=generator_inertia, efficiency=generator_efficiency)

    def build(self):
        for a, b in (
            (self.shaft, self.torsion.flange_b), (self.torsion.flange_a, self.gear.flange_b),
            (self.gear.flange_a, self.generator.shaft), (self.generator_torque, self.generator.torque),
            (self.brake, self.generator.brake),
            (self.generator.speed, self.generator_speed), (self.generator.power, self.generator_power),
        ):  # fmt: skip
            self.connect(a, b)

    def equations(self):
        return [
            initial(self.torsion.twist, 0),
            initial(self.generator.speed, self.gear_ratio * self.rotor_speed_start),
        ]
