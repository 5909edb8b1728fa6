"""The flexible beam: a chain of rigid segments and sprung hinges, under any large motion of its root."""

from __future__ import annotations

import math

import numpy as np

from fowtlib.components.mechanics.beam_division import divide, elastic_axis, pieces, section_axes
from fowtlib.components.mechanics.beam_properties import given_beam
from fowtlib.components.mechanics.beam_settings import BeamNodes, BeamSettings, BeamTable
from fowtlib.components.mechanics.bodies import FixedTranslation, RigidBody
from fowtlib.components.mechanics.interfaces import TwoFrames
from fowtlib.components.mechanics.rotations import axis_rotation, unit_axis
from fowtlib.components.mechanics.sensors import LoadSensor
from fowtlib.language import (
    Matrix,
    RealOutput,
    Scalar,
    Vector,
    der,
    eq,
    like,
    param,
    port,
    rotation,
    shapes,
    var,
)
from fowtlib.language import math as m
from fowtlib.language.errors import ParameterError


class BeamSegment(RigidBody):
    """Rigid piece of a beam: a RigidBody whose numbers are fixed when the model is built.

    Zeros of the centre of mass and of the inertia drop out of the equations then, of which a blade has many.
    """

    inertia: Matrix = param(
        unit="kg*m^2", structural="a number of a table", doc="inertia tensor about the centre of mass, in frame_a"
    )
    r_cm: Vector = param(
        default=(0, 0, 0), unit="m", structural="a number of a table", doc="centre of mass, resolved in frame_a"
    )


class BeamLink(FixedTranslation):
    """Rigid distance along a beam: a FixedTranslation whose numbers are fixed when the model is built."""

    r: Vector = param(unit="m", structural="a number of a table", doc="from frame_a to frame_b, resolved in frame_a")


class BeamTurn(TwoFrames):
    """Fixed turn into the axes of a beam, or out of them; both frames keep the same origin."""

    axes: Matrix = param(
        structural="its zeros drop out of the equations", doc="columns: axes of frame_b, resolved in frame_a"
    )

    def start_rotation(self, command):
        return np.asarray(self.axes, dtype=float)

    def equations(self):
        a, b = self.frame_a, self.frame_b
        return [eq(b.r, a.r), rotation(a, b, np.asarray(self.axes, dtype=float), m.zeros(3)), self.transmit()]


class BendingHinge(TwoFrames):
    """Sprung hinge with two axes, the bending of one piece of a beam; both frames keep the same origin.

    frame_b turns by phi_x about axis_x, then by phi_y about axis_y, which has turned with it. The springs give
    stiffness phi + damping dphi/dt about the axes: EI / l for a piece of length l.
    Reference: Miller, Soares, Van Weddingen, Wendlandt (2017), Modeling flexible bodies with Simscape Multibody.
    """

    axis_x: Vector = param(
        default=(0, 1, 0),
        structural="its zeros drop out of the equations",
        doc="first axis, in frame_a: bends z towards x",
    )
    axis_y: Vector = param(
        default=(-1, 0, 0),
        structural="its zeros drop out of the equations",
        doc="second axis, in frame_a: bends z towards y",
    )
    stiffness_x: Scalar = param(unit="N*m/rad", min=0, doc="stiffness about the first axis")
    stiffness_y: Scalar = param(unit="N*m/rad", min=0, doc="stiffness about the second axis")
    damping_x: Scalar = param(default=0.0, unit="N*m*s/rad", min=0, doc="damping about the first axis")
    damping_y: Scalar = param(default=0.0, unit="N*m*s/rad", min=0, doc="damping about the second axis")
    phi_x_start: Scalar = param(default=0.0, unit="rad", doc="initial phi_x")
    phi_y_start: Scalar = param(default=0.0, unit="rad", doc="initial phi_y")

    phi_x: Scalar = var(unit="rad", start=phi_x_start, state="prefer", doc="angle about the first axis")
    phi_y: Scalar = var(unit="rad", start=phi_y_start, state="prefer", doc="angle about the second axis")
    w_x: Scalar = var(unit="rad/s", state="prefer", doc="rate of phi_x", hint="has the beam mass on both sides?")
    w_y: Scalar = var(unit="rad/s", state="prefer", doc="rate of phi_y", hint="has the beam mass on both sides?")
    a_x: Scalar = var(unit="rad/s^2", doc="second derivative of phi_x")
    a_y: Scalar = var(unit="rad/s^2", doc="second derivative of phi_y")

    def start_rotation(self, command):
        return np.eye(3)

    def equations(self):
        a, b, x, y = self.frame_a, self.frame_b, unit_axis(self.axis_x), unit_axis(self.axis_y)
        first = axis_rotation(x, self.phi_x)
        turned, moment = first @ y, a.R.T @ b.t
        return [
            [eq(der(self.phi_x), self.w_x), eq(der(self.phi_y), self.w_y)],
            [eq(der(self.w_x), self.a_x), eq(der(self.w_y), self.a_y)],
            eq(b.r, a.r),
            rotation(a, b, first @ axis_rotation(y, self.phi_y), x * self.w_x + turned * self.w_y),
            eq(self.stiffness_x * self.phi_x + self.damping_x * self.w_x, m.dot(x, moment)),
            eq(self.stiffness_y * self.phi_y + self.damping_y * self.w_y, m.dot(turned, moment)),
            self.transmit(),
        ]


