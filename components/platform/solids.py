"""Mass, centre and inertia of straight pieces of members, in closed form. NumPy.

A piece runs along an axis from one section to the next; its sizes are linear between them. The area of a section is
of second degree along the axis and its second moments are of fourth, so that three Gauss points give volume, centre
and inertia exactly, of cylinders, cones, boxes and tapered boxes alike.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import ArrayLike, NDArray

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class MassProperties:
    """Mass [kg], centre (3,) [m] and inertia (3, 3) about the centre [kg m^2], in the axes of a common frame."""

    mass: float
    centre: Floats
    inertia: Floats

    def about(self, point: ArrayLike) -> Floats:
        """Inertia (3, 3) about a point, by Steiner's theorem."""
        arm = self.centre - np.asarray(point, dtype=float)
        return self.inertia + self.mass * (arm @ arm * np.eye(3) - np.outer(arm, arm))

    def times(self, factor: float) -> MassProperties:
        """The same body, with another density."""
        return MassProperties(self.mass * factor, self.centre, self.inertia * factor)


NOTHING = MassProperties(0.0, np.zeros(3), np.zeros((3, 3)))


def together(bodies: Iterable[MassProperties]) -> MassProperties:
    """Several bodies as one; a negative mass is a hole."""
    bodies = list(bodies)
    mass = sum(body.mass for body in bodies)
    if not mass:
        return NOTHING
    centre = sum((body.mass * body.centre for body in bodies), np.zeros(3)) / mass
    return MassProperties(mass, centre, sum((body.about(centre) for body in bodies), np.zeros((3, 3))))


def point(mass: float, place: ArrayLike) -> MassProperties:
    """A mass without extension."""
    return MassProperties(mass, np.asarray(place, dtype=float), np.zeros((3, 3)))


@cache
def _gauss() -> tuple[Floats, Floats]:
    nodes, weights = np.polynomial.legendre.leggauss(3)
    return (1 + nodes) / 2, weights / 2


def section(sizes: Floats, is_round: bool) -> tuple[Floats, Floats, Floats]:
    """Area, and second moments along the first and second direction, of sections with sizes (n, 2) [m].

    A round section has two equal diameters.
    """
    a, b = np.asarray(sizes, dtype=float).T
    area = math.pi / 4 * a * b if is_round else a * b
    share = 16 if is_round else 12
    return area, area * a**2 / share, area * b**2 / share


def piece(
    start: ArrayLike, end: ArrayLike, axes: Floats, sizes: tuple[ArrayLike, ArrayLike], is_round: bool,
    density: float = 1.0,
) -> MassProperties:  # fmt: skip
    """A solid piece from `start` to `end` (3,), with the sizes (2,) at both.

    axes (3, 3): the columns are the two directions of the sizes and the axis.
    """
    start, end = np.asarray(start, dtype=float), np.asarray(end, dtype=float)
    length = float(np.linalg.norm(end - start))
    s, weight = _gauss()
    between = (1 - s)[:, None] * np.asarray(sizes[0], dtype=float) + s[:, None] * np.asarray(sizes[1], dtype=float)
    area, along_1, along_2 = section(between, is_round)
    volume = length * float(weight @ area)
    if volume <= 0:
        return NOTHING
    middle = float(weight @ (area * s)) * length / volume  # of the length
    spread = length**3 * float(weight @ (area * (s - middle) ** 2))
    one, two = length * float(weight @ along_1), length * float(weight @ along_2)
    local = np.diag([two + spread, one + spread, one + two])
    return MassProperties(density * volume, start + middle * (end - start), density * axes @ local @ axes.T)
