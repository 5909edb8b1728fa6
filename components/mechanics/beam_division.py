"""How a beam with distributed properties becomes a chain of rigid segments and sprung hinges. NumPy.

The rotation of hinge i is the curvature that the beam collects near it. With M the bending moment, the chain replaces

    integral of M(s)^2 / EI(s) ds   by   sum of c_i M(s_i)^2,      1 / c_i = stiffness of hinge i,

that is, it is a quadrature rule for the strain energy, and its eigenfrequencies are those of the integral equation of
the beam, M(s) = omega^2 int K(s, t) M(t) / EI(t) dt with K(s, t) = int mu (x - s)+ (x - t)+ dx, by Nystroem's method
with that rule. The mass of the segments is exact. Equal pieces with the hinge in the middle are the midpoint rule, of
second order. Gauss points, as many as hinges, cost nothing and converge much faster; the order is limited by K, which
is twice continuously differentiable.

`loaded_tip`: Gauss rule for the weight 1 / EI. Exact for the static deflection and slope of the tip under a force and
a moment there, from two hinges on; for towers and arms, which carry a mass at the end.
`free_tip`: Gauss rule for the weight (L - s)^2 / EI. The moment of a free tip vanishes like (L - s)^2 at the least, so
the hinges leave the tip, where EI is small, to the root; for blades.
`stations`: as `loaded_tip`, between each two stations by itself, with as many hinges in each. A hinge then never leaves
its stations, however their sizes change, nor passes a cut there; for tubes whose sizes a design changes.
The two bending directions share the points (weight with the geometric mean of their EI) and have interpolatory weights
each.
"""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from fowtlib.components.mechanics.beam_properties import BeamProperties
from fowtlib.language.errors import ParameterError

GAUSS = np.polynomial.legendre.leggauss(4)
KEPT = 512  # divisions: as many as slopes by the numbers of some tubes take, which ask for each of them again
QUADRATURES = ("plain", "loaded_tip", "free_tip", "stations")


@dataclass(frozen=True, eq=False)
class Segment:
    """Rigid piece of the chain from s = start to end: mass, centre and inertia, in the axes of the beam's root."""

    start: float
    end: float
    mass: float
    centre: np.ndarray
    inertia: np.ndarray


@dataclass(frozen=True, eq=False)
class Division:
    """The chain: N hinges at s (N,) [m], N + 1 segments between them, and the stiffness of each hinge.

    stiffness_x, _y [N m/rad], torsion [N m/rad] and stretch [N/m] (None where the table has none); axes (N, 3, 3): the
    columns are x', y', z' of each hinge, z' along the elastic axis, x' and y' turned by the structural twist.
    """

    s: np.ndarray
    points: np.ndarray
    axes: np.ndarray
    stiffness_x: np.ndarray
    stiffness_y: np.ndarray
    torsion: np.ndarray | None
    stretch: np.ndarray | None
    segments: list[Segment]
    tip: np.ndarray

    def stations(self, count: int = 5) -> list[np.ndarray]:
        """Distances from the root along each segment, for pictures."""
        return [np.linspace(segment.start, segment.end, count) for segment in self.segments]


def elastic_axis(beam: BeamProperties, s: Any) -> np.ndarray:
    """Point of the elastic axis at the distance s from the root, in the axes of the root; a row for each of several."""
    if _is_straight(beam):
        points = np.zeros((*np.shape(s), 3))
        points[..., 2] = s
        return points
    return np.stack([beam.at("reference_x", s), beam.at("reference_y", s), s], axis=-1)


