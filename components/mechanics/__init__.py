"""Mechanical parts: 3-D multibody with `Frame` ports and 1-D rotational with `Flange` ports."""

# The connectors come first: World (in the environment) has a Frame, and the bodies need World.
from fowtlib.components.mechanics.connectors import Flange, Frame, ModalCoordinates  # isort: skip
from fowtlib.components.environment.world import World
from fowtlib.components.mechanics.adaptors import ForceToPositionAdaptor, PositionToForceAdaptor, PositionToLoadAdaptor
from fowtlib.components.mechanics.beam import AxialSpring, Beam, BeamHinge, BeamTurn, BendingHinge, TorsionHinge
from fowtlib.components.mechanics.beam_properties import BeamProperties, read_beam
from fowtlib.components.mechanics.bodies import Fixed, FixedRotation, FixedTranslation, PointMass, RigidBody
from fowtlib.components.mechanics.forced_motion import ForcedOscillation
from fowtlib.components.mechanics.interfaces import TwoFlanges, TwoFrames
from fowtlib.components.mechanics.joints import Crank, FreeMotion, PlanarLoopRevolute, Prismatic, Revolute, Spherical
from fowtlib.components.mechanics.loads import ConstantForce, SpringDamper, WorldForce, WorldTorque
from fowtlib.components.mechanics.modal import ElasticBody, ElasticFrame
from fowtlib.components.mechanics.rotational import (
    AngleSensor,
    AngleSource,
    BearingFriction,
    FixedFlange,
    IdealGear,
    Inertia,
    SpeedSensor,
    SpeedSource,
    TorqueSensor,
    TorqueSource,
    TorsionSpringDamper,
)
from fowtlib.components.mechanics.sensors import (
    AccelerationSensor,
    AttitudeSensor,
    LoadSensor,
    PositionSensor,
    RelativeSensor,
    VelocitySensor,
)
from fowtlib.components.mechanics.tube_beam import TubeBeam
from fowtlib.components.mechanics.visual import VisualBox, VisualTube
from fowtlib.components.mechanics.wire import AxialWire

__all__ = [
    "AccelerationSensor",
    "AngleSensor",
    "AngleSource",
    "AttitudeSensor",
    "AxialSpring",
    "AxialWire",
    "Beam",
    "BeamProperties",
    "BeamTurn",
    "BearingFriction",
    "BeamHinge",
    "BendingHinge",
    "ConstantForce",
    "Crank",
    "ElasticBody",
    "ElasticFrame",
    "Fixed",
    "FixedFlange",
    "FixedRotation",
    "FixedTranslation",
    "Flange",
    "ForceToPositionAdaptor",
    "ForcedOscillation",
    "Frame",
    "FreeMotion",
    "IdealGear",
    "Inertia",
    "LoadSensor",
    "ModalCoordinates",
    "PlanarLoopRevolute",
    "PointMass",
    "PositionSensor",
    "PositionToForceAdaptor",
    "PositionToLoadAdaptor",
    "Prismatic",
    "RelativeSensor",
    "Revolute",
    "RigidBody",
    "SpeedSensor",
    "SpeedSource",
    "Spherical",
    "SpringDamper",
    "TorqueSensor",
    "TorqueSource",
    "TorsionHinge",
    "TorsionSpringDamper",
    "TubeBeam",
    "TwoFlanges",
    "TwoFrames",
    "VelocitySensor",
    "VisualBox",
    "VisualTube",
    "World",
    "WorldForce",
    "WorldTorque",
    "read_beam",
]
