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
from fowtlib.components.platform.floater import Floater
from fowtlib.components.platform.hull import Hull
from fowtlib.components.platform.member_frame import MemberFrame
from fowtlib.components.platform.space_frame import FrameModes
from fowtlib.language import Data, Number, Scalar, data, param
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
    small, the motion of the frame is not. Drag acts on the members as if they were rigid, and buoyancy of shapes is
    linear. Mass and stiffness of the shapes follow from the members when a run starts.
    Errors: shapes that carry momentum, a database of another structure or of other shapes, nodes off the hull.
    """

    database: Data[ModalDatabase] = data(read_modal_database, doc="potential flow of the hull and its shapes")
    longest: Number = param(default=5.0, unit="m", min=0.1, structural="it divides the frame", doc="longest beam")
    young_modulus: Scalar = param(default=210e9, unit="Pa", min=1.0, doc="Young's modulus of all walls")
    shear_modulus: Scalar = param(default=80.8e9, unit="Pa", min=1.0, doc="shear modulus of all walls")
    damping_time: Scalar = param(default=0.0, unit="s", min=0, doc="damping over stiffness of the structure")

    def build(self):
        count, points = self.database.count, len(self.node_rows())
        self._numbers = StartNumbers(self, "shapes", count * count * 2 + 6 * count * points, shape_numbers)
        self.structure = ElasticBody(
            shapes=count, mass=self._matrix(0, count, count), stiffness=self._matrix(count**2, count, count),
            damping_time=self.damping_time,
        )  # fmt: skip
        super().build()
        self.connect(self.structure.modes, self.potential_flow.modes)

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
    path: str | Path | None = None, **options,
) -> ModalDatabase:  # fmt: skip
    """The potential flow of the rigid motions and the lowest `count` shapes of a floater of members.

    omega [rad/s], headings [rad], panel: about their width [m]; longest beam [m] and moduli [Pa] as the part has them.
    options: density, gravity, path, progress of `hydro.panel.solve_hull`, whose errors are raised.
    """
    from fowtlib.components.hydro.panel import solve_shapes  # with its optional package

    hull = floater.hull()
    structure = MemberFrame(hull, longest, young_modulus, shear_modulus)
    shapes = shapes_of(structure, count).shapes
    mesh = HullMesh(hull.panels(panel), hull.lids(panel), floater.label, join=_SAME_NODE)
    return solve_shapes(
        mesh, lambda points: structure.field(points, shapes), structure.frame.nodes, shapes, omega=omega,
        headings=headings, water_depth=water_depth, path=path, **options,
    )  # fmt: skip


def shape_numbers(floater: ElasticFloater) -> Floats:
    """Modal mass, stiffness, and what nodes do with each shape, when a run starts; everything is checked then."""
    known, structure = floater.database, floater.member_frame()
    nodes = structure.frame.nodes
    if nodes.shape != known.nodes.shape or np.abs(nodes - known.nodes).max() > _SAME_NODE:
        raise ParameterError(
            f"{floater.label}: the frame of its members has {len(nodes)} nodes that are not the {len(known.nodes)} of "
            "its database; members, or longest, are others than when it was made. Make it anew."
        )
    shapes = known.shapes.reshape(known.count, -1)
    mass, stiffness = (shapes @ (matrix @ shapes.T) for matrix in (structure.frame.mass, structure.frame.stiffness))
    _check_momentum(floater, structure, shapes, np.diag(mass))
    _check_alike(floater, structure, shapes, mass)
    points = np.asarray(floater.parameter_value("node_points"), dtype=float).reshape(-1, 3)
    raised = points + [0.0, 0.0, float(floater.parameter_value("raised"))]
    moved = structure.field(raised, known.shapes).displacement  # (k, points, 3)
    turned = structure.turn(raised, known.shapes) if len(points) else moved
    at_nodes = np.stack([moved, turned]).transpose(2, 0, 3, 1)  # points, kind, axis, shape
    return np.concatenate([mass.ravel(), stiffness.ravel(), at_nodes.ravel()])


def _check_momentum(floater: ElasticFloater, structure: MemberFrame, shapes: Floats, modal: Floats) -> None:
    """Shapes carry no momentum: what moves with one and with a rigid motion at once is no shape of the free hull."""
    nodes = structure.frame.nodes
    rigid = np.zeros((6, len(nodes), 6))
    for k in range(3):
        axis = np.eye(3)[k]
        rigid[k, :, :3] = axis
        rigid[3 + k, :, :3], rigid[3 + k, :, 3:] = np.cross(axis, nodes - nodes.mean(axis=0)), axis
    motions = rigid.reshape(6, -1)
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
