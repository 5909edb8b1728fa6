"""Towers between a foundation or platform and the nacelle."""

from __future__ import annotations

import numpy as np

from fowtlib.components.mechanics import (
    Beam,
    FixedTranslation,
    RigidBody,
    TubeBeam,
    TwoFrames,
)
from fowtlib.components.mechanics.beam_properties import given_beam
from fowtlib.components.mechanics.beam_settings import BeamNodes, BeamSettings, BeamTable, WallMaterial
from fowtlib.components.mechanics.tube_beam import TUBE
from fowtlib.language import Array, RealOutput, Scalar, eq, param, port, shapes
from fowtlib.language import math as m
from fowtlib.language.errors import ParameterError


class Tower(TwoFrames, BeamNodes):
    """Partial: a tower from its base (frame_a) to its top (frame_b), z up, x fore-aft (downwind), y side-side (port).

    Moments are those of what is above on what is below the cut, resolved in the base frame for the base and in the top
    frame for the top: fore-aft about y (thrust makes it positive), side-side about x, torsion about z.
    """

    base_fore_aft_moment: RealOutput = port(unit="N*m", doc="moment at the base about y")
    base_side_side_moment: RealOutput = port(unit="N*m", doc="moment at the base about x")
    base_torsion: RealOutput = port(unit="N*m", doc="moment at the base about z")
    top_fore_aft_moment: RealOutput = port(unit="N*m", doc="moment at the top about y")
    top_side_side_moment: RealOutput = port(unit="N*m", doc="moment at the top about x")
    top_torsion: RealOutput = port(unit="N*m", doc="moment at the top about z")
    top_fore_aft_displacement: RealOutput = port(unit="m", doc="displacement of the top along x of the base")
    top_side_side_displacement: RealOutput = port(unit="m", doc="displacement of the top along y of the base")

    def loads(self, displacement):
        """The outputs; displacement (3) of the top in the axes of the base."""
        base = -self.frame_a.R.T @ self.frame_a.t
        top = self.frame_b.R.T @ self.frame_b.t
        return [
            [eq(self.base_side_side_moment, base[0]), eq(self.base_fore_aft_moment, base[1])],
            [eq(self.top_side_side_moment, top[0]), eq(self.top_fore_aft_moment, top[1])],
            [eq(self.base_torsion, base[2]), eq(self.top_torsion, top[2])],
            eq(self.top_fore_aft_displacement, displacement[0]),
            eq(self.top_side_side_displacement, displacement[1]),
        ]


def tube_or_table(component, heights, names="diameters and wall_thicknesses", **settings):
    """The Beam of a component with these settings: a TubeBeam where `heights` along it are given, or that of its table.

    Raises ParameterError where both are given, or neither, or what a table does not use.
    """
    has_table = bool(component.properties) or component.table is not None
    if np.size(heights):
        if has_table:
            raise ParameterError(f"{component.label}: give either properties, or {names}.")
        tube = {name: getattr(component, name) for name in TUBE if name != "heights"}
        try:
            return TubeBeam(heights=heights, **tube, **settings)
        except ParameterError as error:
            raise ParameterError(str(error).replace(TubeBeam.__name__, component.label, 1)) from None
    if has_table:
        source = "properties" if component.properties else "table"
        tube = [name for name in TUBE if name in component.parameters]
        component.refuse_unused(*tube, because=f"{source} is given (stiffness_factor scales what a table says)")
    return Beam(table=given_beam(component), **settings)


