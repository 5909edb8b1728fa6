"""A mooring line of several sections, with clump weights and buoys between them."""

from __future__ import annotations

from functools import partial

import numpy as np

from fowtlib.components.environment.world import World
from fowtlib.components.mechanics.connectors import Frame
from fowtlib.components.mooring import catenary, sections
from fowtlib.components.mooring.catenary_line import LEVEL, hold_anchor
from fowtlib.components.mooring.lost_line import LosableLine
from fowtlib.language import Array, Scalar, Vector, assert_, eq, outer, param, port, shapes, var
from fowtlib.language import math as m
from fowtlib.language.declarations import join
from fowtlib.language.errors import ParameterError

OF_SECTIONS = ("axial_stiffness", "mass_per_length", "diameter", "weight_per_length", "friction", "breaking_load")
OF_POINTS = ("point_mass", "point_volume")


class SectionedLine(LosableLine):
    """Quasi-static line of sections, each an elastic catenary, with weights and floats as points between them.

    Equations: fowtlib.components.mooring.sections, and those of CatenaryLine, which a line of one section is. Sections
    and points are counted from the anchor; a property is one number, or one for each. A point has the weight in water
    (mass - water density volume) g: a clump weight, or a buoy where it is negative; its inertia is left out. Unknowns
    are the two of CatenaryLine, and the height of each point. The seabed is flat; sections touch it where they hang
    down to it, and points rest on it. Friction acts below the lowest of what floats. No dynamics, current or bending.
    Errors: an end below the seabed; a stretch beyond greatest_strain; a point or section that would float at the
    surface. Warnings: the line is slack; a tension above a breaking load. The line may be lost as a whole.
    """

    lengths: Array = param(unit="m", min=0, doc="unstretched lengths of the sections, from the anchor on")
    axial_stiffness: Array = param(unit="N", min=0, doc="axial stiffness EA")
    mass_per_length: Array = param(default=None, unit="kg/m", min=0, doc="mass per length in air")
    diameter: Array = param(default=0.0, unit="m", min=0, doc="diameter of a bar that displaces the same water")
    weight_per_length: Array = param(
        default=None, unit="N/m", doc="weight in water, instead of mass, diameter; negative: the section floats up"
    )
    friction: Array = param(default=0.0, min=0, doc="friction coefficient of the seabed")
    point_mass: Array = param(default=0.0, unit="kg", min=0, doc="masses between the sections, from the anchor on")
    point_volume: Array = param(default=0.0, unit="m^3", min=0, doc="volumes of water that these displace")
    anchor_position: Vector = param(default=(0, 0, 0), unit="m", doc="anchor, world; unless a frame is its anchor")
    greatest_strain: Scalar = param(default=0.1, min=0, doc="stretch per length up to which EA is constant")
    breaking_load: Array = param(default=None, unit="N", min=0, doc="tension above which the line warns")

    world: World = outer(World)
    fairlead: Frame = port(doc="upper end")
    anchor: Frame = port(optional=True, doc="lower end, when the anchor is part of a body")

    clearance: Scalar = var(unit="m", doc="height of the anchor above the seabed; 0: it lies there")
    coordinate: Scalar = var(start=0.3, doc="positive: lateral stiffness; negative: slack; see lateral_stiffness")
    lift: Scalar = var(start=lambda self: _start(self), doc="vertical tension over the weights of the line")
    heights: Array = var(
        unit="m", shape=lambda self: (_count(self) - 1,), start=lambda self: _start_heights(self),
        doc="heights of the points above the seabed",
    )  # fmt: skip
    weights: Array = var(unit="N/m", shape=lambda self: (_count(self),), doc="weights in water per length")
    horizontal_tension: Scalar = var(unit="N", doc="horizontal tension at the fairlead")
    vertical_tension: Scalar = var(unit="N", doc="vertical tension at the fairlead; positive: the line pulls down")
    tension: Scalar = var(unit="N", doc="tension at the fairlead")
    anchor_tension: Scalar = var(unit="N", doc="tension at the anchor")
    drawn: Array = var(unit="N", shape=lambda self: (_count(self),), doc="tensions of the catenaries at upper ends")
    verticals: Array = var(unit="N", shape=lambda self: (_count(self),), doc="vertical tensions at upper ends")
    tensions: Array = var(unit="N", shape=lambda self: (_count(self),), doc="tensions at upper ends of sections")
    seabed_lengths: Array = var(unit="m", shape=lambda self: (_count(self),), doc="lengths of sections on the seabed")
    distance: Scalar = var(unit="m", doc="horizontal distance from anchor to fairlead")
    rise: Scalar = var(unit="m", doc="height of the fairlead above the anchor")

    def equations(self):
        n, fairlead, there = _count(self), self.fairlead, self.intact
        reach = fairlead.r - self.anchor.r
        apart, rise = self.reach(self.distance, self.rise)
        pieces, points = _sections(self, [self.weights[i] for i in range(n)]), _points(self)
        whole = sections.whole(pieces, points)
        force, aside, _ = catenary.scales(whole, m)
        lateral, plan = catenary.lateral_stiffness(self.coordinate, whole, m), m.vertcat(reach[0], reach[1])
        H, V, spanned = lateral * apart, self.lift * force, m.sqrt(apart**2 + (aside / lateral) ** 2)
        heights = [self.clearance, *(self.heights[i] for i in range(n - 1)), self.clearance + rise]
        hung = sections.hung(lateral * spanned, V, pieces, points, heights)
        left, pull = hung[0].share * hung[0].left, hung[0].state.anchor
        return [
            [eq(self.weights[i], w) for i, w in enumerate(_weights(self))],
            eq(self.clearance, m.fmax(self.anchor.r[2] + self.world.water_depth - LEVEL, 0)),
            eq(self.distance, m.smooth_norm(plan, 1e-5 * whole.length)),
            eq(self.rise, reach[2]),
            eq(sum(item.span for item in hung), spanned),
            [eq(item.state.height, heights[i + 1] - heights[i]) for i, item in enumerate(hung)],
            eq(self.horizontal_tension, there * H),
            eq(self.vertical_tension, there * V),
            eq(self.tension, there * m.sqrt(H**2 + V**2)),
            eq(self.anchor_tension, there * m.sqrt((H * left) ** 2 + pull**2)),
            [_shown(self, i, item, there, H) for i, item in enumerate(hung)],
            self.when_lost(apart, rise),
            [eq(fairlead.f, there * m.vertcat(lateral * plan, V)), eq(fairlead.t, m.zeros(3))],
            hold_anchor(self, there * m.vertcat(-lateral * left * plan, -pull)),
            *_limits(self, hung, heights),
        ]

    def drawing(self) -> shapes.Drawing:
        diameter = float(np.max(self.parameter_value("diameter")))
        scalars = ["clearance", "tension", "distance", *(f"heights[{i}]" for i in range(_count(self) - 1))]
        scalars += [f"{name}[{i}]" for name in ("weights", "drawn", "verticals") for i in range(_count(self))]
        of = {name: join(self.path, name) for name in scalars}
        stiffness, friction = (_each(self, name, self.parameter_value) for name in ("axial_stiffness", "friction"))
        fixed = list(zip(np.atleast_1d(self.parameter_value("lengths")), stiffness, friction, strict=True))
        return [shapes.Curve({**of, "anchor": self.anchor, "fairlead": self.fairlead},
                             lambda at: _form(at, fixed), diameter or None)]  # fmt: skip


