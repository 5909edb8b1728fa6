"""Floaters whose members bend: the rigid motions of a Floater, and a few shapes of its structure."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from fowtlib.components.hydro.hull_mesh import HullMesh
from fowtlib.components.hydro.modal_database import ModalDatabase
from fowtlib.components.hydro.modal_loads import ModalPotentialFlow, ShapeHydrostatics
from fowtlib.components.mechanics.modal import ElasticBody, ElasticFrame
from fowtlib.components.platform.bending_hull import BendingHull
from fowtlib.components.platform.bending_members import BendingMemberLoads, SectionLoads
from fowtlib.components.platform.floater import Floater
from fowtlib.components.platform.frame_loads import check_carried, check_mesh, water_at_rest
from fowtlib.components.platform.member_frame import MemberFrame
from fowtlib.components.platform.shape_numbers import (
    RHO,
    SAME_NODE,
    rows_of,
    shape_numbers,
    shapes_of,
)
from fowtlib.language.expressions import StartNumbers


class ElasticFloater(BendingHull):
    """A hull of members that bend: a Floater with the lowest shapes of its structure as further coordinates.

    The structure is a frame of beams along the axes of the members (see MemberFrame), with all that the hull weighs;
    its shapes are those of the free hull, whose water and whatever stands on it come as loads. The `database`, made
    by `modal_database`, has the flow of the rigid motions and of each shape. Without one, `shapes` says how many of the
    lowest are in use, and the water acts by strips on members with an `added_mass_coefficient`: no waves are made, and
    shapes follow the sizes of a run. `attached` nodes, on which something heavy stands, have shapes of their loads
    too. `nodes` move with the shapes. Bending is small, the motion of the frame is not. Drag acts on the members as
    they move, and buoyancy of shapes is linear. Mass and stiffness of the shapes follow from the members when a run
    starts; weight and water at rest bend the hull and change its stiffness, with the `node_forces` that are given for
    that. `sections.force` and `sections.moment` are the loads in the members at the `section_points`, see SectionLoads.
    Errors: shapes that carry momentum, a database of another structure or of other shapes, nodes off the hull, sections
    off the axes of members.
    """

    def build(self):
        count, points, cuts = self.count, len(self.node_rows()), len(rows_of(self, "section_points"))
        recovered = 6 * cuts * (1 + count + 6 * points)
        first = 2 * count**2 + 6 * count * points
        last = first + recovered + count
        floats = 0 if self.database is not None else count * (count + 6)
        self._numbers = StartNumbers(self, "shapes", last + floats, shape_numbers)
        self.structure = ElasticBody(
            shapes=count, mass=self._matrix(0, count, count), stiffness=self._matrix(count**2, count, count),
            damping_time=self.damping_time, load=self._matrix(first + recovered, 1, count)[0],
        )  # fmt: skip
        super().build()
        if self.database is not None:
            self.connect(self.structure.modes, self.potential_flow.modes)
        else:
            self.buoyancy_of_shapes = ShapeHydrostatics(
                shapes=count, position=self.position, reference_density=RHO,
                among=self._matrix(last, count, count), with_rigid=self._matrix(last + count**2, count, 6),
            )  # fmt: skip
            self.connect(self.frame, self.buoyancy_of_shapes.frame)
            self.connect(self.structure.modes, self.buoyancy_of_shapes.modes)
        self.connect(self.structure.modes, self.member_loads.modes)
        if cuts:
            by_nodes = self._matrix(first + 6 * cuts * (1 + count), 6 * cuts, 6 * points) if points else None
            self.sections = SectionLoads(
                shapes=count, sections=cuts, carried=points, at_rest=self._matrix(first, 1, 6 * cuts)[0],
                by_shapes=self._matrix(first + 6 * cuts, 6 * cuts, count), by_nodes=by_nodes,
            )  # fmt: skip
            self.connect(self.structure.modes, self.sections.modes)

    def loads_of_members(self):
        return BendingMemberLoads(shapes=self.count)

    def flow(self, **settings):
        return ModalPotentialFlow(shapes=self.count, **settings)

    def carry(self, k, point):
        count = self.count
        first = 2 * count**2 + 6 * count * k
        arm = self.add(f"to_node_{k + 1}", ElasticFrame(
            shapes=count, place=point, displacement=self._matrix(first, 3, count),
            turn=self._matrix(first + 3 * count, 3, count),
        ))  # fmt: skip
        self.connect(self.frame, arm.frame)
        self.connect(arm.node, self.nodes[k])
        self.connect(self.structure.modes, arm.modes)

    def _matrix(self, first: int, rows: int, columns: int) -> list:
        return [[self._numbers[first + i * columns + j] for j in range(columns)] for i in range(rows)]


def modal_database(
    floater: ElasticFloater | Floater, count: int, *, omega: Iterable[float], headings: Iterable[float], panel: float,
    water_depth: float, mesh: HullMesh | None = None, longest: float = 5.0, young_modulus: float = 210e9,
    shear_modulus: float = 80.8e9, attached: ArrayLike = (), path: str | Path | None = None, rho: float = 1025.0,
    g: float = 9.80665, **options,
) -> ModalDatabase:  # fmt: skip
    """The potential flow of the rigid motions and the lowest `count` shapes of a floater of members.

    omega [rad/s], headings [rad], panel: about their width [m]; longest beam [m] and moduli [Pa] as the part has them.
    attached (p, 3) [m]: where heavy things stand, as towers; each adds six shapes, see `shapes_of`.
    rho [kg/m^3], g [m/s^2]; options: source, progress of `hydro.panel.solve_shapes`, whose errors are raised.
    mesh: panels of another source, in the place of those that the members have; they must lie on the members.
    Raises ParameterError for a mesh that does not match the frame.
    """
    from fowtlib.components.hydro.panel import solve_shapes  # with its optional package

    hull = floater.hull()
    structure = MemberFrame(hull, longest, young_modulus, shear_modulus)
    check_carried(structure, np.asarray(attached, dtype=float).reshape(-1, 3), f"{floater.label}, attached")
    shapes = shapes_of(structure, count, attached).shapes
    if mesh is None:
        mesh = HullMesh(hull.panels(panel), hull.lids(panel), floater.label, join=SAME_NODE)
    else:
        check_mesh(structure, mesh)
    return solve_shapes(
        mesh, lambda points: structure.field(points, shapes), structure.frame.nodes, shapes,
        rho * g * water_at_rest(structure, mesh.panels), omega=omega, headings=headings, water_depth=water_depth,
        path=path, rho=rho, g=g, **options,
    )  # fmt: skip
