"""Rotor, nacelle and drive train of a turbine with flexible blades, on a tower top."""

from __future__ import annotations

from fowtlib.components.aero import RotorSide
from fowtlib.components.mechanics import Frame
from fowtlib.components.mechanics.beam_properties import BeamProperties
from fowtlib.components.turbine.blade import BladeDamping, FlexibleBlade
from fowtlib.components.turbine.hub import Hub
from fowtlib.components.turbine.nacelle import Drivetrain, Nacelle
from fowtlib.components.turbine.start import give_default
from fowtlib.language import (
    Array,
    Data,
    RealInput,
    RealOutput,
    Scalar,
    cyclic_symmetry,
    eq,
    like,
    param,
    part,
    parts,
    port,
)
from fowtlib.language import math as m


class RotorNacelleAssembly(RotorSide, BladeDamping):
    """Nacelle, drive train, hub and blades, structure and drives only: loads come through `nodes`, torque by signal.

    Give the parts `nacelle`, `hub` and `drivetrain` with their own parameters, and the blades by their table. Moments
    at the blade roots: see FlexibleBlade, in the pitched axes. Tip displacements are resolved in the coned axes that do
    not pitch: out_of_plane is positive downwind, in_plane positive against the sense of rotation (towards the trailing
    edge). Nodes come blade by blade: nodes[k * nodes_per_blade + i].
    """

    blades: int = like(Hub.blades)
    rotation: int = like(Hub.rotation)
    blade_properties: Data[BeamProperties] = like(FlexibleBlade.properties)
    blade_table: object = like(FlexibleBlade.table)
    blade_hinges: int = like(FlexibleBlade.hinges)
    blade_quadrature: str = like(FlexibleBlade.quadrature)
    blade_torsion: bool = like(FlexibleBlade.torsion)
    blade_cuts: Array = like(FlexibleBlade.cuts)
    node_points: list = like(FlexibleBlade.node_points, doc="aerodynamic nodes of a blade, see BeamNodes")
    n_nodes: int = param(default=lambda self: self.blades * len(self.node_points), min=0, doc="nodes of all blades")
    rotor_speed_start: Scalar = param(default=0.0, unit="rad/s", doc="initial rotor speed")

    frame: Frame = port(doc="tower top; x downwind, z up")
    nodes: Frame = port(size="n_nodes", optional=True, doc="frames of the aerodynamic nodes, blade by blade")
    blade_pitch: RealInput = port(unit="rad", default=0.0, doc="commanded pitch of all blades")
    individual_pitch: RealInput = port(size="blades", unit="rad", default=0.0, doc="to be added for each blade")
    generator_torque: RealInput = port(unit="N*m", default=0.0, doc="electromagnetic torque")
    brake: RealInput = port(unit="N*m", default=0.0, doc="torque of a brake on the high speed shaft")
    yaw_command: RealInput = port(unit="rad", default=0.0, doc="commanded yaw angle of the nacelle")
    pitch_demand: RealOutput = port(size="blades", unit="rad", doc="commanded pitch of each blade")
    out_of_plane: RealOutput = port(size="blades", unit="m", doc="displacement of each tip, downwind")
    in_plane: RealOutput = port(size="blades", unit="m", doc="displacement of each tip, against the rotation")

    nacelle: Nacelle = part(Nacelle)
    drivetrain: Drivetrain = part(Drivetrain)
    hub: Hub = part(Hub)
    rotor_blades: list[FlexibleBlade] = parts(
        FlexibleBlade, size="blades", name="blade", properties=blade_properties, table=blade_table, hinges=blade_hinges,
        cuts=blade_cuts, quadrature=blade_quadrature, torsion=blade_torsion,
        node_points=node_points, mirrored=lambda self: self.rotation < 0,
        each=lambda self, k: self.values_of(BladeDamping),
    )  # fmt: skip

    def build(self):
        for component, names in (
            (self.nacelle, ("rotation", "rotor_speed_start", "downwind")), (self.drivetrain, ("rotor_speed_start",)),
            (self.hub, ("rotation", "blades", "downwind")),
        ):  # fmt: skip
            for name in names:
                give_default(component, name, getattr(self, name))
        for a, b in (
            (self.frame, self.nacelle.frame_a), (self.nacelle.hub, self.hub.frame),
            (self.nacelle.shaft, self.drivetrain.shaft), (self.yaw_command, self.nacelle.yaw_command),
            (self.generator_torque, self.drivetrain.generator_torque), (self.brake, self.drivetrain.brake),
        ):  # fmt: skip
            self.connect(a, b)
        for k, blade in enumerate(self.rotor_blades):
            self.connect(self.hub.roots[k], blade.frame_a)
            self.connect(self.pitch_demand[k], self.hub.pitch_command[k])
            for i in range(len(self.node_points)):
                self.connect(blade.nodes[i], self.nodes[k * len(self.node_points) + i])

    def equations(self):
        return [
            *(_of_blade(self, k) for k in range(self.blades)),
            cyclic_symmetry(self.nacelle.azimuth, self.rotor_blades),
            cyclic_symmetry(self.nacelle.azimuth, self.hub.bearings),
        ]


def _of_blade(turbine, k):
    """Pitch demand and tip displacement of blade k, whose axes pitch, resolved in axes that do not."""
    tip, pitch = turbine.rotor_blades[k].tip_deflection, turbine.hub.pitch[k]
    s, c = turbine.rotation * m.sin(pitch), m.cos(pitch)
    return [
        eq(turbine.pitch_demand[k], turbine.blade_pitch + turbine.individual_pitch[k]),
        eq(turbine.out_of_plane[k], c * tip[0] + s * tip[1]),
        eq(turbine.in_plane[k], turbine.rotation * (c * tip[1] - s * tip[0])),
    ]