def _form(at, fixed):
    """Points along the line at all moments; of one that is lost, at its anchor."""
    base = at["clearance"]
    heights = [base, *(at[f"heights[{i}]"] for i in range(len(fixed) - 1))]
    x, z = np.zeros((len(base), 1)), np.zeros((len(base), 1))
    for i, (length, stiffness, friction) in enumerate(fixed):
        weight = float(at[f"weights[{i}]"][0])  # the same at all moments
        line = catenary.Line(length, weight, stiffness, friction, np.maximum(heights[i], 0)[..., None])
        T = at[f"drawn[{i}]"]
        shape = catenary.profile(T, at[f"verticals[{i}]"], line, points=31, drawn=T)
        x = np.concatenate([x, x[:, -1:] + shape["x"][:, 1:]], axis=1)
        z = np.concatenate([z, (heights[i] - base)[:, None] + shape["z"][:, 1:]], axis=1)
    way = (at["fairlead"] - at["anchor"])[:, None, :2]
    plan = at["anchor"][:, None, :2] + (x / x[:, -1:])[..., None] * way
    points = np.concatenate([plan, (at["anchor"][:, 2:] + z)[..., None]], axis=-1)
    return np.where((at["tension"] == 0)[:, None, None], at["anchor"][:, None, :], points)


def _count(line: SectionedLine) -> int:
    return len(np.atleast_1d(line.parameter_value("lengths")))


def _each(line: SectionedLine, name, values, count=None):
    """A property of each section, or of each point: one number for all, or a list of as many."""
    count = _count(line) if count is None else count
    shape, value = np.shape(line.parameter_value(name)), values(name)
    if shape and shape[0] != count:
        of = "points between the sections" if name in OF_POINTS else "sections"
        raise ParameterError(f"{line.label}.{name} has {shape[0]} values for {count} {of}.")
    return [value[i] if shape else value for i in range(count)]