class TorsionHinge(TwoFrames):
    """Sprung hinge about one axis, the torsion of one piece of a beam: GJ / l."""

    n: Vector = param(
        default=(0, 0, 1), structural="its zeros drop out of the equations", doc="axis, resolved in frame_a"
    )
    stiffness: Scalar = param(unit="N*m/rad", min=0, doc="stiffness")
    damping: Scalar = param(default=0.0, unit="N*m*s/rad", min=0, doc="damping")

    phi: Scalar = var(unit="rad", state="prefer", doc="angle")
    w: Scalar = var(unit="rad/s", state="prefer", doc="rate", hint="has the beam a rotary inertia?")
    a: Scalar = var(unit="rad/s^2", doc="angular acceleration")

    def start_rotation(self, command):
        return np.eye(3)

    def equations(self):
        a, b, n = self.frame_a, self.frame_b, unit_axis(self.n)
        return [
            [eq(der(self.phi), self.w), eq(der(self.w), self.a)],
            eq(b.r, a.r),
            rotation(a, b, axis_rotation(n, self.phi), n * self.w),
            eq(self.stiffness * self.phi + self.damping * self.w, m.dot(a.R @ n, b.t)),
            self.transmit(),
        ]


class AxialSpring(TwoFrames):
    """Sprung slide along one axis, the stretch of one piece of a beam: EA / l."""

    n: Vector = param(
        default=(0, 0, 1), structural="its zeros drop out of the equations", doc="axis, resolved in frame_a"
    )
    stiffness: Scalar = param(unit="N/m", min=0, doc="stiffness")
    damping: Scalar = param(default=0.0, unit="N*s/m", min=0, doc="damping")

    s: Scalar = var(unit="m", state="prefer", doc="stretch")
    v: Scalar = var(unit="m/s", state="prefer", doc="rate", hint="has the beam mass on both sides?")
    a: Scalar = var(unit="m/s^2", doc="second derivative of the stretch")

    def start_rotation(self, command):
        return np.eye(3)

    def equations(self):
        a, b, n = self.frame_a, self.frame_b, unit_axis(self.n)
        along = a.R @ n
        return [
            [eq(der(self.s), self.v), eq(der(self.v), self.a)],
            eq(b.r, a.r + along * self.s),
            rotation(a, b, m.eye(3), m.zeros(3)),
            eq(self.stiffness * self.s + self.damping * self.v, m.dot(along, b.f)),
            self.transmit(along * self.s),
        ]


