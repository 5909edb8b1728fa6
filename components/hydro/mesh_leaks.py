"""Whether the panels of a hull are watertight, and where they are not: which edge, which gap, which panel is turned.

Every edge of a closed hull belongs to two panels that run along it in opposite directions; only at the still water
level (z = 0) is there one. An edge that is divided on one side only closes, too, where its points lie on one line.
"""

from __future__ import annotations

from collections import Counter

import numpy as np

from fowtlib.language.errors import ParameterError

SAME = 1e-6  # of the extent of the mesh: corners that are nearer are one point
_LEVEL = 1e-5  # of the extent of the mesh: what is nearer to z = 0 lies on the water level
_SHOWN = 3  # leaks that a message names


class LeakError(ParameterError):
    """A mesh of panels that has gaps below the water level."""


def check_closed(panels: np.ndarray, name: str = "hull", reach: float = 0.0) -> None:
    """Raise LeakError, with the places of the gaps [m], if the panels (n, 4, 3) do not close below z = 0.

    ParameterError where one of them is turned, or there twice.

    reach: how far from an edge a corner may lie that divides it [m]; at least a millionth of the extent.
    """
    points, edges = _edges(panels)
    if turned := _twice(edges):
        a, b = points[list(turned)]
        raise ParameterError(f"{name}: two panels run the same way along the edge from {_place(a)} to {_place(b)}: the "
                             "normal of one of them points into the hull, or the two cover each other. List "
                             "the corners of the one in the other order, or leave one away")
    level = _LEVEL * _extent(points)
    free = [(a, b) for a, b in _unmatched(points, edges, reach) if min(points[a][2], points[b][2]) < -level]
    if not free:
        return
    holes = _holes(free)
    holes.sort(key=lambda hole: -_length(points, hole))
    loose = points[np.unique(free)]
    shown = "; ".join(_told(points, hole, loose) for hole in holes[:_SHOWN])
    more = f"; and {len(holes) - _SHOWN} more" if len(holes) > _SHOWN else ""
    number = "an open rim" if len(holes) == 1 else f"{len(holes)} open rims"
    raise LeakError(f"{name}: the mesh leaks, along {number}: {shown}{more}. Join the corners there, or close "
                         "the gap with panels")


def joined(panels: np.ndarray, reach: float) -> np.ndarray:
    """The panels (n, 4, 3) with corners that are nearer than `reach` [m] put on one point, their mean."""
    label, points = _clusters(panels.reshape(-1, 3), reach)
    return points[label].reshape(-1, 4, 3)


def free_edges(panels: np.ndarray) -> tuple[np.ndarray, list[tuple[int, int]]]:
    """Points (k, 3), and the edges (from, to) that belong to one panel only, in the direction in which it runs."""
    points, edges = _edges(panels)
    return points, _unmatched(points, edges, 0.0)


def _edges(panels: np.ndarray) -> tuple[np.ndarray, list[tuple[int, int]]]:
    """Points, near ones joined, and the directed edges of all panels; those that cancel within a panel left out."""
    corners = panels.reshape(-1, 3)
    label, points = _clusters(corners, SAME * _extent(corners))
    quads = label.reshape(-1, 4)
    ends = np.stack([quads, np.roll(quads, -1, axis=1)], axis=2).reshape(-1, 2)
    return points, [(int(a), int(b)) for a, b in ends if a != b]


def _clusters(corners: np.ndarray, reach: float) -> tuple[np.ndarray, np.ndarray]:
    """Which point (k, 3) each corner belongs to, corners within `reach` being one point."""
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components
    from scipy.spatial import cKDTree

    pairs = cKDTree(corners).query_pairs(reach, output_type="ndarray")
    links = coo_matrix((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(len(corners),) * 2)
    number, label = connected_components(links, directed=False)
    points, count = np.zeros((number, 3)), np.bincount(label)
    np.add.at(points, label, corners)
    return label, points / count[:, None]


def _twice(edges: list[tuple[int, int]]) -> tuple[int, int] | None:
    """An edge that is run along twice in one direction and never in the other."""
    counts = Counter(edges)
    return next((edge for edge, n in counts.items() if n > counts[edge[::-1]] + 1), None)


def _unmatched(points: np.ndarray, edges: list[tuple[int, int]], reach: float) -> list[tuple[int, int]]:
    """Edges without their counterpart, after long ones were divided at the free points that lie on them."""
    from scipy.spatial import cKDTree

    rest = _without_counterparts(edges)
    if not rest:
        return []
    loose = np.unique(rest)
    tree, near = cKDTree(points[loose]), max(SAME * _extent(points), reach)
    divided = []
    for a, b in rest:
        start, end = points[a], points[b]
        length = float(np.linalg.norm(end - start))
        close = loose[tree.query_ball_point((start + end) / 2, length / 2 + near)]
        along = (points[close] - start) @ (end - start) / length
        off = np.linalg.norm(points[close] - start - along[:, None] * (end - start) / length, axis=1)
        on = close[(off < near) & (along > near) & (along < length - near)]
        stops = [a, *on[np.argsort((points[on] - start) @ (end - start))].tolist(), b]
        divided += zip(stops[:-1], stops[1:], strict=True)
    return _without_counterparts(divided)


def _without_counterparts(edges: list[tuple[int, int]]) -> list[tuple[int, int]]:
    counts = Counter(edges)
    return [edge for edge, n in counts.items() for _ in range(n - min(n, counts[edge[::-1]]))]


def _holes(edges: list[tuple[int, int]]) -> list[list[tuple[int, int]]]:
    """The edges, those together that hang together."""
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components

    ends = np.array(edges)
    names, index = np.unique(ends, return_inverse=True)
    index = index.reshape(ends.shape)
    size = (names.size, names.size)
    _, label = connected_components(coo_matrix((np.ones(len(index)), index.T), shape=size), directed=False)
    groups: dict[int, list[tuple[int, int]]] = {}
    for edge, (start, _) in zip(edges, index, strict=True):
        groups.setdefault(int(label[start]), []).append(edge)
    return list(groups.values())


def _told(points: np.ndarray, hole: list[tuple[int, int]], loose: np.ndarray) -> str:
    """How many edges a rim has, the longest of them, and how near its corners come to another one on a rim."""
    from scipy.spatial import cKDTree

    ends = np.array(hole)
    lengths = np.linalg.norm(points[ends[:, 1]] - points[ends[:, 0]], axis=1)
    a, b = ends[int(lengths.argmax())]
    corners = points[np.unique(ends)]
    nearest, index = cKDTree(loose).query(corners, k=2)
    at = int(nearest[:, 1].argmin())
    count = "one edge" if len(hole) == 1 else f"{len(hole)} edges"
    return (f"{count} without a neighbour, the longest from {_place(points[a])} to {_place(points[b])}, the nearest "
            f"two corners {nearest[at, 1]:.3g} m apart, at {_place(corners[at])} and {_place(loose[index[at, 1]])}")


def _length(points: np.ndarray, hole: list[tuple[int, int]]) -> float:
    ends = np.array(hole)
    return float(np.linalg.norm(points[ends[:, 1]] - points[ends[:, 0]], axis=1).sum())


def _extent(points: np.ndarray) -> float:
    return float(np.ptp(points, axis=0).max())


def _place(point: np.ndarray) -> str:
    return "(" + ", ".join(f"{round(float(value), 4):g}" for value in point) + ")"
