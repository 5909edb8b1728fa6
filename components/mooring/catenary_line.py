"""A mooring line as an elastic catenary over the seabed."""

from __future__ import annotations

import numpy as np

from fowtlib.components.environment.world import World
from fowtlib.components.mechanics.connectors import Frame
from fowtlib.components.mooring import catenary, line_motion
from fowtlib.components.mooring.anchors import LEVEL, ends_above_seabed, hold_anchor, long_enough
from fowtlib.components.mooring.line_properties import IN_BALANCE, MOVING, UniformLine
from fowtlib.language import (
    Scalar,
    Vector,
    assert_,
    eq,
    outer,
    param,
    port,
    shapes,
    var,
)
from fowtlib.language import math as m
from fowtlib.language.declarations import join
from fowtlib.language.errors import ParameterError


class CatenaryLine(UniformLine):
    """Quasi-static elastic catenary from an anchor to a fairlead: taut, slack, on the seabed, lifted or in mid-water.

    Equations: fowtlib.components.mooring.catenary (Jonkman, NREL/TP-500-41958, 2007, section 2.6, and lines that touch
    no seabed, float or have no weight in water). Two algebraic unknowns, of the size of 1: the vertical tension over
    the weight, and a coordinate of the lateral stiffness H / x, which is finite for a vertical line too; Newton finds
    them from one fixed start. The line pulls its fairlead towards the anchor and, where it is heavy, down.
    The seabed is flat and lies World.water_depth deep; the line touches it where it hangs down to it. An anchor within
    1 cm of it lies on it, and friction acts on the line that lies towards it; of an anchor in mid-water the line hangs,
    and friction is left out. No current or bending. A slack line hangs vertically, its excess lies on
    the seabed, and it warns. Errors: an end below the seabed; a stretch beyond greatest_strain, up to which EA is taken
    as constant; a line that would float at the surface. Warnings: half of greatest_strain; a tension above the breaking
    load, where one is given. A line may be lost. With `dynamics` its shape has inertia and drag, in one degree of
    freedom (fowtlib.components.mooring.line_motion): `tension` is then that of the moving line; the horizontal and
    vertical ones and that at the anchor are those of the line in balance.
    """

    mode_names = {"*": "{part} shape"}

    anchor_position: Vector = param(default=(0, 0, 0), unit="m", doc="anchor, world; unless a frame is its anchor")

    world: World = outer(World)
    fairlead: Frame = port(doc="upper end")
    anchor: Frame = port(optional=True, doc="lower end, when the anchor is part of a body")

    weight: Scalar = var(unit="N/m", doc="weight in water per length")
    clearance: Scalar = var(unit="m", doc="height of the anchor above the seabed; 0: it lies there")
    coordinate: Scalar = var(start=1.0, doc="positive: lateral stiffness; negative: slack; see lateral_stiffness")
    lift: Scalar = var(start=lambda self: _start(self), doc="vertical tension over weight of the line")
    horizontal_tension: Scalar = var(unit="N", doc="horizontal tension at the fairlead")
    vertical_tension: Scalar = var(unit="N", doc="vertical tension at the fairlead; positive: the line pulls down")
    tension: Scalar = var(unit="N", doc="tension at the fairlead")
    anchor_tension: Scalar = var(unit="N", doc="tension at the anchor")
    seabed_length: Scalar = var(unit="m", doc="length of line on the seabed")
    distance: Scalar = var(unit="m", doc="horizontal distance from anchor to fairlead")
    rise: Scalar = var(unit="m", doc="height of the fairlead above the anchor")

    def build(self):
        if self.dynamics != "none":
            line_motion.declare(self)
        else:
            self.refuse_unused(*MOVING, because=IN_BALANCE)

    def equations(self):
        fairlead, reach, there = self.fairlead, self.fairlead.r - self.anchor.r, self.intact
        apart, rise = self.reach(self.distance, self.rise)
        force, aside, _ = catenary.scales(self, m)
        lateral, plan = catenary.lateral_stiffness(self.coordinate, self, m), m.vertcat(reach[0], reach[1])
        H, V, spanned = lateral * apart, self.lift * force, m.sqrt(apart**2 + (aside / lateral) ** 2)
        line = catenary.state(lateral * spanned, V, self, m)
        pull, T = m.vertcat(lateral * plan, V), m.sqrt(H**2 + V**2)
        moving = line_motion.laws((lateral * spanned, V, T, pull, plan / self.distance), self)
        left = 1 - m.fmin(line.held, 1)  # of the horizontal tension, at the anchor
        return [
            eq(self.weight, line_weight(self)),
            eq(self.clearance, m.fmax(self.anchor.r[2] + self.world.water_depth - LEVEL, 0)),
            eq(self.distance, m.smooth_norm(plan, 1e-5 * self.length)),
            eq(self.rise, reach[2]),
            eq(line.grounded + lateral * spanned * line.flexibility, spanned),
            eq(line.height, rise),
            eq(self.horizontal_tension, there * H),
            eq(self.vertical_tension, there * V),
            eq(self.tension, there * (T + moving.excess)),
            eq(self.anchor_tension, there * m.sqrt((H * left) ** 2 + line.anchor**2)),
            [eq(self.seabed_length, line.grounded), self.when_lost(apart, rise)],
            [eq(fairlead.f, there * (pull + moving.felt)), eq(fairlead.t, m.zeros(3))],
            hold_anchor(self, there * m.vertcat(-lateral * left * plan, -line.anchor)),
            *_limits(self, line.anchor),
            *moving.equations,
        ]

    def drawing(self) -> shapes.Drawing:
        length, *more = (self.parameter_value(name) for name in ("length", "axial_stiffness", "friction"))

        def form(at):
            line = catenary.Line(length, at["weight"][0], *more, at["clearance"][..., None])  # weight: always the same
            return _profile(at["anchor"], at["fairlead"], at["H"], at["V"], line)

        scalars = {"H": "horizontal_tension", "V": "vertical_tension", **{k: k for k in ("weight", "clearance")}}
        of = {key: join(self.path, name) for key, name in scalars.items()}
        diameter = self.parameter_value("diameter")
        return [shapes.Curve({**of, "anchor": self.anchor, "fairlead": self.fairlead}, form, diameter or None)]