class BeamHinge(TwoFrames):
    """The elastic joint of one piece of a beam: bending, then torsion and stretch where wanted.

    axes: columns x', y', z' of the section in frame_a. Stiffnesses are those of the piece (EI / l, GJ / l, EA / l).
    """

    axes: Matrix = param(
        default=np.eye(3),
        structural="its zeros drop out of the equations",
        doc="columns: principal axes and tangent, in frame_a",
    )
    torsion: bool = param(default=False, doc="with a torsion hinge")
    stretch: bool = param(default=False, doc="with an axial spring")
    stiffness_x: Scalar = param(unit="N*m/rad", min=0, doc="stiffness of bending towards x'")
    stiffness_y: Scalar = param(unit="N*m/rad", min=0, doc="stiffness of bending towards y'")
    torsional_stiffness: Scalar = param(default=0.0, unit="N*m/rad", min=0, doc="stiffness of torsion")
    axial_stiffness: Scalar = param(default=0.0, unit="N/m", min=0, doc="stiffness of the axis")
    damping_x: Scalar = param(default=0.0, unit="s", min=0, doc="damping over stiffness, bending towards x'")
    damping_y: Scalar = param(default=0.0, unit="s", min=0, doc="damping over stiffness, bending towards y'")
    damping: Scalar = param(default=0.0, unit="s", min=0, doc="damping over stiffness, torsion and stretch")

    def build(self):
        x, y, z = np.asarray(self.axes, dtype=float).T
        self.bending = BendingHinge(
            axis_x=y, axis_y=-x, stiffness_x=self.stiffness_x, stiffness_y=self.stiffness_y,
            damping_x=self.damping_x * self.stiffness_x, damping_y=self.damping_y * self.stiffness_y,
        )  # fmt: skip
        if self.torsion:
            k = self.torsional_stiffness
            self.twisting = TorsionHinge(n=z, stiffness=k, damping=self.damping * k)
        if self.stretch:
            k = self.axial_stiffness
            self.stretching = AxialSpring(n=z, stiffness=k, damping=self.damping * k)
        frame = self.frame_a
        for part in list(self.parts.values()):
            self.connect(frame, part.frame_a)
            frame = part.frame_b
        self.connect(frame, self.frame_b)


class Beam(TwoFrames, BeamTable, BeamSettings, BeamNodes):
    """Slender beam along z of frame_a, as `hinges` sprung hinges between rigid segments.

    The chain of the generalized beam element: each piece is two rigid bodies about a hinge with the stiffness EI / l;
    bodies that meet between two hinges are one segment here. Bending in two directions, torsion and stretch as options.
    `quadrature` places the hinges: "plain" in the middle of equal pieces, as that chain does; the others at Gauss
    points (see beam_division), where few hinges converge. Mass, centre and inertia are exact for any number of hinges.
    Rotation, weight and follower loads stiffen or soften the beam by themselves, because the motion of the segments is
    exact; a segment is as long as between two hinges, so shortening by bending is that of the polygon.
    Damping is proportional to stiffness, damping ratio = pi frequency damping. All frames along the beam are parallel
    to frame_a while it is undeflected: the structural twist turns the axes of the hinges, not the frames.
    A cut parts the rigid segment in which it lies, so its loads hold the weight and the inertia of all that is beyond;
    a node at the place of a cut belongs to its root side. hinges = 0 makes the beam rigid.
    """

    hinges: int = like(BeamSettings.hinges, default=6)
    stretch: bool = param(default=False, doc="axial springs")
    damping_x: Scalar = param(default=0.0, unit="s", min=0, doc="damping over stiffness, bending towards x")
    damping_y: Scalar = param(default=damping_x, unit="s", min=0, doc="damping over stiffness, bending towards y")
    damping: Scalar = param(default=damping_x, unit="s", min=0, doc="damping over stiffness, torsion and stretch")
    cut_axes: str = param(
        default="segment", choices=("segment", "section"),
        doc="axes of the loads of a cut, turning with the beam: parallel to frame_a while undeflected, or the "
        "principal axes of the section (structural twist) and the tangent",
    )  # fmt: skip

    deflection: RealOutput = port(unit="m", shape=(3,), doc="displacement of frame_b, resolved in frame_a")
    root_force: RealOutput = port(unit="N", shape=(3,), doc="force of the root on the beam, resolved in frame_a")
    root_moment: RealOutput = port(unit="N*m", shape=(3,), doc="moment of the root on the beam, resolved in frame_a")
    cut_force: RealOutput = port(size="n_cuts", unit="N", shape=(3,), doc="force of the root side on the tip side")
    cut_moment: RealOutput = port(size="n_cuts", unit="N*m", shape=(3,), doc="its moment, about the elastic axis")

    def build(self):
        parts = divide(given_beam(self), self.hinges, self.quadrature)
        carriers = _chain(self, parts)
        _, frame, origin = carriers[-1]
        self.connect(_link(self, frame, parts.tip - origin, "end"), self.frame_b)
        for k, given in enumerate(self.node_points):
            point = _on_the_beam(self, k, given)
            _, frame, origin = next((c for c in carriers if point[2] <= c[0].segment.end), carriers[-1])
            self.connect(_link(self, frame, point - origin, f"to_node_{k + 1}"), self.nodes[k])

    def drawing(self) -> shapes.Drawing:
        return [shapes.Tube(frame, axis, np.maximum(x, y), material="tower") for frame, axis, _, x, y in bodies(self)]

    def equations(self):
        a, b, beam = self.frame_a, self.frame_b, given_beam(self)
        cuts = [getattr(self, f"cut_{k + 1}") for k in range(self.n_cuts)]
        axes = [section_axes(beam, s) if self.cut_axes == "section" else np.eye(3) for s in self.cuts]
        return [
            [eq(self.cut_force[k], m.mtimes(axes[k].T, cut.force)) for k, cut in enumerate(cuts)],
            [eq(self.cut_moment[k], m.mtimes(axes[k].T, cut.torque)) for k, cut in enumerate(cuts)],
            eq(self.deflection, a.R.T @ (b.r - a.r) - elastic_axis(beam, beam.length)),
            eq(self.root_force, a.R.T @ a.f),
            eq(self.root_moment, a.R.T @ a.t),
        ]


