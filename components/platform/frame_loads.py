"""Loads on the frame of a hull: those at rest, the stiffness that they give it, and the loads in its sections.

At rest the water presses on the panels of the hull, and gravity pulls at its beams and masses. Each is a load on the
section that carries it, and so on the nodes beside it. Section loads are those by which the elastic displacements
strain the beams, so that a beam knows what acts between its ends only at the ends; short beams (`longest`) make up
for that.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fowtlib.components.hydro.deformation import quadrature
from fowtlib.components.hydro.hull_mesh import HullMesh
from fowtlib.components.platform.hull import APART
from fowtlib.components.platform.member_frame import FAR, MemberFrame
from fowtlib.components.platform.space_frame import SpaceFrame, leaning, rigid_motions
from fowtlib.language.errors import ParameterError

if TYPE_CHECKING:
    from scipy import sparse

Floats = NDArray[np.float64]


def water_at_rest(structure: MemberFrame, panels: ArrayLike) -> Floats:
    """Loads (n, 6) on the nodes over rho g by the pressure -z on panels (k, 4, 3), normals into the water."""
    points, weight = quadrature(panels)
    count = len(points) // 3  # triangles, each by three points
    points, force = points.reshape(count, 3, 3), (points[:, 2, None] * weight).reshape(count, 3, 3)
    middle = points.mean(axis=1)
    moment = np.cross(points - middle[:, None], force).sum(axis=1)
    total = np.zeros((len(structure.frame.nodes), 6))
    for place, push, turn in zip(middle, force.sum(axis=1), moment, strict=True):
        total += _carried(structure, place, push, turn)
    return total


def weight_at_rest(frame: SpaceFrame, gravity: float) -> Floats:
    """Loads (n, 6) on the nodes by the weight of all beams and masses; z is up."""
    down = rigid_motions(frame.nodes)[2].reshape(-1)
    return -gravity * (frame.mass @ down).reshape(-1, 6)


def loads_at(structure: MemberFrame, points: ArrayLike, forces: ArrayLike) -> Floats:
    """Loads (n, 6) on the nodes of forces (p, 3) at points (p, 3) of the hull."""
    total = np.zeros((len(structure.frame.nodes), 6))
    for point, force in zip(np.asarray(points, dtype=float), np.asarray(forces, dtype=float), strict=True):
        total += _carried(structure, point, force)
    return total


def unit_loads(structure: MemberFrame, points: ArrayLike) -> Floats:
    """Loads (6 p, n, 6) on the nodes of a unit force and moment about each axis at points (p, 3) of the hull."""
    units = np.split(np.eye(6), 6)
    loads = [_carried(structure, point, unit[0, :3], unit[0, 3:])
             for point in np.asarray(points, dtype=float).reshape(-1, 3) for unit in units]  # fmt: skip
    return np.array(loads).reshape(-1, len(structure.frame.nodes), 6)


def stiffness_by_loads(frame: SpaceFrame, loads: ArrayLike, gravity: float) -> sparse.csc_matrix:
    """What loads (n, 6) at rest, weight among them, add to the stiffness: what beams bear, and masses above nodes.

    The beams have the tension, shear, moments and torsion by which they bear the loads, with inertia relief where those
    are not in balance. A mass that stands above its node falls with it.
    """
    matrix = frame.stress_stiffness(frame.relieved(np.asarray(loads)[None])[0]).tolil()
    for one in frame.masses:
        turns = slice(6 * one.node + 3, 6 * one.node + 6)
        matrix[turns, turns] += leaning((0.0, 0.0, one.mass * gravity), one.centre)
    return matrix.tocsc()


class SectionRecovery:
    """Loads in sections of a frame from the coordinates of its shapes and from loads that are known by their place.

    Loads by their place are not only what they do to the shapes: what the shapes leave of their displacement, with the
    inertia of the structure, is added (the mode acceleration of R.L. Bisplinghoff, H. Ashley and R.L. Halfman,
    Aeroelasticity (1955), 10.2). places (s, 3): points on members; shapes (k, n, 6).
    Axes of a section: along its member from start to end, and the two directions across, as a Beam has them.
    """

    def __init__(self, structure: MemberFrame, shapes: ArrayLike, places: ArrayLike):
        self.structure, self.frame = structure, structure.frame
        self.shapes = np.asarray(shapes, dtype=float).reshape(len(np.asarray(shapes)), -1)
        self.where = [structure.carrier(place) for place in np.asarray(places, dtype=float).reshape(-1, 3)]
        self._carried = self.frame.mass @ self.shapes.T
        self._own = self.shapes @ self._carried

    def by_displacements(self, displacements: ArrayLike) -> Floats:
        """Force [N] and moment [N m] (m, s, 6) of what is beyond on what is before, for displacements (m, n, 6)."""
        found = [self.frame.section_loads(one) for one in np.asarray(displacements, dtype=float)]
        return np.array([[(1 - share) * ends[beam, 0] + share * ends[beam, 1] for beam, share in self.where]
                         for ends in found]).reshape(len(found), len(self.where), 6)  # fmt: skip

    def by_shapes(self) -> Floats:
        """Section loads (k, s, 6) per coordinate of each shape."""
        return self.by_displacements(self.shapes.reshape(len(self.shapes), -1, 6))

    def by_loads(self, loads: ArrayLike) -> Floats:
        """Section loads (m, s, 6) of loads (m, n, 6) on the nodes beyond what the shapes have of them."""
        bent = self.frame.relieved(loads).reshape(-1, self.shapes.shape[1])
        rest = bent - np.linalg.solve(self._own, self._carried.T @ bent.T).T @ self.shapes
        return self.by_displacements(rest.reshape(len(rest), -1, 6))

    def by_points(self, points: ArrayLike) -> Floats:
        """The same (p, 6, s, 6) of unit forces and moments at points (p, 3), in the axes of the frame."""
        given = np.asarray(points, dtype=float).reshape(-1, 3)
        loads = unit_loads(self.structure, given)
        found = self.by_loads(loads) if len(loads) else np.zeros((0, len(self.where), 6))
        return found.reshape(len(given), 6, len(self.where), 6)

    def axes(self) -> Floats:
        """Columns (s, 3, 3) of each section: along the member, first and second direction across."""
        return np.array([self.frame.axes(beam) for beam, _ in self.where]).reshape(-1, 3, 3)


def check_carried(structure: MemberFrame, places: ArrayLike, name: str) -> None:
    """Raises ParameterError for a point that no member carries: a joint that meets no node of the frame."""
    for k, (x, y, z) in enumerate(np.asarray(places, dtype=float).reshape(-1, 3)):
        distance, member = structure.nearest(np.array([x, y, z]))
        if distance > FAR:
            raise ParameterError(
                f"{name}[{k}]: the point ({x:g}, {y:g}, {z:g}) m meets no node of the frame: it is {distance:.2g} "
                f"radii from the axis of {member}, the nearest member. Put it on a member, or lead a member to it."
            )


def check_mesh(structure: MemberFrame, mesh: HullMesh) -> None:
    """Raises ParameterError for a mesh that is not that of the frame: off its members, or of another volume."""
    volume = structure.hull.buoyancy.volume
    if abs(mesh.volume / volume - 1) > APART:
        raise ParameterError(
            f"the mesh {mesh.name} holds {mesh.volume:.6g} m^3, and the members of the frame {volume:.6g} m^3: the "
            "mesh does not match the frame. Are draft, origin and unit the same?"
        )
    for x, y, z in mesh.panels.mean(axis=1):
        distance, member = structure.nearest(np.array([x, y, z]))
        if distance > FAR:
            raise ParameterError(
                f"the mesh {mesh.name} does not match the frame: its panel at ({x:g}, {y:g}, {z:g}) m is "
                f"{distance:.2g} radii from the axis of {member}, the nearest member. Are draft, origin and unit the "
                "same?"
            )


def check_on_axes(structure: MemberFrame, places: ArrayLike, name: str) -> None:
    """Raises ParameterError for a point that lies in no beam of the frame, as inside of a wider member."""
    for x, y, z in np.asarray(places, dtype=float).reshape(-1, 3):
        point = np.array([x, y, z])
        apart = np.inf
        if structure.nearest(point)[0] <= FAR:
            beam, share = structure.carrier(point)
            piece = structure.pieces[beam]
            axis = structure.hull.members[piece.member].at(piece.low + share * (piece.high - piece.low))
            apart = float(np.linalg.norm(axis - point))
        if apart > 0.01 * max(1.0, structure.longest):
            raise ParameterError(
                f"{name}: the point ({x:g}, {y:g}, {z:g}) m lies on no beam of the frame; a section is on the "
                "axis of a member, outside of wider ones."
            )


def _carried(structure: MemberFrame, place: Floats, force: Floats, moment: ArrayLike = (0.0, 0.0, 0.0)) -> Floats:
    """Loads (n, 6) on the nodes of a force and a moment at a point, by the section that carries it."""
    beam, share = structure.carrier(place)
    axis = structure.frame.place(beam, share)
    on_axis = np.concatenate([force, np.asarray(moment) + np.cross(place - axis, force)])
    return structure.frame.carried(beam, share, on_axis)[0]
