"""Panels that are mirror images of each other, for a hull that is symmetric while its panels are not.

A mesher that cuts members with each other makes panels that differ from side to side. Where the surface is the same on
both sides of x = 0 or y = 0, one side is cut off at the plane and taken twice; the panel method then solves a part.
"""

from __future__ import annotations

import contextlib
from dataclasses import replace

import numpy as np

from fowtlib.components.hydro.hull_mesh import HullMesh, clipped
from fowtlib.language.errors import ParameterError

_SNAP = 0.01  # of the median width of panels: corners nearer to the plane are put on it, so that no slivers are cut
_TOUCH = 1e-6  # the same, where that opens the hull
_ASIDE = 0.25  # of the same: how far the two sides may lie apart (polygons of circles do not turn alike)
_VOLUME = 1e-3  # relative difference of the volumes of the two sides
_SAMPLES = 5  # points along each side of a panel, by which the panels near a point are found
_NEIGHBOURS = 24  # of such points


def with_mirrored_panels(hull: HullMesh) -> HullMesh:
    """The same hull, of panels on one side of its planes of symmetry and their mirror images, where that saves work.

    The hull itself where its panels are symmetric already, or its surface is not. Volume and waterplane change by
    0.1 % at most.
    """
    found = hull
    for axis, plane in ((1, "xOz"), (0, "yOz")):
        if plane in found.symmetry.planes or found.symmetry.rotation > 2:
            continue
        for snap in (_SNAP, _TOUCH):
            halves = [_half(found.panels, axis, sign, snap) for sign in (1, -1)]
            if not all(map(len, halves)) or not _alike(*halves):
                break
            images = []
            for sign, half in zip((1, -1), halves, strict=True):
                lid = _half(found.lid, axis, sign, snap) if len(found.lid) else found.lid
                images.append({"panels": _with_image(half, axis), "lid": _with_image(lid, axis)})
            # of a hull that leaks, the half without a gap; else gaps of its panels may stay, and no others come in
            tries = [(images[0], False)] if hull.watertight else [(image, False) for image in images]
            tries += [(images[0], True)] if snap == _TOUCH and not hull.watertight else []
            whole = next(filter(None, (_tight(found, image, leaky) for image, leaky in tries)), None)
            if whole is not None:
                found = whole
                break
    return found if found.symmetry.fold > hull.symmetry.fold else hull


def _tight(hull: HullMesh, image: dict[str, np.ndarray], leaky: bool) -> HullMesh | None:
    """The hull of these panels and lid; None where a corner that divides an edge was moved off it, or a gap is left."""
    with contextlib.suppress(ParameterError):
        return replace(hull, **image, leaky=leaky)
    return None


def _half(panels: np.ndarray, axis: int, sign: int, snap: float) -> np.ndarray:
    """What of the panels lies where the coordinate has this sign; the other side turned to it by a mirror."""
    turned = panels.copy()
    turned[:, :, axis] *= sign
    turned[:, :, axis][np.abs(turned[:, :, axis]) < snap * _width(panels)] = 0.0
    order = [1 - axis, 2, axis]
    cut = turned[:, :, order] * [1, 1, -1]
    inside = clipped(cut) * [1, 1, -1]
    half = inside[:, :, np.argsort(order)]
    half = half[half[:, :, axis].max(axis=1) > 0]  # what lies in the plane is no surface
    return half if sign > 0 else half[:, ::-1]


def _with_image(half: np.ndarray, axis: int) -> np.ndarray:
    image = half[:, ::-1].copy()
    image[:, :, axis] *= -1
    return np.concatenate([half, image])


def _alike(one: np.ndarray, other: np.ndarray) -> bool:
    """Whether two halves are the same surface: by their volumes, and by the distance of one from the other."""
    volumes = [_volume(half) for half in (one, other)]
    if abs(volumes[0] - volumes[1]) > _VOLUME * abs(volumes[0]):
        return False
    far = max(_distances(a, b).max() for a, b in ((one, other), (other, one)))
    return bool(far < _ASIDE * _width(one))


def _volume(half: np.ndarray) -> float:
    """By z: the plane of symmetry, which closes the half, is upright and adds nothing."""
    triangles = np.concatenate([half[:, [0, 1, 2]], half[:, [0, 2, 3]]])
    normal = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])[:, 2] / 2
    return float(triangles[:, :, 2].mean(axis=1) @ normal)


def _distances(panels: np.ndarray, surface: np.ndarray) -> np.ndarray:
    """Distance (n,) of the centre of each panel from another surface [m]."""
    from scipy.spatial import cKDTree

    points = panels.mean(axis=1)
    s, t = (c.reshape(-1, 1, 1) for c in np.meshgrid(np.linspace(0, 1, _SAMPLES), np.linspace(0, 1, _SAMPLES)))
    a, b, c, d = surface.transpose(1, 0, 2)
    samples = (1 - s) * ((1 - t) * a + t * b) + s * ((1 - t) * d + t * c)  # small panels lie beside large ones
    _, near = cKDTree(samples.reshape(-1, 3)).query(points, k=_NEIGHBOURS)
    near = near % len(surface)
    found = np.full(len(points), np.inf)
    for k in range(near.shape[1]):
        quads = surface[near[:, k]]
        for corners in ((0, 1, 2), (0, 2, 3)):
            found = np.minimum(found, _from_triangle(points, quads[:, corners]))
    return found


def _from_triangle(points: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Distance (n,) of each point from its triangle (n, 3, 3)."""
    normal = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    size = np.linalg.norm(normal, axis=1)
    unit = normal / np.maximum(size, 1e-300)[:, None]
    height = ((points - triangles[:, 0]) * unit).sum(axis=1)
    inside, edges = size > 1e-12, np.full(len(points), np.inf)
    for i in range(3):
        a, b = triangles[:, i], triangles[:, (i + 1) % 3]
        along = b - a
        inside &= (np.cross(along, points - a) * unit).sum(axis=1) >= 0
        part = ((points - a) * along).sum(axis=1) / np.maximum((along**2).sum(axis=1), 1e-300)
        edges = np.minimum(edges, np.linalg.norm(points - a - np.clip(part, 0, 1)[:, None] * along, axis=1))
    return np.where(inside, np.abs(height), edges)


def _width(panels: np.ndarray) -> float:
    diagonal = np.linalg.norm(panels[:, 2] - panels[:, 0], axis=1)
    return float(np.median(diagonal)) / np.sqrt(2)
