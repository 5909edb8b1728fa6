"""Floaters whose members bend: the rigid motions of a Floater, and a few shapes of its structure."""

from __future__ import annotations

from collections.abc import Iterable
from functools import lru_cache
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from fowtlib.components.hydro.hull_mesh import HullMesh
from fowtlib.components.hydro.modal_database import ModalDatabase
from fowtlib.components.hydro.modal_loads import ModalPotentialFlow, read_modal_database
from fowtlib.components.mechanics.modal import ElasticBody, ElasticFrame
from fowtlib.components.platform.bending_members import BendingMemberLoads, SectionLoads
from fowtlib.components.platform.floater import Floater, drawn_between
from fowtlib.components.platform.frame_loads import (
    SectionRecovery,
    check_on_axes,
    loads_at,
    stiffness_by_loads,
    water_at_rest,
    weight_at_rest,
)
from fowtlib.components.platform.hull import Hull
from fowtlib.components.platform.member_frame import MemberFrame
from fowtlib.components.platform.member_parts import members_of
from fowtlib.components.platform.space_frame import FrameModes, rigid_motions
from fowtlib.language import Array, Data, Number, Scalar, data, param, shapes
from fowtlib.language.errors import ParameterError
from fowtlib.language.expressions import StartNumbers

Floats = NDArray[np.float64]
_SAME_NODE = 1e-3  # m
_MOMENTUM = 1e-3  # largest share of the mass that moves with a shape as with a rigid motion
_ALIKE = 0.95  # least part of each own shape that the shapes of the database make up


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


def shapes_of(structure: MemberFrame, count: int) -> FrameModes:
    """The lowest shapes of the free structure, of one metre at most; frequencies [rad/s]."""
    modes = structure.frame.modes(6 + count)
    if len(modes.frequencies) < 6 + count:
        raise ParameterError(f"the frame has {len(modes.frequencies) - 6} shapes, and {count} are asked; set longest.")
    shapes = modes.shapes[6:] / np.linalg.norm(modes.shapes[6:, :, :3], axis=2).max(axis=1)[:, None, None]
    return FrameModes(modes.frequencies[6:], shapes)


def modal_database(
    floater: ElasticFloater | Floater, count: int, *, omega: Iterable[float], headings: Iterable[float], panel: float,
    water_depth: float, longest: float = 5.0, young_modulus: float = 210e9, shear_modulus: float = 80.8e9,
    path: str | Path | None = None, rho: float = 1025.0, g: float = 9.80665, **options,
) -> ModalDatabase:  # fmt: skip
    """The potential flow of the rigid motions and the lowest `count` shapes of a floater of members.

    omega [rad/s], headings [rad], panel: about their width [m]; longest beam [m] and moduli [Pa] as the part has them.
    rho [kg/m^3], g [m/s^2]; options: source, progress of `hydro.panel.solve_shapes`, whose errors are raised.
    """
    from fowtlib.components.hydro.panel import solve_shapes  # with its optional package

    hull = floater.hull()
    structure = MemberFrame(hull, longest, young_modulus, shear_modulus)
    shapes = shapes_of(structure, count).shapes
    panels = hull.panels(panel)
    mesh = HullMesh(panels, hull.lids(panel), floater.label, join=_SAME_NODE)
    return solve_shapes(
        mesh, lambda points: structure.field(points, shapes), structure.frame.nodes, shapes,
        rho * g * water_at_rest(structure, panels), omega=omega, headings=headings, water_depth=water_depth, path=path,
        rho=rho, g=g, **options,
    )  # fmt: skip


def rows_of(floater: ElasticFloater, name: str) -> Floats:
    """A parameter of points or forces as rows (n, 3)."""
    values = np.asarray(floater.parameter_value(name), dtype=float)
    if values.size and (values.ndim != 2 or values.shape[1] != 3):
        raise ParameterError(f"{floater.label}.{name} must be a list of rows (x, y, z).")
    return values.reshape(-1, 3)


