"""A line as point masses between elastic elements: the forces on its nodes, as expressions of arrays.

n elements join n + 1 nodes, from the anchor to the fairlead. A node has half of the mass, volume and length of the
elements beside it. With the unstretched length l of an element, its length L, direction e and the rate L' of L:

- tension T = max(f(L / l - 1) + c L' / l, 0), f the axial stiffness times the strain, or a table of a fibre rope; the
  corner is rounded over a force of SLACK of the stiffness, and a rope cannot push, whatever its damping;
- bending: the energy EI / (2 s) |e_i+1 - e_i|^2 of a node, s the mean length of the elements beside it, whose curvature
  is |e_i+1 - e_i| / s: moments EI curvature for angles that are small from element to element;
- water: Morison's forces on a node with its tangent q, across 1/2 rho C_d d l |u_n| u_n, along 1/2 rho C_t pi d l
  |u_t| u_t, of the water against the node; rho V (a + C_a a_n + C_at a_t) of its acceleration a, and the added masses
  rho V C_a across and rho V C_at along, so that the acceleration of a node is explicit;
- the still water level: what stands above it has no buoyancy, drag or added mass, the share by the heights that a node
  stands for;
- seabed: k d l times the depth below it, and damping c d l w of the speed w, only where they push; the touch begins
  smoothly, over a quarter of the depth to which the weight sinks in. Friction mu N v / sqrt(v^2 + CREEP^2) against the
  level velocity v of a node that pushes with N: at rest it lets go, slowly.

Sources: M. Hall and A. Goupee, Ocean Engineering 104 (2015) 590-603, whose scheme of half elements and tangents this
is; Morison's forces as in DNV-RP-C205 (2010), 6.2; bending: M. Bergou et al., ACM Trans. Graphics 27 (2008) 63, for
small angles.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import casadi as ca

from fowtlib.language import math as m
from fowtlib.language import quadratic

SLACK = 1e-7
"""Force, as a share of the axial stiffness, over which the corner of a slack element is rounded."""
CREEP = 0.01
"""Speed [m/s] at which friction has 0.7 of its size."""
TOUCH = 0.25
"""Depth, as a share of that to which the weight sinks into the seabed, over which the touch begins."""
FEATHER = 1e-9
"""Weight [N] of a node that counts as one without weight."""
STILL = 1e-3
"""Speed [m/s] of the rounding of quadratic drag; see `quadratic`."""


@dataclass(frozen=True, eq=False)
class Elements:
    """Properties of the elements, rows (1, n): lengths [m], EA [N], damping c [N s], mass [kg/m] and so on."""

    length: Any
    stiffness: Any
    damping: Any
    mass: Any
    diameter: Any
    bending: Any
    drag: Any
    axial_drag: Any
    added: Any
    axial_added: Any
    table: Any = None
    """Strains and tensions (k, 2) of a fibre rope, which take the place of the stiffness where `fibre` is 1."""
    fibre: Any = None

    @property
    def volume(self) -> Any:
        """Displaced volumes [m^3]."""
        return m.pi / 4 * self.diameter**2 * self.length


@dataclass(frozen=True, eq=False)
class Points:
    """What stands on the nodes, rows (1, n + 1): masses [kg], volumes [m^3], C_d A [m^2], added mass coefficients."""

    mass: Any
    volume: Any
    drag_area: Any
    added: Any


@dataclass(frozen=True, eq=False)
class Surroundings:
    """Water and seabed: densities [kg/m^3], gravity [m/s^2], depth [m], k [Pa/m], c [Pa s/m], friction (1, n).

    velocity and acceleration (3, n + 1) are those of the water at the nodes, world.
    """

    density: Any
    gravity: Any
    depth: Any
    stiffness: Any
    damping: Any
    friction: Any
    velocity: Any
    acceleration: Any


def at_nodes(of_elements: Any) -> Any:
    """Half of what the elements beside each node have, (rows, n + 1)."""
    half = of_elements / 2
    none = ca.SX.zeros(half.shape[0], 1)
    return ca.horzcat(none, half) + ca.horzcat(half, none)


def _wide(row: Any) -> Any:
    """A row three times below itself."""
    return ca.repmat(ca.SX(row), 3, 1)


def _dots(a: Any, b: Any) -> Any:
    return ca.sum1(a * b)


def directions(nodes: Any) -> tuple[Any, Any]:
    """Lengths (1, n) of the elements between nodes (3, n + 1), and their directions (3, n)."""
    ways = nodes[:, 1:] - nodes[:, :-1]
    lengths = ca.sqrt(_dots(ways, ways))
    return lengths, ways / _wide(lengths)


def tensions(nodes: Any, velocities: Any, line: Elements) -> Any:
    """Tensions (1, n) of the elements."""
    lengths, along = directions(nodes)
    rate = _dots(along, velocities[:, 1:] - velocities[:, :-1]) / line.length
    strain = lengths / line.length - 1
    width = SLACK * line.stiffness
    elastic = line.stiffness * strain
    if line.table is not None:
        elastic = ca.if_else(line.fibre, tabulated(strain, line.table), elastic)
    pull = elastic + line.damping * rate
    return (pull + ca.sqrt(pull**2 + width**2)) / 2


def tabulated(strain: Any, table: Any) -> Any:
    """Tension over strain: straight pieces through the points (k, 2) and beyond, corners rounded over 1e-5."""
    count = table.shape[0]
    slopes = [(table[i + 1, 1] - table[i, 1]) / (table[i + 1, 0] - table[i, 0]) for i in range(count - 1)]
    value = table[0, 1] + slopes[0] * (strain - table[0, 0])
    for i in range(1, count - 1):
        above = strain - table[i, 0]
        value += (slopes[i] - slopes[i - 1]) * (above + ca.sqrt(above**2 + 1e-10)) / 2
    return value


def curvatures(nodes: Any, line: Elements) -> Any:
    """Curvatures (1, n - 1) [1/m] at the nodes between the ends."""
    along = directions(nodes)[1]
    turn = along[:, 1:] - along[:, :-1]
    return ca.sqrt(_dots(turn, turn) + 1e-24) / ((line.length[:, 1:] + line.length[:, :-1]) / 2)


def shears(nodes: Any, line: Elements) -> Any:
    """Forces (3, n) across the elements that bending puts on their lower nodes, and against their upper ones."""
    lengths, along = directions(nodes)
    mean = (line.length[:, 1:] + line.length[:, :-1]) / 2
    rigidity = (line.bending[:, 1:] + line.bending[:, :-1]) / 2
    turn = (along[:, 1:] - along[:, :-1]) * _wide(rigidity / mean)
    none = ca.SX.zeros(3, 1)
    couple = ca.horzcat(none, turn) - ca.horzcat(turn, none)
    return (couple - along * _wide(_dots(along, couple))) / _wide(lengths)


@dataclass(frozen=True, eq=False)
class Loads:
    """Forces (3, n + 1) on the nodes without those of the elements, and masses along and across the tangent (1, n + 1).

    weight: weight less buoyancy (1, n + 1), which is among the forces.
    """

    force: Any
    weight: Any
    tangent: Any
    axial_mass: Any
    normal_mass: Any

    def accelerations(self, force: Any) -> Any:
        """Of nodes under forces (3, n + 1)."""
        along = _dots(self.tangent, force)
        a = force / _wide(self.normal_mass)
        return a + self.tangent * _wide(along * (1 / self.axial_mass - 1 / self.normal_mass))

    def inertia(self, accelerations: Any) -> Any:
        """Force that nodes of these accelerations (3, n + 1) take."""
        along = _dots(self.tangent, accelerations)
        return accelerations * _wide(self.normal_mass) + self.tangent * _wide(
            along * (self.axial_mass - self.normal_mass)
        )


def tangents(nodes: Any) -> Any:
    """Unit vectors (3, n + 1) along the line at the nodes: between the neighbours; at the ends along the element."""
    count = nodes.shape[1]
    before, after = [0, *range(count - 1)], [*range(1, count), count - 1]
    ways = nodes[:, after] - nodes[:, before]
    return ways / _wide(ca.sqrt(_dots(ways, ways)))


def wet(nodes: Any, diameter: Any) -> Any:
    """Share (1, n + 1) of each node that lies below the still water level: over the heights that it stands for."""
    count = nodes.shape[1]
    before, after = [0, *range(count - 1)], [*range(1, count), count - 1]
    half = ca.fabs(nodes[2, after] - nodes[2, before]) / 4 + diameter[0, [0, *range(count - 1)]] / 2
    s = ca.fmax(ca.fmin(nodes[2, :] / half, 1), -1)
    return 0.5 - 0.75 * s + 0.25 * s**3


def loads(nodes: Any, velocities: Any, line: Elements, points: Points, around: Surroundings) -> Loads:
    """The loads on the nodes; inside equations() only, because drag is told to the frequency domain."""
    rho, q = around.density, tangents(nodes)
    share = wet(nodes, ca.SX(line.diameter))
    volume = at_nodes(line.volume) + points.volume
    mass = at_nodes(line.mass * line.length) + points.mass
    added = rho * share * (at_nodes(line.added * line.volume) + points.added * points.volume)
    axial_added = rho * share * (at_nodes(line.axial_added * line.volume) + points.added * points.volume)
    down = around.gravity * (mass - rho * share * volume)
    flow = around.velocity - velocities
    along = _dots(q, flow)
    across = flow - q * _wide(along)
    area = at_nodes(line.drag * line.diameter * line.length)
    skin = at_nodes(line.axial_drag * m.pi * line.diameter * line.length)
    drag = []
    for k in range(nodes.shape[1]):
        force = area[k] * quadratic(across[:, k], STILL) + skin[k] * quadratic(along[k], STILL, "axial drag") * q[:, k]
        if not ca.SX(points.drag_area[k]).is_zero():
            force += points.drag_area[k] * quadratic(flow[:, k], STILL, "drag of a point")
        drag.append(rho / 2 * share[k] * force)
    wave = around.acceleration
    by_waves = _wide(rho * share * volume + added) * wave + q * _wide(_dots(q, wave) * (axial_added - added))
    force = ca.horzcat(*drag) + by_waves + seabed(nodes, velocities, down, line, around)
    return Loads(force - ca.vertcat(ca.SX.zeros(2, nodes.shape[1]), down), down, q, mass + axial_added, mass + added)


def seabed(nodes: Any, velocities: Any, weight: Any, line: Elements, around: Surroundings) -> Any:
    """Forces (3, n + 1) of the seabed; a point on a node rests on it by its weight, sinking in as the line does."""
    own = at_nodes((line.mass - around.density * m.pi / 4 * line.diameter**2) * line.length) * around.gravity
    heavy = ca.fmax(own, FEATHER)
    area = at_nodes(line.diameter * line.length)
    stiffness = area * ca.fmax(weight, heavy) / heavy
    depth = -around.depth - nodes[2, :]
    width = TOUCH * heavy / (around.stiffness * area)
    size = ca.sqrt(depth**2 + width**2)
    touching = (1 + depth / size) / 2
    push = stiffness * (around.stiffness * (depth + size) / 2 - around.damping * touching * velocities[2, :])
    push = ca.fmax(push, 0)
    level = velocities[:2, :]
    grip = at_nodes(around.friction * line.length) / at_nodes(line.length) * push
    friction = -level * ca.repmat(grip / ca.sqrt(ca.sum1(level**2) + CREEP**2), 2, 1)
    return ca.vertcat(friction, push)