def _profile(anchor, fairlead, H, V, line):
    """Points along a line; of one that is lost, at its anchor."""
    lost = ((H == 0) & (V == 0))[..., None, None]
    with np.errstate(invalid="ignore", divide="ignore"):
        points = catenary.profile_between(anchor, fairlead, H, V, line, points=31)
    return np.where(lost, np.asarray(anchor)[..., None, :], points)


def _start(line):
    """Start value of the lift: 0.6 of the weight."""
    weight, stiffness = line_weight(line), line.axial_stiffness
    plain = catenary.Line(line.length, weight, stiffness)
    return 0.6 * weight * line.length / catenary.scales(plain, m)[0]


def _limits(line, V_anchor):
    """What the equations hold for."""
    depth, anchor, fairlead = line.world.water_depth, line.anchor.r[2], line.fairlead.r[2]
    strain = m.fmax(line.tension, line.anchor_tension) / line.axial_stiffness
    least = line.intact * catenary.scales(line, m)[2]
    peak = anchor + arch(line.weight, line.horizontal_tension, V_anchor, line.vertical_tension)
    breaking = [] if line.breaking_load is None else [
        assert_(line.tension < line.breaking_load, "the tension of {tension} N is above the breaking load", "warning",
                tension=line.tension)
    ]  # fmt: skip
    return [
        *ends_above_seabed(depth, anchor, fairlead),
        assert_(strain < line.greatest_strain, "the line is stretched by {strain} of its length; its axial stiffness "
                "is taken as constant up to greatest_strain = {limit}. Its ends are {apart} m apart, it is {length} m "
                "long", strain=strain, limit=line.greatest_strain, length=line.length,
                apart=m.sqrt(line.distance**2 + line.rise**2)),
        assert_(peak <= m.fmax(m.fmax(anchor, fairlead), 0), "the line rises to the surface between its "
                "ends; a line that floats there is not modelled"),
        assert_(line.coordinate > 0, "the line is slack: it hangs vertically, its excess on the seabed", "warning"),
        assert_(line.tension >= 2 * least, "the line is slack, and has no weight in water to hang by", "warning"),
        assert_(strain < line.greatest_strain / 2, "the line is stretched by {strain} of its length, more than half of "
                "greatest_strain", "warning", strain=strain),
        long_enough(line, line.length), *breaking,
    ]  # fmt: skip


def arch(weight, horizontal, lower, upper):
    """How far a line rises above its lower end: one that floats is an arch, where it pulls up at both ends; else 0.

    weight: in water per length; horizontal, lower, upper: tensions, the vertical ones positive where it pulls down at
    its upper end, and up at its lower one.
    """
    arched = m.if_else(weight < 0, m.fmin(lower, -upper), 0) > 0
    return m.if_else(arched, (m.sqrt(horizontal**2 + lower**2) - horizontal) / m.fmax(-weight, 1e-9), 0)


def weight_is_given(line):
    """Whether the weight in water is given, and not mass and diameter; ParameterError for both or none of them."""
    given, by_mass = (line.parameter_value(name) is not None for name in ("weight_per_length", "mass_per_length"))
    if given == by_mass:
        raise ParameterError(
            f"{line.label} needs its weight once: give mass_per_length and diameter, or weight_per_length (in water)."
        )
    return given


def line_weight(line):
    """Weight in water per length, given or from mass and diameter."""
    if weight_is_given(line):
        return line.weight_per_length
    return catenary.weight_in_water(line.mass_per_length, line.diameter, line.world.gravity, line.world.water_density)
