"""Members of a floater that bend: the loads of the water on them, and the loads in their sections."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from fowtlib.components.hydro.modal_loads import ModalLoad
from fowtlib.components.hydro.strips import Strip
from fowtlib.components.mechanics.connectors import ModalCoordinates
from fowtlib.components.platform.member_parts import MemberLoads, members_of
from fowtlib.language import Array, Component, at_start, eq, param, port, var
from fowtlib.language import math as m

if TYPE_CHECKING:
    from fowtlib.components.platform.elastic_floater import ElasticFloater


class BendingMemberLoads(ModalLoad, MemberLoads):
    """What the water does to members that bend, on the frame of the floater and on its shapes: the sum over members.

    A strip moves with the frame and with the shapes, and its load does the same work on both. Its axis is that of the
    member at rest in the frame: the turn by bending is left out. See MemberLoads.
    """

    bends = True

    def equations(self):
        members = members_of(next(iter(self.enclosing())))
        loads = [m.vertcat(member.force, member.moment, member.on_shapes) for member in members]
        extra = m.vertcat(self.extra_force, self.extra_moment, m.zeros(self.shapes))
        return self.push(sum(loads, extra))

    def bending(self, floater: ElasticFloater, number: int, strips: Sequence[Strip]) -> list[Strip]:
        """The strips of a member, by its number, with how they move in each shape."""
        counts = [3 * self.shapes * len(places) for places in strip_places(floater)]
        ends = np.cumsum([0, *counts]).tolist()
        found = at_start("strip_shapes", ends[-1], "1", "how strips move with the shapes", _strip_shapes, of=floater)
        own, size = found[ends[number] : ends[number + 1]], 3 * self.shapes
        rows = [[own[k * size + i * self.shapes : k * size + (i + 1) * self.shapes].T for i in range(3)]
                for k in range(len(strips))]  # fmt: skip
        return [replace(strip, shapes=m.vertcat(*row)) for strip, row in zip(strips, rows, strict=True)]


class SectionLoads(Component):
    """Loads in sections of members: of what is beyond, towards the end of the member, on what is before.

    By the coordinates of the shapes; loads at the nodes of the floater and those at rest are known by their place, and
    what the shapes leave of them is added (mode acceleration). Axes of a section: along its member, and the two
    directions across.
    """

    shapes: int = param(min=1, doc="number of shapes")
    sections: int = param(min=1, doc="number of sections")
    carried: int = param(min=0, doc="number of nodes of the floater")
    at_rest: Array = param(shape=lambda self: (6 * self.sections,), doc="loads at rest, beyond those by the shapes")
    by_shapes: Array = param(shape=lambda self: (6 * self.sections, self.shapes), doc="loads per coordinate")
    by_nodes: Array = param(
        default=None, shape=lambda self: (6 * self.sections, 6 * self.carried), doc="loads per load at each node"
    )

    modes: ModalCoordinates = port(shape="shapes", doc="coordinates of the shapes")
    force: Array = var(shape=lambda self: (self.sections, 3), unit="N", doc="force in each section, tension first")
    moment: Array = var(shape=lambda self: (self.sections, 3), unit="N*m", doc="moment in each section, torsion first")

    def equations(self):
        total = self.at_rest + m.mtimes(self.by_shapes, self.modes.q)
        if self.carried:
            floater = next(iter(self.enclosing()))
            arms: list[Any] = [floater.parts[f"to_node_{k + 1}"] for k in range(self.carried)]
            given = [m.mtimes(arm.frame.R.T, load) for arm in arms for load in (arm.node.f, arm.node.t)]
            total = total + m.mtimes(self.by_nodes, m.vertcat(*given))
        rows = [total[6 * k : 6 * k + 6].T for k in range(self.sections)]
        return [
            eq(self.force, m.vertcat(*[row[:3] for row in rows])),
            eq(self.moment, m.vertcat(*[row[3:] for row in rows])),
            eq(self.modes.f, m.zeros(self.shapes)),
        ]


def strip_places(floater: ElasticFloater) -> list[np.ndarray]:
    """Places (k, 3) of the strips of each member, in the frame; none of one without sections."""
    hull, found = floater.hull(), []
    for k, member in enumerate(members_of(floater)):
        count = member.parameter_value("sections")
        found.append(hull.strips(k, count).places if count else np.zeros((0, 3)))
    return found


def _strip_shapes(floater: ElasticFloater) -> np.ndarray:
    """Displacement of all strips per coordinate, row by row: strip, axis, shape."""
    places = np.concatenate(strip_places(floater))
    moved = floater.member_frame().field(places, floater.database.shapes).displacement
    return moved.transpose(1, 2, 0).ravel()
