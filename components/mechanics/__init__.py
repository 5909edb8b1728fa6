"""Mechanical parts: 3-D multibody with `Frame` ports, 1-D rotation and translation with flanges."""

# The connectors come first: World (in the environment) has a Frame, and the bodies need World.
from fowtlib.components.mechanics.connectors import Flange, Frame, ModalCoordinates, TranslationalFlange  # isort: skip
from fowtlib.components.environment.world import World
from fowtlib.components.mechanics.adaptors import ForceToPositionAdaptor, PositionToForceAdaptor, PositionToLoadAdaptor
from fowtlib.components.mechanics.beam import AxialSpring, Beam, BeamHinge, BeamTurn, BendingHinge, TorsionHinge
from fowtlib.components.mechanics.beam_properties import BeamProperties, read_beam
from fowtlib.components.mechanics.bodies import Fixed, FixedRotation, FixedTranslation, PointMass, RigidBody
from fowtlib.components.mechanics.forced_motion import ForcedOscillation
from fowtlib.components.mechanics.guide import Guide
from fowtlib.components.mechanics.imposed_motion import ImposedMotion, MotionRecord, read_motion
from fowtlib.components.mechanics.interfaces import TwoFlanges, TwoFrames
from fowtlib.components.mechanics.joints import Crank, FreeMotion, PlanarLoopRevolute, Prismatic, Revolute, Spherical
from fowtlib.components.mechanics.loads import ConstantForce, SpringDamper, WorldForce, WorldTorque
from fowtlib.components.mechanics.loose_guide import LooseGuide
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
from fowtlib.components.mechanics.swept_force import SweptForce
from fowtlib.components.mechanics.translational import EndStop, Latch, SlidingFriction
from fowtlib.components.mechanics.tube_beam import TubeBeam
from fowtlib.components.mechanics.visual import VisualBox, VisualTube
from fowtlib.components.mechanics.wire import AxialWire

__all__ = [
    "TranslationalFlange",
    "SlidingFriction",
    "Latch",
    "Guide",
    "LooseGuide",
    "EndStop",
    "AccelerationSensor",
    "AngleSensor",
    "AngleSource",
    "AttitudeSensor",
    "AxialSpring",
    "AxialWire",
    "Beam",
    "BeamHinge",
    "BeamProperties",
    "BeamTurn",
    "BearingFriction",
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
    "ImposedMotion",
    "Inertia",
    "LoadSensor",
    "ModalCoordinates",
    "MotionRecord",
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
    "SweptForce",
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
    "read_motion",
]
