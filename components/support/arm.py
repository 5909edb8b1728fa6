"""Arms that carry rotors off the axis of a tower."""

from __future__ import annotations

import numpy as np

from fowtlib.components.mechanics import BeamTurn, FixedTranslation, Frame
from fowtlib.components.mechanics.beam_settings import BeamCuts, BeamSettings, BeamTable, WallMaterial
from fowtlib.components.support.tower import tube_or_table
from fowtlib.language import Array, Number, RealOutput, Scalar, Vector, eq, param, port
from fowtlib.language import math as m
from fowtlib.language.errors import ParameterError


class ArmLoads(BeamCuts):
    """Partial: frames, places and loads of an arm; see Arm for the signs."""

    node_distances: Array = param(
        default=(), unit="m", structural="it says which segment carries each frame",
        doc="frames along the arm: distance from the root of the tube"
    )  # fmt: skip
    n_nodes: int = param(default=lambda self: len(self.node_distances), min=0, doc="number of those frames")

    frame_a: Frame = port(doc="on the axis of the tower")
    tip: Frame = port(doc="end of the arm, where a nacelle stands; parallel to frame_a while the arm is straight")
    nodes: Frame = port(size="n_nodes", optional=True, doc="frames along the arm, parallel to those of the beam")
    root_vertical_moment: RealOutput = port(unit="N*m", doc="vertical bending at the root of the tube")
    root_horizontal_moment: RealOutput = port(unit="N*m", doc="horizontal bending at the root of the tube")
    root_torsion: RealOutput = port(unit="N*m", doc="torsion at the root of the tube")
    cut_vertical_moment: RealOutput = port(size="n_cuts", unit="N*m", doc="vertical bending at each cut")
    cut_horizontal_moment: RealOutput = port(size="n_cuts", unit="N*m", doc="horizontal bending at each cut")
    cut_torsion: RealOutput = port(size="n_cuts", unit="N*m", doc="torsion at each cut")
    tip_displacement: RealOutput = port(unit="m", shape=(3,), doc="displacement of the tip, in the axes of frame_a")

    def loads(self, beam, side):
        """The moments, from those of the beam in its axes; side as arm_axes gives it."""
        root, cuts = -beam.root_moment, [-beam.cut_moment[k] for k in range(self.n_cuts)]
        return [
            [eq(self.root_vertical_moment, -side * root[0]), eq(self.root_horizontal_moment, root[1])],
            eq(self.root_torsion, side * root[2]),
            [eq(self.cut_vertical_moment[k], -side * cut[0]) for k, cut in enumerate(cuts)],
            [eq(self.cut_horizontal_moment[k], cut[1]) for k, cut in enumerate(cuts)],
            [eq(self.cut_torsion[k], side * cut[2]) for k, cut in enumerate(cuts)],
        ]


class Arm(ArmLoads, BeamTable, WallMaterial, BeamSettings):
    """A flexible arm from a tower to a rotor, see Beam: a round tube that tapers, or a table (x horizontal).

    frame_a is on the axis of the tower; the arm is rigid up to `root_radius`, where the tube begins. frame_a, the tip
    and the nodes are parallel while the arm is straight: x downwind, z up. Loads are those of what is outboard on the
    root, and at the cuts, in axes that turn with the bending arm: vertical bending is positive where it bends the tip
    down, horizontal bending to the horizontal normal that points downwind (of an arm along x: to port), torsion about
    the arm, in the sense of a thrust above it. Thus arms to both sides have equal loads under equal weight and thrust.
    """

    mode_names = {"*_x": "arm horizontal", "*_y": "arm vertical", "*.twisting.*": "arm torsion"}

    to: Vector = param(
        unit="m", structural="the axes of the beam follow from it", doc="the tip, from frame_a, resolved in frame_a"
    )
    root_radius: Number = param(default=0.0, unit="m", min=0, doc="where the tube begins, from frame_a along the arm")
    diameters: Array = param(
        default=(), unit="m", doc="outer diameters at equal distances from root to tip, linear between"
    )
    wall_thicknesses: Array = param(default=(), unit="m", doc="wall thicknesses at the same places")
    damping_horizontal: Scalar = param(default=0.003, unit="s", min=0, doc="damping over stiffness, horizontal")
    damping_vertical: Scalar = param(default=damping_horizontal, unit="s", min=0, doc="the same, vertical")

    def build(self):
        to, (axes, _), length = np.ravel(self.to), arm_axes(self), arm_length(self)
        stations = np.linspace(0, length, np.size(self.parameter_value("diameters")))
        self.root = FixedTranslation(r=tuple(to * self.root_radius / np.linalg.norm(to)))
        self.turn, self.turn_back = BeamTurn(axes=axes), BeamTurn(axes=axes.T)
        self.beam = tube_or_table(
            self, stations, damping_x=self.damping_horizontal, damping_y=self.damping_vertical,
            node_points=self.node_distances, **self.values_of(BeamSettings),
        )  # fmt: skip
        if not len(stations) and abs(self.beam.table.length - length) > 1e-6 * length:
            raise ParameterError(
                f"{self.label}: the properties are those of {self.beam.table.length:g} m, the arm is {length:g} m long "
                "(from root_radius to the tip)."
            )
        for a, b in (
            (self.frame_a, self.root.frame_a), (self.root.frame_b, self.turn.frame_a),
            (self.turn.frame_b, self.beam.frame_a), (self.beam.frame_b, self.turn_back.frame_a),
            (self.turn_back.frame_b, self.tip),
            *((self.beam.nodes[k], self.nodes[k]) for k in range(self.n_nodes)),
        ):  # fmt: skip
            self.connect(a, b)

    def equations(self):
        axes, side = arm_axes(self)
        return [self.loads(self.beam, side), eq(self.tip_displacement, m.mtimes(axes, self.beam.deflection))]


def arm_length(arm: Arm) -> float:
    """Length of the tube [m]. Raises ParameterError where the root lies beyond the tip."""
    length = float(np.linalg.norm(np.ravel(arm.to))) - arm.root_radius
    if length <= 0:
        raise ParameterError(f"{arm.label}: the root, at {arm.root_radius:g} m, must lie before the tip.")
    return length


def arm_axes(arm: Arm) -> tuple[np.ndarray, int]:
    """Axes of the beam in frame_a (columns: horizontal normal, z x that, along the arm), and 1 for an arm to port.

    1 means that the arm points along (up x normal), as an arm to port does, -1 that it points the other way.
    Raises ParameterError for a vertical arm.
    """
    along = np.ravel(arm.to) / np.linalg.norm(np.ravel(arm.to))
    normal = np.cross(along, (0.0, 0.0, 1.0))
    if np.linalg.norm(normal) < 1e-6:
        raise ParameterError(f"{arm.label}: an arm that points along z has no horizontal normal; use a FlexibleTower.")
    normal /= np.linalg.norm(normal)
    side = 1 if normal[0] > 1e-9 or (abs(normal[0]) <= 1e-9 and normal[1] > 0) else -1
    return np.column_stack([side * normal, np.cross(along, side * normal), along]), side
