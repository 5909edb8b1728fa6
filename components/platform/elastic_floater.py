"""Floaters whose members bend: the rigid motions of a Floater, and a few shapes of its structure."""

from __future__ import annotations

from collections.abc import Iterable
from functools import lru_cache
from pathlib import Path

from fowtlib.components.hydro.hull_mesh import HullMesh
from fowtlib.components.hydro.modal_database import ModalDatabase
from fowtlib.components.hydro.modal_loads import ModalPotentialFlow, read_modal_database
from fowtlib.components.mechanics.modal import ElasticBody, ElasticFrame
from fowtlib.components.platform.bending_members import BendingMemberLoads, SectionLoads
from fowtlib.components.platform.floater import Floater, drawn_between
from fowtlib.components.platform.frame_loads import check_mesh, water_at_rest
from fowtlib.components.platform.hull import Hull
from fowtlib.components.platform.member_frame import MemberFrame
from fowtlib.components.platform.member_parts import members_of
from fowtlib.components.platform.shape_numbers import SAME_NODE, rows_of, shape_numbers, shapes_of
from fowtlib.language import Array, Data, Number, Scalar, data, param, shapes
from fowtlib.language.expressions import StartNumbers


class ElasticFloater(Floater):
    """A hull of members that bend: a Floater with the lowest shapes of its structure as further coordinates.

    The structure is a frame of beams along the axes of the members (see MemberFrame), with all that the hull weighs;
    its shapes are those of the free hull, whose water and whatever stands on it come as loads. The `database`, made
    by `modal_database`, has the flow of the rigid motions and of each shape; `nodes` move with the shapes. Bending is
    small, the motion of the frame is not. Drag acts on the members as they move, and buoyancy of shapes is linear. Mass
    and stiffness of the shapes follow from the members when a run starts; weight and water at rest bend the hull and
    change its stiffness, with the `node_forces` that are given for that. `sections.force` and `sections.moment` are
    the loads in the members at the `section_points`, see SectionLoads.
    Errors: shapes that carry momentum, a database of another structure or of other shapes, nodes off the hull, sections
    off the axes of members.
    """

    database: Data[ModalDatabase] = data(read_modal_database, doc="potential flow of the hull and its shapes")
    longest: Number = param(default=5.0, unit="m", min=0.1, structural="it divides the frame", doc="longest beam")
    young_modulus: Scalar = param(default=210e9, unit="Pa", min=1.0, doc="Young's modulus of all walls")
    shear_modulus: Scalar = param(default=80.8e9, unit="Pa", min=1.0, doc="shear modulus of all walls")
    damping_time: Scalar = param(default=0.0, unit="s", min=0, doc="damping over stiffness of the structure")
    section_points: Array = param(default=(), unit="m", doc="points (n, 3) on axes of members with section loads")
    drawn_bending: Scalar = param(default=1.0, min=0, doc="how many times its size bending has in pictures")
    node_forces: Array = param(
        default=(), unit="N", doc="forces (n, 3) on the nodes at rest, as far as they change the stiffness; none: zero"
    )

    def build(self):
        count, points, cuts = self.database.count, len(self.node_rows()), len(rows_of(self, "section_points"))
        recovered = 6 * cuts * (1 + count + 6 * points)
        first = 2 * count**2 + 6 * count * points
        self._numbers = StartNumbers(self, "shapes", first + recovered + count, shape_numbers)
        self.structure = ElasticBody(
            shapes=count, mass=self._matrix(0, count, count), stiffness=self._matrix(count**2, count, count),
            damping_time=self.damping_time, load=self._matrix(first + recovered, 1, count)[0],
        )  # fmt: skip
        super().build()
        self.connect(self.structure.modes, self.potential_flow.modes)
        self.connect(self.structure.modes, self.member_loads.modes)
        if cuts:
            by_nodes = self._matrix(first + 6 * cuts * (1 + count), 6 * cuts, 6 * points) if points else None
            self.sections = SectionLoads(
                shapes=count, sections=cuts, carried=points, at_rest=self._matrix(first, 1, 6 * cuts)[0],
                by_shapes=self._matrix(first + 6 * cuts, 6 * cuts, count), by_nodes=by_nodes,
            )  # fmt: skip
            self.connect(self.structure.modes, self.sections.modes)

    def loads_of_members(self):
        return BendingMemberLoads(shapes=self.database.count)

    def flow(self, **settings):
        return ModalPotentialFlow(shapes=self.database.count, **settings)

    def carry(self, k, point):
        count = self.database.count
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

    def drawing(self) -> shapes.Drawing:
        """Its beams, each on a frame that moves with the shapes."""
        if not members_of(self):
            return []
        structure, size = self.member_frame(), float(self.parameter_value("drawn_bending"))
        found, of = [], tuple(f"{self.structure.path}.q[{k}]" for k in range(self.database.count))
        for k, piece in enumerate(structure.pieces):
            axis, motion, _ = structure.frame.section_motion(k, 0.5, self.database.shapes)
            x, y, z = axis.tolist()
            carrier = shapes.Carried(self.frame, (x, y, z), of, size * motion[:, :3].T, size * motion[:, 3:].T)
            found.append(drawn_between(carrier, structure.hull.members[piece.member], piece.low, piece.high, axis))
        return found

    def member_frame(self) -> MemberFrame:
        """Its structure with the values that the parameters have now."""
        moduli = (float(self.parameter_value(name)) for name in ("young_modulus", "shear_modulus"))
        return _frame(self.hull(), float(self.parameter_value("longest")), *moduli)


@lru_cache(maxsize=16)
def _frame(hull: Hull, longest: float, young_modulus: float, shear_modulus: float) -> MemberFrame:
    return MemberFrame(hull, longest, young_modulus, shear_modulus)


def modal_database(
    floater: ElasticFloater | Floater, count: int, *, omega: Iterable[float], headings: Iterable[float], panel: float,
    water_depth: float, mesh: HullMesh | None = None, longest: float = 5.0, young_modulus: float = 210e9,
    shear_modulus: float = 80.8e9, path: str | Path | None = None, rho: float = 1025.0, g: float = 9.80665, **options,
) -> ModalDatabase:  # fmt: skip
    """The potential flow of the rigid motions and the lowest `count` shapes of a floater of members.

    omega [rad/s], headings [rad], panel: about their width [m]; longest beam [m] and moduli [Pa] as the part has them.
    rho [kg/m^3], g [m/s^2]; options: source, progress of `hydro.panel.solve_shapes`, whose errors are raised.
    mesh: panels of another source, in the place of those that the members have; they must lie on the members.
    Raises ParameterError for a mesh that does not match the frame.
    """
    from fowtlib.components.hydro.panel import solve_shapes  # with its optional package

    hull = floater.hull()
    structure = MemberFrame(hull, longest, young_modulus, shear_modulus)
    shapes = shapes_of(structure, count).shapes
    if mesh is None:
        mesh = HullMesh(hull.panels(panel), hull.lids(panel), floater.label, join=SAME_NODE)
    else:
        check_mesh(structure, mesh)
    return solve_shapes(
        mesh, lambda points: structure.field(points, shapes), structure.frame.nodes, shapes,
        rho * g * water_at_rest(structure, mesh.panels), omega=omega, headings=headings, water_depth=water_depth,
        path=path, rho=rho, g=g, **options,
    )  # fmt: skip