class FlexibleTower(Tower, BeamTable, WallMaterial, BeamSettings):
    """A tower as a chain of sprung hinges (see Beam), from a table or from the diameters and walls of a steel tube.

    Give `properties`, or `heights`, `diameters` and `wall_thicknesses`, linear between the heights, with the material.
    Moments at the cuts have the signs of the tower's, in axes that turn with it as it bends.
    Two hinges with `quadrature: loaded_tip` are within 0.4 % for the first two bending modes of the OC3 tower.
    """

    mode_names = {"*_x": "{part} fore-aft", "*_y": "{part} side-side", "*.twisting.*": "{part} torsion"}

    heights: Array = param(default=(), unit="m", doc="heights of the stations, base first")
    diameters: Array = param(default=(), unit="m", doc="outer diameters at the heights")
    wall_thicknesses: Array = param(default=(), unit="m", doc="wall thicknesses at the heights")
    damping_fore_aft: Scalar = param(default=0.03, unit="s", min=0, doc="damping over stiffness, fore-aft")
    damping_side_side: Scalar = param(default=damping_fore_aft, unit="s", min=0, doc="the same, side-side")

    cut_fore_aft_moment: RealOutput = port(size="n_cuts", unit="N*m", doc="moment at each cut about y")
    cut_side_side_moment: RealOutput = port(size="n_cuts", unit="N*m", doc="moment at each cut about x")
    cut_torsion: RealOutput = port(size="n_cuts", unit="N*m", doc="moment at each cut about the axis of the tower")

    def build(self):
        self.beam = tube_or_table(
            self, self.heights, "heights, diameters and wall_thicknesses",
            damping_x=self.damping_fore_aft, damping_y=self.damping_side_side, node_points=self.node_points,
            **self.values_of(BeamSettings),
        )  # fmt: skip
        self.connect(self.frame_a, self.beam.frame_a)
        self.connect(self.beam.frame_b, self.frame_b)
        for k in range(self.n_nodes):
            self.connect(self.beam.nodes[k], self.nodes[k])

    def equations(self):
        cuts = [-self.beam.cut_moment[k] for k in range(self.n_cuts)]
        return [
            self.loads(self.beam.deflection),
            [eq(self.cut_side_side_moment[k], cut[0]) for k, cut in enumerate(cuts)],
            [eq(self.cut_fore_aft_moment[k], cut[1]) for k, cut in enumerate(cuts)],
            [eq(self.cut_torsion[k], cut[2]) for k, cut in enumerate(cuts)],
        ]


class RigidTower(Tower):
    """A rigid tower: one body of given mass, centre and inertia. A table of properties: FlexibleTower with hinges 0."""

    height: Scalar = param(unit="m", min=0, doc="height of the top above the base")
    mass: Scalar = param(unit="kg", min=0, doc="mass")
    centre_of_mass: Scalar = param(unit="m", doc="height of the centre of mass above the base")
    inertia: Scalar = param(default=0.0, unit="kg*m^2", min=0, doc="inertia about the centre of mass, about x and y")
    axial_inertia: Scalar = param(default=0.0, unit="kg*m^2", min=0, doc="moment of inertia about z")

    def build(self):
        across, along = self.inertia, self.axial_inertia
        self.body = RigidBody(
            mass=self.mass, r_cm=(0, 0, self.centre_of_mass), inertia=((across, 0, 0), (0, across, 0), (0, 0, along))
        )
        self.rod = FixedTranslation(r=(0, 0, self.height))
        self.connect(self.frame_a, self.body.frame_a)
        self.connect(self.frame_a, self.rod.frame_a)
        self.connect(self.rod.frame_b, self.frame_b)
        for k, given in enumerate(self.node_points):
            point = given if isinstance(given, tuple | list) else (0, 0, given)
            link = self.add(f"to_node_{k + 1}", FixedTranslation(r=point))
            self.connect(self.frame_a, link.frame_a)
            self.connect(link.frame_b, self.nodes[k])

    def equations(self):
        return self.loads(m.zeros(3))

    def drawing(self) -> shapes.Drawing:
        """A tube with the mean diameter of a thin wall, from the inertia about its axis; a rod where that is zero."""
        height, mass, inertia = (self.parameter_value(name) for name in ("height", "mass", "axial_inertia"))
        diameter = 2 * (inertia / mass) ** 0.5 if inertia and mass else None
        return [shapes.Tube(self.frame_a, [(0, 0, 0), (0, 0, height)], diameter, material="tower")]
