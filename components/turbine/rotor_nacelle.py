"""Rotor, nacelle, drive train and controller of one turbine, as one rigid assembly at the hub."""

from __future__ import annotations

from collections.abc import Callable

from fowtlib.components.aero import CoefficientRotor, RotorSide, outlines
from fowtlib.components.environment.wind import Wind
from fowtlib.components.environment.world import World
from fowtlib.components.mechanics import Frame, IdealGear, RigidBody
from fowtlib.components.servo import BaselineController, Generator, SafetySystem, TurbineController
from fowtlib.components.turbine.operating_point import SteadyTurbine
from fowtlib.components.turbine.start import controlled, give_default, start_point, unknown_start
from fowtlib.language import (
    Component,
    Matrix,
    RealInput,
    RealOutput,
    Scalar,
    Vector,
    eq,
    like,
    outer,
    param,
    part,
    port,
)
from fowtlib.language.bounds import POSITIVE
from fowtlib.language.shapes import Drawing


def _start_of(name: str) -> Callable[[RotorNacelle], float]:
    return lambda turbine: getattr(start_point(turbine, turbine.rotor.station), name)


class RotorNacelle(RotorSide):
    """A turbine above its tower: rotor, gear, generator, controller, and the mass of rotor and nacelle as one body.

    Give the parts `rotor` and `control` with their own parameters; `safety` offers shutdowns as events. The inertia
    about the shaft belongs to the rotor, `inertia` is the rest. The simulation starts at the steady operating point in
    the mean wind of the rotor's station, unless start values are given; without wind, or without loads of the air, the
    rotor stands still. Downwind of its tower the body is turned round about z.
    """

    mass: Scalar = param(unit="kg", min=0, doc="mass of rotor and nacelle")
    inertia: Matrix = like(
        RigidBody.inertia, default=((0, 0, 0), (0, 0, 0), (0, 0, 0)), doc="inertia tensor about the centre of mass"
    )
    centre_of_mass: Vector = param(default=(0, 0, 0), unit="m", doc="from the hub, resolved in the frame")
    gear_ratio: Scalar = param(min=POSITIVE, doc="generator speed over rotor speed")
    generator_inertia: Scalar = param(unit="kg*m^2", min=0, doc="moment of inertia about the high speed shaft")
    generator_efficiency: Scalar = param(default=1.0, min=0, max=1, doc="electrical over mechanical power")
    air_loads: Scalar = like(CoefficientRotor.air_loads)
    rotor_speed_start: Scalar = param(default=_start_of("rotor_speed"), unit="rad/s", doc="initial rotor speed")
    blade_pitch_start: Scalar = param(default=_start_of("blade_pitch"), unit="rad", doc="initial blade pitch")

    world: World = outer(World)
    wind: Wind = outer(Wind)
    frame: Frame = port(doc="hub; x downwind")
    yaw: RealInput = port(default=0.0, unit="rad", doc="yaw angle of the platform, for the yaw control")

    rotor_speed: RealOutput = port(unit="rad/s", doc="rotor speed")
    generator_speed: RealOutput = port(unit="rad/s", doc="generator speed")
    blade_pitch: RealOutput = port(unit="rad", doc="blade pitch")
    generator_torque: RealOutput = port(unit="N*m", doc="generator torque")
    generator_power: RealOutput = port(unit="W", doc="electrical power")
    aero_power: RealOutput = port(unit="W", doc="aerodynamic power")
    thrust: RealOutput = port(unit="N", doc="rotor thrust")

    rotor: CoefficientRotor = part(CoefficientRotor)
    control: TurbineController = part(BaselineController)
    safety: SafetySystem = part(SafetySystem)
    gear: IdealGear = part(IdealGear, ratio=gear_ratio)
    generator: Generator = part(Generator, inertia=generator_inertia, efficiency=generator_efficiency)
    body: RigidBody = part(RigidBody, mass=mass, inertia=inertia, r_cm=centre_of_mass)

    def build(self):
        rotor, control, generator, safety = self.rotor, self.control, self.generator, self.safety
        for a, b in (
            (self.frame, rotor.frame), (rotor.shaft, self.gear.flange_b),
            (self.gear.flange_a, generator.shaft), *safety.around(control, generator.speed, self.yaw),
            (generator.speed, self.generator_speed), (safety.brake.torque, generator.brake),
            (safety.pitch.output, rotor.blade_pitch), (safety.pitch.output, self.blade_pitch),
            (safety.generator.output, generator.torque), (safety.generator.output, self.generator_torque),
            (generator.power, self.generator_power), (rotor.aero_power, self.aero_power), (rotor.thrust, self.thrust),
        ):  # fmt: skip
            self.connect(a, b)
        self.carry(self.frame, self.body)
        give_default(rotor, "downwind", self.downwind)
        give_default(rotor, "air_loads", self.air_loads)
        give_default(rotor, "w_start", self.rotor_speed_start)
        give_default(control, "pitch_start", self.blade_pitch_start * (1 - safety.idling))
        give_default(control, "speed_start", self.gear_ratio * self.rotor_speed_start)
        give_default(safety, "station", rotor.station)

    @property
    def carrier(self) -> tuple[Component, str]:
        return self, "frame"

    def drawing(self) -> Drawing:
        return [*outlines.housing(self.frame, self.rotor), *self.rotor.drawing()]

    def equations(self):
        return [eq(self.rotor_speed, self.rotor.w)]

    def steady_turbine(self) -> SteadyTurbine:
        """Rotor and controller as numbers, for steady operating points."""
        rotor = self.rotor
        if not isinstance(rotor, CoefficientRotor):
            raise unknown_start(self)
        table = rotor.coefficients
        sizes = {name: rotor.parameter_value(name) for name in ("radius", "precone", "tilt")}
        return SteadyTurbine(table, gear_ratio=self.parameter_value("gear_ratio"), **sizes, **controlled(self))