def shape_numbers(floater: ElasticFloater) -> Floats:
    """Modal mass, stiffness, what nodes do with each shape, section loads; everything is checked when a run starts."""
    known, structure = floater.database, floater.member_frame()
    frame, nodes = structure.frame, structure.frame.nodes
    if nodes.shape != known.nodes.shape or np.abs(nodes - known.nodes).max() > _SAME_NODE:
        raise ParameterError(
            f"{floater.label}: the frame of its members has {len(nodes)} nodes that are not the {len(known.nodes)} of "
            "its database; members, or longest, are others than when it was made. Make it anew."
        )
    raise_by = [0.0, 0.0, float(floater.parameter_value("raised"))]
    points, cuts = (rows_of(floater, name) + raise_by for name in ("node_points", "section_points"))
    check_on_axes(structure, cuts, f"{floater.label}.section_points")
    resting = loads_at_rest(floater, structure, points)
    gravity = float(floater.world.parameter_value("gravity"))
    shapes = known.shapes.reshape(known.count, -1)
    mass = shapes @ (frame.mass @ shapes.T)
    stiffness = shapes @ ((frame.stiffness + stiffness_by_loads(frame, resting.sum(axis=0), gravity)) @ shapes.T)
    _check_momentum(floater, structure, shapes, np.diag(mass))
    _check_alike(floater, structure, shapes, mass)
    moved = structure.field(points, known.shapes).displacement  # (k, points, 3)
    turned = structure.turn(points, known.shapes) if len(points) else moved
    at_nodes = np.stack([moved, turned]).transpose(2, 0, 3, 1)  # points, kind, axis, shape
    recovery = SectionRecovery(structure, known.shapes, cuts)
    recovered = [
        recovery.by_loads(resting[:1]).ravel(), recovery.by_shapes().reshape(known.count, -1).T.ravel(),
        recovery.by_points(points).reshape(6 * len(points), -1).T.ravel(),
    ] if len(cuts) else []  # fmt: skip
    load = shapes @ resting[0].ravel()
    return np.concatenate([mass.ravel(), stiffness.ravel(), at_nodes.ravel(), *recovered, load])


def loads_at_rest(floater: ElasticFloater, structure: MemberFrame, points: Floats) -> Floats:
    """Loads (2, n, 6) on the nodes of the frame at rest: of water and weight, and of the `node_forces`."""
    density, gravity = (float(floater.world.parameter_value(name)) for name in ("water_density", "gravity"))
    known, forces = floater.database, rows_of(floater, "node_forces")
    if len(forces) not in (0, len(points)):
        raise ParameterError(
            f"{floater.label}.node_forces has {len(forces)} rows, and there are {len(points)} node_points; give one "
            "force for each, or none."
        )
    water = known.at_rest * density * gravity / (known.rho * known.g)
    weight = weight_at_rest(structure.frame, gravity) if water.any() else np.zeros_like(water)
    return np.stack([water + weight, loads_at(structure, points[: len(forces)], forces)])


def _check_momentum(floater: ElasticFloater, structure: MemberFrame, shapes: Floats, modal: Floats) -> None:
    """Shapes carry no momentum: what moves with one and with a rigid motion at once is no shape of the free hull."""
    nodes = structure.frame.nodes
    motions = rigid_motions(nodes, nodes.mean(axis=0)).reshape(6, -1)
    inertia = np.sqrt(np.einsum("ij,ij->i", motions, (structure.frame.mass @ motions.T).T))
    shared = np.abs(shapes @ (structure.frame.mass @ motions.T)) / np.outer(np.sqrt(modal), inertia)
    if shared.max() > _MOMENTUM:
        shape, motion = np.unravel_index(int(shared.argmax()), shared.shape)
        name = ("surge", "sway", "heave", "roll", "pitch", "yaw")[motion]
        raise ParameterError(
            f"{floater.label}: shape {shape + 1} of its database moves the mass of the hull in {name}, by "
            f"{shared.max():.2g} of it; shapes must be free of rigid motion. Has the ballast changed since? Make the "
            "database anew."
        )


def _check_alike(floater: ElasticFloater, structure: MemberFrame, shapes: Floats, mass: Floats) -> None:
    """The shapes of the database make up the lowest ones that the structure has now."""
    own = shapes_of(structure, 1).shapes.reshape(1, -1)
    shared = shapes @ (structure.frame.mass @ own.T)
    part = float((shared.T @ np.linalg.solve(mass, shared))[0, 0] / (own @ (structure.frame.mass @ own.T))[0, 0])
    if part < _ALIKE:
        raise ParameterError(
            f"{floater.label}: the shapes of its database make up {part:.0%} of the lowest shape of its members; they "
            "are of another structure. Make the database anew."
        )
