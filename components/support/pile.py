"""Piles in soil: a tube from its toe to where a tower stands, with springs of the soil along it."""

from __future__ import annotations

import numpy as np

from fowtlib.components.mechanics import FreeMotion, TubeBeam
from fowtlib.components.mechanics.beam_settings import BeamSettings, WallMaterial
from fowtlib.components.mechanics.connectors import Frame
from fowtlib.components.mechanics.tube_beam import TUBE
from fowtlib.components.support.soil_springs import ClaySpring, LinearSoilSpring, SandSpring, SoilSpring
from fowtlib.language import Array, Number, RealOutput, Scalar, eq, like, param, port
from fowtlib.language import math as m
from fowtlib.language.bounds import POSITIVE
from fowtlib.language.errors import ParameterError


class Pile(WallMaterial):
    """Partial: an upright round pile in soil, a chain of sprung hinges (see Beam) with a spring in each equal piece.

    It stands in the ground by its springs alone: frame `ground` is the world's, `head` the top of the pile. Heights are
    above the still water level. The soil inside it has no mass, its toe no spring of its own, water around it no load.
    Bending moments are those of what is above on what is below, at the mudline. A subclass says which soil there is.
    Errors: a mudline that does not part the pile.
    """

    mode_names = {"*_x": "{part} fore-aft", "*_y": "{part} side-side", "*.twisting.*": "{part} torsion"}

    heights: Array = param(unit="m", doc="heights of the stations, toe first")
    diameters: Array = param(unit="m", min=POSITIVE, doc="outer diameters at the heights")
    wall_thicknesses: Array = param(unit="m", min=POSITIVE, doc="wall thicknesses at the heights")
    hinges: int = like(BeamSettings.hinges, default=10)
    quadrature: str = like(BeamSettings.quadrature, default="plain")
    torsion: bool = like(BeamSettings.torsion)
    stiffness_factor: Scalar = like(BeamSettings.stiffness_factor)
    damping_time: Scalar = param(default=0.0, unit="s", min=0, doc="damping over stiffness, of the pile")
    mudline: Number = param(unit="m", structural="springs lie below it", doc="height of the seabed")
    springs: int = param(default=10, min=1, doc="number of springs")
    axial_stiffness: Scalar = like(SoilSpring.axial_stiffness, default=5e8)
    torsional_stiffness: Scalar = like(SoilSpring.torsional_stiffness, default=5e8)
    soil_damping_time: Scalar = like(SoilSpring.damping_time)

    ground: Frame = port(doc="the ground: world.frame")
    head: Frame = port(doc="top of the pile; z up")
    mudline_fore_aft_moment: RealOutput = port(unit="N*m", doc="moment at the mudline about y")
    mudline_side_side_moment: RealOutput = port(unit="N*m", doc="moment at the mudline about x")
    mudline_displacement: RealOutput = port(unit="m", shape=(2,), doc="displacement of the pile at the mudline")

    def spring(self, depth: float, diameter: float, **others) -> SoilSpring:
        """The spring of a piece at this depth below the mudline [m], where the pile has this diameter [m]."""
        raise NotImplementedError

    def build(self):
        heights = np.ravel(self.parameter_value("heights"))
        toe, top, mudline = float(heights[0]), float(heights[-1]), float(self.parameter_value("mudline"))
        if not toe < mudline <= top:
            raise ParameterError(
                f"{self.label}: it goes from {toe:g} m to {top:g} m; the mudline, at {mudline:g} m, must lie between."
            )
        length = (mudline - toe) / self.springs
        places = [toe + (k + 0.5) * length for k in range(self.springs)]
        self.motion = FreeMotion(heave_start=toe)
        self.beam = TubeBeam(
            **{name: getattr(self, name) for name in (*TUBE, "hinges", "quadrature", "torsion", "stiffness_factor")},
            damping_x=self.damping_time, cuts=[mudline - toe], node_points=[*(z - toe for z in places), mudline - toe],
        )  # fmt: skip
        for a, b in ((self.ground, self.motion.frame_a), (self.motion.frame_b, self.beam.frame_a),
                     (self.beam.frame_b, self.head)):  # fmt: skip
            self.connect(a, b)
        diameters = np.ravel(self.parameter_value("diameters"))
        for k, z in enumerate(places):
            soil = self.add(f"soil_{k + 1}", self.spring(
                mudline - z, float(np.interp(z, heights, diameters)), place=(0, 0, z), length=length,
                axial_stiffness=self.axial_stiffness, torsional_stiffness=self.torsional_stiffness,
                damping_time=self.soil_damping_time,
            ))  # fmt: skip
            self.connect(self.beam.nodes[k], soil.frame)

    def equations(self):
        cut, there = -self.beam.cut_moment[0], self.beam.nodes[self.springs].r
        return [
            [eq(self.mudline_side_side_moment, cut[0]), eq(self.mudline_fore_aft_moment, cut[1])],
            eq(self.mudline_displacement, m.vertcat(there[0], there[1])),
        ]


class PileInLinearSoil(Pile):
    """A pile in soil with one lateral stiffness, or one that grows with the depth, Winkler's; see Pile."""

    lateral_stiffness: Scalar = like(LinearSoilSpring.lateral_stiffness, default=0.0, doc="at the mudline")
    stiffness_gradient: Scalar = param(default=0.0, unit="N/m^3", min=0, doc="its growth with the depth")

    def spring(self, depth, diameter, **others):
        return LinearSoilSpring(lateral_stiffness=self.lateral_stiffness + self.stiffness_gradient * depth, **others)


class PileInSand(Pile):
    """A pile in sand of one friction angle; see Pile and SandSpring."""

    friction_angle: Scalar = like(SandSpring.friction_angle)
    unit_weight: Scalar = like(SandSpring.unit_weight, default=1e4)
    modulus_gradient: Scalar = like(SandSpring.modulus_gradient)
    cyclic: bool = like(SandSpring.cyclic)

    def spring(self, depth, diameter, **others):
        return SandSpring(
            depth=depth, diameter=diameter, friction_angle=self.friction_angle, unit_weight=self.unit_weight,
            modulus_gradient=self.modulus_gradient, cyclic=self.cyclic, **others,
        )  # fmt: skip


class PileInClay(Pile):
    """A pile in clay whose strength is one at the mudline and grows with the depth; see Pile and ClaySpring."""

    shear_strength: Scalar = like(ClaySpring.shear_strength, doc="undrained shear strength at the mudline")
    strength_gradient: Scalar = param(default=0.0, unit="Pa/m", min=0, doc="its growth with the depth")
    unit_weight: Scalar = like(ClaySpring.unit_weight, default=8e3)
    strain_50: Scalar = like(ClaySpring.strain_50)
    shape: Scalar = like(ClaySpring.shape)
    initial_stiffness: Scalar = like(ClaySpring.initial_stiffness)

    def spring(self, depth, diameter, **others):
        return ClaySpring(
            depth=depth, diameter=diameter, shear_strength=self.shear_strength + self.strength_gradient * depth,
            unit_weight=self.unit_weight, strain_50=self.strain_50, shape=self.shape,
            initial_stiffness=self.initial_stiffness, **others,
        )  # fmt: skip
