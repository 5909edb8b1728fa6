"""The shape of a line of point masses at rest between two places, in NumPy: where runs start.

The nodes are those of fowtlib.components.mooring.lumped_mass, without bending, friction and current.
The way to it is that of a line in honey: implicit steps along -dE/dr, of growing length, with the exact stiffness of
the elements, the seabed and the weight, so that the energy E falls whatever the start is.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fowtlib.components.mooring.lumped_mass import SLACK
from fowtlib.language.errors import ModelError

Floats = NDArray[np.float64]

SETTLED = 3e-8
"""Force on a node at rest, as a share of the largest weight of one."""


@dataclass(frozen=True)
class StaticLine:
    """Numbers of elements (n,): length [m], tension(strain) and its slope, and of nodes (n + 1,): weight [N].

    lift: buoyancy [N] of the nodes under water, which is in their weight; diameter [m]. ground: stiffness [N/m] of the
    seabed at each node, depth [m]; width [m] over which it begins.
    """

    length: Floats
    tension: Any
    weight: Floats
    lift: Floats
    diameter: Floats
    ground: Floats
    width: Floats
    depth: float


def rounded(pull: Floats, slope: Floats, stiffness: Floats) -> tuple[Floats, Floats]:
    """A pull that cannot push, and its slope."""
    size = np.sqrt(pull**2 + (SLACK * stiffness) ** 2)
    return (pull + size) / 2, slope * (1 + pull / size) / 2


def _forces(nodes: Floats, line: StaticLine) -> tuple[Floats, Floats, Floats]:
    """Forces (n + 1, 3) on the nodes, stiffnesses (n, 3, 3) of the elements and (n + 1,) of the seabed, upwards."""
    ways = np.diff(nodes, axis=0)
    lengths = np.linalg.norm(ways, axis=1)
    along = ways / lengths[:, None]
    pull, slope = line.tension(lengths / line.length - 1)
    force = np.zeros_like(nodes)
    force[:-1] += pull[:, None] * along
    force[1:] -= pull[:, None] * along
    outer = along[:, :, None] * along[:, None, :]
    stiffness = (slope / line.length)[:, None, None] * outer + (pull / lengths)[:, None, None] * (np.eye(3) - outer)
    below = -line.depth - nodes[:, 2]
    size = np.sqrt(below**2 + line.width**2)
    force[:, 2] += line.ground * (below + size) / 2 - line.weight
    half = np.abs(np.diff(nodes[:, 2], prepend=nodes[0, 2]) + np.diff(nodes[:, 2], append=nodes[-1, 2])) / 4
    half = half + line.diameter / 2
    s = np.clip(nodes[:, 2] / half, -1, 1)
    force[:, 2] -= line.lift * (0.5 + 0.75 * s - 0.25 * s**3)
    upright = line.ground * (1 + below / size) / 2 + np.maximum(line.lift, 0) * 0.75 * (1 - s**2) / half
    return force, stiffness, upright


def settled(nodes: Floats, line: StaticLine) -> Floats:
    """The nodes (n + 1, 3) at rest between the ends that they have; ModelError where they do not settle.

    A line that does not, stiff and slack, is tried as a soft one first.
    """
    found = _settled(nodes, line)
    for softness in (1e-3, 1e-2, 1e-1, 1.0) if found is None else ():
        found = _settled(nodes, _softer(line, softness))
        nodes = nodes if found is None else found
    if found is None:
        raise ModelError("the line does not come to rest between its ends where the run starts.")
    return found


def _softer(line: StaticLine, share: float) -> StaticLine:
    def tension(strain: Floats) -> tuple[Floats, Floats]:
        pull, slope = line.tension(strain)
        return share * pull, share * slope

    return replace(line, tension=tension)


def _settled(nodes: Floats, line: StaticLine) -> Floats | None:
    nodes, total = nodes.copy(), float(np.sum(np.abs(line.weight)))
    force, stiffness, ground = _forces(nodes, line)
    step = 1e-3 / max(float(np.max(stiffness)), 1e-12)
    for _ in range(500):
        size = float(np.max(np.abs(force[1:-1])))
        if size < SETTLED * np.max(np.abs(line.weight)):
            return nodes
        move = _solved(force[1:-1], stiffness, ground[1:-1], 1 / step)
        longest = np.max(np.linalg.norm(move, axis=1)) / np.min(line.length)
        if not np.isfinite(longest):
            break
        tried = nodes.copy()
        tried[1:-1] += move
        after = _forces(tried, line)
        if longest > 0.5 or np.max(np.abs(after[0][1:-1])) > 2 * max(size, total):  # over the hill, not down it
            step /= 4
            continue
        nodes, (force, stiffness, ground) = tried, after
        step = min(step * (4 if longest < 0.1 else 1.5), 1e12)
        if longest < 1e-11 and step > 1e-2 / np.min(np.abs(stiffness[:, [0, 1, 2], [0, 1, 2]]).max(axis=1)):
            return nodes
    if np.max(np.abs(force[1:-1])) < 1e-4 * np.max(np.abs(line.weight)):  # what lies on the seabed, slack
        return nodes
    return None


def _solved(force: Floats, stiffness: Floats, ground: Floats, honey: float) -> Floats:
    """Displacements (k, 3) of the nodes between the ends: banded, three unknowns a node."""
    from scipy.linalg import solve_banded

    count = len(force)
    own = stiffness[:-1] + stiffness[1:] + honey * np.eye(3)
    own[:, 2, 2] += ground
    bands = np.zeros((11, 3 * count))
    for i in range(3):
        for j in range(3):
            bands[5 + i - j, j::3] = own[:, i, j]
            if count > 1:
                bands[5 + i - j - 3, 3 + j :: 3] = -stiffness[1:-1, i, j]
                bands[5 + i - j + 3, j : 3 * (count - 1) : 3] = -stiffness[1:-1, i, j]
    return solve_banded((5, 5), bands, force.ravel()).reshape(count, 3)


def first_shape(start: Floats, end: Floats, stations: Floats, length: float, depth: float) -> Floats:
    """A first guess (n + 1, 3): a sag of about the right length between the ends, above the seabed."""
    ways = end - start
    straight = float(np.linalg.norm(ways))
    points = start + stations[:, None] * ways
    sag = np.sqrt(max(length**2 - straight**2, 0.0)) * np.sqrt(3 / 8) if length > straight else 0.0
    points[:, 2] -= 4 * sag * stations * (1 - stations)
    lowest = min(-depth, float(start[2]), float(end[2]))
    points[1:-1, 2] = np.maximum(points[1:-1, 2], lowest)
    return points
