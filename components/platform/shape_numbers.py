"""Numbers of a floater that bends: modal mass and stiffness, loads at rest and in sections, when a run starts."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from fowtlib.components.hydro.deformation import shape_stiffness
from fowtlib.components.platform.frame_loads import (
    SectionRecovery,
    check_carried,
    check_on_axes,
    loads_at,
    stiffness_by_loads,
    water_at_rest,
    weight_at_rest,
)
from fowtlib.components.platform.member_frame import MemberFrame
from fowtlib.components.platform.space_frame import FrameModes, rigid_motions
from fowtlib.language.errors import ParameterError

if TYPE_CHECKING:
    from fowtlib.components.platform.elastic_floater import ElasticFloater

Floats = NDArray[np.float64]
SAME_NODE = 1e-3  # m
RHO = 1025.0  # kg/m^3: density for which buoyancy of own shapes is computed; ShapeHydrostatics scales it
_MOMENTUM = 1e-3  # largest share of the mass that moves with a shape as with a rigid motion
_ALIKE = 0.95  # least part of each own shape that the shapes of the database make up


def shapes_of(structure: MemberFrame, count: int) -> FrameModes:
    """The lowest shapes of the free structure, of one metre at most; frequencies [rad/s]."""
    modes = structure.frame.modes(6 + count)
    if len(modes.frequencies) < 6 + count:
        raise ParameterError(f"the frame has {len(modes.frequencies) - 6} shapes, and {count} are asked; set longest.")
    shapes = modes.shapes[6:] / np.linalg.norm(modes.shapes[6:, :, :3], axis=2).max(axis=1)[:, None, None]
    return FrameModes(modes.frequencies[6:], shapes)


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


def shapes_in_use(floater: ElasticFloater) -> ShapesInUse:
    """Those of its database; without one computed, the water at rest on panels as wide as beams are long."""
    known = floater.database
    if known is None:
        return _own_shapes(floater.member_frame(), floater.count)
    weight = known.rho * known.g
    return ShapesInUse(
        known.nodes, known.shapes, known.at_rest / weight, known.among / weight, known.with_rigid / weight
    )


@lru_cache(maxsize=16)
def _own_shapes(structure: MemberFrame, count: int) -> ShapesInUse:
    shapes, panels = shapes_of(structure, count).shapes, structure.hull.panels(structure.longest)
    stiffness = shape_stiffness(panels, lambda points: structure.field(points, shapes))
    among = (stiffness.among + stiffness.among.T) / 2
    return ShapesInUse(structure.frame.nodes, shapes, water_at_rest(structure, panels), among, stiffness.with_rigid)


def rows_of(floater: ElasticFloater, name: str) -> Floats:
    """A parameter of points or forces as rows (n, 3)."""
    values = np.asarray(floater.parameter_value(name), dtype=float)
    if values.size and (values.ndim != 2 or values.shape[1] != 3):
        raise ParameterError(f"{floater.label}.{name} must be a list of rows (x, y, z).")
    return values.reshape(-1, 3)


def shape_numbers(floater: ElasticFloater) -> Floats:
    """Modal mass, stiffness, what nodes do with each shape, section loads; everything is checked when a run starts."""
    known, structure = shapes_in_use(floater), floater.member_frame()
    frame, nodes = structure.frame, structure.frame.nodes
    if nodes.shape != known.nodes.shape or np.abs(nodes - known.nodes).max() > SAME_NODE:
        raise ParameterError(
            f"{floater.label}: the frame of its members has {len(nodes)} nodes that are not the {len(known.nodes)} of "
            "its database; members, or longest, are others than when it was made. Make it anew."
        )
    count = len(known.shapes)
    raise_by = [0.0, 0.0, float(floater.parameter_value("raised"))]
    points, cuts = (rows_of(floater, name) + raise_by for name in ("node_points", "section_points"))
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


def loads_at_rest(floater: ElasticFloater, structure: MemberFrame, points: Floats) -> Floats:
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
