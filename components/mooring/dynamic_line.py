"""A mooring line or cable with inertia, drag and the touch of the seabed along it: point masses between elements."""

from __future__ import annotations

from typing import Any

import casadi as ca
import numpy as np

from fowtlib.components.environment.current import Current
from fowtlib.components.environment.sea import Sea
from fowtlib.components.mechanics.connectors import Frame
from fowtlib.components.mooring import line_at_rest, line_snap, lumped_mass
from fowtlib.components.mooring.anchors import ends_above_seabed, hold_anchor
from fowtlib.components.mooring.dynamic_sections import DynamicSections
from fowtlib.language import (
    Array,
    Scalar,
    Vector,
    assert_,
    assign,
    at_start,
    der,
    eq,
    on,
    outer,
    param,
    port,
    shapes,
    var,
)
from fowtlib.language import math as m
from fowtlib.language.declarations import join

SHARP = 0.5
"""Angle [rad] between elements from which on a line that bends warns."""


class DynamicLine(DynamicSections):
    """A line of `elements` elastic elements between point masses, in waves and current, over a flat seabed.

    Equations: fowtlib.components.mooring.lumped_mass. Ports and names are those of CatenaryLine, whose place it takes.
    States are the offsets of the nodes between the ends from the shape at rest, which is found where a run starts for
    where the ends are then, and goes with them: node k by the share of unstretched length that lies below it. The run
    begins settled, but for bending and current; with these, and where a start value moves an end, `equilibrium` settles
    the line.

    Good for elements of less than a quarter of the length of the waves in the line, whose axial modes the solver need
    not resolve; for a seabed without slopes; for angles from element to element that are small, where it bends. The
    water is that at the nodes at rest. Errors: an end below the seabed; a strain beyond greatest_strain. Warnings: a
    tension above breaking_load; a curvature above 1 / least_bending_radius; steps or output points too far apart for
    the snap of a slack element. It may break at its fairlead during a run (`loss`), and falls.
    """

    mode_names = {"*": "{part} motion"}

    anchor_position: Vector = param(default=(0, 0, 0), unit="m", doc="anchor, world; unless a frame is its anchor")
    greatest_strain: Scalar = param(default=0.1, min=0, doc="stretch per length up to which the tension law holds")

    sea: Sea = outer(Sea, optional=True)
    sea_current: Current = outer(Current, optional=True)
    fairlead: Frame = port(doc="upper end")
    anchor: Frame = port(optional=True, doc="lower end, when the anchor is part of a body")

    offsets: Array = var(
        unit="m", shape=lambda self: (3, self.nodes() - 2), start=0.0, state="prefer", doc="of the nodes, world"
    )
    offset_rates: Array = var(
        unit="m/s", shape=lambda self: (3, self.nodes() - 2), start=0.0, state="prefer", doc="rates of the offsets"
    )
    positions: Array = var(unit="m", shape=lambda self: (3, self.nodes()), doc="nodes from the anchor on, world")
    tensions: Array = var(unit="N", shape=lambda self: (self.nodes() - 1,), doc="tensions of the elements")
    clearances: Array = var(unit="m", shape=lambda self: (self.nodes(),), doc="heights of the nodes above the seabed")
    curvatures: Array = var(unit="1/m", shape=lambda self: (self.nodes() - 2,), doc="at the nodes between the ends")
    curvature: Scalar = var(unit="1/m", doc="largest of the curvatures")
    tension: Scalar = var(unit="N", doc="tension at the fairlead: the force that holds the end there")
    anchor_tension: Scalar = var(unit="N", doc="tension at the anchor: of the first element")

    def equations(self):
        n, fairlead, anchor = self.nodes(), self.fairlead, self.anchor
        rest = at_start("shape at rest", 3 * n, "m", "nodes where a run starts", line_at_rest.shape_at_rest)
        rest, share = ca.reshape(rest, 3, n), self.shares()
        ends = ca.horzcat(anchor.r, fairlead.r) - ca.horzcat(rest[:, 0], rest[:, -1])
        carried = [_carried(of, share) for of in (ends, *_rates(anchor, fairlead))]
        nodes = rest + carried[0] + _between(self.offsets)
        velocities = carried[1] + _between(self.offset_rates)
        line, points, around = self.elements_now(), self.points_now(), self.surroundings(nodes)
        now = lumped_mass.loads(nodes, velocities, line, points, around)
        pull = lumped_mass.tensions(nodes, velocities, line) * self.whole(n - 1)
        inside = lumped_mass.directions(nodes)[1] * ca.repmat(pull, 3, 1)
        if self.bends():
            inside += lumped_mass.shears(nodes, line) * ca.repmat(self.whole(n - 1), 3, 1)
        moving = now.accelerations(now.force + _differences(inside))[:, 1:-1] - carried[2][:, 1:-1]
        held = now.inertia(carried[2]) - now.force
        pulls = [held[:, 0] - inside[:, 0], held[:, -1] + inside[:, -1]]  # what holds the ends
        return [
            eq(der(self.offsets), self.offset_rates),
            eq(der(self.offset_rates), moving),
            eq(self.positions, nodes),
            eq(self.tensions, pull.T),
            eq(self.clearances, nodes[2, :].T + self.world.water_depth),
            [eq(self.curvatures, lumped_mass.curvatures(nodes, line).T), eq(self.curvature, ca.mmax(self.curvatures))],
            eq(self.tension, self.intact * m.norm(pulls[1])),
            eq(self.anchor_tension, m.norm(inside[:, 0])),
            [eq(fairlead.f, pulls[1]), eq(fairlead.t, m.zeros(3))],
            hold_anchor(self, pulls[0]),
            on(self.loss, assign(self.intact, 0)),
            *_limits(self, nodes, line, line_snap.resolved(self, nodes, velocities, line, now.weight)),
        ]

    def drawing(self) -> shapes.Drawing:
        n = self.nodes()
        of = {f"{i},{k}": join(self.path, f"positions[{i},{k}]") for k in range(n) for i in range(3)}

        def form(at: Any) -> np.ndarray:
            return np.stack([np.stack([at[f"{i},{k}"] for i in range(3)], axis=-1) for k in range(n)], axis=1)

        return [shapes.Curve(of, form, float(np.max(self.parameter_value("diameter"))) or None)]