def _chain(beam, parts):
    """Hinges, cuts and segments from root to tip; each piece with the frame that carries it and the frame's place."""
    frame, origin, carriers = beam.frame_a, np.zeros(3), []
    for piece in pieces(given_beam(beam), parts, beam.cuts):
        if piece.hinge or piece.cut:
            arm = f"arm_{piece.hinge}" if piece.hinge else f"to_cut_{piece.cut}"
            joint = _hinge(beam, parts, piece.hinge) if piece.hinge else beam.add(f"cut_{piece.cut}", LoadSensor())
            beam.connect(_link(beam, frame, piece.root - origin, arm), joint.frame_a)
            frame, origin = joint.frame_b, piece.root
        carriers.append((piece, frame, origin))
        segment = piece.segment
        if segment.end > segment.start:
            body = BeamSegment(mass=segment.mass, inertia=segment.inertia, r_cm=segment.centre - origin)
            beam.connect(frame, beam.add(piece.name, body).frame_a)
    return carriers


def _on_the_beam(beam, k, given):
    """The place of node k, in the axes of the root."""
    table = given_beam(beam)
    point = elastic_axis(table, float(given)) if np.ndim(given) == 0 else np.asarray(given, dtype=float)
    if not -1e-9 <= point[2] <= table.length + 1e-9:
        raise ParameterError(f"node {k + 1} at {point[2]:g} m is off the beam of {table.length:g} m.")
    return point


def _hinge(beam, parts, i):
    return beam.add(f"hinge_{i}", BeamHinge(axes=parts.axes[i - 1], **_elasticity(beam, parts, i - 1)))


def _link(beam, frame, r, name):
    link = beam.add(name, BeamLink(r=r))
    beam.connect(frame, link.frame_a)
    return link.frame_b


def _elasticity(beam, parts, i):
    """Stiffness and damping of unit i."""
    given = {"torsion": parts.torsion, "stretch": parts.stretch}
    columns = {"stiffness_x": parts.stiffness_x, "stiffness_y": parts.stiffness_y}
    for (name, values), column in zip(given.items(), ("torsional_stiffness", "axial_stiffness"), strict=True):
        if getattr(beam, name):
            if values is None:
                raise ParameterError(f"{beam.label}: {name} needs the {column} of the properties.")
            columns[column] = values
    stiffness = {name: beam.stiffness_factor * float(values[i]) for name, values in columns.items()}
    damping = {name: getattr(beam, name) for name in ("damping_x", "damping_y", "damping")}
    return {**stiffness, **damping, "torsion": beam.torsion, "stretch": beam.stretch}


def bodies(beam):
    """The rigid segments of a Beam from root to tip, for pictures, each with stations along it.

    Frame, elastic axis in the frame (n, 3), distance from the root (n,), sizes along x and y (n,) [m].
    """
    table = given_beam(beam)
    parts = divide(table, beam.hinges, beam.quadrature)
    frames = [beam.frame_a, *(beam.parts[f"hinge_{i + 1}"].frame_b for i in range(beam.hinges))]
    found = []
    for frame, place, segment in zip(frames, [np.zeros(3), *parts.points], parts.segments, strict=True):
        stations = max(3, math.ceil((segment.end - segment.start) / table.length * 24) + 1)
        s = np.linspace(segment.start, segment.end, stations)
        axis = np.array([elastic_axis(table, si) for si in s]) - place
        found.append((frame, axis, s, *table.outline(s)))
    return found