def _weights(line: SectionedLine):
    """Weights in water per length of the sections."""
    given, by_mass = (line.parameter_value(name) is not None for name in ("weight_per_length", "mass_per_length"))
    if given == by_mass:
        raise ParameterError(
            f"{line.label} needs its weight once: give mass_per_length and diameter, or weight_per_length (in water)."
        )
    if given:
        return _each(line, "weight_per_length", partial(getattr, line))
    mass, diameter = (_each(line, name, partial(getattr, line)) for name in ("mass_per_length", "diameter"))
    gravity, density = line.world.gravity, line.world.water_density
    return [catenary.weight_in_water(*item, gravity, density) for item in zip(mass, diameter, strict=True)]


def _points(line: SectionedLine):
    """Weights in water of the points."""
    mass, volume = (_each(line, name, partial(getattr, line), _count(line) - 1) for name in OF_POINTS)
    return [(a - line.world.water_density * b) * line.world.gravity for a, b in zip(mass, volume, strict=True)]


def _sections(line: SectionedLine, weights):
    lengths = _each(line, "lengths", partial(getattr, line))
    stiffness, friction = (_each(line, name, partial(getattr, line)) for name in ("axial_stiffness", "friction"))
    return [sections.Section(*item, 0) for item in zip(lengths, weights, stiffness, friction, strict=True)]


def _start(line: SectionedLine):
    """Start value of the lift: all weights."""
    pieces, points = _sections(line, _weights(line)), _points(line)
    total = sum(piece.weight * piece.length for piece in pieces) + sum(points)
    return total / catenary.scales(sections.whole(pieces, points), m)[0]


def _start_heights(line: SectionedLine):
    """Start values of the heights: half the water depth, in proportion to the way along the line."""
    pieces = _sections(line, _weights(line))
    whole = sum(piece.length for piece in pieces)
    ways = [sum(piece.length for piece in pieces[: i + 1]) / whole for i in range(len(pieces) - 1)]
    return [0.5 * line.world.water_depth * way for way in ways]


def _shown(line: SectionedLine, i, hung, there, H):
    """The variables of section i."""
    return [
        eq(line.drawn[i], hung.horizontal),
        eq(line.verticals[i], hung.vertical),
        eq(line.tensions[i], there * m.sqrt((H * hung.share) ** 2 + hung.vertical**2)),
        eq(line.seabed_lengths[i], hung.state.grounded),
    ]


def _limits(line: SectionedLine, hung, heights):
    """What the equations hold for."""
    depth, anchor, fairlead = line.world.water_depth, line.anchor.r[2], line.fairlead.r[2]
    strain, highest = 0, -m.inf
    for item, height in zip(hung, heights, strict=False):
        T, lower, upper, w = item.horizontal, item.state.anchor, item.vertical, item.line.weight
        stretching = m.fmax(m.sqrt(T**2 + upper**2), m.sqrt(T**2 + lower**2))
        strain = m.fmax(strain, line.intact * stretching / item.line.axial_stiffness)
        # a section that floats is an arch, where it pulls up at both ends
        arched = m.if_else(w < 0, m.fmin(lower, -upper), 0) > 0
        peak = m.if_else(arched, (m.sqrt(T**2 + lower**2) - T) / m.fmax(-w, 1e-9), 0)
        highest = m.fmax(highest, line.anchor.r[2] - line.clearance + height + peak)
    breaking = [] if line.parameter_value("breaking_load") is None else [
        assert_(line.tensions[i] < load, f"the tension of {{tension}} N in section {i + 1} is above its breaking load",
                "warning", tension=line.tensions[i])
        for i, load in enumerate(_each(line, "breaking_load", partial(getattr, line)))
    ]  # fmt: skip
    return [
        assert_(anchor > -depth - LEVEL, "the anchor is at {z} m, below the seabed at {seabed} m (World.water_depth)",
                z=anchor, seabed=-depth),
        assert_(fairlead > -depth - LEVEL, "the fairlead is at {z} m, below the seabed at {seabed} m",
                z=fairlead, seabed=-depth),
        assert_(strain < line.greatest_strain, "a section is stretched by {strain} of its length; its axial stiffness "
                "is taken as constant up to greatest_strain = {limit}", strain=strain, limit=line.greatest_strain),
        assert_(highest <= m.fmax(m.fmax(anchor, fairlead), 0), "the line comes up to z = {z} m between its ends; a "
                "line or buoy that floats at the surface is not modelled", z=highest),
        assert_(line.coordinate > 0, "the line is slack: it hangs vertically, its excess on the seabed", "warning"),
        *breaking,
    ]  # fmt: skip