@lru_cache(maxsize=KEPT)
def divide(
    beam: BeamProperties, count: int, quadrature: str = "plain", marks: tuple[float, ...] | None = None
) -> Division:
    """Hinges and segments of a beam with `count` hinges; marks [m]: its stations from the root, not those of the table.

    Raises ParameterError for an unknown quadrature, or hinges that the stations do not share alike.
    """
    if quadrature not in QUADRATURES:
        raise ParameterError(f"quadrature of a beam: {', '.join(QUADRATURES)}, not {quadrature!r}.")
    if quadrature == "plain" or count == 0:
        hinges, flexibility = _middles(beam, count)
    elif quadrature == "stations":
        hinges, flexibility = _between_stations(beam, count, marks or tuple(beam.z - beam.z[0]))
    else:
        hinges, flexibility = _gauss(beam, count, 0.0, beam.length, quadrature == "free_tip")
    bounds = np.concatenate([[0.0], hinges, [beam.length]])
    segments = _segments(beam, bounds)
    stiffness = {name: None if c is None else 1 / c for name, c in flexibility.items()}
    points, axes = elastic_axis(beam, hinges), section_axes(beam, hinges)
    return Division(
        hinges, points, axes, stiffness["stiffness_x"], stiffness["stiffness_y"], stiffness["torsional_stiffness"],
        stiffness["axial_stiffness"], segments, elastic_axis(beam, beam.length),
    )  # fmt: skip


@dataclass(frozen=True, eq=False)
class Piece:
    """A segment, or a part of one that is cut: what begins at `root`, with a hinge or a cut (their numbers, or 0)."""

    name: str
    root: np.ndarray
    segment: Segment
    hinge: int = 0
    cut: int = 0


def pieces(beam: BeamProperties, division: Division, cuts: Any = ()) -> list[Piece]:
    """The chain from root to tip, its segments parted at the cuts (distances from the root [m], in any order).

    A cut at a hinge lies on its tip side, which makes no difference: the hinge has no mass. Raises ParameterError for
    a cut off the beam.
    """
    return list(_pieces(beam, division, tuple(float(cut) for cut in cuts)))


@lru_cache(maxsize=KEPT)
def _pieces(beam: BeamProperties, division: Division, cuts: tuple[float, ...]) -> tuple[Piece, ...]:
    given = np.array(cuts)
    s = np.clip(given, 0.0, beam.length)
    for k in np.flatnonzero(np.abs(s - given) > 1e-9 * beam.length):
        raise ParameterError(f"cut {k + 1} at {given[k]:g} m is off the beam of {beam.length:g} m.")
    found, order, last = list[tuple[str, Any, int, int]](), np.argsort(s, kind="stable").tolist(), len(division.s)
    bounds = list[float]()
    for i, segment in enumerate(division.segments):
        root = division.points[i - 1] if i else np.zeros(3)
        within = [k for k in order if segment.start <= s[k] < segment.end or (i == last and s[k] == segment.end)]
        bounds += [segment.start, *s[within].tolist()]
        found.append((f"segment_{i}", root, i, 0))
        found += [(f"beyond_cut_{k + 1}", elastic_axis(beam, s[k]), 0, k + 1) for k in within]
    parts = division.segments if len(found) == last + 1 else _segments(beam, np.array([*bounds, beam.length]))
    return tuple(Piece(name, root, part, hinge=hinge, cut=cut)
                 for (name, root, hinge, cut), part in zip(found, parts, strict=True))  # fmt: skip


def _quadrature(beam: BeamProperties, a: float, b: float, pieces: int = 4) -> tuple[np.ndarray, np.ndarray]:
    """Points and weights from a to b that respect the kinks of the table: 4 Gauss points in each piece."""
    stations = beam.distances
    within = stations[stations.searchsorted(a, "right") : stations.searchsorted(b)]
    return _points(np.concatenate([[a], within, [b]]), pieces)


def _points(marks: np.ndarray, pieces: int) -> tuple[np.ndarray, np.ndarray]:
    """Points and weights between marks: 4 Gauss points in each of so many pieces between two of them."""
    parts = (marks[1:] - marks[:-1])[:, None] / pieces
    edges = np.concatenate([(marks[:-1, None] + parts * np.arange(pieces)).ravel(), marks[-1:]])
    x, w = GAUSS
    middle, half = (edges[1:] + edges[:-1]) / 2, (edges[1:] - edges[:-1]) / 2
    return (middle[:, None] + half[:, None] * x).ravel(), (half[:, None] * w).ravel()


