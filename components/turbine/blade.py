"""Blades on their root frames: flexible and rigid."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from fowtlib.components.aero import outlines
from fowtlib.components.mechanics import Beam, BeamProperties, FixedTranslation, Frame, RigidBody
from fowtlib.components.mechanics.beam import bodies
from fowtlib.components.mechanics.beam_properties import given_beam
from fowtlib.components.mechanics.beam_settings import BeamNodes, BeamSettings, BeamTable
from fowtlib.language import Component, RealOutput, Scalar, eq, like, param, port, shapes
from fowtlib.language import math as m

_mirrored = lru_cache(maxsize=8)(BeamProperties.mirrored)  # the same object for the same blade


class Blade(BeamNodes):
    """Partial: a blade with its root and nodes.

    Axes of the root: z along the pitch axis to the tip, x flapwise and y edgewise at zero twist: for a rotor that turns
    clockwise, seen from upwind, at zero pitch x points downwind and y to the trailing edge.
    """

    frame_a: Frame = port(doc="blade root, turned by the pitch bearing")
    flapwise_moment: RealOutput = port(unit="N*m", doc="root moment about y: positive bends the blade downwind")
    edgewise_moment: RealOutput = port(unit="N*m", doc="root moment about x: positive bends the blade to -y")
    pitching_moment: RealOutput = port(unit="N*m", doc="root moment about z")
    tip_deflection: RealOutput = port(unit="m", shape=(3,), doc="displacement of the tip, resolved in the root frame")


class BladeDamping(Component):
    """Partial: the damping of a flexible blade."""

    damping_flapwise: Scalar = param(default=0.003, unit="s", min=0, doc="damping over stiffness, flapwise")
    damping_edgewise: Scalar = param(default=damping_flapwise, unit="s", min=0, doc="damping over stiffness, edgewise")


class FlexibleBlade(Blade, BeamTable, BeamSettings, BladeDamping):
    """A blade as a chain of sprung hinges, see Beam.

    The root moments are what the loads outboard do to the root: the moment of the blade on the hub, resolved in the
    pitched root frame. Those of the cuts are the same farther out, in axes that turn with the blade as it bends, but
    not with its structural twist. Data: a CSV as models/data/nrel5mw/blade_structure.csv.
    """

    mode_names = {"*_x": "blade flap", "*_y": "blade edge", "*.twisting.*": "blade torsion"}

    hinges: int = like(BeamSettings.hinges, default=6)
    mirrored: bool = param(default=False, doc="mirror image, for a rotor that turns counter-clockwise")
    quadrature: str = like(BeamSettings.quadrature, default="free_tip")

    cut_flapwise_moment: RealOutput = port(size="n_cuts", unit="N*m", doc="moment at each cut about y")
    cut_edgewise_moment: RealOutput = port(size="n_cuts", unit="N*m", doc="moment at each cut about x")
    cut_pitching_moment: RealOutput = port(size="n_cuts", unit="N*m", doc="moment at each cut about z")

    def build(self):
        table = given_beam(self)
        self.beam = Beam(
            table=_mirrored(table) if self.mirrored else table, damping_x=self.damping_flapwise,
            damping_y=self.damping_edgewise, node_points=self.node_points, **self.values_of(BeamSettings),
        )  # fmt: skip
        self.connect(self.frame_a, self.beam.frame_a)
        self.connect(self.beam.deflection, self.tip_deflection)
        for k in range(self.n_nodes):
            self.connect(self.beam.nodes[k], self.nodes[k])

    def drawing(self) -> shapes.Drawing:
        return self.skin()

    def skin(self, stations=None, chords=None):
        """What pictures show; sizes follow from the inertia of the sections, unless the chord [m] is known at stations.

        stations (n,): distance from the root [m].
        """
        sense, skins = -1 if self.mirrored else 1, []
        for frame, axis, s, thickness, estimate in bodies(self.beam):
            chord = estimate if chords is None else np.interp(s, stations, chords)
            twist = sense * self.beam.table.at("twist", s)
            sections = outlines.blade_sections(axis, chord, thickness, twist, sense)
            skins.append(shapes.Loft(frame, sections, closed=self.hinges == 0, material="blade"))
        return skins

    def equations(self):
        moment = -self.beam.root_moment
        cuts = [-self.beam.cut_moment[k] for k in range(self.n_cuts)]
        return [
            [eq(self.edgewise_moment, moment[0]), eq(self.flapwise_moment, moment[1])],
            eq(self.pitching_moment, moment[2]),
            [eq(self.cut_edgewise_moment[k], cut[0]) for k, cut in enumerate(cuts)],
            [eq(self.cut_flapwise_moment[k], cut[1]) for k, cut in enumerate(cuts)],
            [eq(self.cut_pitching_moment[k], cut[2]) for k, cut in enumerate(cuts)],
        ]


class RigidBlade(Blade):
    """A rigid blade from mass, centre of mass along its axis, and inertia about the root across the axis.

    The inertia about the centre of mass follows from the parallel axis theorem.
    """

    mass: Scalar = param(unit="kg", min=0, doc="mass")
    centre_of_mass: Scalar = param(unit="m", doc="distance of the centre of mass from the root, along z")
    inertia: Scalar = param(unit="kg*m^2", min=0, doc="moment of inertia about the root, across the axis")

    def build(self):
        across = self.inertia - self.mass * self.centre_of_mass**2
        self.body = RigidBody(
            mass=self.mass, r_cm=(0, 0, self.centre_of_mass), inertia=((across, 0, 0), (0, across, 0), (0, 0, 0))
        )
        self.connect(self.frame_a, self.body.frame_a)
        for k, given in enumerate(self.node_points):
            link = self.add(f"to_node_{k + 1}", FixedTranslation(r=(0, 0, given) if np.ndim(given) == 0 else given))
            self.connect(self.frame_a, link.frame_a)
            self.connect(link.frame_b, self.nodes[k])

    def drawing(self) -> shapes.Drawing:
        """The skin of a typical blade, to the outermost node, else thrice as long as to the centre of mass."""
        given = [float(point if np.ndim(point) == 0 else point[2]) for point in self.node_points]
        length = max([*given, 0.0]) or 3 * self.parameter_value("centre_of_mass")
        return [shapes.Loft(self.frame_a, outlines.typical_blade(0.0, length), material="blade")] if length > 0 else []

    def equations(self):
        moment = -self.frame_a.R.T @ self.frame_a.t
        return [eq(self.edgewise_moment, moment[0]), eq(self.flapwise_moment, moment[1]),
                eq(self.pitching_moment, moment[2]), eq(self.tip_deflection, m.zeros(3))]  # fmt: skip
