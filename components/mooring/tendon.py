"""A tendon of a tension leg platform: straight, elastic, heavy, and slack rather than in compression."""

from __future__ import annotations

from fowtlib.components.environment.world import World
from fowtlib.components.mechanics.connectors import Frame
from fowtlib.components.mooring.anchors import hold_anchor
from fowtlib.components.mooring.catenary_line import line_weight
from fowtlib.components.mooring.lost_line import Losable
from fowtlib.language import Scalar, Vector, assert_, assign, der, eq, on, outer, param, port, shapes, var, when
from fowtlib.language import math as m
from fowtlib.language.bounds import POSITIVE


class Tendon(Losable):
    """A straight heavy tendon from an anchor to a fairlead: EA / L along it, T / L across it, its weight half and half.

    `length` is the distance of its ends at which an upright tendon has the tension `pretension` at its fairlead; where
    no pretension is given, its unstretched length. With the mean tension T_0 = pretension - w length / 2, or 0, w the
    weight in water, and the unstretched length L = length / (1 + T_0 / EA), the mean tension is T = T_0 + EA / L
    (distance - length) + damping d(distance)/dt, and (T + sqrt(T^2 + slack_tension^2)) / 2 in its place: smooth, never
    negative, within (slack_tension / 2 T)^2 of T where it is taut. Towards its ends the tension differs from the mean
    by half of the weight, w L / 2 upwards.
    Where the least tension along it comes below zero the tendon goes slack: an event, counted, with its time, and
    said once as a warning. An equilibrium with a slack tendon is an error. What a straight tendon leaves out is its
    sag: (w L / T)^2 / 12 of the stiffness across it, 1 % at w L = 0.35 T; beyond w L = T, 8 %, it warns. No inertia,
    drag or bending. Errors: an end below the seabed; a mean stretch beyond greatest_strain. Warnings: a tension above
    the breaking load. It may be lost.
    """

    length: Scalar = param(unit="m", min=1e-3, doc="distance at which it has the pretension; without one, unstretched")
    pretension: Scalar = param(default=None, unit="N", min=0, doc="tension at the fairlead at that distance, upright")
    axial_stiffness: Scalar = param(unit="N", min=1e-3, doc="axial stiffness EA")
    mass_per_length: Scalar = param(default=None, unit="kg/m", min=0, doc="mass per length in air")
    diameter: Scalar = param(default=0.0, unit="m", min=0, doc="diameter of a bar that displaces the same water")
    weight_per_length: Scalar = param(default=None, unit="N/m", doc="weight in water, instead of mass and diameter")
    damping: Scalar = param(default=0.0, unit="N*s/m", min=0, doc="axial damping")
    slack_tension: Scalar = param(default=1000.0, unit="N", min=1e-6, doc="width of the rounding where it goes slack")
    anchor_position: Vector = param(default=(0, 0, 0), unit="m", doc="anchor, world; unless a frame is its anchor")
    greatest_strain: Scalar = param(default=0.1, min=POSITIVE, doc="stretch per length up to which EA is constant")
    breaking_load: Scalar = param(default=None, unit="N", min=0, doc="tension above which the tendon warns")

    world: World = outer(World)
    fairlead: Frame = port(doc="upper end")
    anchor: Frame = port(optional=True, doc="lower end, when the anchor is part of a body")

    distance: Scalar = var(unit="m", state="never", doc="distance of the two ends")
    unstretched: Scalar = var(unit="m", doc="unstretched length")
    mean_tension: Scalar = var(unit="N", doc="tension half way along, if it could push; negative when slack")
    tension: Scalar = var(unit="N", doc="tension at the fairlead")
    anchor_tension: Scalar = var(unit="N", doc="tension at the anchor")
    least_tension: Scalar = var(unit="N", doc="the smaller one of those at its ends, if it could push; below 0: slack")
    slack_events: Scalar = var(discrete=True, start=0.0, doc="how often it has gone slack")
    first_slack: Scalar = var(unit="s", discrete=True, start=0.0, doc="when it did so first")

    def equations(self):
        there, w, EA = self.intact, line_weight(self), self.axial_stiffness
        line = self.fairlead.r - self.anchor.r
        along, half = line / self.distance, w * self.unstretched / 2
        rate = m.dot(along, der(self.fairlead.r) - der(self.anchor.r))
        start = 0 if self.pretension is None else self.pretension - w * self.length / 2
        pull = there * m.smooth_max(self.mean_tension, 0, self.slack_tension)
        weight = m.vertcat(0, 0, there * half)
        first = m.if_else(self.slack_events > 0.5, self.first_slack, self.time)
        return [
            eq(self.distance, m.norm(line)),
            eq(self.unstretched, self.length / (1 + start / EA)),
            eq(self.mean_tension, start + EA / self.unstretched * (self.distance - self.length) + self.damping * rate),
            eq(self.tension, m.fmax(pull + there * half * along[2], 0)),
            eq(self.anchor_tension, m.fmax(pull - there * half * along[2], 0)),
            eq(self.least_tension, there * (self.mean_tension - m.abs(half * along[2]))),
            [eq(self.fairlead.f, along * pull + weight), eq(self.fairlead.t, m.zeros(3))],
            hold_anchor(self, weight - along * pull),
            on(self.loss, assign(self.intact, 0)),
            when(self.least_tension + (1 - there) * self.slack_tension < 0,
                 assign(self.slack_events, self.slack_events + 1), assign(self.first_slack, first)),
            *_limits(self, half),
        ]  # fmt: skip

    def drawing(self) -> shapes.Drawing:
        return [shapes.link(self.anchor, self.fairlead, self.parameter_value("diameter") or None, "line")]


