"""Members of a floater that bend: the loads of the water on them, and the loads in their sections."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from fowtlib.components.hydro.modal_loads import ModalLoad
from fowtlib.components.hydro.strips import Strip
from fowtlib.components.mechanics.connectors import ModalCoordinates
from fowtlib.components.platform.member_parts import MemberLoads, has_inertia, members_of, wave_forces
from fowtlib.components.platform.shape_numbers import shapes_in_use
from fowtlib.language import Array, Component, at_start, eq, param, port, var
from fowtlib.language import math as m

if TYPE_CHECKING:
    from fowtlib.components.platform.bending_hull import BendingHull


class BendingMemberLoads(ModalLoad, MemberLoads):
    """What the water does to members that bend, on the frame of the floater and on its shapes: the sum over members.

    A strip moves with the frame and with the shapes, and its load does the same work on both. Its axis is that of the
    member at rest in the frame: the turn by bending is left out. See MemberLoads.
    """

    bends = True
    wave_inputs = ("extra_force", "extra_moment", "extra_on_shapes")

    extra_on_shapes: Array = param(
        default=lambda self: [0.0] * self.shapes, shape="shapes", unit="N", doc="load added to that on the shapes"
    )

    def equations(self):
        members = members_of(next(iter(self.enclosing())))
        loads = [m.vertcat(member.force, member.moment, member.on_shapes) for member in members]
        extra = m.vertcat(self.extra_force, self.extra_moment, self.extra_on_shapes)
        return self.push(sum(loads, extra))

    @property
    def wave_transfer(self):
        """Complex load (n, 6 + k) per unit wave amplitude, a function of frequencies [rad/s] and a heading [rad]."""
        rigid, floater = super().wave_transfer, next(iter(self.enclosing()))

        def transfer(omega: np.ndarray, heading: float) -> np.ndarray:
            on_shapes = np.zeros((len(omega), self.shapes), dtype=complex)
            ends = np.cumsum([0, *(len(places) for places in strip_places(floater))])
            moved = _strip_shapes(floater).reshape(ends[-1], 3, self.shapes)
            for k, member in enumerate(members_of(floater)):
                if has_inertia(member):
                    force, _ = wave_forces(self.world, member, omega, heading)
                    on_shapes += np.einsum("nki,kis->ns", force, moved[ends[k] : ends[k + 1]])
            return np.hstack([rigid(omega, heading), on_shapes])

        return transfer

    def bending(self, floater: BendingHull, number: int, strips: Sequence[Strip]) -> list[Strip]:
        """The strips of a member, by its number, with how they move in each shape."""
        rows = self._moved(floater, number)
        return [replace(strip, shapes=row) for strip, row in zip(strips, rows[:-1], strict=True)]

    def at_waterline(self, floater: BendingHull, number: int) -> Any:
        """How the section of a member at the water level moves in each shape (3, k)."""
        return self._moved(floater, number)[-1]

    def _moved(self, floater: BendingHull, number: int) -> list[Any]:
        size = 3 * self.shapes
        ends = np.cumsum([0, *(size * len(places) for places in strip_places(floater))]).tolist()
        found = at_start("strip_shapes", ends[-1], "1", "how strips move with the shapes", _strip_shapes, of=floater)
        own = found[ends[number] : ends[number + 1]]
        return [m.vertcat(*[own[k + i * self.shapes : k + (i + 1) * self.shapes].T for i in range(3)])
                for k in range(0, ends[number + 1] - ends[number], size)]  # fmt: skip


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


def strip_places(floater: BendingHull) -> list[np.ndarray]:
    """Places (k, 3) of the strips of each member and of its water line, in the frame; none of one without sections."""
    hull, found = floater.hull(), []
    for k, member in enumerate(members_of(floater)):
        count = member.parameter_value("sections")
        strips = hull.strips(k, count) if count else None
        wet = strips is not None and strips.waterline > 0
        line = [] if strips is None else [strips.waterline_place if wet else strips.places[0]]
        found.append(np.zeros((0, 3)) if strips is None else np.vstack([strips.places, *line]))
    return found


def _strip_shapes(floater: BendingHull) -> np.ndarray:
    """Displacement of all strips per coordinate, row by row: strip, axis, shape."""
    places = np.concatenate(strip_places(floater))
    moved = floater.member_frame().field(places, shapes_in_use(floater).shapes).displacement
    return moved.transpose(1, 2, 0).ravel()