def _between(of_nodes: Any) -> Any:
    """With zeros for the ends."""
    none = ca.SX.zeros(3, 1)
    return ca.horzcat(none, of_nodes, none)


def _differences(of_elements: Any) -> Any:
    """Forces on all nodes of what pulls in the elements."""
    none = ca.SX.zeros(3, 1)
    return ca.horzcat(of_elements, none) - ca.horzcat(none, of_elements)


def _carried(of_ends: Any, share: Any) -> Any:
    """What the nodes take of two columns of the ends."""
    return ca.mtimes(of_ends[:, 0], 1 - share) + ca.mtimes(of_ends[:, 1], share)


def _rates(anchor: Any, fairlead: Any) -> list[Any]:
    """Velocities and accelerations of the ends."""
    velocities = [der(end.r) for end in (anchor, fairlead)]
    return [ca.horzcat(*velocities), ca.horzcat(*(der(velocity) for velocity in velocities))]


def _strengths(line: DynamicLine) -> list[Any]:
    """Breaking loads [N] of the end at the fairlead, and of the elements."""
    of_elements = line.of_elements("breaking_load")
    return [of_elements[-1], *of_elements]


def _limits(line: DynamicLine, nodes: Any, elements: lumped_mass.Elements, snap: Any) -> list[Any]:
    """What the equations hold for."""
    whole = line.whole(nodes.shape[1] - 1)  # an element that broke has no strain
    strains = (lumped_mass.directions(nodes)[0] / elements.length - 1) * whole
    strain = ca.mmax(strains)
    breaking = []
    if line.parameter_value("breaking_load") is not None:
        share = ca.mmax(ca.vertcat(line.tension, line.tensions) / ca.vertcat(*_strengths(line)))
        breaking = [assert_(share < 1, "the tension is {share} of the breaking load", "warning", share=share)]
    return [
        *ends_above_seabed(line.world.water_depth, line.anchor.r[2], line.fairlead.r[2]),
        assert_(strain < line.greatest_strain, "an element is stretched by {strain} of its length; its tension is "
                "known up to greatest_strain = {limit}", strain=strain, limit=line.greatest_strain),
        *breaking,
        *_tables(line, strains, elements),
        *_angles(line, nodes, elements),
        *_bent(line), snap,
    ]  # fmt: skip


def _tables(line: DynamicLine, strains: Any, elements: lumped_mass.Elements) -> list[Any]:
    """A rope is not stretched beyond its table."""
    if elements.table is None:
        return []
    last, reached = elements.table[elements.table.shape[0] - 1, 0], ca.mmax(strains * elements.fibre)
    return [assert_(reached <= last, "a rope is stretched by {strain} of its length; its strain_table ends at {last}",
                    strain=reached, last=last)]  # fmt: skip


_BENT = "the cable is bent to {share} times the curvature of its least_bending_radius"


def _bent(line: DynamicLine) -> list[Any]:
    """A cable is not bent more than it may be."""
    if line.parameter_value("least_bending_radius") is None:
        return []
    radii = line.of_elements("least_bending_radius")  # of a node the larger one of both sides
    allowed = ca.vertcat(*(ca.fmax(*pair) for pair in zip(radii, radii[1:], strict=False)))
    share = ca.mmax(line.curvatures * allowed)
    return [assert_(share < 1, _BENT, "warning", share=share)]


def _angles(line: DynamicLine, nodes: Any, elements: lumped_mass.Elements) -> list[Any]:
    """Where a line bends, the angles between its elements are small."""
    if not line.bends():
        return []
    lengths = (elements.length[:, 1:] + elements.length[:, :-1]) / 2
    angle = ca.mmax(lumped_mass.curvatures(nodes, elements) * lengths)
    said = "two elements are at an angle of {angle} rad; bending is good for small ones: take more elements"
    return [assert_(angle < SHARP, said, "warning", angle=angle)]