def _limits(tendon: Tendon, half):
    """What the equations hold for."""
    short, strain = tendon.unstretched - tendon.distance, tendon.intact * (tendon.distance / tendon.unstretched - 1)
    breaking = [] if tendon.breaking_load is None else [
        assert_(tendon.tension < tendon.breaking_load, "the tension of {tension} N is above the breaking load",
                "warning", tension=tendon.tension)
    ]  # fmt: skip
    slack, straight = tendon.least_tension < 0, tendon.intact * 2 * m.abs(half) <= m.fmax(tendon.mean_tension, 0)
    return [
        assert_(tendon.distance > 1e-9, "the two ends of the tendon meet, so its direction is undetermined"),
        assert_(tendon.fairlead.r[2] > -tendon.world.water_depth, "the fairlead is at {z} m, below the seabed at "
                "{seabed} m", z=tendon.fairlead.r[2], seabed=-tendon.world.water_depth),
        assert_(strain < tendon.greatest_strain, "the tendon is stretched by {strain} of its length, and its axial "
                "stiffness is constant up to {limit}", strain=strain, limit=tendon.greatest_strain),
        assert_(tendon.slack_events < 0.5, "the tendon went slack at t = {time} s", "warning", time=tendon.first_slack),
        assert_(m.logic_not(m.if_else(tendon.slack_events > 0.5, 0, slack)), "the tendon is slack from the start on, "
                "by {tension} N", "warning", tension=tendon.least_tension),
        assert_(m.logic_not(slack), "the tendon is slack at rest: its least tension would be {tension} N, and its ends "
                "are {distance} m apart, {short} m less than its unstretched length. Give the platform more buoyancy "
                "or less ballast, or the tendon less length or more pretension", "rest", tension=tendon.least_tension,
                distance=tendon.distance, short=short),
        assert_(m.if_else(slack, 1, straight), "the tendon pulls with {tension} N, less than its weight: it sags, "
                "which is left out here (8 % of its stiffness across); take a CatenaryLine", "warning",
                tension=tendon.mean_tension),
        *breaking,
    ]  # fmt: skip
