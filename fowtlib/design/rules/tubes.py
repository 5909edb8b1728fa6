"""Rules for all sections of a hull or a tower at once, from its sizes at nodes and the loads of a response.

A tube has nodes from its foot up; diameters (outer) and walls are linear in between, and a section counts as the
cylinder of its mean radius and wall. Quantities are columns, of numbers or of CasADi expressions, in SI units.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import pi, tan
from typing import Any

import casadi as ca
import numpy as np

from fowtlib.design.rules.column import column_slenderness
from fowtlib.design.rules.cost import SteelCost, steel_cost, tube_sections
from fowtlib.design.rules.either import between, demand_nodes, is_expression, larger, smaller, total
from fowtlib.design.rules.limits import heave_period
from fowtlib.design.rules.ring import Ring, panel_ring
from fowtlib.design.rules.shell import cylinder_stress, hoop_stress, shell_buckling
from fowtlib.design.rules.tower import tower_buckling
from fowtlib.design.splines import basis
from fowtlib.language.errors import ModelError

YEARS_20 = 20 * 365.25 * 86400.0


def column(values: Any) -> Any:
    """Numbers, expressions, or a list of both as one column."""
    if isinstance(values, (list, tuple)) and any(is_expression(item) for item in values):
        return ca.vertcat(*values)
    return values if is_expression(values) else np.ravel(np.asarray(values, dtype=float))


def spread(values: Any, sections: int) -> Any:
    """One number for all sections, one for each, or the control points of a B-spline over their numbers."""
    values = column(values)
    count = values.numel() if is_expression(values) else values.size
    if count == sections:
        return values
    weights = basis(np.arange(sections), count)  # of one, ones
    return ca.mtimes(ca.DM(weights), values) if is_expression(values) else weights @ values


def rings_of(sizes: tuple[Any, Any, Any, Any, Any], sections: int) -> Ring:
    """T-rings of a hull: web height and thickness, flange width and thickness, spacing; see `spread`."""
    return Ring(*(spread(item, sections) for item in sizes))


def _middles(values: Any) -> Any:
    low, high = between(values)
    return (low + high) / 2


def _count(values: Any) -> int:
    return values.numel() if is_expression(values) else int(np.size(values))


def _joined(*columns: Any) -> Any:
    return ca.vertcat(*columns) if any(is_expression(item) for item in columns) else np.hstack(columns)


def _ends(values: Any) -> Any:
    """Lower ends of all sections, then their upper ends."""
    return _joined(*between(values))


def _at_nodes(known: Any, nodes: int) -> Any:
    """Loads at all nodes, of those at all nodes, or at those from the second on, or fewer.

    The lowest node has the load of the second, what is left at the top that of the last.
    """
    count = _count(known)
    below = 0 if count == nodes else 1
    return _joined(*[known[0]] * below, known, *[known[-1]] * (nodes - below - count))


@dataclass(frozen=True)
class HullUse:
    """Utilisations [-] of each section of a hull: the shell between rings, rings, and the hull as a column.

    Rings: area, inertia, stress, web, flange, torsion; the column: its slenderness. By ends there are those of all
    lower ends, then of all upper ones, but for web, flange and column.
    """

    shell: Any
    area: Any
    inertia: Any
    stress: Any
    web: Any
    flange: Any
    torsion: Any
    column: Any


def hull_buckling(
    heights: Any, diameters: Any, walls: Any, moments: Any, axial_forces: Any, web_height: Any, web_thickness: Any,
    flange_width: Any, flange_thickness: Any, spacing: Any, *, ends: bool = False, load_factor: float = 1.35,
    least_factor: float = 1.10, water_density: float = 1025.0, gravity: float = 9.80665,
) -> HullUse:  # fmt: skip
    """Shell, panel-ring and column buckling of all sections of a hull of a spar, DNV-RP-C202 (see the single rules).

    heights above the still water level, diameters, walls (n,) at the nodes [m]; moments [N m], the largest of either
    sign, and axial_forces [N], mean, negative in compression and without the pressure of the water on the section, at
    the nodes from the second on; the keel bears what the second node does, and at nodes above those that are given
    loads are as at the last. A section counts as the cylinder of its mean radius and wall with the worse loads of its
    ends and the pressure of the lower one; with `ends`, as two: each end with its own sizes, loads and pressure. (A
    wall that goes up and down from node to node has thin ends, which the mean hides.) Water presses from outside and
    along the hull; ballast does not press back. The load factor is on the moment, as on all that the weather does.
    Rings: `spread`.
    """
    z, D, t, M, N = (column(item) for item in (heights, diameters, walls, moments, axial_forces))
    demand_nodes("hull buckling", heights=z, diameters=D, walls=t)
    nodes = _count(z)
    pressed = (pi / 4) * D**2 * water_density * gravity * larger(-z, 0.0)
    axial, bent = _at_nodes(N - pressed[1 : 1 + _count(N)], nodes), _at_nodes(M, nodes)
    rings = rings_of((web_height, web_thickness, flange_width, flange_thickness, spacing), nodes - 1)
    if ends:
        r, wall, depth, axial, bent = (_ends(item) for item in ((D - t) / 2, t, -z, axial, bent))
        ring = Ring(*(_joined(item, item) for item in vars(rings).values()))
    else:
        r, wall, depth, ring = _middles(D - t) / 2, _middles(t), -between(z)[0], rings
        axial, bent = smaller(*between(axial)), larger(*between(bent))
    pressure = water_density * gravity * larger(depth, 0.0)
    stress, bending, _ = cylinder_stress(r, wall, axial, -load_factor * bent)
    hoop = hoop_stress(pressure, stress + bending, r, wall, ring.spacing, ring.area, ring.flange_radius(r, wall))
    shell = shell_buckling(stress, bending, r, wall, ring.spacing, hoop_stress=hoop.between, least_factor=least_factor)
    frame = panel_ring(ring, r, wall, stress + bending, pressure)
    slender = column_slenderness(z[-1] - z[0], _middles(D - t) / 2)
    return HullUse(shell.utilisation, frame.area, frame.inertia, frame.stress, frame.web[: nodes - 1],
                   frame.flange[: nodes - 1], frame.torsion, slender)  # fmt: skip


def hull_cost(
    heights: Any, diameters: Any, walls: Any, web_height: Any, web_thickness: Any, flange_width: Any,
    flange_thickness: Any, spacing: Any, *, density: float = 7850.0,
) -> SteelCost:  # fmt: skip
    """Cost [EUR], mass [kg] and minutes of a hull with its rings; see `steel_cost`."""
    z, D, t = (column(item) for item in (heights, diameters, walls))
    ring = rings_of((web_height, web_thickness, flange_width, flange_thickness, spacing), _count(z) - 1)
    return steel_cost(tube_sections(z, D, t), ring, density=density)


def ring_fraction(
    heights: Any, diameters: Any, walls: Any, web_height: Any, web_thickness: Any, flange_width: Any,
    flange_thickness: Any, spacing: Any,
) -> Any:  # fmt: skip
    """Mass of the rings of a hull over that of its wall."""
    z, D, t = (column(item) for item in (heights, diameters, walls))
    sizes = (web_height, web_thickness, flange_width, flange_thickness, spacing)
    return hull_cost(z, D, t, *sizes).mass / steel_cost(tube_sections(z, D, t)).mass - 1.0


def tower_cost(heights: Any, diameters: Any, walls: Any, *, density: float = 8500.0) -> SteelCost:
    """Cost [EUR], mass [kg] and minutes of a tower without rings; see `steel_cost`."""
    return steel_cost(tube_sections(column(heights), column(diameters), column(walls)), density=density)


def tower_use(
    heights: Any, diameters: Any, walls: Any, moments: Any, top_mass: float, *, load_factor: float = 1.35,
    density: float = 8500.0, gravity: float = 9.80665,
) -> Any:  # fmt: skip
    """Buckling utilisations [-] of all sections of a tower, stiffened at its nodes, EN 1993-1-6 (see tower_buckling).

    heights, diameters, walls, moments (n,) at the nodes [m, N m], the larger of both ends of a section counts;
    top_mass [kg] stands on the tower. The load factor is on all stresses.
    """
    z, D, t, M = (column(item) for item in (heights, diameters, walls, moments))
    demand_nodes("tower buckling", heights=z, diameters=D, walls=t, moments=M)
    (low, high), r, wall = between(z), (_middles(D) - _middles(t)) / 2, _middles(t)
    masses = density * pi * (high - low) * _middles((D - t) * t)
    n = _count(z) - 1
    above = [top_mass + total(masses[k:]) for k in range(n)]
    axial, bending, _ = cylinder_stress(r, wall, -gravity * column(above), -larger(*between(_at_nodes(M, n + 1))))
    return tower_buckling(load_factor * (axial + bending), r, wall, high - low).utilisation


def tube_fatigue(
    ranges: Any, diameters: Any, walls: Any, factor: float, *, first: int = 0, slope: float = 5.0,
    intercept: float = 15.606, lifetime: float = YEARS_20, thickness_exponent: float = 0.2,
    reference_thickness: float = 0.025,
) -> Any:  # fmt: skip
    """Damage [-] of a life times a design fatigue factor at the nodes of a tube, from ranges of moments [N m].

    The ranges are those of 1 Hz with the exponent `slope` (damage-equivalent), the curve is 10^intercept S^-slope with
    S in MPa: by default the branch of many cycles of curve D, DNV-RP-C203. Stress M r / I of a thin tube at its middle.
    ranges (m,): at the nodes from number `first` on; weighted over the states with their probabilities, it is that of
    the life.
    """
    R, D, t = (column(item) for item in (ranges, diameters, walls))
    D, t = (item[first : first + _count(R)] for item in (D, t))
    stress = R / (pi * ((D - t) / 2) ** 2 * t) * 1e-6
    thick = (larger(t, reference_thickness) / reference_thickness) ** thickness_exponent
    return factor * lifetime * (stress * thick) ** slope / 10**intercept


def tapers(heights: Any, diameters: Any, *, limit: float = pi / 18) -> Any:
    """Half angle of each section over its limit [rad] by their tangents, positive where it widens upwards."""
    (low, high), (below, above) = between(column(heights)), between(column(diameters))
    return (above - below) / (2 * (high - low)) / tan(limit)


def unevenness(heights: Any, values: Any) -> Any:
    """Sum over the inner nodes of the squares of how much the slope of diameters or walls changes there [-].

    Sections are judged by their mean sizes, nodes by their own, so that sizes that go up and down from node to node
    cost nearly nothing; a small price on this keeps them smooth.
    """
    (low, high), (below, above) = between(column(heights)), between(column(values))
    first, second = between((above - below) / (high - low))
    return total((second - first) ** 2)


def sizes_at(heights: Any, known_heights: Any, known_sizes: Any) -> Any:
    """Sizes [m] at heights, linear between those that are known and on along the outermost pieces: walls by depth.

    known_heights are numbers that grow (ModelError otherwise). Slopes have a step at each of them.
    """
    z, size = np.asarray(known_heights, dtype=float), np.asarray(known_sizes, dtype=float)
    demand_nodes("sizes", heights=z, sizes=size)
    if np.any(np.diff(z) <= 0):
        raise ModelError("sizes at heights: those that are known are given from the lowest to the highest.")
    slopes = np.diff(size) / np.diff(z)
    at = column(heights)
    found = size[0] + slopes[0] * (at - z[0])
    for height, bend in zip(z[1:-1], np.diff(slopes), strict=True):
        found = found + bend * (larger(at, height) - height)  # of heights, so that a kink is rounded off over some
    return found


def spar_heave_period(heights: Any, diameters: Any, line_load: Any = 0.0, line_stiffness: Any = 0.0, *,
                      lines: int = 3, water_density: float = 1025.0, gravity: float = 9.80665,
                      keel: str = "node") -> Any:  # fmt: skip
    """Natural period [s] in heave of a spar that floats at rest, from its shape; one node at the water line, 0.

    Each of the lines pulls down with line_load [N], which is displaced, but does not move with the spar; line_stiffness
    [N/m] is by how much that grows per metre of heave (`hanging_line` has both).
    keel: "node", the disc has the diameter of the lowest node and the water line its own; "section": the mean diameters
    of the lowest section and of the one above the water, as in J.M. Hegseth et al. (2020).
    """
    z, D = column(heights), column(diameters)
    (low, high), (below, above) = between(z), between(D)
    wet = smaller(high, 0.0) - smaller(low, 0.0)
    volume = total(pi / 12 * wet * (below**2 + below * above + above**2))
    disc = D[0] if keel == "node" else (D[0] + D[1]) / 2
    surface = D[-2] if keel == "node" else (D[-2] + D[-1]) / 2
    mass = water_density * volume - lines * line_load / gravity
    return heave_period(mass, disc, surface, water_density, gravity, lines * line_stiffness)


def tube_mass(heights: Any, diameters: Any, walls: Any, density: Any) -> Any:
    """Mass [kg] of a tube with diameters and walls that are linear between its nodes."""
    z, D, t = (column(item) for item in (heights, diameters, walls))
    area = (D - t) * t
    (low, high), (below, above) = between(z), between(area)
    return density * pi * total((high - low) / 6 * (below + above + 4 * _middles(D - t) * _middles(t)))


def spar_ballast(
    heights: Any, diameters: Any, walls: Any, ring_share: Any, tower_heights: Any, tower_diameters: Any,
    tower_walls: Any, top_mass: Any, line_load: Any, *, lines: int = 3, density: float = 7850.0,
    tower_density: float = 8500.0, water_density: float = 1025.0, gravity: float = 9.80665,
) -> Any:  # fmt: skip
    """Ballast [kg] with which a spar floats at its draft: buoyancy less the weights of all else.

    Hull and tower are cones with linear walls, ring_share is the mass of the rings over that of the wall; top_mass [kg]
    stands on the tower, and each of the lines pulls down with line_load [N]. One node of the hull is at 0.
    """
    z, D = column(heights), column(diameters)
    (low, high), (below, above) = between(z), between(D)
    wet = smaller(high, 0.0) - smaller(low, 0.0)
    displaced = water_density * total(pi / 12 * wet * (below**2 + below * above + above**2))
    steel = (1 + ring_share) * tube_mass(z, D, walls, density)
    tower = tube_mass(tower_heights, tower_diameters, tower_walls, tower_density)
    return displaced - steel - tower - top_mass - lines * line_load / gravity
