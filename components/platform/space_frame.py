"""A space frame: straight beams between nodes, its stiffness, its mass, and the stiffness that its loads add.

Six displacements a node: three of the place [m], three small turns [rad], in the axes of the frame. Beams are
Timoshenko's; shear areas without end make them Euler and Bernoulli's. Along a beam the displacement is that of a beam
without loads between its ends (Z. Friedman and J.B. Kosmatka, Computers and Structures 47 (1993) 473-481), from which
mass and geometric stiffness are integrated.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fowtlib.language.errors import ParameterError

if TYPE_CHECKING:
    from scipy import sparse

Floats = NDArray[np.float64]
_GAUSS = np.polynomial.legendre.leggauss(4)  # exact for what is integrated, of degree 6


@dataclass(frozen=True)
class Section:
    """A cross-section of a beam. Its first direction is that of `Beam.first`; second moments are about the axes.

    area [m^2]; about_first, about_second [m^4]; torsion: constant of St. Venant [m^4]; shear_first, shear_second:
    effective shear areas [m^2] along the axes; mass [kg/m]; axial_inertia, inertia_first, inertia_second: of the mass,
    about the axis of the beam and those of the section [kg m]; young_modulus, shear_modulus [Pa].
    """

    area: float
    about_first: float
    about_second: float
    torsion: float
    young_modulus: float
    shear_modulus: float
    mass: float
    axial_inertia: float
    inertia_first: float = 0.0
    inertia_second: float = 0.0
    shear_first: float = math.inf
    shear_second: float = math.inf

    @classmethod
    def tube(cls, diameter: float, wall: float, density: float, young_modulus: float, shear_modulus: float) -> Section:
        """A round tube; its shear area is half of the area, as of a thin one (G.R. Cowper, J. Appl. Mech. 33, 1966)."""
        inner = diameter - 2 * wall
        area, second = math.pi / 4 * (diameter**2 - inner**2), math.pi / 64 * (diameter**4 - inner**4)
        return cls(
            area, second, second, 2 * second, young_modulus, shear_modulus, density * area, 2 * density * second,
            density * second, density * second, area / 2, area / 2,
        )  # fmt: skip

    @classmethod
    def box(cls, sizes: Sequence[float], wall: float, density: float, young_modulus: float,
            shear_modulus: float) -> Section:  # fmt: skip
        """A thin box of these outer sizes; shear is borne by the walls along it, torsion as R. Bredt (1896) says."""
        one, two = sizes
        area = one * two - (one - 2 * wall) * (two - 2 * wall)
        about_first = (one * two**3 - (one - 2 * wall) * (two - 2 * wall) ** 3) / 12
        about_second = (two * one**3 - (two - 2 * wall) * (one - 2 * wall) ** 3) / 12
        middle = (one - wall) * (two - wall)
        torsion = 4 * middle**2 * wall / (2 * (one + two - 2 * wall))
        return cls(
            area, about_first, about_second, torsion, young_modulus, shear_modulus, density * area,
            density * (about_first + about_second), density * about_first, density * about_second,
            2 * wall * one, 2 * wall * two,
        )  # fmt: skip


@dataclass(frozen=True)
class Beam:
    """A beam from node `start` to node `end`, by number; its ends may lie off the nodes, rigidly joined to them.

    first: the first direction of the section, across the axis as far as it can be. start_arm, end_arm [m]: from the
    nodes to the ends.
    """

    start: int
    end: int
    section: Section
    first: tuple[float, float, float] = (0.0, 0.0, 0.0)
    start_arm: tuple[float, float, float] = (0.0, 0.0, 0.0)
    end_arm: tuple[float, float, float] = (0.0, 0.0, 0.0)


@dataclass(frozen=True)
class NodeMass:
    """A rigid mass at a node: mass [kg], its centre from the node [m], inertia (3, 3) about the centre [kg m^2]."""

    node: int
    mass: float
    centre: tuple[float, float, float] = (0.0, 0.0, 0.0)
    inertia: ArrayLike = field(default_factory=lambda: np.zeros((3, 3)))


@dataclass(frozen=True)
class FrameModes:
    """Modes of a frame. frequencies [rad/s], ascending; shapes (modes, nodes, 6), of modal mass 1 [kg or kg m^2]."""

    frequencies: Floats
    shapes: Floats


class SpaceFrame:
    """Nodes (n, 3) [m], beams between them, and rigid masses at them.

    Raises ParameterError for a beam without length, and a frame that is not one piece.
    """

    def __init__(self, nodes: ArrayLike, beams: Sequence[Beam], masses: Sequence[NodeMass] = ()):
        self.nodes = np.array(nodes, dtype=float)
        self.beams, self.masses = tuple(beams), tuple(masses)
        self._elements = [_Element(self.nodes, k, beam) for k, beam in enumerate(self.beams)]
        self._check_joined()

    @cached_property
    def stiffness(self) -> sparse.csc_matrix:
        """Elastic stiffness (6 n, 6 n) [N/m and so on]."""
        return self._assembled(element.stiffness() for element in self._elements)

    @cached_property
    def mass(self) -> sparse.csc_matrix:
        """Consistent mass (6 n, 6 n) [kg and so on], with the masses at nodes."""
        total = self._assembled(element.mass() for element in self._elements).tolil()
        for one in self.masses:
            rows = slice(6 * one.node, 6 * one.node + 6)
            total[rows, rows] += _rigid_mass(one)
        return total.tocsc()

    def geometric_stiffness(self, tensions: ArrayLike) -> sparse.csc_matrix:
        """What axial forces [N], one a beam and positive in tension, add to the stiffness across the beams."""
        pulled = np.broadcast_to(np.asarray(tensions, dtype=float), (len(self.beams),))
        return self._assembled(
            element.geometric_stiffness(force) for element, force in zip(self._elements, pulled, strict=True)
        )

    def stress_stiffness(self, displacements: ArrayLike) -> sparse.csc_matrix:
        """What all that the beams bear at these displacements (n, 6) adds to the stiffness, with their rigid arms.

        Axial forces resist turns of the axis; shear, bending moments and torsion couple turns about different axes.
        Turns at nodes are rotation vectors to the second order, so that moments balance at joints of any angle (J.H.
        Argyris et al., Computer Methods in Applied Mechanics and Engineering 20 (1979) 105-155, semitangential).
        """
        moved = np.asarray(displacements, dtype=float).reshape(-1)
        return self._assembled(element.stress_stiffness(element.end_loads(moved)) for element in self._elements)

    def static(self, loads: ArrayLike, held: ArrayLike, tensions: ArrayLike = 0.0) -> Floats:
        """Displacements (n, 6) under loads (n, 6) [N, N m]; held (n, 6): True where a displacement is zero.

        Raises ParameterError where what is held leaves the frame free to move.
        """
        from scipy.sparse.linalg import splu

        matrix = self.stiffness + self.geometric_stiffness(tensions)
        free = ~np.asarray(held, dtype=bool).reshape(-1)
        given = np.asarray(loads, dtype=float).reshape(-1)
        found = np.zeros(given.size)
        try:
            factors = splu(matrix[free][:, free].tocsc())
        except RuntimeError:
            raise _loose() from None
        pivots = np.abs(factors.U.diagonal())
        if pivots.min() < 1e-13 * pivots.max():
            raise _loose()
        found[free] = factors.solve(given[free])
        return found.reshape(-1, 6)

    def tensions(self, displacements: ArrayLike) -> Floats:
        """Axial force of each beam [N], positive in tension."""
        moved = np.asarray(displacements, dtype=float).reshape(-1)
        return np.array([element.end_loads(moved)[6] for element in self._elements])

    def section_loads(self, displacements: ArrayLike) -> Floats:
        """Loads at both ends of each beam (beams, 2, 6), of what is beyond on what is before, in the axes of the beam.

        Axes: along the beam, first, second direction. Force [N], then moment [N m]. Without what acts between the ends.
        """
        moved = np.asarray(displacements, dtype=float).reshape(-1)
        loads = np.array([element.end_loads(moved) for element in self._elements]).reshape(-1, 2, 6)
        return loads * np.array([-1.0, 1.0])[None, :, None]

    def modes(self, number: int, held: ArrayLike | None = None, tensions: ArrayLike = 0.0) -> FrameModes:
        """The lowest modes, dry; a frame that nothing holds has six of frequency zero first."""
        from scipy.linalg import eigh

        matrix = (self.stiffness + self.geometric_stiffness(tensions)).toarray()
        mass = self.mass.toarray()
        free = np.ones(len(mass), dtype=bool) if held is None else ~np.asarray(held, dtype=bool).reshape(-1)
        number = min(number, int(free.sum()))
        values, vectors = eigh(matrix[np.ix_(free, free)], mass[np.ix_(free, free)], subset_by_index=(0, number - 1))
        shapes = np.zeros((number, len(mass)))
        shapes[:, free] = vectors.T
        return FrameModes(np.sqrt(np.maximum(values, 0.0)), shapes.reshape(number, -1, 6))

    def direction(self, beam: int) -> Floats:
        """Unit vector (3,) along a beam."""
        return self._elements[beam].axes[:, 0]

    def axes(self, beam: int) -> Floats:
        """Columns (3, 3): along a beam, first and second direction of its section."""
        return self._elements[beam].axes

    def section_motion(self, beam: int, share: float, shapes: ArrayLike) -> tuple[Floats, Floats, Floats]:
        """A section of a beam at a share 0 to 1 of its length: its place (3,), and how it moves in shapes (m, n, 6).

        The motion (m, 6) is displacement and turn, the third its derivative along the beam [1/m].
        """
        element, moved = self._elements[beam], np.asarray(shapes, dtype=float).reshape(len(shapes), -1)
        local = element.to_local @ moved[:, element.rows].T
        turn = np.kron(np.eye(2), element.axes)
        motion, slope = (turn @ (matrix @ local) for matrix in (element.interpolation(share), element.rates(share)))
        return self.place(beam, share), motion.T, slope.T

    def place(self, beam: int, share: float) -> Floats:
        """The point (3,) of its axis at a share 0 to 1 of the length of a beam."""
        element = self._elements[beam]
        return element.first_end + share * element.length * element.axes[:, 0]

    def carried(self, beam: int, share: float, load: ArrayLike) -> Floats:
        """Loads (m, n, 6) on the nodes that do the work of loads (m, 6) on a section, as `section_motion` moves it."""
        element, given = self._elements[beam], np.asarray(load, dtype=float).reshape(-1, 6)
        turn = np.kron(np.eye(2), element.axes)
        found = np.zeros((len(given), 6 * len(self.nodes)))
        np.add.at(found.T, element.rows, (given @ turn @ element.interpolation(share) @ element.to_local).T)
        return found.reshape(len(given), -1, 6)

    def relieved(self, loads: ArrayLike) -> Floats:
        """Displacements (m, n, 6) of the free frame under loads (m, n, 6): bent by them and by its own inertia.

        What the loads leave unbalanced moves the frame as a rigid one, whose inertia is a load too (inertia relief).
        Rigid motion is taken off: M-orthogonal displacements.
        """
        from scipy.sparse.linalg import splu

        given = np.asarray(loads, dtype=float).reshape(-1, 6 * len(self.nodes))
        rigid = rigid_motions(self.nodes).reshape(6, -1)
        carried = self.mass @ rigid.T
        own = rigid @ carried
        balanced = given - np.linalg.solve(own, rigid @ given.T).T @ carried.T
        held = np.zeros((len(self.nodes), 6), dtype=bool)
        held[0] = True
        factors = splu(self.stiffness[~held.reshape(-1)][:, ~held.reshape(-1)].tocsc())
        found = np.zeros_like(given)
        found[:, 6:] = factors.solve(balanced[:, 6:].T).T
        return (found - np.linalg.solve(own, carried.T @ found.T).T @ rigid).reshape(len(given), -1, 6)

    def _assembled(self, matrices: Iterable[Floats]) -> sparse.csc_matrix:
        from scipy import sparse

        size, rows, columns, values = 6 * len(self.nodes), [], [], []
        for element, matrix in zip(self._elements, matrices, strict=True):
            rows.append(np.repeat(element.rows, 12))
            columns.append(np.tile(element.rows, 12))
            values.append(matrix.reshape(-1))
        if not rows:
            return sparse.csc_matrix((size, size))
        place = np.concatenate(rows), np.concatenate(columns)
        return sparse.coo_matrix((np.concatenate(values), place), (size, size)).tocsc()

    def _check_joined(self) -> None:
        from scipy import sparse

        pairs = np.array([(beam.start, beam.end) for beam in self.beams]).reshape(-1, 2)
        count = len(self.nodes)
        graph = sparse.coo_matrix((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), (count, count))
        pieces, names = sparse.csgraph.connected_components(graph, directed=False)
        if pieces > 1:
            lost = int(np.flatnonzero(names != names[0])[0])
            raise ParameterError(
                f"the frame falls into {pieces} pieces: nothing joins the node at {_said(self.nodes[lost])} to that at "
                f"{_said(self.nodes[0])}."
            )


class _Element:
    """A beam as its matrices, in the displacements of its two nodes."""

    def __init__(self, nodes: Floats, number: int, beam: Beam):
        self.section = beam.section
        self.arms = np.asarray(beam.start_arm, dtype=float), np.asarray(beam.end_arm, dtype=float)
        self.rows = np.concatenate([6 * n + np.arange(6) for n in (beam.start, beam.end)])
        self.first_end = nodes[beam.start] + beam.start_arm
        along = nodes[beam.end] + beam.end_arm - self.first_end
        self.length = float(np.linalg.norm(along))
        if self.length < 1e-9:
            raise ParameterError(f"beam {number + 1} has no length: its ends meet at {_said(self.first_end)}.")
        self.axes = _axes(along / self.length, np.asarray(beam.first))
        turn = np.kron(np.eye(4), self.axes.T)
        self.to_local = turn @ np.kron(np.diag([1.0, 0.0]), _arm(beam.start_arm)) + turn @ np.kron(
            np.diag([0.0, 1.0]), _arm(beam.end_arm)
        )

    def stiffness(self) -> Floats:
        return self.to_local.T @ self._local_stiffness() @ self.to_local

    def _local_stiffness(self) -> Floats:
        section, length = self.section, self.length
        matrix = np.zeros((12, 12))
        for row, value in ((0, section.young_modulus * section.area), (3, section.shear_modulus * section.torsion)):
            ends = np.ix_((row, row + 6), (row, row + 6))
            matrix[ends] += value / length * np.array([[1, -1], [-1, 1]])
        for turned, bending, shear in self._planes():
            rows, sign = turned
            matrix[np.ix_(rows, rows)] += _bending(bending, shear, length) * np.outer(sign, sign)
        return matrix

    def mass(self) -> Floats:
        section = self.section
        turning = [section.axial_inertia, section.inertia_first, section.inertia_second]
        per_length = np.diag([section.mass] * 3 + turning)
        total = np.zeros((12, 12))
        for x, weight in zip(*_GAUSS, strict=True):
            there = self.interpolation((1 + x) / 2)
            total += weight * self.length / 2 * there.T @ per_length @ there
        return self.to_local.T @ total @ self.to_local

    def geometric_stiffness(self, tension: float) -> Floats:
        total = np.zeros((12, 12))
        for x, weight in zip(*_GAUSS, strict=True):
            slope = self._slopes((1 + x) / 2)
            total += weight * self.length / 2 * tension * slope.T @ slope
        return self.to_local.T @ total @ self.to_local

    def stress_stiffness(self, ends: Floats) -> Floats:
        """By loads (12,) on both ends, in the axes of the beam.

        With section loads N, F_1, F_2 and T, M_1, M_2, displacements u, v, w and turns t, a, b (axis, first, second):
        N (v'^2 + w'^2) / 2 + M_1 (-v' t' + (t b)' / 2) - M_2 (w' t' + (t a)' / 2)
        + F_1 (w' t + t a / 2 - u' b) + F_2 (-v' t + t b / 2 + u' a) + T (a' b - a b') / 2 along the beam, from the
        quadratic part of Green's strain.
        """
        total, before = np.zeros((12, 12)), -ends[:6]
        for x, weight in zip(*_GAUSS, strict=True):
            share = (1 + x) / 2
            load = (1 - share) * before + share * ends[6:]
            t, a, b = self.interpolation(share)[3:]
            du, dt, da, db = self.rates(share)[[0, 3, 4, 5]]
            v, w = self._slopes(share)
            pairs = [
                (load[0] / 2, v, v), (load[0] / 2, w, w), (load[3] / 2, da, b), (-load[3] / 2, a, db),
                (-load[4], v, dt), (load[4] / 2, dt, b), (load[4] / 2, t, db),
                (-load[5], w, dt), (-load[5] / 2, dt, a), (-load[5] / 2, t, da),
                (load[1], w, t), (load[1] / 2, t, a), (-load[1], du, b),
                (-load[2], v, t), (load[2] / 2, t, b), (load[2], du, a),
            ]  # fmt: skip
            energy = sum(force * np.outer(one, other) for force, one, other in pairs)
            total += weight * self.length / 2 * (energy + energy.T)
        found = self.to_local.T @ total @ self.to_local
        for turns, force, arm in zip((slice(3, 6), slice(9, 12)), (ends[:3], ends[6:9]), self.arms, strict=True):
            found[turns, turns] += leaning(self.axes @ force, arm)
        return found

    def end_loads(self, moved: Floats) -> Floats:
        """Forces and moments (12,) of the nodes on the ends, in the axes of the beam."""
        return self._local_stiffness() @ self.to_local @ moved[self.rows]

    def interpolation(self, x: float) -> Floats:
        """Displacements and turns (6, 12) at a share x of the length, from those of the ends; axes of the beam."""
        matrix = np.zeros((6, 12))
        for row in (0, 3):
            matrix[row, row], matrix[row, row + 6] = 1 - x, x
        for place, ((rows, sign), bending, shear) in zip(((1, 5), (2, 4)), self._planes(), strict=True):
            moved, turned = _shapes(x, self.length, _shear_factor(bending, shear, self.length))
            matrix[place[0], rows] += moved * sign
            matrix[place[1], rows] += turned * sign * sign[1]
        return matrix

    def rates(self, x: float) -> Floats:
        """Derivatives of displacements and turns along the axis (6, 12) at a share x; of third degree at most."""
        step = 0.25
        ends = [self.interpolation(x + k * step) for k in (-2, -1, 1, 2)]
        return (ends[0] - 8 * ends[1] + 8 * ends[2] - ends[3]) / (12 * step * self.length)

    def _slopes(self, x: float) -> Floats:
        """Slopes of the axis (2, 12) along the two directions of the section."""
        matrix = np.zeros((2, 12))
        for k, ((rows, sign), bending, shear) in enumerate(self._planes()):
            matrix[k, rows] = _slope(x, self.length, _shear_factor(bending, shear, self.length)) * sign
        return matrix

    def _planes(self):
        """Of both planes of bending: numbers and signs of displacement and turn at the ends; stiffnesses."""
        section, e, g = self.section, self.section.young_modulus, self.section.shear_modulus
        first = ((1, 5, 7, 11), np.array([1.0, 1.0, 1.0, 1.0]))
        second = ((2, 4, 8, 10), np.array([1.0, -1.0, 1.0, -1.0]))
        return (
            (first, e * section.about_second, g * section.shear_first),
            (second, e * section.about_first, g * section.shear_second),
        )


def rigid_motions(nodes: ArrayLike, about: ArrayLike = (0.0, 0.0, 0.0)) -> Floats:
    """Displacements (6, n, 6) of nodes (n, 3) in surge, sway, heave, and roll, pitch, yaw about a point."""
    places = np.asarray(nodes, dtype=float) - np.asarray(about, dtype=float)
    moved = np.zeros((6, len(places), 6))
    for k in range(3):
        axis = np.eye(3)[k]
        moved[k, :, :3] = axis
        moved[3 + k, :, :3], moved[3 + k, :, 3:] = np.cross(axis, places), axis
    return moved


def leaning(force: ArrayLike, arm: ArrayLike) -> Floats:
    """Stiffness (3, 3) on small turns of a force that an arm carries: where it goes at the second order of the turn."""
    f, a = np.asarray(force, dtype=float), np.asarray(arm, dtype=float)
    return (np.outer(f, a) + np.outer(a, f)) / 2 - (f @ a) * np.eye(3)


def _shear_factor(bending: float, shear: float, length: float) -> float:
    """12 EI / (G A_s L^2)."""
    return 0.0 if math.isinf(shear) else 12 * bending / (shear * length**2)


def _bending(bending: float, shear: float, length: float) -> Floats:
    """Stiffness (4, 4) of a beam in one plane: displacement and turn at both ends."""
    f, a = _shear_factor(bending, shear, length), length
    return bending / ((1 + f) * a**3) * np.array([
        [12, 6 * a, -12, 6 * a],
        [6 * a, (4 + f) * a**2, -6 * a, (2 - f) * a**2],
        [-12, -6 * a, 12, -6 * a],
        [6 * a, (2 - f) * a**2, -6 * a, (4 + f) * a**2],
    ])  # fmt: skip


def _shapes(x: float, a: float, f: float) -> tuple[Floats, Floats]:
    """Displacement and turn at a share x of the length a from displacement and turn at both ends; f: shear factor."""
    moved = [
        2 * x**3 - 3 * x**2 - f * x + 1 + f, a * (x**3 - (2 + f / 2) * x**2 + (1 + f / 2) * x),
        -2 * x**3 + 3 * x**2 + f * x, a * (x**3 - (1 - f / 2) * x**2 - f / 2 * x),
    ]  # fmt: skip
    turned = [
        6 / a * (x**2 - x), 3 * x**2 - (4 + f) * x + 1 + f, -6 / a * (x**2 - x), 3 * x**2 - (2 - f) * x,
    ]  # fmt: skip
    return np.array(moved) / (1 + f), np.array(turned) / (1 + f)


def _slope(x: float, a: float, f: float) -> Floats:
    """Derivative of the displacement along the axis."""
    return np.array([
        (6 * x**2 - 6 * x - f) / a, 3 * x**2 - (4 + f) * x + 1 + f / 2,
        (-6 * x**2 + 6 * x + f) / a, 3 * x**2 - (2 - f) * x - f / 2,
    ]) / (1 + f)  # fmt: skip


def _axes(along: Floats, first: Floats) -> Floats:
    """Columns: along the beam, the first and the second direction of the section."""
    across = first - (first @ along) * along
    if np.linalg.norm(across) < 1e-9:
        across = np.cross([0.0, 0.0, 1.0], along)
        if np.linalg.norm(across) < 1e-9:
            across = np.array([1.0, 0.0, 0.0])
    one = across / np.linalg.norm(across)
    return np.stack([along, one, np.cross(along, one)], axis=1)


def _skew(v: ArrayLike) -> Floats:
    x, y, z = np.asarray(v, dtype=float)
    return np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])


def _arm(arm: ArrayLike) -> Floats:
    """Displacements (6, 6) at the end of a rigid arm from those of the node."""
    return np.block([[np.eye(3), -_skew(arm)], [np.zeros((3, 3)), np.eye(3)]])


def _rigid_mass(one: NodeMass) -> Floats:
    matrix = np.zeros((6, 6))
    matrix[:3, :3], matrix[3:, 3:] = one.mass * np.eye(3), np.asarray(one.inertia, dtype=float)
    arm = _arm(one.centre)
    return arm.T @ matrix @ arm


def _said(point: Floats) -> str:
    return "(" + ", ".join(f"{value:g}" for value in point) + ") m"


def _loose() -> ParameterError:
    return ParameterError("what is held leaves the frame free to move; hold at least six displacements of one node.")