STIFFNESSES = ("stiffness_x", "stiffness_y", "torsional_stiffness", "axial_stiffness")


def _middles(beam: BeamProperties, count: int) -> tuple[np.ndarray, dict[str, np.ndarray | None]]:
    """Equal pieces, hinges in the middle, l / mean(EI): the chain of Miller et al. (2017)."""
    length = beam.length / max(count, 1)
    flexibility: dict[str, np.ndarray | None] = dict.fromkeys(STIFFNESSES)
    for name in STIFFNESSES:
        if getattr(beam, name) is not None:
            rules = [_quadrature(beam, i * length, (i + 1) * length) for i in range(count)]
            flexibility[name] = np.array([length / (w @ beam.at(name, s) / length) for s, w in rules])
    return (np.arange(count) + 0.5) * length, flexibility


def _between_stations(
    beam: BeamProperties, count: int, marks: tuple[float, ...]
) -> tuple[np.ndarray, dict[str, np.ndarray | None]]:
    """Gauss points of each piece between stations, for the weight 1 / EI."""
    number = len(marks) - 1
    if count % number:
        raise ParameterError(
            f"quadrature 'stations' shares the hinges among the {number} pieces between stations; {count} hinges are "
            f"no multiple of {number}."
        )
    if count == number:
        return _one_each(beam, np.array(marks))
    rules = [_gauss(beam, count // number, a, b) for a, b in zip(marks, marks[1:], strict=False)]
    known = [name for name in STIFFNESSES if getattr(beam, name) is not None]
    flexibility: dict[str, np.ndarray | None] = dict.fromkeys(STIFFNESSES)
    flexibility |= {name: np.concatenate([found[name] for _, found in rules]) for name in known}
    return np.concatenate([nodes for nodes, _ in rules]), flexibility


def _one_each(beam: BeamProperties, marks: np.ndarray) -> tuple[np.ndarray, dict[str, np.ndarray | None]]:
    """The same with one point in each piece, all pieces at once: the centre of the weight."""
    s, w, first, _ = _along(beam, marks, pieces=4)
    stiffness = {name: beam.at(name, s) for name in STIFFNESSES if getattr(beam, name) is not None}
    weight = w / np.sqrt(stiffness["stiffness_x"] * stiffness["stiffness_y"])
    flexibility: dict[str, np.ndarray | None] = dict.fromkeys(STIFFNESSES)
    flexibility |= {name: np.add.reduceat(w / here, first) for name, here in stiffness.items()}
    return np.add.reduceat(weight * s, first) / np.add.reduceat(weight, first), flexibility


def _along(
    beam: BeamProperties, bounds: np.ndarray, pieces: int
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Points and weights as of `_quadrature`, from each bound (n,) to the next that is beyond it.

    And the number of the first point of each of these, and of the bounds at which they begin.
    """
    begin = np.flatnonzero(np.diff(bounds) > 0)
    starts, end = bounds[begin], bounds[-1]
    stations = beam.distances
    marks = np.union1d([*starts, end], stations[(stations > starts[0]) & (stations < end)])
    s, w = _points(marks, pieces)
    return s, w, np.searchsorted(marks, starts) * (pieces * len(GAUSS[0])), begin


def _gauss(
    beam: BeamProperties, count: int, start: float, end: float, free_tip: bool = False
) -> tuple[np.ndarray, dict[str, np.ndarray | None]]:
    """Gauss points of the weight that the module's docstring names, and interpolatory weights of each stiffness."""
    key = ("gauss", count, free_tip, beam.length if free_tip else 0.0, *_within(beam, STIFFNESSES, start, end))
    return _KNOWN(key, lambda: _gauss_rule(beam, count, start, end, free_tip))


def _gauss_rule(
    beam: BeamProperties, count: int, start: float, end: float, free_tip: bool
) -> tuple[np.ndarray, dict[str, np.ndarray | None]]:
    L = beam.length
    s, w = _quadrature(beam, start, end, pieces=max(4, count))
    stiffness = {name: beam.at(name, s) for name in STIFFNESSES if getattr(beam, name) is not None}
    EI = np.sqrt(stiffness["stiffness_x"] * stiffness["stiffness_y"])
    taper = (1 - s / L) ** (2 if free_tip else 0)
    nodes = start + gauss_points(s - start, w * taper / EI, end - start, count)[0]
    cells = np.digitize(s, (nodes[1:] + nodes[:-1]) / 2)
    spread = np.ones((count, s.size))
    for p, row in zip(nodes, spread, strict=True):
        for q in nodes[nodes != p]:
            row *= (s - q) / (p - q)
    flexibility: dict[str, np.ndarray | None] = dict.fromkeys(STIFFNESSES)
    for name, here in stiffness.items():
        bending = name in ("stiffness_x", "stiffness_y")
        weight = w / here * (taper if bending else 1.0)
        rule = spread @ weight
        if rule.min() <= 0:  # far from the weight of the points: each point stands for what is nearest to it
            rule = np.bincount(cells, weights=weight, minlength=count)
        flexibility[name] = rule / ((1 - nodes / L) ** 2 if bending and free_tip else 1.0)
    return nodes, flexibility


def gauss_points(s: np.ndarray, weight: np.ndarray, length: float, n: int) -> tuple[np.ndarray, np.ndarray]:
    """Nodes and weights of the Gauss rule with n points for a discrete weight at s in [0, length].

    Source: G. Golub, J. Welsch (1969), Math. Comp. 23.
    """
    x, diagonal, off = 2 * s / length - 1, np.zeros(n), np.zeros(n)
    basis = [np.full_like(x, 1 / np.sqrt(weight.sum()))]
    for k in range(n):
        after = x * basis[-1]
        diagonal[k] = weight @ (after * basis[-1])
        for polynomial in (*basis, *basis):  # twice: orthogonal to rounding, for any number of hinges
            after = after - (weight @ (after * polynomial)) * polynomial
        off[k] = np.sqrt(weight @ after**2)
        basis.append(after / off[k])
    nodes, vectors = np.linalg.eigh(np.diag(diagonal) + np.diag(off[:-1], 1) + np.diag(off[:-1], -1))
    return (nodes + 1) / 2 * length, weight.sum() * vectors[0] ** 2


def section_axes(beam: BeamProperties, s: Any) -> np.ndarray:
    """Columns x', y', z' at s: z' along the elastic axis, x' and y' the principal axes of bending; (n, 3, 3) for n."""
    if _is_straight(beam):
        return np.broadcast_to(np.eye(3), (*np.shape(s), 3, 3)).copy()
    step = 1e-6 * beam.length
    tangent = elastic_axis(beam, np.minimum(s + step, beam.length)) - elastic_axis(beam, np.maximum(s - step, 0.0))
    tangent /= np.linalg.norm(tangent, axis=-1, keepdims=True)
    twist = np.asarray(beam.at("twist", s))
    x = np.stack([np.cos(twist), -np.sin(twist), 0.0 * twist], axis=-1)
    x -= tangent * (x * tangent).sum(axis=-1, keepdims=True)
    x /= np.linalg.norm(x, axis=-1, keepdims=True)
    return np.stack([x, np.cross(tangent, x), tangent], axis=-1)


def _segments(beam: BeamProperties, bounds: np.ndarray) -> list[Segment]:
    """Mass, centre and inertia of the beam from each bound to the next."""
    if _is_straight(beam):
        return _straight(beam, bounds)
    return [_bent(beam, a, b) for a, b in zip(bounds[:-1], bounds[1:], strict=True)]


def _bent(beam: BeamProperties, a: float, b: float) -> Segment:
    s, w = _quadrature(beam, a, b, pieces=2)
    mass = w * beam.at("mass_per_length", s)
    axes = section_axes(beam, s)
    offset = np.stack([beam.at("centre_of_mass_x", s), beam.at("centre_of_mass_y", s), 0 * s], axis=1)
    r = elastic_axis(beam, s) + np.einsum("nij,nj->ni", axes, offset)
    total = mass.sum()
    centre = mass @ r / total if total > 0 else r.mean(axis=0)
    arm = r - centre
    inertia = np.einsum("n,nij->ij", mass, (arm**2).sum(1)[:, None, None] * np.eye(3) - arm[:, :, None] * arm[:, None])
    x, y = beam.at("rotary_inertia_x", s), beam.at("rotary_inertia_y", s)  # about y' and about x'
    section = np.stack([y, x, x + y], axis=1) * w[:, None]
    inertia = inertia + np.einsum("nij,nj,nkj->ik", axes, section, axes)
    return Segment(a, b, float(total), centre, inertia)


# --- what lies along the z axis, as tubes do -----------------------------------------------------------------------

LYING = ("mass_per_length", "rotary_inertia_x", "rotary_inertia_y")
OFF_AXIS = ("twist", "reference_x", "reference_y", "centre_of_mass_x", "centre_of_mass_y")


@lru_cache(maxsize=KEPT)
def _is_straight(beam: BeamProperties) -> bool:
    """Whether axis and mass are on z, and the principal axes x and y."""
    return not any(np.any(getattr(beam, name)) for name in OFF_AXIS)


def _straight(beam: BeamProperties, bounds: np.ndarray) -> list[Segment]:
    """The same, all at once."""
    s, w, first, begin = _along(beam, bounds, pieces=2)
    count = len(bounds) - 1
    total, height, inertia = np.zeros(count), bounds[:-1].copy(), np.zeros((count, 3, 3))
    mass = w * beam.at("mass_per_length", s)
    total[begin] = here = np.add.reduceat(mass, first)
    middle = (bounds[begin] + bounds[begin + 1]) / 2
    height[begin] = np.where(here > 0, np.add.reduceat(mass * s, first) / np.where(here > 0, here, 1.0), middle)
    sizes = np.diff(np.append(first, len(s)))
    across = np.add.reduceat(mass * (s - np.repeat(height[begin], sizes)) ** 2, first)
    x, y = (np.add.reduceat(w * beam.at(name, s), first) for name in LYING[1:])
    for k, moment in enumerate((across + y, across + x, x + y)):
        inertia[begin, k, k] = moment
    centre = np.zeros((count, 3))
    centre[:, 2] = height
    ends = bounds.tolist()
    return [Segment(*item) for item in zip(ends[:-1], ends[1:], total.tolist(), centre, inertia, strict=True)]


def _within(beam: BeamProperties, names: tuple[str, ...], a: float, b: float) -> tuple[Any, ...]:
    """Something that is equal where these properties between a and b are."""
    z, known, table = _rows_of(beam, names)
    return a, b, known, table[max(bisect_right(z, a) - 1, 0) : bisect_left(z, b) + 1].tobytes()


@lru_cache(maxsize=KEPT)
def _rows_of(beam: BeamProperties, names: tuple[str, ...]) -> tuple[list[float], tuple[str, ...], np.ndarray]:
    """Distances of the stations from the root, which properties are known, and rows of distance and these."""
    z, known = beam.z - beam.z[0], tuple(name for name in names if getattr(beam, name) is not None)
    return z.tolist(), known, np.column_stack([z, *(getattr(beam, name) for name in known)])


class _Known:
    """What was computed of pieces of beams: of a tube with another wall at one place most of them are as before."""

    def __init__(self, most: int):
        self.most, self._kept = most, {}

    def __call__(self, key: Any, make: Callable[[], Any]) -> Any:
        found = self._kept.get(key)
        if found is None:
            found = self._kept[key] = make()
            if len(self._kept) > self.most:
                self._kept.pop(next(iter(self._kept)), None)
        return found


_KNOWN = _Known(8 * KEPT)
