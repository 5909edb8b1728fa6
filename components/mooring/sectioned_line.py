"""A mooring line of several sections, with clump weights and buoys between them."""

from __future__ import annotations

import numpy as np

from fowtlib.components.mechanics.connectors import Frame
from fowtlib.components.mooring import catenary, sections
from fowtlib.components.mooring.anchors import LEVEL, ends_above_seabed, hold_anchor, long_enough
from fowtlib.components.mooring.catenary_line import arch
from fowtlib.components.mooring.line_of_sections import LineOfSections
from fowtlib.language import Array, Scalar, Vector, assert_, eq, param, port, shapes, var
from fowtlib.language import math as m
from fowtlib.language.declarations import join


class SectionedLine(LineOfSections):
    """Quasi-static line of sections, each an elastic catenary, with weights and floats as points between them.

    Equations: fowtlib.components.mooring.sections, and those of CatenaryLine, which a line of one section is. Sections
    and points are counted from the anchor; a property is one number, or one for each. A point has the weight in water
    (mass - water density volume) g: a clump weight, or a buoy where it is negative; its inertia is left out. Unknowns
    are the two of CatenaryLine, and the height of each point. The seabed is flat; sections touch it where they hang
    down to it, and points rest on it. Friction acts below the lowest of what floats. No dynamics, current or bending.
    Errors: an end below the seabed; a stretch beyond greatest_strain; a point or section that would float at the
    surface. Warnings: the line is slack; a tension above a breaking load. The line may be lost as a whole.
    """

    anchor_position: Vector = param(default=(0, 0, 0), unit="m", doc="anchor, world; unless a frame is its anchor")
    greatest_strain: Scalar = param(default=0.1, min=0, doc="stretch per length up to which EA is constant")

    fairlead: Frame = port(doc="upper end")
    anchor: Frame = port(optional=True, doc="lower end, when the anchor is part of a body")

    clearance: Scalar = var(unit="m", doc="height of the anchor above the seabed; 0: it lies there")
    coordinate: Scalar = var(start=0.3, doc="positive: lateral stiffness; negative: slack; see lateral_stiffness")
    lift: Scalar = var(start=lambda self: self.start_lift(), doc="vertical tension over the weights of the line")
    heights: Array = var(
        unit="m", shape=lambda self: (self.count() - 1,), start=lambda self: self.start_heights(),
        doc="heights of the points above the seabed",
    )  # fmt: skip
    weights: Array = var(unit="N/m", shape=lambda self: (self.count(),), doc="weights in water per length")
    horizontal_tension: Scalar = var(unit="N", doc="horizontal tension at the fairlead")
    vertical_tension: Scalar = var(unit="N", doc="vertical tension at the fairlead; positive: the line pulls down")
    tension: Scalar = var(unit="N", doc="tension at the fairlead")
    anchor_tension: Scalar = var(unit="N", doc="tension at the anchor")
    drawn: Array = var(unit="N", shape=lambda self: (self.count(),), doc="tensions of the catenaries at upper ends")
    verticals: Array = var(unit="N", shape=lambda self: (self.count(),), doc="vertical tensions at upper ends")
    tensions: Array = var(unit="N", shape=lambda self: (self.count(),), doc="tensions at upper ends of sections")
    seabed_lengths: Array = var(unit="m", shape=lambda self: (self.count(),), doc="lengths of sections on the seabed")
    distance: Scalar = var(unit="m", doc="horizontal distance from anchor to fairlead")
    rise: Scalar = var(unit="m", doc="height of the fairlead above the anchor")

    def equations(self):
        n, fairlead, there = self.count(), self.fairlead, self.intact
        reach = fairlead.r - self.anchor.r
        apart, rise = self.reach(self.distance, self.rise)
        pieces, points = self.pieces([self.weights[i] for i in range(n)]), self.point_weights()
        whole = sections.whole(pieces, points)
        force, aside, _ = catenary.scales(whole, m)
        lateral, plan = catenary.lateral_stiffness(self.coordinate, whole, m), m.vertcat(reach[0], reach[1])
        H, V, spanned = lateral * apart, self.lift * force, m.sqrt(apart**2 + (aside / lateral) ** 2)
        heights = [self.clearance, *(self.heights[i] for i in range(n - 1)), self.clearance + rise]
        hung = sections.hung(lateral * spanned, V, pieces, points, heights)
        left, pull = hung[0].share * hung[0].left, hung[0].state.anchor
        return [
            [eq(self.weights[i], w) for i, w in enumerate(self.section_weights())],
            eq(self.clearance, m.fmax(self.anchor.r[2] + self.world.water_depth - LEVEL, 0)),
            [eq(self.distance, m.smooth_norm(plan, 1e-5 * whole.length)), eq(self.rise, reach[2])],
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
        scalars = ["clearance", "tension", "distance", *(f"heights[{i}]" for i in range(self.count() - 1))]
        scalars += [f"{name}[{i}]" for name in ("weights", "drawn", "verticals") for i in range(self.count())]
        of = {name: join(self.path, name) for name in scalars}
        stiffness, friction = (self.each(name, self.parameter_value) for name in ("axial_stiffness", "friction"))
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
    anchor, fairlead = line.anchor.r[2], line.fairlead.r[2]
    strain, highest = 0, -m.inf
    for item, height in zip(hung, heights, strict=False):
        T, lower, upper = item.horizontal, item.state.anchor, item.vertical
        stretching = m.fmax(m.sqrt(T**2 + upper**2), m.sqrt(T**2 + lower**2))
        strain = m.fmax(strain, line.intact * stretching / item.line.axial_stiffness)
        peak = height + arch(item.line.weight, T, lower, upper)
        highest = m.fmax(highest, anchor - line.clearance + peak)
    breaking = [] if line.parameter_value("breaking_load") is None else [
        assert_(line.tensions[i] < load, f"the tension of {{tension}} N in section {i + 1} is above its breaking load",
                "warning", tension=line.tensions[i])
        for i, load in enumerate(line.each("breaking_load"))
    ]  # fmt: skip
    return [
        *ends_above_seabed(line.world.water_depth, anchor, fairlead),
        assert_(strain < line.greatest_strain, "a section is stretched by {strain} of its length; its axial stiffness "
                "is taken as constant up to greatest_strain = {limit}", strain=strain, limit=line.greatest_strain),
        long_enough(line, sum(line.each("lengths"))),
        assert_(highest <= m.fmax(m.fmax(anchor, fairlead), 0), "the line comes up to z = {z} m between its ends; a "
                "line or buoy that floats at the surface is not modelled", z=highest),
        assert_(line.coordinate > 0, "the line is slack: it hangs vertically, its excess on the seabed", "warning"),
        *breaking,
    ]  # fmt: skip
