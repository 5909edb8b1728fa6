"""Shapes as triangles: every rigid shape of fowtlib.language.shapes becomes a mesh in the axes of its frame. NumPy."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fowtlib.language import shapes

SIDES = 28  # of round things
ROD, BALL = 0.011, 0.018  # diameters that the picture chooses, as a share of the size of what it shows


@dataclass(frozen=True, eq=False)
class Mesh:
    """Points (n, 3) [m], unit normals (n, 3), and triangles (m, 3), numbers of points."""

    points: np.ndarray
    normals: np.ndarray
    triangles: np.ndarray


def mesh(shape: shapes.Shape, size: float) -> Mesh:
    """The mesh of a rigid shape; `size` [m] of the whole picture decides about diameters that nobody gave."""
    if isinstance(shape, shapes.Tube):
        diameters = np.full(len(shape.points), ROD * size) if shape.diameters is None else shape.diameters
        return tube(shape.points, diameters)
    if isinstance(shape, shapes.Box):
        return box(shape.centre, shape.size)
    if isinstance(shape, shapes.Ball):
        return ball(shape.centre, BALL * size if shape.diameter is None else shape.diameter)
    if isinstance(shape, shapes.Loft):
        return loft(shape.sections, shape.closed)
    raise TypeError(f"no mesh for a {type(shape).__name__}")


def joined(parts: list[Mesh]) -> Mesh:
    """One mesh of several."""
    offsets = np.cumsum([0, *(len(part.points) for part in parts)])
    return Mesh(
        np.concatenate([part.points for part in parts]),
        np.concatenate([part.normals for part in parts]),
        np.concatenate([part.triangles + offset for part, offset in zip(parts, offsets, strict=False)]),
    )


def tube(points: np.ndarray, diameters: np.ndarray) -> Mesh:
    """Frustums between the points, with a cap at both ends; two equal points make a step."""
    steps = np.diff(points, axis=0)
    lengths = np.linalg.norm(steps, axis=1)
    if not lengths.any():
        return ball(points[0], float(diameters.max()))
    long = np.flatnonzero(lengths)
    nearest = long[np.argmin(np.abs(np.arange(len(steps))[:, None] - long), axis=1)]  # a step has its neighbour's axis
    axes = steps[nearest] / lengths[nearest, None]
    radii = np.asarray(diameters, dtype=float) / 2
    around = np.linspace(0, 2 * np.pi, SIDES + 1)
    parts = []
    for i, axis in enumerate(axes):
        e, g = _across(axis)
        radial = np.cos(around)[:, None] * e + np.sin(around)[:, None] * g
        normal = radial * lengths[i] + axis * (radii[i] - radii[i + 1])
        normal /= np.linalg.norm(normal, axis=1, keepdims=True) + 1e-300
        rings = np.concatenate([points[i] + radii[i] * radial, points[i + 1] + radii[i + 1] * radial])
        parts.append(Mesh(rings, np.concatenate([normal, normal]), _grid(2, SIDES + 1)))
        if i == 0:
            parts.append(_cap(points[0], points[0] + radii[0] * radial, -axis))
        if i == len(axes) - 1:
            parts.append(_cap(points[-1], points[-1] + radii[-1] * radial, axis))
    return joined(parts)


def box(centre: np.ndarray, size: np.ndarray) -> Mesh:
    """Six faces with their own normals."""
    parts = []
    for axis in range(3):
        for side in (-1.0, 1.0):
            normal, e, g = side * np.eye(3)[axis], np.eye(3)[(axis + 1) % 3], np.eye(3)[(axis + 2) % 3]
            corners = np.array([normal - e - g, normal + e - g, normal - e + g, normal + e + g])
            parts.append(Mesh(centre + corners * size / 2, np.tile(normal, (4, 1)), _grid(2, 2)))
    return joined(parts)


def ball(centre: np.ndarray, diameter: float) -> Mesh:
    """A sphere of meridians and parallels."""
    down, around = np.meshgrid(np.linspace(0, np.pi, 13), np.linspace(0, 2 * np.pi, SIDES + 1), indexing="ij")
    out = np.stack([np.sin(down) * np.cos(around), np.sin(down) * np.sin(around), np.cos(down)], axis=-1)
    normals = out.reshape(-1, 3)
    return Mesh(centre + normals * diameter / 2, normals, _grid(13, SIDES + 1))


def loft(sections: np.ndarray, closed: bool = True) -> Mesh:
    """A smooth skin over sections (n, k, 3), which are closed lines; `closed`: with a cap at both ends."""
    rings = np.concatenate([sections, sections[:, :1]], axis=1)
    n, k, _ = rings.shape
    around = np.roll(sections, -1, axis=1) - np.roll(sections, 1, axis=1)
    along = np.gradient(sections, axis=0)
    normals = np.cross(around, along)
    outward = np.einsum("nki,nki->", normals, sections - sections.mean(axis=1, keepdims=True))
    normals *= (1 if outward.sum() >= 0 else -1) / (np.linalg.norm(normals, axis=2, keepdims=True) + 1e-300)
    normals = np.concatenate([normals, normals[:, :1]], axis=1)
    skin = Mesh(rings.reshape(-1, 3), normals.reshape(-1, 3), _grid(n, k))
    if not closed:
        return skin
    axis = sections[-1].mean(axis=0) - sections[0].mean(axis=0)
    axis /= np.linalg.norm(axis) + 1e-300
    ends = [_cap(sections[i].mean(axis=0), rings[i], sign * axis) for i, sign in ((0, -1), (-1, 1))]
    return joined([skin, *ends])


def arrow() -> Mesh:
    """An arrow of length 1 along x with its tip at the origin."""
    shaft = tube(np.array([[-1.0, 0, 0], [-0.22, 0, 0]]), np.array([0.04, 0.04]))
    head = tube(np.array([[-0.22, 0, 0], [0.0, 0, 0]]), np.array([0.13, 0.0]))
    return joined([shaft, head])


def _across(axis: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Two unit vectors across an axis and each other."""
    e = np.cross(axis, np.eye(3)[np.argmin(np.abs(axis))])
    e /= np.linalg.norm(e)
    return e, np.cross(axis, e)


def _cap(centre: np.ndarray, ring: np.ndarray, normal: np.ndarray) -> Mesh:
    """A fan from the centre over a closed ring, whose first point is repeated at the end."""
    n = len(ring)
    fan = np.array([(0, i, i + 1) for i in range(1, n)])
    return Mesh(np.concatenate([[centre], ring]), np.tile(normal, (n + 1, 1)), fan)


def _grid(rows: int, columns: int) -> np.ndarray:
    """Triangles between neighbouring rows of points, two for each cell."""
    first = (np.arange(rows - 1)[:, None] * columns + np.arange(columns - 1)).ravel()
    corners = [first, first + 1, first + columns, first + 1, first + columns + 1, first + columns]
    return np.stack(corners, axis=1).reshape(-1, 3)
