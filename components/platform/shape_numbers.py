"""Numbers of a floater that bends: modal mass and stiffness, loads at rest and in sections, when a run starts."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fowtlib.components.hydro.deformation import shape_stiffness
from fowtlib.components.platform.frame_loads import (
    SectionRecovery,
    check_carried,
    check_on_axes,
    loads_at,
    stiffness_by_loads,
    unit_loads,
    water_at_rest,
    weight_at_rest,
)
from fowtlib.components.platform.member_frame import MemberFrame
from fowtlib.components.platform.space_frame import FrameModes, SpaceFrame, rigid_motions
from fowtlib.language.errors import ParameterError

if TYPE_CHECKING:
    from fowtlib.components.platform.bending_hull import BendingHull

Floats = NDArray[np.float64]
SAME_NODE = 1e-3  # m
RHO = 1025.0  # kg/m^3: density for which buoyancy of own shapes is computed; ShapeHydrostatics scales it
_SAME_SHAPE = 1e-8  # of shapes that are the same but for this share
_MOMENTUM = 1e-3  # largest share of the mass that moves with a shape as with a rigid motion
_ALIKE = 0.95  # least part of each own shape that the shapes of the database make up


def shapes_of(structure: MemberFrame, count: int, attached: ArrayLike = ()) -> FrameModes:
    """The lowest shapes of the free structure, of one metre at most; frequencies [rad/s].

    attached (p, 3) [m]: points where something heavy stands. Each adds six shapes, into which the structure bends
    under a force or a moment there and its own inertia: free shapes alone have no moment at an end, and many of them
    make up for that (S. Rubin, AIAA J. 13 (1975) 995-1006).
    They are made orthogonal to the others and to each other, so that they are the shapes of a smaller structure.
    """
    modes = structure.frame.modes(6 + count)
    if len(modes.frequencies) < 6 + count:
        raise ParameterError(f"the frame has {len(modes.frequencies) - 6} shapes, and {count} are asked; set longest.")
    found, frequencies = modes.shapes[6:].reshape(count, -1), modes.frequencies[6:]
    points = np.asarray(attached, dtype=float).reshape(-1, 3)
    if len(points):
        bent = structure.frame.relieved(unit_loads(structure, points)).reshape(6 * len(points), -1)
        own = np.concatenate([found, bent / np.abs(bent).max(axis=1)[:, None]])
        frequencies, found = _ritz(structure.frame, own)
    shapes = found.reshape(len(found), -1, 6)
    return FrameModes(frequencies, shapes / np.linalg.norm(shapes[:, :, :3], axis=2).max(axis=1)[:, None, None])


def _ritz(frame: SpaceFrame, shapes: Floats) -> tuple[Floats, Floats]:
    """Frequencies and shapes (m, 6 n) of the structure that bends into these only; dependent ones are left out."""
    mass, stiffness = (shapes @ (matrix @ shapes.T) for matrix in (frame.mass, frame.stiffness))
    size = 1 / np.sqrt(np.diag(mass))
    value, vector = np.linalg.eigh(mass * np.outer(size, size))
    kept = value > _SAME_SHAPE * value.max()
    basis = (vector[:, kept] / np.sqrt(value[kept])).T * size
    squares, mixed = np.linalg.eigh(basis @ stiffness @ basis.T)
    return np.sqrt(np.maximum(squares, 0.0)), mixed.T @ basis @ shapes


@dataclass(frozen=True, eq=False)
class ShapesInUse:
    """The shapes of a floater: of its database, or the lowest of its structure as it is now.

    shapes (k, p, 6) on nodes (p, 3); at_rest (p, 6): load of the water at rest on the nodes over rho g [m^3, m^4];
    among (k, k), with_rigid (k, 6): stiffness by buoyancy over rho g, see hydro.deformation.
    """

    nodes: Floats
    shapes: Floats
    at_rest: Floats
    among: Floats
    with_rigid: Floats


def shapes_in_use(floater: BendingHull) -> ShapesInUse:
    """Those of its database; without one computed, the water at rest on panels as wide as beams are long."""
    known = floater.database
    if known is None:
        structure = floater.member_frame()
        attached = rows_of(floater, "node_points")[: floater.attached] + _raised(floater)
        check_carried(structure, attached, f"{floater.label}.node_points")
        used = _own_shapes(structure, floater.shapes, tuple(map(tuple, attached.tolist())))
        if len(used.shapes) != floater.count:
            raise ParameterError(
                f"{floater.label}: its attached nodes do not have six shapes each beside the {floater.shapes} lowest; "
                "take fewer shapes, or attach fewer nodes."
            )
        return used
    weight = known.rho * known.g
    return ShapesInUse(
        known.nodes, known.shapes, known.at_rest / weight, known.among / weight, known.with_rigid / weight
    )


@lru_cache(maxsize=16)
def _own_shapes(structure: MemberFrame, count: int, attached: tuple[tuple[float, ...], ...]) -> ShapesInUse:
    shapes, panels = shapes_of(structure, count, attached).shapes, structure.hull.panels(structure.longest)
    stiffness = shape_stiffness(panels, lambda points: structure.field(points, shapes))
    among = (stiffness.among + stiffness.among.T) / 2
    return ShapesInUse(structure.frame.nodes, shapes, water_at_rest(structure, panels), among, stiffness.with_rigid)


def rows_of(floater: BendingHull, name: str) -> Floats:
    """A parameter of points or forces as rows (n, 3)."""
    values = np.asarray(floater.parameter_value(name), dtype=float)
    if values.size and (values.ndim != 2 or values.shape[1] != 3):
        raise ParameterError(f"{floater.label}.{name} must be a list of rows (x, y, z).")
    return values.reshape(-1, 3)


def shape_numbers(floater: BendingHull) -> Floats:
    """Modal mass, stiffness, what nodes do with each shape, section loads; everything is checked when a run starts."""
    known, structure = shapes_in_use(floater), floater.member_frame()
    frame, nodes = structure.frame, structure.frame.nodes
    if nodes.shape != known.nodes.shape or np.abs(nodes - known.nodes).max() > SAME_NODE:
        raise ParameterError(
            f"{floater.label}: the frame of its members has {len(nodes)} nodes that are not the {len(known.nodes)} of "
            "its database; members, or longest, are others than when it was made. Make it anew."
        )
    count = len(known.shapes)
    points, cuts = (rows_of(floater, name) + _raised(floater) for name in ("node_points", "section_points"))
    check_carried(structure, points, f"{floater.label}.node_points")
    check_on_axes(structure, cuts, f"{floater.label}.section_points")
    resting = loads_at_rest(floater, structure, points)
    gravity = float(floater.world.parameter_value("gravity"))
    shapes = known.shapes.reshape(count, -1)
    mass = shapes @ (frame.mass @ shapes.T)
    stiffness = shapes @ ((frame.stiffness + stiffness_by_loads(frame, resting.sum(axis=0), gravity)) @ shapes.T)
    _check_momentum(floater, structure, shapes, np.diag(mass))
    _check_alike(floater, structure, shapes, mass)
    moved = structure.field(points, known.shapes).displacement  # (k, points, 3)
    turned = structure.turn(points, known.shapes) if len(points) else moved
    at_nodes = np.stack([moved, turned]).transpose(2, 0, 3, 1)  # points, kind, axis, shape
    recovery = SectionRecovery(structure, known.shapes, cuts)
    recovered = [
        recovery.by_loads(resting[:1]).ravel(), recovery.by_shapes().reshape(count, -1).T.ravel(),
        recovery.by_points(points).reshape(6 * len(points), -1).T.ravel(),
    ] if len(cuts) else []  # fmt: skip
    load = shapes @ resting[0].ravel()
    own = [] if floater.database is not None else [known.among.ravel(), known.with_rigid.ravel()]
    floats = [RHO * gravity * stiffness for stiffness in own]
    return np.concatenate([mass.ravel(), stiffness.ravel(), at_nodes.ravel(), *recovered, load, *floats])


def _raised(floater: BendingHull) -> Floats:
    return np.array([0.0, 0.0, float(floater.parameter_value("raised"))])


def loads_at_rest(floater: BendingHull, structure: MemberFrame, points: Floats) -> Floats:
    """Loads (2, n, 6) on the nodes of the frame at rest: of water and weight, and of the `node_forces`."""
    density, gravity = (float(floater.world.parameter_value(name)) for name in ("water_density", "gravity"))
    forces = rows_of(floater, "node_forces")
    if len(forces) not in (0, len(points)):
        raise ParameterError(
            f"{floater.label}.node_forces has {len(forces)} rows, and there are {len(points)} node_points; give one "
            "force for each, or none."
        )
    water = shapes_in_use(floater).at_rest * density * gravity
    weight = weight_at_rest(structure.frame, gravity) if water.any() else np.zeros_like(water)
    return np.stack([water + weight, loads_at(structure, points[: len(forces)], forces)])


def _check_momentum(floater: BendingHull, structure: MemberFrame, shapes: Floats, modal: Floats) -> None:
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


def _check_alike(floater: BendingHull, structure: MemberFrame, shapes: Floats, mass: Floats) -> None:
    """The shapes of the database make up the lowest ones that the structure has now."""
    own = shapes_of(structure, 1).shapes.reshape(1, -1)
    shared = shapes @ (structure.frame.mass @ own.T)
    part = float((shared.T @ np.linalg.solve(mass, shared))[0, 0] / (own @ (structure.frame.mass @ own.T))[0, 0])
    if part < _ALIKE:
        raise ParameterError(
            f"{floater.label}: the shapes of its database make up {part:.0%} of the lowest shape of its members; they "
            "are of another structure. Make the database anew."
        )
