"""A complete turbine above its tower: structure, air and controller."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache

import numpy as np

from fowtlib.components.aero import (
    BladeElementAerodynamics,
    BladeElementRotor,
    CoefficientTable,
    RotorSide,
    coefficient_table,
    node_points,
)
from fowtlib.components.environment.wind import Wind
from fowtlib.components.environment.world import World
from fowtlib.components.mechanics import Frame
from fowtlib.components.servo import BaselineController, SafetySystem, TurbineController
from fowtlib.components.turbine.operating_point import SteadyTurbine
from fowtlib.components.turbine.rotor_nacelle_assembly import RotorNacelleAssembly
from fowtlib.components.turbine.start import controlled, give_default, start_point
from fowtlib.language import Component, RealInput, RealOutput, Scalar, like, outer, param, part, port
from fowtlib.language.shapes import Drawing


def _start_of(name: str) -> Callable[[Turbine], float]:
    return lambda turbine: getattr(start_point(turbine, turbine.aerodynamics.station), name)


class Turbine(RotorSide):
    """A turbine above its tower: flexible or rigid blades in the wind by blade-element momentum theory, and control.

    Give the parts `assembly`, `aerodynamics` and `control` with their own parameters (`safety` offers shutdowns as
    events); blades, rotation and hub radius are those of the assembly. The simulation starts at the steady operating
    point in the mean wind of the rotor's station with unbent blades, unless start values are given; without wind,
    or without loads of the air, the rotor stands still.
    """

    air_loads: Scalar = like(BladeElementAerodynamics.air_loads)
    rotor_speed_start: Scalar = param(default=_start_of("rotor_speed"), unit="rad/s", doc="initial rotor speed")
    blade_pitch_start: Scalar = param(default=_start_of("blade_pitch"), unit="rad", doc="initial blade pitch")

    world: World = outer(World)
    wind: Wind = outer(Wind)
    frame: Frame = port(doc="tower top; x downwind, z up")
    yaw: RealInput = port(default=0.0, unit="rad", doc="yaw angle of the platform, for the yaw control")
    yaw_command: RealInput = port(unit="rad", default=0.0, doc="commanded yaw angle of the nacelle")

    rotor_speed: RealOutput = port(unit="rad/s", doc="rotor speed")
    azimuth: RealOutput = port(unit="rad", doc="azimuth of blade 1, 0 is up")
    generator_speed: RealOutput = port(unit="rad/s", doc="generator speed")
    blade_pitch: RealOutput = port(unit="rad", doc="commanded blade pitch")
    generator_torque: RealOutput = port(unit="N*m", doc="generator torque")
    generator_power: RealOutput = port(unit="W", doc="electrical power")
    aero_power: RealOutput = port(unit="W", doc="aerodynamic power")
    thrust: RealOutput = port(unit="N", doc="force of the air along the shaft")

    assembly: RotorNacelleAssembly = part(RotorNacelleAssembly)
    aerodynamics: BladeElementAerodynamics = part(BladeElementAerodynamics)
    control: TurbineController = part(BaselineController)
    safety: SafetySystem = part(SafetySystem)

    def build(self):
        body, air, control, safety = self.assembly, self.aerodynamics, self.control, self.safety
        air.blades, air.rotation, air.hub_radius = body.blades, body.rotation, float(body.hub.radius)
        body.node_points = node_points(air.rotor.blade, body.rotation)
        for a, b in (
            (self.frame, body.frame), (body.nacelle.hub, air.hub), (self.yaw_command, body.yaw_command),
            *safety.around(control, body.drivetrain.generator_speed, self.yaw),
            (body.drivetrain.generator_speed, self.generator_speed),
            (body.drivetrain.generator_power, self.generator_power), (body.nacelle.azimuth, self.azimuth),
            (body.nacelle.rotor_speed, self.rotor_speed), (safety.pitch.output, body.blade_pitch),
            (safety.pitch.output, self.blade_pitch), (safety.generator.output, body.generator_torque),
            (safety.generator.output, self.generator_torque), (safety.brake.torque, body.brake),
            (air.aero_power, self.aero_power), (air.thrust, self.thrust),
        ):  # fmt: skip
            self.connect(a, b)
        for k in range(body.n_nodes):
            self.connect(body.nodes[k], air.nodes[k])
        for component, name, value in (
            (body, "rotor_speed_start", self.rotor_speed_start), (body, "downwind", self.downwind),
            (control, "pitch_start", self.blade_pitch_start * (1 - safety.idling)),
            (control, "speed_start", body.drivetrain.gear_ratio * self.rotor_speed_start),
            (safety, "station", air.station), (air, "air_loads", self.air_loads),
        ):  # fmt: skip
            give_default(component, name, value)

    @property
    def carrier(self) -> tuple[Component, str]:
        """Behind the yaw drive, in front of the tilt."""
        return self.assembly.nacelle.tilted, "frame_a"

    def drawing(self) -> Drawing:
        """The parts of the assembly, its blades with the chord of the aerodynamics."""
        body, blade = self.assembly, self.aerodynamics.steady_rotor.blade
        ends = [blade.hub_radius, *blade.radius, blade.tip_radius] - np.float64(blade.hub_radius)
        chords = [blade.chord[0], *blade.chord, 0.3 * blade.chord[-1]]
        skins = [body.parts[f"blade_{k + 1}"].skin(ends, chords) for k in range(body.blades)]
        return [*body.nacelle.drawing(), *body.hub.drawing(), *(shape for skin in skins for shape in skin)]

    def steady_turbine(self, table: CoefficientTable | None = None) -> SteadyTurbine:
        """Rotor and controller as numbers, for steady operating points; the blades do not bend.

        table: coefficients of the rotor; without it a coarse table is computed.
        """
        body, rotor = self.assembly, self.aerodynamics.steady_rotor
        cone, tilt = body.hub.side * body.hub.parameter_value("precone"), body.nacelle.parameter_value("tilt")
        return SteadyTurbine(
            table=table or steady_table(rotor, cone), radius=rotor.blade.tip_radius, precone=cone, tilt=tilt,
            gear_ratio=body.drivetrain.parameter_value("gear_ratio"), **controlled(self),
        )  # fmt: skip


@lru_cache(maxsize=8)
def steady_table(rotor: BladeElementRotor, precone: float) -> CoefficientTable:
    """A coarse table of a rotor, for where a simulation starts."""
    ratios, pitches = np.linspace(2.0, 18.0, 33), np.radians(np.linspace(-2.0, 28.0, 16))
    return coefficient_table(rotor, ratios, pitches, precone=precone)
