"""Motions of a hull as fields: rigid ones, and shapes into which it deforms; the stiffness that pressure gives them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Field:
    """Displacements (m, k, 3) of k points in m shapes, and their gradients (m, k, 3, 3): [..., i, j] du_i / dx_j.

    Points that rigid sections carry have besides the turns (m, k, 3) of their section, and their arms (k, 3) from its
    axis: to the second order they go round it, and not straight on.
    """

    displacement: Floats
    gradient: Floats
    turn: Floats | None = None
    arm: Floats | None = None


Deformation = Callable[[Floats], Field]


def rigid_field(points: ArrayLike) -> Field:
    """Surge, sway, heave, roll, pitch and yaw about the origin."""
    places = np.asarray(points, dtype=float).reshape(-1, 3)
    moved, gradient = np.zeros((6, len(places), 3)), np.zeros((6, len(places), 3, 3))
    for k in range(3):
        axis = np.eye(3)[k]
        moved[k] = axis
        moved[3 + k] = np.cross(axis, places)
        gradient[3 + k] = np.cross(axis, np.eye(3)).T
    return Field(moved, gradient)


def together(*fields: Field) -> Field:
    """The shapes of several fields, one after the other, without sections."""
    return Field(np.concatenate([one.displacement for one in fields]), np.concatenate([one.gradient for one in fields]))


def pressure_stiffness(panels: ArrayLike, deformation: Deformation) -> Floats:
    """Hydrostatic stiffness over rho g (m, m) of panels (n, 4, 3) by the pressure on them; normals into the water.

    K_ij = -int u^i . [u^j_z n + z (div u^j n - grad(u^j)^T n)] dS: the pressure at the moved place, on the moved
    surface, by the shapes at rest. Weight, and stresses that the structure has at rest, add what makes it symmetric
    and turns the arms of moments with the hull; for rigid motions take `HullMesh.stiffness`.
    Where sections carry the points, what the pressure does along their second-order way comes to it: across a tube it
    is -p A on turns of its axis, which the stress around the section would have if points went straight on. With the
    tension of the walls, N, it leaves the effective tension N + p A (C.P. Sparks, J. Energy Resources Technology 106
    (1984) 46-54).
    Source: L.L. Huang and H.R. Riggs, Marine Structures 13 (2000) 91-106.
    """
    points, weight = quadrature(panels)
    field = deformation(points)
    moved, gradient = field.displacement, field.gradient
    divergence = np.einsum("mkii->mk", gradient)
    turned = divergence[..., None] * weight - np.einsum("mkij,ki->mkj", gradient, weight)
    change = moved[..., 2, None] * weight + points[:, 2, None] * turned
    straight = -np.einsum("ika,jka->ij", moved, change)
    if field.turn is None or field.arm is None:
        return straight
    return straight + _around(-points[:, 2, None] * weight, field.turn, field.arm)


def _around(push: Floats, turn: Floats, arm: Floats) -> Floats:
    """Stiffness (m, m) of forces -push (k, 3) at arms (k, 3): energy push . turn x (turn x arm) / 2."""
    by_push, by_arm = np.einsum("mka,ka->mk", turn, push), np.einsum("mka,ka->mk", turn, arm)
    mixed = by_push @ by_arm.T
    return (mixed + mixed.T) / 2 - np.einsum("ika,jka,k->ij", turn, turn, np.einsum("ka,ka->k", push, arm))


@dataclass(frozen=True)
class ShapeStiffness:
    """Stiffness over rho g that buoyancy gives shapes: between them (m, m), and with the rigid motions (m, 6).

    A shape is carried along by the body that turns, so that its stiffness with roll and pitch is by the pressure at the
    turned place alone, and both ways the same, as buoyancy has a potential. Surge, sway and yaw have none.
    """

    among: Floats
    with_rigid: Floats


def shape_stiffness(panels: ArrayLike, deformation: Deformation) -> ShapeStiffness:
    """What buoyancy gives the shapes of a hull of panels (n, 4, 3), normals into the water."""
    points, weight = quadrature(panels)
    flux = np.einsum("mka,ka->mk", deformation(points).displacement, weight)
    x, y, _ = points.T
    with_rigid = np.zeros((len(flux), 6))
    with_rigid[:, 2], with_rigid[:, 3], with_rigid[:, 4] = -flux.sum(axis=1), -flux @ y, flux @ x
    return ShapeStiffness(pressure_stiffness(panels, deformation), with_rigid)


def quadrature(panels: ArrayLike) -> tuple[Floats, Floats]:
    """Points (k, 3) of a quadrature that is exact to the second degree, and the normals times the area (k, 3)."""
    corners = np.asarray(panels, dtype=float)
    triangles = np.concatenate([corners[:, [0, 1, 2]], corners[:, [0, 2, 3]]])
    normal = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0]) / 2
    kept = np.linalg.norm(normal, axis=1) > 0
    middle = (triangles[kept] + np.roll(triangles[kept], -1, axis=1)) / 2  # of the sides
    return middle.reshape(-1, 3), np.repeat(normal[kept] / 3, 3, axis=0)
